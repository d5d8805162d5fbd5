//! The shipped examples of proxies, each below a path and with compression, with the real programs.

use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;

use serde_json::json;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use url::Url;
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::wait::until;
use vibrissa_tests::web::{Answer, ask, open, send};

use crate::served::Served;
use crate::sign_in::{Attempt, Provider, cookie};

const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../deploy/proxies");
const TOKEN: &str = "a-token-of-more-than-32-characters-for-the-test";
static BEARER: LazyLock<String> = LazyLock::new(|| format!("Bearer {TOKEN}"));

/// A running proxy, stopped on drop.
struct Proxy {
    process: Child,
    address: SocketAddr,
    _folder: TempDir,
}

impl Drop for Proxy {
    fn drop(&mut self) {
        let pid = nix::unistd::Pid::from_raw(self.process.id().cast_signed());
        // nginx and Apache end their workers at this signal.
        let _ = nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGTERM);
        let _ = self.process.wait();
    }
}

/// The shipped example for another port, and without TLS.
fn example(name: &str, port: u16, supervisor: SocketAddr) -> String {
    let text = std::fs::read_to_string(Path::new(EXAMPLES).join(name)).unwrap();
    let lines = text.lines().filter(|line| !line.trim_start().to_ascii_lowercase().starts_with("ssl"));
    let text: String = lines.flat_map(|line| [line, "\n"]).collect();
    let mut changed = text.replace("127.0.0.1:8080", &supervisor.to_string());
    for (real, here) in [
        ("listen 443 ssl", format!("listen 127.0.0.1:{port}")),
        ("<VirtualHost *:443>", format!("<VirtualHost *:{port}>")),
        ("\nvibrissa.example {", format!("\nhttp://127.0.0.1:{port} {{\n\tencode gzip")),
    ] {
        changed = changed.replace(real, &here);
    }
    assert!(changed.contains(&port.to_string()) && changed.contains(&supervisor.to_string()), "{changed}");
    changed
}

/// Settings around the example, as a distribution has them: with compression of everything.
fn whole(name: &str, example: &str, folder: &str, port: u16) -> String {
    match name {
        "nginx.conf" => format!(
            "user root;\nworker_processes 1;\npid {folder}/pid;\nevents {{}}\nhttp {{\naccess_log off;\n\
             client_body_temp_path {folder}/body;\nproxy_temp_path {folder}/proxy;\nfastcgi_temp_path {folder}/fastcgi;\n\
             uwsgi_temp_path {folder}/uwsgi;\nscgi_temp_path {folder}/scgi;\n\
             gzip on;\ngzip_proxied any;\ngzip_min_length 1;\ngzip_types *;\n{example}}}\n"
        ),
        "apache.conf" => {
            let modules = ["mpm_event", "authz_core", "alias", "filter", "deflate", "proxy", "proxy_http"];
            let load = |name: &&str| format!("LoadModule {name}_module /usr/lib/apache2/modules/mod_{name}.so\n");
            let modules: String = modules.iter().map(load).collect();
            format!(
                "ServerRoot {folder}\nServerName localhost\nListen 127.0.0.1:{port}\nPidFile {folder}/pid\n\
                 DefaultRuntimeDir {folder}\nErrorLog {folder}/errors\nUser www-data\nGroup www-data\n\
                 {modules}AddOutputFilterByType DEFLATE application/json\n{example}"
            )
        }
        _ => format!("{{\n\tadmin off\n\tauto_https off\n}}\n{example}"),
    }
}

async fn start(name: &str, supervisor: SocketAddr) -> Proxy {
    start_at(name, free_port(), supervisor).await
}

async fn start_at(name: &str, port: u16, supervisor: SocketAddr) -> Proxy {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().to_str().unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, whole(name, &example(name, port, supervisor), place, port)).unwrap();
    let (program, arguments): (&str, &[&str]) = match name {
        "nginx.conf" => ("/usr/sbin/nginx", &["-e", "errors", "-g", "daemon off;", "-p", place, "-c"]),
        "apache.conf" => ("/usr/sbin/apache2", &["-D", "FOREGROUND", "-f"]),
        _ => ("caddy", &["run", "--adapter", "caddyfile", "--config"]),
    };
    let mut command = Command::new(program);
    command.args(arguments).arg(&file).env("HOME", place).env("XDG_DATA_HOME", place).env("XDG_CONFIG_HOME", place);
    let log = std::fs::File::create(folder.path().join("log")).unwrap();
    let process = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(log).spawn();
    let process = process.unwrap_or_else(|problem| panic!("{program} must be installed: {problem}"));
    let proxy = Proxy { process, address: ([127, 0, 0, 1], port).into(), _folder: folder };
    until("the proxy's answer", async || ask(proxy.address, "GET", "/vibrissa", &[]).await.ok()).await;
    proxy
}

async fn sent(proxy: &Proxy, method: &str, path: &str, tag: &str, body: Option<&serde_json::Value>) -> Answer {
    let headers = [("Authorization", BEARER.as_str()), ("If-Match", tag)];
    send(proxy.address, method, &format!("/vibrissa{path}"), &headers, body).await.unwrap()
}

/// `ETag` of a compressed answer.
async fn compressed_tag(proxy: &Proxy, path: &str) -> String {
    let mut stream = TcpStream::connect(proxy.address).await.unwrap();
    let request = format!(
        "GET /vibrissa{path} HTTP/1.1\r\nHost: {}\r\nAuthorization: {}\r\nAccept-Encoding: gzip\r\nConnection: close\r\n\r\n",
        proxy.address, *BEARER
    );
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).await.unwrap();
    let head = String::from_utf8_lossy(&answer).into_owned();
    let lines = head.lines().take_while(|line| !line.is_empty()).filter_map(|line| line.split_once(": "));
    let tag = lines.filter(|(name, _)| name.eq_ignore_ascii_case("etag")).map(|(_, tag)| tag.to_owned()).next();
    tag.unwrap_or_else(|| panic!("no ETag: {head}"))
}

async fn regress_works_behind(name: &str) {
    let served = Served::to(&AccessOptions { token: Some(Secret::new(TOKEN)), oidc: None }).await;
    let proxy = start(name, served.http).await;
    let page = sent(&proxy, "GET", "/", "*", None).await;
    assert!(page.status == 200 && page.body.contains("src=\"console/main.js\""), "{page:?}");
    assert_eq!(sent(&proxy, "GET", "/console/main.js", "*", None).await.status, 200);
    let bare = ask(proxy.address, "GET", "/vibrissa", &[]).await.unwrap();
    assert!(bare.status == 308 && bare.headers["location"].ends_with("/vibrissa/"), "{bare:?}");
    let runbooks = ask(proxy.address, "GET", "/vibrissa/runbooks", &[]).await.unwrap();
    assert!(runbooks.headers["location"].ends_with("/vibrissa/runbooks/README.md"), "{runbooks:?}");
    let list = ask(proxy.address, "GET", "/vibrissa/v1/whiskers?limit=1", &[("Authorization", BEARER.as_str())])
        .await
        .unwrap();
    assert!(list.headers["link"].starts_with("<?limit=1&cursor="), "{list:?}");

    // Events arrive while they happen.
    let bearer = [("Authorization", BEARER.as_str()), ("Accept-Encoding", "gzip")];
    let (status, mut events) = open(proxy.address, "/vibrissa/v1/events", &bearer).await.unwrap();
    assert_eq!(status, 200);
    let alarms = sent(&proxy, "GET", "/v1/alarms?fleet=f&standing=true", "*", None).await.json();
    let path = format!("/v1/alarms/{}/acknowledge", alarms["items"][0]["alarm_id"]);
    let origin = format!("http://{}", proxy.address);
    let headers = [("Authorization", BEARER.as_str()), ("Origin", origin.as_str())];
    let done = send(proxy.address, "POST", &format!("/vibrissa{path}"), &headers, None).await.unwrap();
    assert_eq!(done.status, 200, "{}", done.body);
    let event = tokio::time::timeout(vibrissa_tests::wait::PATIENCE, events.next()).await;
    assert_eq!(event.expect("the proxy must pass the event on").unwrap().unwrap().event, "change");

    // The tag of a compressed answer is accepted, and only that of the version in force.
    let path = "/v1/fleets/f/allowed-robots";
    let tag = compressed_tag(&proxy, path).await;
    let body = json!({ "robots": ["r1"] });
    let put = sent(&proxy, "PUT", path, &tag, Some(&body)).await;
    assert_eq!(put.status, 200, "{tag}: {}", put.body);
    assert_eq!(sent(&proxy, "PUT", path, &tag, Some(&body)).await.status, 412, "{tag} is of an older version");
}

async fn regress_people_sign_in_behind(name: &str) {
    let (provider, port) = (Provider::start().await, free_port());
    let public = format!("http://127.0.0.1:{port}/vibrissa");
    let served = provider.served_at(&public).await;
    let proxy = start_at(name, port, served.http).await;
    let attempt = Attempt::begin_at(proxy.address, "/vibrissa", "%23/robots").await;
    assert_eq!(attempt.redirect_uri, format!("{public}/auth/callback"));
    provider.gives_operator(&attempt.nonce);
    let path = format!("/vibrissa/auth/callback?code=c&state={}", attempt.state);
    let back = ask(proxy.address, "GET", &path, &[("Cookie", attempt.cookie.as_str())]).await.unwrap();
    assert!(back.status == 303 && back.headers["location"].ends_with("/vibrissa/#/robots"), "{back:?}");
    let session = cookie(&back);
    // Other services of the host do not get it.
    assert!(back.headers["set-cookie"].contains("; Path=/vibrissa; "), "{back:?}");
    let headers = [("Cookie", session.as_str())];
    assert_eq!(ask(proxy.address, "GET", "/vibrissa/v1/me", &headers).await.unwrap().status, 200);
    // What a problem refers to is found below the path.
    let problem = ask(proxy.address, "GET", "/vibrissa/v1/fleets/f/robots/none", &headers).await.unwrap().json();
    assert_eq!(problem["instance"], "/vibrissa/v1/fleets/f/robots/none", "{problem}");
    let of_type = problem["type"].as_str().unwrap();
    let explained = ask(proxy.address, "GET", of_type, &headers).await.unwrap();
    assert!(explained.status == 200 && explained.json()["type"] == *of_type, "{problem}: {explained:?}");
    let alarms = ask(proxy.address, "GET", "/vibrissa/v1/alarms?fleet=f&limit=1", &headers).await.unwrap().json();
    let runbook = alarms["items"][0]["runbook_url"].as_str().unwrap();
    assert_eq!(ask(proxy.address, "GET", runbook, &headers).await.unwrap().status, 200, "{runbook}");

    let origin = format!("http://{}", proxy.address);
    let headers = [("Cookie", session.as_str()), ("Origin", origin.as_str())];
    let out = ask(proxy.address, "POST", "/vibrissa/auth/sign-out", &headers).await.unwrap();
    let end: Url = out.json()["end_session_url"].as_str().unwrap().parse().unwrap();
    let led = end.query_pairs().find(|(name, _)| name == "post_logout_redirect_uri").unwrap().1.into_owned();
    assert_eq!(led, format!("{public}/"));
    assert_eq!(ask(proxy.address, "GET", "/vibrissa/v1/me", &headers).await.unwrap().status, 401, "signed out");
}

#[tokio::test]
async fn regress_everything_works_behind_nginx() {
    regress_works_behind("nginx.conf").await;
    regress_people_sign_in_behind("nginx.conf").await;
}

#[tokio::test]
async fn regress_everything_works_behind_apache() {
    regress_works_behind("apache.conf").await;
    regress_people_sign_in_behind("apache.conf").await;
}

#[tokio::test]
async fn regress_everything_works_behind_caddy() {
    regress_works_behind("Caddyfile").await;
    regress_people_sign_in_behind("Caddyfile").await;
}
