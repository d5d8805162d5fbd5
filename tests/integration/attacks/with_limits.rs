//! Runs the real program with a real broker and either database.

use std::net::SocketAddr;
use std::path::PathBuf;

use serde_json::Value;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Connection};
use tempfile::TempDir;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{Answer, send, try_get};

const PROGRAM: &str = env!("CARGO_BIN_EXE_vibrissa-under-test");

/// The database in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DatabaseKind {
    Sqlite,
    Postgres,
}

/// A supervisor of fleet `f` as a process.
pub(crate) struct Supervised {
    pub(crate) broker: Mosquitto,
    pub(crate) http: SocketAddr,
    pub(crate) folder: TempDir,
    postgres: Option<Postgres>,
    _process: Process,
}

impl Supervised {
    /// Starts everything and waits until the supervisor is ready.
    pub(crate) async fn start(kind: DatabaseKind, arguments: &[&str]) -> Self {
        Self::start_in(tempfile::tempdir().unwrap(), kind, arguments).await
    }

    /// The same with an existing folder, which may contain files.
    pub(crate) async fn start_in(folder: TempDir, kind: DatabaseKind, arguments: &[&str]) -> Self {
        // Limits of the shipped configuration.
        let broker = Mosquitto::builder().line("max_inflight_messages 65535").line("max_queued_bytes 67108864").start();
        let postgres = match kind {
            DatabaseKind::Sqlite => None,
            DatabaseKind::Postgres => Some(Postgres::start().await),
        };
        let database = match &postgres {
            None => format!("sqlite:{}", folder.path().join("v.sqlite3").display()),
            Some(server) => Postgres::url(server.port()),
        };
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let own = [
            "run".to_owned(),
            "--fleet=f".to_owned(),
            format!("--http={http}"),
            format!("--mqtt-url=mqtt://127.0.0.1:{}", broker.port()),
            format!("--database-url={database}"),
        ];
        let process = Process::start(Launch {
            program: program(),
            arguments: own.into_iter().chain(arguments.iter().map(ToString::to_string)).collect(),
            environment: vec![("RUST_LOG".to_owned(), "warn".to_owned())],
            log: folder.path().join("log"),
        });
        let supervised = Self { broker, http, folder, postgres, _process: process };
        until_true("the supervisor is ready", async || {
            matches!(try_get(http, "/readyz").await, Ok((200, _)))
                && supervised.metric("vibrissa_broker_connected{fleet=\"f\"}").await == 1.0
        })
        .await;
        supervised
    }

    pub(crate) fn port(&self) -> u16 {
        self.broker.port()
    }

    /// Value of a metric by name with labels; 0 if it does not exist.
    pub(crate) async fn metric(&self, name: &str) -> f64 {
        let (_, text) = try_get(self.http, "/metrics").await.unwrap();
        let value = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        value.map_or(0.0, |value| value.parse().unwrap())
    }

    /// Number of messages refused for this reason.
    pub(crate) async fn refused(&self, reason: &str) -> f64 {
        self.metric(&format!("vibrissa_messages_refused_total{{fleet=\"f\",reason=\"{reason}\"}}")).await
    }

    /// Texts that a query returns, in its order.
    pub(crate) async fn texts(&self, sql: &'static str) -> Vec<String> {
        match &self.postgres {
            None => {
                let file = self.folder.path().join("v.sqlite3");
                let mut link = SqliteConnectOptions::new().filename(file).read_only(true).connect().await.unwrap();
                let found = sqlx::query_scalar(sql).fetch_all(&mut link).await.unwrap();
                link.close().await.unwrap();
                found
            }
            Some(server) => {
                let mut link = server.connect().connect().await.unwrap();
                let found = sqlx::query_scalar(sql).fetch_all(&mut link).await.unwrap();
                link.close().await.unwrap();
                found
            }
        }
    }

    /// Names of the fleet's robots in the database.
    pub(crate) async fn robots(&self) -> Vec<String> {
        self.texts("SELECT robot FROM robots ORDER BY robot").await
    }

    /// Sends a request with a method, headers and an optional body.
    pub(crate) async fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)], body: Option<&Value>) -> Answer {
        send(self.http, method, path, headers, body).await.unwrap()
    }

    /// Runs a command of the program that asks this supervisor. Returns whether it succeeded, and its output.
    pub(crate) async fn command(&self, arguments: &[&str]) -> (bool, String) {
        let url = format!("http://{}", self.http);
        let mut command = tokio::process::Command::new(program());
        let output = command.args(arguments).env("VIBRISSA_URL", url).kill_on_drop(true).output().await.unwrap();
        let said = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap()).concat();
        (output.status.success(), said)
    }
}

/// Path of the program. `ATTACKED_PROGRAM` replaces it, for example by an older build on which an attack succeeds.
fn program() -> PathBuf {
    std::env::var_os("ATTACKED_PROGRAM").map_or_else(|| PROGRAM.into(), PathBuf::from)
}
