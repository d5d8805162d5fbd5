//! A headless Chromium, controlled with the DevTools protocol over a WebSocket.

use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use futures_util::{SinkExt, StreamExt};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;
use serde_json::{Value, json};
use tempfile::TempDir;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::{WebSocketStream, client_async};
use vibrissa_tests::wait::PATIENCE;

/// A browser with one page, killed on drop.
pub(crate) struct Browser {
    process: Child,
    /// A private, empty profile.
    _profile: TempDir,
    socket: WebSocketStream<TcpStream>,
    session: Option<String>,
    calls: u64,
    /// Events of the page in order: method and parameters.
    heard: Vec<(String, Value)>,
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Debian's program is a script that starts the browser. It may have ended already.
        let _ = killpg(Pid::from_raw(self.process.id() as i32), Signal::SIGKILL);
        let _ = self.process.wait();
    }
}

impl Browser {
    /// Starts a browser with an empty page of 1280 x 900 pixels and light colours.
    pub(crate) async fn start() -> Self {
        let profile = tempfile::tempdir().unwrap();
        // It starts with a fifth of the computing time of the complete browser.
        let mut process = Command::new("chromium-headless-shell")
            .args(["--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--disable-dev-shm-usage"])
            .args(["--no-first-run", "--disable-background-networking", "--disable-component-update"])
            .args(["--remote-debugging-port=0", "about:blank"])
            .arg(format!("--user-data-dir={}", profile.path().display()))
            .process_group(0)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("chromium-headless-shell is installed: tests/run does it");
        let mut lines = BufReader::new(process.stderr.take().unwrap()).lines().map_while(Result::ok);
        let address = lines.find_map(|line| line.strip_prefix("DevTools listening on ").map(ToOwned::to_owned));
        let address = address.expect("chromium must print its address");
        // Reading goes on so that a full pipe never blocks the browser.
        std::thread::spawn(move || lines.for_each(drop));
        let host = address.trim_start_matches("ws://").split('/').next().unwrap().to_owned();
        let stream = TcpStream::connect(host).await.unwrap();
        let (socket, _) = client_async(address, stream).await.unwrap();
        let mut browser = Self { process, _profile: profile, socket, session: None, calls: 0, heard: Vec::new() };
        browser.attach().await;
        browser.size(1280, 900).await;
        browser
    }

    async fn attach(&mut self) {
        let target = self.call("Target.createTarget", json!({ "url": "about:blank" })).await;
        let target = json!({ "targetId": target["targetId"], "flatten": true });
        let session = self.call("Target.attachToTarget", target).await;
        self.session = session["sessionId"].as_str().map(ToOwned::to_owned);
        for domain in ["Page", "Runtime", "Log", "Network", "Accessibility"] {
            self.call(&format!("{domain}.enable"), json!({})).await;
        }
    }

    /// Calls a method of the protocol.
    pub(crate) async fn call(&mut self, method: &str, params: Value) -> Value {
        self.calls += 1;
        let id = self.calls;
        let mut message = json!({ "id": id, "method": method, "params": params });
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.socket.send(Message::text(message.to_string())).await.unwrap();
        loop {
            let mut answer = self.hear(method).await;
            if answer["id"] == json!(id) {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].take();
            }
        }
    }

    async fn hear(&mut self, what: &str) -> Value {
        loop {
            let message = tokio::time::timeout(2 * PATIENCE, self.socket.next()).await;
            let message = message.unwrap_or_else(|_| panic!("no answer from the browser: {what}"));
            let Message::Text(text) = message.expect("a browser").unwrap() else { continue };
            let said: Value = serde_json::from_str(&text).unwrap();
            if let Some(method) = said["method"].as_str() {
                self.heard.push((method.to_owned(), said["params"].clone()));
            }
            return said;
        }
    }

    /// Opens an address and waits until the console shows its page.
    pub(crate) async fn open(&mut self, url: &str) {
        self.load(url).await;
        self.shown().await;
    }

    /// Opens an address and waits until the page is loaded.
    pub(crate) async fn load(&mut self, url: &str) {
        let before = self.count("Page.loadEventFired");
        let navigated = self.call("Page.navigate", json!({ "url": url })).await;
        assert!(navigated["errorText"].is_null(), "{url}: {navigated}");
        // A change of the fragment alone loads no page.
        while !navigated["loaderId"].is_null() && self.count("Page.loadEventFired") == before {
            self.hear(url).await;
        }
    }

    fn count(&self, method: &str) -> usize {
        self.heard.iter().filter(|(heard, _)| heard == method).count()
    }

    /// Waits until the console shows the page of its address, with its charts.
    pub(crate) async fn shown(&mut self) {
        self.until(
            "the page is shown",
            "document.getElementById('main').dataset.address === location.hash \
             && [...document.querySelectorAll('whisker-charts, model-chart, error-chart')] \
                .every((chart) => chart.querySelector('[data-state]'))",
        )
        .await;
    }

    /// Value of a JavaScript expression in the page; promises are awaited.
    pub(crate) async fn js(&mut self, expression: &str) -> Value {
        let params = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.call("Runtime.evaluate", params).await;
        let thrown = &answer["exceptionDetails"];
        assert!(thrown.is_null(), "{expression}: {}", thrown["exception"]["description"]);
        answer["result"]["value"].take()
    }

    /// Waits until an expression is true, testing it at each change of the page. Returns its value.
    pub(crate) async fn until(&mut self, what: &str, expression: &str) -> Value {
        let patience = Duration::as_millis(&PATIENCE);
        let promise = format!(
            "new Promise((found, missed) => {{
               const look = () => {{ const value = {expression}; if (value) {{ watcher.disconnect(); found(value); }} }};
               const watcher = new MutationObserver(look);
               watcher.observe(document, {{ subtree: true, childList: true, attributes: true, characterData: true }});
               setTimeout(() => missed(new Error('timed out; the page shows: ' + document.body.innerText)), {patience});
               look();
             }}) /* {what} */"
        );
        self.js(&promise).await
    }

    /// Clicks an element as soon as the page has it; `element` is a JavaScript expression.
    pub(crate) async fn click(&mut self, element: &str) {
        self.until(element, &format!("((found) => found && (found.click(), true))({element})")).await;
    }

    /// Presses a key: "Tab", "Enter", "Escape", an arrow key, "Home", "End", or a character.
    pub(crate) async fn press(&mut self, key: &str) {
        let code = match key {
            "Tab" => 9,
            "Enter" => 13,
            "Escape" => 27,
            "End" => 35,
            "Home" => 36,
            "ArrowLeft" => 37,
            "ArrowRight" => 39,
            character if character.len() == 1 => 0,
            other => panic!("no code for {other}"),
        };
        let text = match key {
            "Enter" => "\r",
            character if character.len() == 1 => character,
            _ => "",
        };
        let down = json!({ "type": if text.is_empty() { "rawKeyDown" } else { "keyDown" }, "key": key, "code": key,
            "windowsVirtualKeyCode": code, "text": text });
        self.call("Input.dispatchKeyEvent", down).await;
        let up = json!({ "type": "keyUp", "key": key, "code": key, "windowsVirtualKeyCode": code });
        self.call("Input.dispatchKeyEvent", up).await;
    }

    /// Moves the mouse to a place, with the left button down or not.
    pub(crate) async fn mouse(&mut self, kind: &str, (x, y): (f64, f64), clicks: u32) {
        let button = if clicks > 0 || kind == "mouseMoved" { "left" } else { "none" };
        let event = json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": clicks });
        self.call("Input.dispatchMouseEvent", event).await;
    }

    /// Types text into the focused field.
    pub(crate) async fn type_text(&mut self, text: &str) {
        self.call("Input.insertText", json!({ "text": text })).await;
    }

    pub(crate) async fn size(&mut self, width: u32, height: u32) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": false });
        self.call("Emulation.setDeviceMetricsOverride", size).await;
    }

    /// Sets the preferred colour scheme: "light" or "dark".
    pub(crate) async fn prefers(&mut self, scheme: &str) {
        let features = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        self.call("Emulation.setEmulatedMedia", features).await;
    }

    /// Writes a picture of the whole page as PNG.
    pub(crate) async fn picture(&mut self, path: &Path) {
        let picture = self.call("Page.captureScreenshot", json!({ "captureBeyondViewport": true })).await;
        std::fs::write(path, STANDARD.decode(picture["data"].as_str().unwrap()).unwrap()).unwrap();
    }

    /// Writes a picture of the upper part of the page as PNG.
    pub(crate) async fn picture_of_top(&mut self, path: &Path, width: f64, height: f64) {
        let clip = json!({ "x": 0, "y": 0, "width": width, "height": height, "scale": 1 });
        let asked = json!({ "captureBeyondViewport": true, "clip": clip });
        let picture = self.call("Page.captureScreenshot", asked).await;
        std::fs::write(path, STANDARD.decode(picture["data"].as_str().unwrap()).unwrap()).unwrap();
    }

    /// Errors of scripts, of loading, and of the security policy.
    pub(crate) fn problems(&self) -> Vec<String> {
        let problem = |(method, said): &(String, Value)| match method.as_str() {
            "Runtime.exceptionThrown" => Some(said["exceptionDetails"].to_string()),
            "Runtime.consoleAPICalled" if said["type"] == "error" => Some(said["args"].to_string()),
            "Log.entryAdded" if said["entry"]["level"] == "error" => Some(said["entry"].to_string()),
            _ => None,
        };
        self.heard.iter().filter_map(problem).collect()
    }

    /// All requested addresses.
    pub(crate) fn asked(&self) -> Vec<String> {
        let sent = self.heard.iter().filter(|(method, _)| method == "Network.requestWillBeSent");
        sent.filter_map(|(_, said)| said["request"]["url"].as_str().map(ToOwned::to_owned)).collect()
    }
}
