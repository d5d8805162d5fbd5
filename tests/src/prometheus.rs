//! Runs a private Prometheus on a free port with its data in a temporary folder.

use std::fs::File;
use std::io;
use std::process::{Child, Command, Stdio};

use serde_json::Value;
use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::mosquitto::free_port;
use crate::wait;

/// A running server, killed on drop.
#[derive(Debug)]
pub struct Prometheus {
    process: Child,
    port: u16,
    folder: TempDir,
}

impl Prometheus {
    /// Starts the server with this configuration and waits until it is ready.
    ///
    /// # Panics
    /// Prometheus is not installed, or does not start.
    pub async fn start(configuration: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("prometheus.yml"), configuration).expect("a folder of ours");
        let log = File::create(folder.path().join("log")).expect("a log");
        let port = free_port();
        let process = Command::new("prometheus")
            .args(["--config.file=prometheus.yml", "--storage.tsdb.path=data"])
            .arg(format!("--web.listen-address=127.0.0.1:{port}"))
            .current_dir(folder.path())
            .stdout(Stdio::null())
            .stderr(log)
            .spawn()
            .expect("Prometheus must be installed for this test");
        let mut server = Self { process, port, folder };
        wait::until("Prometheus' readiness", async || {
            let ended = server.process.try_wait().expect("our process");
            assert!(ended.is_none(), "Prometheus ended: {}", server.log());
            get(server.port, "/-/ready").await.ok().filter(|(status, _)| *status == 200)
        })
        .await;
        server
    }

    /// The data of an answer of its API, for example of `query` with parameters.
    ///
    /// # Errors
    /// Prometheus refuses the request; the text is its reason.
    ///
    /// # Panics
    /// Prometheus does not answer.
    pub async fn ask(&self, what: &str, parameters: &[(&str, &str)]) -> Result<Value, String> {
        let parameters: Vec<String> =
            parameters.iter().map(|(name, value)| format!("{}={}", escaped(name), escaped(value))).collect();
        let path = format!("/api/v1/{what}?{}", parameters.join("&"));
        let (_, body) = get(self.port, &path).await.unwrap_or_else(|problem| panic!("{problem}: {}", self.log()));
        let answer: Value = serde_json::from_str(&body).unwrap_or_else(|problem| panic!("{problem}: {body}"));
        match answer["status"].as_str() {
            Some("success") => Ok(answer["data"].clone()),
            _ => Err(answer["error"].as_str().unwrap_or(&body).to_owned()),
        }
    }

    /// The server's log.
    fn log(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }
}

impl Drop for Prometheus {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Status and body of an answer. HTTP/1.0 avoids chunked answers.
async fn get(port: u16, path: &str) -> io::Result<(u16, String)> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).await?;
    stream.write_all(format!("GET {path} HTTP/1.0\r\n\r\n").as_bytes()).await?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await?;
    let bad = || io::Error::other(format!("no HTTP: {answer}"));
    let (head, body) = answer.split_once("\r\n\r\n").ok_or_else(bad)?;
    let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).ok_or_else(bad)?;
    Ok((status, body.to_owned()))
}

/// Escapes text for use in a URL.
fn escaped(text: &str) -> String {
    let one = |byte: u8| match byte {
        b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => char::from(byte).to_string(),
        other => format!("%{other:02X}"),
    };
    text.bytes().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn it_answers_and_says_what_it_refuses() {
        let server = Prometheus::start("").await;
        let data = server.ask("query", &[("query", r#"label_replace(vector(1) + 1, "of", "a&b=c +ä", "", "")"#)]).await;
        let series = &data.unwrap()["result"][0];
        assert_eq!((&series["metric"]["of"], &series["value"][1]), (&"a&b=c +ä".into(), &"2".into()));
        assert!(server.ask("query", &[("query", "rate(x)")]).await.unwrap_err().contains("expected type range vector"));
    }
}
