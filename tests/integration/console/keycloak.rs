//! A real identity provider: Keycloak with the realm of `tests/data/keycloak`.

use std::io::Write as _;
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, killpg};
use nix::unistd::Pid;
use serde_json::Value;
use std::io::Read as _;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::web::ask;

/// It needs 25 s of a quiet machine, and several times as long on a busy one.
const START_PATIENCE: Duration = Duration::from_secs(400);
/// Its administrator, who exists only in this test.
const ADMIN: &str = "admin-of-this-test";

/// A running Keycloak, stopped on drop.
pub(crate) struct Keycloak {
    process: Child,
    port: u16,
}

impl Drop for Keycloak {
    fn drop(&mut self) {
        // The script and its Java process are a group of their own.
        let _ = killpg(Pid::from_raw(self.process.id() as i32), Signal::SIGKILL);
        let _ = self.process.wait();
    }
}

impl Keycloak {
    /// Starts it, or says why it cannot be had.
    pub(crate) async fn start(folder: &Path) -> Result<Self, String> {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/keycloak");
        let got = Command::new(script).output().map_err(|problem| problem.to_string())?;
        if !got.status.success() {
            return Err(String::from_utf8_lossy(&got.stderr).trim().to_owned());
        }
        let home = String::from_utf8(got.stdout).unwrap().trim().to_owned();
        let (port, management) = (free_port(), free_port());
        let log = std::fs::File::create(folder.join("keycloak.log")).unwrap();
        let process = Command::new(format!("{home}/bin/kc.sh"))
            .args(["start", "--optimized", "--http-enabled=true", "--http-host=127.0.0.1", "--hostname-strict=false"])
            .args([format!("--http-port={port}"), format!("--http-management-port={management}")])
            .arg("--import-realm")
            .env("KC_BOOTSTRAP_ADMIN_USERNAME", ADMIN)
            .env("KC_BOOTSTRAP_ADMIN_PASSWORD", ADMIN)
            .env("JAVA_OPTS_KC_HEAP", "-Xms128m -Xmx512m")
            // A short life: the second compiler never pays off.
            .env("JAVA_OPTS_APPEND", "-XX:TieredStopAtLevel=1")
            .stdin(Stdio::null())
            .stdout(log.try_clone().unwrap())
            .stderr(log)
            .process_group(0)
            .spawn()
            .map_err(|problem| problem.to_string())?;
        let mut keycloak = Self { process, port };
        let deadline = Instant::now() + START_PATIENCE;
        let path = "/realms/robots/.well-known/openid-configuration";
        while !ask(([127, 0, 0, 1], port).into(), "GET", path, &[]).await.is_ok_and(|answer| answer.status == 200) {
            let log = || std::fs::read_to_string(folder.join("keycloak.log")).unwrap_or_default();
            let has_ended = keycloak.process.try_wait().unwrap().is_some();
            assert!(!has_ended && Instant::now() < deadline, "Keycloak does not start: {}", log());
            tokio::time::sleep(Duration::from_millis(500)).await;
        }
        Ok(keycloak)
    }

    /// The issuer: another site than the console, which is at 127.0.0.1.
    pub(crate) fn issuer(&self) -> String {
        format!("http://localhost:{}/realms/robots", self.port)
    }

    /// Ends all sessions of the realm, as an administrator of the provider does.
    pub(crate) fn end_all_sessions(&self) {
        let form = format!("grant_type=password&client_id=admin-cli&username={ADMIN}&password={ADMIN}");
        let answer = self.post("/realms/master/protocol/openid-connect/token", &form, "");
        let body = answer.split_once("\r\n\r\n").unwrap().1;
        let json = &body[body.find('{').unwrap()..=body.rfind('}').unwrap()];
        let token: Value = serde_json::from_str(json).unwrap();
        let bearer = format!("Authorization: Bearer {}\r\n", token["access_token"].as_str().unwrap());
        let answer = self.post("/admin/realms/robots/logout-all", "", &bearer);
        assert!(matches!(answer.split(' ').nth(1), Some("200" | "204")), "{answer}");
    }

    fn post(&self, path: &str, form: &str, headers: &str) -> String {
        let mut stream = std::net::TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        let request = format!(
            "POST {path} HTTP/1.0\r\nHost: localhost:{}\r\n{headers}Content-Type: application/x-www-form-urlencoded\r\n\
             Content-Length: {}\r\n\r\n{form}",
            self.port,
            form.len()
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }
}
