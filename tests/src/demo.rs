//! Runs `vibrissa-lab demo --serve --live` as a child process, and types its commands.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex};

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use tempfile::TempDir;

use crate::wait::{PATIENCE, found_within, until};
use crate::web::ask;

/// Name of the file with the demo's log, in its folder.
const LOG: &str = "log";

/// A running demo without its scripted part; killed on drop.
#[derive(Debug)]
pub struct LiveDemo {
    /// Address of its HTTP server.
    pub http: SocketAddr,
    /// URL of its broker.
    pub mqtt: String,
    child: Child,
    input: Option<ChildStdin>,
    printed: Arc<Mutex<Vec<String>>>,
    folder: TempDir,
}

impl LiveDemo {
    /// Starts the demo, and waits until it accepts commands.
    ///
    /// # Panics
    /// The program cannot be started, or it ends.
    pub async fn start(program: impl AsRef<Path>) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let mut child = Command::new(program.as_ref())
            .args(["demo", "--serve", "--live", "--folder"])
            .arg(folder.path())
            .env("RUST_LOG", "mqtt5=warn,rumqttc=warn,info")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(File::create(folder.path().join(LOG)).expect("a log"))
            .spawn()
            .expect("the program");
        let printed: Arc<Mutex<Vec<String>>> = Arc::default();
        let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        let kept = printed.clone();
        std::thread::spawn(move || {
            lines.map_while(Result::ok).for_each(|line| kept.lock().expect("no panic").push(line));
        });
        let input = child.stdin.take();
        let http = SocketAddr::from(([127, 0, 0, 1], 0));
        let mut demo = Self { http, mqtt: String::new(), child, input, printed, folder };
        let console = demo.prints("Console: http://").await;
        let address = console.trim_start_matches("Console: http://").trim_end_matches('/');
        let begun = demo.prints("over MQTT on ").await;
        let (_, after) = begun.split_once("over MQTT on ").expect("the broker");
        demo.mqtt = after.split(';').next().unwrap_or_default().to_owned();
        demo.http = address.parse().expect("an address");
        demo
    }

    /// Waits until a line with this text is printed, and returns it.
    pub async fn prints(&self, text: &str) -> String {
        let found = async || self.printed.lock().expect("no panic").iter().find(|line| line.contains(text)).cloned();
        until(text, found).await
    }

    /// Lines of its log so far.
    ///
    /// # Panics
    /// The log cannot be read.
    pub fn log(&self) -> Vec<String> {
        let text = std::fs::read_to_string(self.folder.path().join(LOG)).expect("the log");
        text.lines().map(str::to_owned).collect()
    }

    /// Types a line.
    ///
    /// # Panics
    /// The demo has ended, or its input is closed.
    pub fn type_line(&mut self, line: &str) {
        writeln!(self.input.as_mut().expect("an open input"), "{line}").expect("a running demo");
    }

    /// Closes the standard input of the demo.
    pub fn close_input(&mut self) {
        self.input = None;
    }

    /// Waits until a list of the API has an item for which `is_it` is true, and returns that item. It waits long: a demo may
    /// share its processors with a thousand robots and a browser.
    ///
    /// # Panics
    /// There is no such item in time; the message contains the list, the losses that the metrics count, and the
    /// whiskers of crawler-1.
    pub async fn item(&self, path: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let asked = async |path: &str| ask(self.http, "GET", path, &[]).await.map(|answer| answer.body);
        let look = async || {
            let items: Value = serde_json::from_str(&asked(path).await.ok()?).ok()?;
            items["items"].as_array()?.iter().find(|item| is_it(item)).cloned()
        };
        if let Some(found) = found_within(2 * PATIENCE, look).await {
            return found;
        }
        let whiskers = asked("/v1/whiskers?robot=crawler-1").await;
        let metrics = asked("/metrics").await.unwrap_or_default();
        let losses: Vec<_> = metrics.lines().filter(|line| line.contains("lost") && !line.starts_with('#')).collect();
        panic!(
            "timed out waiting for: {path}: {:?}; {losses:?}; whiskers of crawler-1: {whiskers:?}",
            asked(path).await
        );
    }

    /// Sends SIGINT, as Ctrl-C does.
    ///
    /// # Panics
    /// The demo has ended.
    pub fn interrupt(&self) {
        let pid = Pid::from_raw(i32::try_from(self.child.id()).expect("a process id"));
        kill(pid, Signal::SIGINT).expect("our process");
    }

    /// Waits for the end of the demo.
    pub async fn ended(&mut self) -> ExitStatus {
        until("the end of the demo", async || self.child.try_wait().expect("our process")).await
    }
}

impl Drop for LiveDemo {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
