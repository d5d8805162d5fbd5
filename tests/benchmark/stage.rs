//! Sets up the programs under test: the shipped broker, databases, and supervisors as child processes.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use nix::sys::signal::Signal;
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Connection, Row, SqliteConnection};
use tempfile::TempDir;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::web;

const SHIPPED: &str = include_str!("../../deploy/mosquitto/mosquitto.conf");
/// Settings of the shipped broker that control access.
const ACCESS: [&str; 5] =
    ["per_listener_settings ", "allow_anonymous ", "password_file ", "acl_file ", "use_username_as_clientid "];
/// Time limit of a start with many whiskers.
const READY_PATIENCE: Duration = Duration::from_secs(120);
const READY_PAUSE: Duration = Duration::from_millis(5);
const END_PATIENCE: Duration = Duration::from_secs(30);

/// The program under test and the folder of its files.
pub struct Stage {
    /// Path of the program `vibrissa`.
    pub program: PathBuf,
    /// Temporary folder for the supervisors' logs and SQLite databases.
    pub folder: TempDir,
}

/// A broker with the shipped settings except access control: passwords and the access list would cost both sides the
/// same.
pub fn broker() -> Mosquitto {
    let is_access = |line: &&str| ACCESS.iter().any(|setting| line.starts_with(setting));
    let lines: Vec<&str> = SHIPPED.lines().filter(|line| !is_access(line)).chain(["allow_anonymous true"]).collect();
    tokio::task::block_in_place(|| Mosquitto::builder().file(&lines.join("\n")).start())
}

/// Database of a supervisor.
pub enum Store {
    /// A private PostgreSQL server.
    Postgres(Postgres),
    /// Path of a SQLite file.
    Sqlite(PathBuf),
}

/// Contacts recorded of one boot of the robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Recorded {
    /// Number of contact rows.
    pub rows: i64,
    /// Number of different contacts among them.
    pub distinct: i64,
}

const ROWS: &str = "SELECT count(*) FROM contacts WHERE boot IN (SELECT boot FROM boots WHERE boot_id = $1)";
const DISTINCT: &str = "SELECT count(*) FROM (SELECT DISTINCT boot, seq, position FROM contacts \
                        WHERE boot IN (SELECT boot FROM boots WHERE boot_id = $1)) AS one";

impl Store {
    /// Starts a new, empty PostgreSQL server.
    pub async fn postgres() -> Self {
        let server = Postgres::start().await;
        server.synchronise().await;
        Self::Postgres(server)
    }

    /// Name of the database for the tables.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Postgres(_) => "PostgreSQL",
            Self::Sqlite(_) => "SQLite",
        }
    }

    /// URL for the supervisor's configuration.
    fn url(&self) -> String {
        match self {
            Self::Postgres(server) => Postgres::url(server.port()),
            Self::Sqlite(path) => format!("sqlite:{}", path.display()),
        }
    }

    /// Process id of the PostgreSQL server.
    pub fn pid(&self) -> Option<u32> {
        match self {
            Self::Postgres(server) => server.pid(),
            Self::Sqlite(_) => None,
        }
    }

    /// Counts the recorded contacts of a boot.
    pub async fn recorded(&self, boot_id: &str) -> anyhow::Result<Recorded> {
        let count = async |sql: &'static str| -> anyhow::Result<i64> {
            match self {
                Self::Postgres(server) => {
                    let mut connection = server.connect().connect().await?;
                    let count = sqlx::query(sql).bind(boot_id).fetch_one(&mut connection).await?.try_get(0)?;
                    connection.close().await?;
                    Ok(count)
                }
                Self::Sqlite(path) => {
                    let options = SqliteConnectOptions::new().filename(path).read_only(true);
                    let mut connection = SqliteConnection::connect_with(&options).await?;
                    let count = sqlx::query(sql).bind(boot_id).fetch_one(&mut connection).await?.try_get(0)?;
                    connection.close().await?;
                    Ok(count)
                }
            }
        };
        Ok(Recorded { rows: count(ROWS).await?, distinct: count(DISTINCT).await? })
    }
}

/// Whether the supervisor is ready and connected for this fleet. A supervisor without any fleet reports itself ready,
/// too.
async fn is_ready(http: SocketAddr, fleet: &str) -> bool {
    let heard = format!("vibrissa_broker_connected{{fleet=\"{fleet}\"}} 1");
    matches!(web::try_get(http, "/metrics").await, Ok((200, text)) if text.contains(&heard))
        && matches!(web::try_get(http, "/readyz").await, Ok((200, _)))
}

/// A supervisor that has become ready.
pub struct Supervisor {
    process: Process,
    log: PathBuf,
    /// Address of its HTTP server.
    pub http: SocketAddr,
    /// Time from the start of the process until it was ready, seconds.
    pub ready_s: f64,
}

impl Supervisor {
    /// Starts a supervisor for a fleet and waits until it is ready.
    pub async fn start(stage: &Stage, broker: &Mosquitto, store: &Store, fleet: &str) -> anyhow::Result<Self> {
        Self::start_with(stage, broker, store, fleet, &[]).await
    }

    /// As [`Self::start`], with further arguments.
    pub async fn start_with(
        stage: &Stage,
        broker: &Mosquitto,
        store: &Store,
        fleet: &str,
        further: &[&str],
    ) -> anyhow::Result<Self> {
        let begun = Instant::now();
        let mut supervisor = Self::launch(stage, broker, store, fleet, further);
        while !is_ready(supervisor.http, fleet).await {
            ensure!(supervisor.is_running(), "the supervisor has ended: {}", supervisor.log());
            ensure!(begun.elapsed() < READY_PATIENCE, "the supervisor does not become ready: {}", supervisor.log());
            tokio::time::sleep(READY_PAUSE).await;
        }
        supervisor.ready_s = begun.elapsed().as_secs_f64();
        Ok(supervisor)
    }

    /// Starts a supervisor with further arguments, without waiting.
    fn launch(stage: &Stage, broker: &Mosquitto, store: &Store, fleet: &str, further: &[&str]) -> Self {
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let mut arguments: Vec<String> = ["run", "--name", "bench", "--fleets", fleet].map(str::to_owned).into();
        arguments.extend(["--http-listen".to_owned(), http.to_string(), "--database-url".to_owned(), store.url()]);
        arguments.extend(["--mqtt-url".to_owned(), format!("mqtt://127.0.0.1:{}", broker.port())]);
        arguments.extend(further.iter().map(|&one| one.to_owned()));
        let log = stage.folder.path().join(format!("{fleet}-{}-bench.log", store.name()));
        let level = ("RUST_LOG".to_owned(), "info,rumqttc=warn".to_owned());
        let process = Process::start(Launch {
            program: stage.program.clone(),
            arguments,
            environment: vec![level],
            log: log.clone(),
        });
        Self { process, log, http, ready_s: 0.0 }
    }

    /// Whether the process has not ended.
    pub fn is_running(&mut self) -> bool {
        self.process.ended_already().is_none()
    }

    /// Text of its log.
    pub fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap_or_default()
    }

    /// Process id of the supervisor.
    pub fn pid(&self) -> u32 {
        self.process.pid()
    }

    /// Stops the supervisor with SIGTERM.
    pub async fn stop(mut self) -> anyhow::Result<()> {
        self.process.signal(Signal::SIGTERM);
        self.process.ended(END_PATIENCE).await.context("the supervisor does not end")?;
        Ok(())
    }
}
