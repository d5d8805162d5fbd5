//! Runs the program as a process with a private Mosquitto and database.

use std::net::SocketAddr;
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until;
use vibrissa_tests::web::try_get;

use crate::with_limits::DatabaseKind;

/// A supervisor of fleet `f` with its broker and database.
pub(crate) struct Stage {
    pub(crate) broker: Mosquitto,
    pub(crate) server: Option<Postgres>,
    pub(crate) process: Process,
    pub(crate) http: SocketAddr,
    pub(crate) folder: TempDir,
}

impl Stage {
    /// Starts all programs and waits until the supervisor is ready.
    pub(crate) async fn start(kind: DatabaseKind) -> Self {
        let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
        let server = match kind {
            DatabaseKind::Sqlite => None,
            DatabaseKind::Postgres => Some(Postgres::start().await),
        };
        let database = match &server {
            Some(server) => Postgres::url(server.port()),
            None => format!("sqlite:{}", folder.path().join("v.sqlite3").display()),
        };
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let (mqtt, listen) = (format!("mqtt://127.0.0.1:{}", broker.port()), http.to_string());
        let arguments =
            ["run", "--fleets", "f", "--database-url", &database, "--mqtt-url", &mqtt, "--http-listen", &listen];
        let launch = Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.map(ToOwned::to_owned).to_vec(),
            environment: vec![("RUST_LOG".to_owned(), "info".to_owned())],
            log: folder.path().join("log"),
        };
        let stage = Self { broker, server, process: Process::start(launch), http, folder };
        stage.ready().await;
        stage
    }

    /// Waits until the supervisor is ready.
    pub(crate) async fn ready(&self) {
        until("the supervisor is ready", async || {
            try_get(self.http, "/readyz").await.ok().filter(|(status, _)| *status == 200)
        })
        .await;
    }

    /// Value of a series in `/metrics`; 0 if it does not exist.
    pub(crate) async fn metric(&self, series: &str) -> f64 {
        let (_, text) = try_get(self.http, "/metrics").await.unwrap();
        let line = text.lines().find(|line| line.rsplit_once(' ').is_some_and(|(name, _)| name == series));
        line.and_then(|line| line.rsplit_once(' ')).map_or(0.0, |(_, value)| value.parse().unwrap())
    }

    /// GETs a path of the API. Returns the JSON of an answer 200.
    pub(crate) async fn get(&self, path: &str) -> Value {
        let (status, body) = try_get(self.http, path).await.unwrap();
        assert_eq!(status, 200, "{path}: {body}");
        serde_json::from_str(&body).unwrap()
    }

    /// The program's log so far.
    pub(crate) fn log(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("log")).unwrap()
    }

    /// Stops the program in an orderly way.
    pub(crate) async fn stop(mut self) {
        self.process.signal(nix::sys::signal::Signal::SIGTERM);
        let ended = self.process.ended(Duration::from_secs(20)).await;
        assert!(ended.is_some_and(|status| status.success()), "{}", self.log());
    }
}
