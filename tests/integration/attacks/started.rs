//! Runs `vibrissa run` as a process on free ports with the embedded broker, on either database.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc;

use tempfile::TempDir;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::wait::{PATIENCE, until};
use vibrissa_tests::web::{Answer, ask};

/// Path of the program under test.
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_vibrissa-under-test");
/// A token with all rights.
pub(crate) const ROOT: &str = "a-token-of-more-than-32-characters-for-the-test";

/// An empty database and a folder for files.
pub(crate) struct EmptyDatabase {
    pub(crate) folder: TempDir,
    pub(crate) database_url: String,
    _server: Option<Postgres>,
}

impl EmptyDatabase {
    pub(crate) fn sqlite() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let database_url = format!("sqlite:{}", folder.path().join("v.sqlite3").display());
        Self { folder, database_url, _server: None }
    }

    pub(crate) async fn postgres() -> Self {
        let server = Postgres::start().await;
        let database_url = Postgres::url(server.port());
        Self { folder: tempfile::tempdir().unwrap(), database_url, _server: Some(server) }
    }

    /// Runs a command of the program with this database.
    pub(crate) fn command(&self, arguments: &[&str]) -> Output {
        let mut command = assert_cmd::Command::new(PROGRAM);
        command.args(arguments).args(["--database-url", &self.database_url]).timeout(PATIENCE).output().unwrap()
    }

    /// Creates a token.
    pub(crate) fn token(&self, role: &str, scope: &[&str]) -> String {
        let made = self.command(&[&["token", "create", "--role", role], scope].concat());
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
        String::from_utf8(made.stdout).unwrap().trim().to_owned()
    }

    /// Starts a supervisor and waits until it prints its HTTP address.
    pub(crate) fn start(&self, arguments: &[&str]) -> Started {
        let log = self.folder.path().join("log");
        let mut process = Command::new(PROGRAM)
            .args(["run", "--mqtt-port", "0", "--database-url", &self.database_url])
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(File::create(&log).unwrap())
            .spawn()
            .unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let (said, says) = mpsc::channel();
        std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| said.send(line)));
        let line = says.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("it does not start: {}", read(&log)));
        let http = line.rsplit_once("http://").unwrap_or_else(|| panic!("no address: {line}")).1.parse().unwrap();
        Started { process, http, log }
    }

    /// The same with [`ROOT`] as a token with all rights.
    pub(crate) fn start_closed(&self, arguments: &[&str]) -> Started {
        let file = self.folder.path().join("token");
        std::fs::write(&file, ROOT).unwrap();
        let file = file.display().to_string();
        // The embedded broker needs a password then; here nobody uses it.
        let mqtt = ["--mqtt-username", "robots", "--mqtt-password-file", &file];
        self.start(&[&["--http", "127.0.0.1:0", "--http-token-file", &file], &mqtt[..], arguments].concat())
    }
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

/// A running program, killed on drop.
pub(crate) struct Started {
    process: Child,
    pub(crate) http: SocketAddr,
    log: PathBuf,
}

impl Drop for Started {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Started {
    /// The log so far.
    pub(crate) fn log(&self) -> String {
        read(&self.log)
    }

    /// Waits until it owns all of these fleets.
    pub(crate) async fn owns(&self, fleets: &[&str]) {
        until("the fleets", async || {
            let answer = ask(self.http, "GET", "/readyz", &[]).await.ok()?;
            let body = answer.json();
            let is_owned = |fleet: &&str| {
                body["fleets"].to_string().contains(fleet) && body["fleets"].to_string().contains("OWNED")
            };
            (answer.status == 200 && fleets.iter().all(is_owned)).then_some(())
        })
        .await;
    }

    pub(crate) async fn get(&self, path: &str, headers: &[(&str, &str)]) -> Answer {
        ask(self.http, "GET", path, headers).await.unwrap()
    }

    /// Statuses of requests sent over one connection; each head is given without its last lines.
    pub(crate) async fn statuses(&self, heads: &[String]) -> Vec<u16> {
        let stream = TcpStream::connect(self.http).await.unwrap();
        let (mut from, mut to) = stream.into_split();
        let (last, others) = heads.split_last().unwrap();
        let mut text: String = others.iter().map(|head| format!("{head}Host: {}\r\n\r\n", self.http)).collect();
        text.push_str(&format!("{last}Host: {}\r\nConnection: close\r\n\r\n", self.http));
        let writing = tokio::spawn(async move {
            to.write_all(text.as_bytes()).await.unwrap();
            to
        });
        let mut answers = Vec::new();
        from.read_to_end(&mut answers).await.unwrap();
        writing.await.unwrap();
        let answers = String::from_utf8_lossy(&answers);
        answers.split("HTTP/1.1 ").skip(1).map(|answer| answer[..3].parse().unwrap()).collect()
    }
}
