//! The program as a process, with Mosquitto and either database: its answers, its log and its records.

use std::collections::BTreeMap;
use std::net::SocketAddr;

use serde_json::json;
use sqlx::postgres::PgConnection;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{ConnectOptions, Connection};
use tempfile::TempDir;
use vibrissa_protocol::ArrayType;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

/// Contacts until a whisker counts as learned; few, so that tests are fast.
pub(crate) const LEARNED: usize = 60;

/// A supervisor of fleet `f`. Between it and the broker is a proxy.
pub(crate) struct Supervised {
    pub(crate) proxy: Proxy,
    process: Process,
    broker: Mosquitto,
    postgres: Option<Postgres>,
    http: SocketAddr,
    folder: TempDir,
}

impl Supervised {
    pub(crate) async fn on_sqlite() -> Self {
        Self::on(None).await
    }

    pub(crate) async fn on_postgres() -> Self {
        Self::on(Some(Postgres::start().await)).await
    }

    async fn on(postgres: Option<Postgres>) -> Self {
        let (folder, broker) = (tempfile::tempdir().unwrap(), Mosquitto::start());
        let proxy = Proxy::to(broker.port()).await;
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let database = match &postgres {
            Some(server) => Postgres::url(server.port()),
            None => format!("sqlite:{}", folder.path().join("v.sqlite3").display()),
        };
        let arguments = [
            "run",
            "--fleet",
            "f",
            "--http-listen",
            &http.to_string(),
            "--mqtt-url",
            &format!("mqtt://127.0.0.1:{}", proxy.port()),
            "--database-url",
            &database,
            "--detection-cold-start-contacts",
            &LEARNED.to_string(),
        ];
        let launch = Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.iter().map(|&argument| argument.to_owned()).collect(),
            environment: vec![
                ("RUST_LOG".to_owned(), "warn".to_owned()),
                ("VIBRISSA_TEST_CLOCK_FILE".to_owned(), folder.path().join("clock").display().to_string()),
            ],
            log: folder.path().join("log"),
        };
        let one = Self { proxy, process: Process::start(launch), broker, postgres, http, folder };
        one.is_ready().await;
        one
    }

    /// Waits until the supervisor is ready.
    pub(crate) async fn is_ready(&self) {
        until_true("a supervisor that is ready", async || self.answers("/readyz").await.is_some()).await;
    }

    /// Body of a successful answer.
    pub(crate) async fn answers(&self, path: &str) -> Option<String> {
        try_get(self.http, path).await.ok().filter(|(status, _)| *status == 200).map(|(_, body)| body)
    }

    /// Kills the supervisor, as a power failure would, and starts it again.
    pub(crate) async fn restart(&mut self) {
        self.begin_again();
        self.is_ready().await;
    }

    /// As [`Self::restart`], without waiting until it is ready.
    pub(crate) fn begin_again(&mut self) {
        self.process.kill();
        self.process.restart();
    }

    /// Sets the clock of the supervisor's host so far ahead of the true time, in microseconds.
    pub(crate) fn set_host_clock(&self, ahead_us: i64) {
        let (file, new) = (self.folder.path().join("clock"), self.folder.path().join("clock.new"));
        std::fs::write(&new, ahead_us.to_string()).unwrap();
        std::fs::rename(new, file).unwrap();
    }

    /// The body of `/readyz`, whatever its status.
    pub(crate) async fn readiness(&self) -> String {
        try_get(self.http, "/readyz").await.map(|(_, body)| body).unwrap_or_default()
    }

    /// Whether it shares its database with others.
    pub(crate) fn is_shared(&self) -> bool {
        self.postgres.is_some()
    }

    /// A robot with two whiskers. Waits until its first message is accepted.
    pub(crate) async fn robot(&self, name: &str) -> HandRobot {
        HandRobot::born(self.broker.port(), name, array(ArrayType::Type2, &[70.0, 69.3])).await
    }

    /// Counts of refused messages by reason, without zeros.
    pub(crate) async fn refused(&self) -> BTreeMap<String, f64> {
        let before = "vibrissa_messages_refused_total{fleet=\"f\",reason=\"";
        let counted = |line: &str| {
            let (reason, count) = line.strip_prefix(before)?.split_once("\"} ")?;
            let count: f64 = count.parse().ok()?;
            (count > 0.0).then(|| (reason.to_owned(), count))
        };
        self.answers("/metrics").await.expect("metrics").lines().filter_map(counted).collect()
    }

    /// Waits until exactly these messages were refused.
    pub(crate) async fn has_refused(&self, reasons: &[(&str, f64)]) {
        let expected: BTreeMap<String, f64> =
            reasons.iter().map(|&(reason, count)| (reason.to_owned(), count)).collect();
        until_true(&format!("refused: {expected:?}"), async || self.refused().await == expected).await;
    }

    /// Value of a metric by name with labels.
    pub(crate) async fn metric(&self, name: &str) -> f64 {
        let metrics = self.answers("/metrics").await.expect("metrics");
        let value = metrics.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' ')?.parse().ok());
        value.unwrap_or_default()
    }

    /// Result of a query for one number.
    pub(crate) async fn number(&self, sql: &'static str) -> i64 {
        match &self.postgres {
            Some(server) => {
                let mut link: PgConnection = server.connect().connect().await.unwrap();
                sqlx::query_scalar(sql).fetch_one(&mut link).await.unwrap()
            }
            None => {
                let path = self.folder.path().join("v.sqlite3");
                let options = SqliteConnectOptions::new().filename(path).read_only(true);
                let mut link = SqliteConnection::connect_with(&options).await.unwrap();
                sqlx::query_scalar(sql).fetch_one(&mut link).await.unwrap()
            }
        }
    }

    /// Sets the pressure of a whisker of robot `r` as an operator.
    pub(crate) async fn set_by_hand(&self, whisker: u16, pressure_mpa: f64) {
        let path = format!("/v1/fleets/f/robots/r/arrays/left/whiskers/{whisker}/setpoint");
        let body = json!({ "pressure_mpa": pressure_mpa, "reason": "a test" });
        let answer = send(self.http, "POST", &path, &[], Some(&body)).await.unwrap();
        assert_eq!(answer.status / 100, 2, "{}", answer.body);
    }

    /// Number of log lines that contain this text.
    pub(crate) fn logged(&self, text: &str) -> usize {
        std::fs::read_to_string(self.folder.path().join("log")).unwrap().matches(text).count()
    }
}
