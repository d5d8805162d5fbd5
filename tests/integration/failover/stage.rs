//! A supervisor with its embedded broker, and robots that touch and lose whiskers all the time.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use sqlx::ConnectOptions;
use sqlx::postgres::{PgConnectOptions, PgConnection};
use tempfile::TempDir;
use tokio::time::{sleep, timeout};
use vibrissa_protocol::{ArrayType, Name, OnSupervisorLoss};
use vibrissa_simulator::scenario::{ArrayScenario, Behaviour, Change, Event, Noise, RobotScenario, WhiskerScenario};
use vibrissa_simulator::{Broker, Scenario};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::oracle::robots::Robots;
use vibrissa_tests::oracle::{ledger, obedience, recorded};
use vibrissa_tests::patroni::Patroni;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until_within;
use vibrissa_tests::web::ask;

/// Name of the fleet.
const FLEET: &str = "f";
/// Number of robots, and of whiskers of each.
const ROBOTS: usize = 6;
const WHISKERS: u16 = 2;
/// Contacts per second of a whisker.
const RATE: f64 = 10.0;
/// Time in seconds between two cuts, each at the next robot.
const CUTS_APART_S: f64 = 1.5;
/// Seconds before the first cut, in which whiskers are learned.
const FIRST_CUT_S: f64 = 5.0;
/// Time limit of waits for a failover or for the end of a run.
pub(crate) const LONG: Duration = Duration::from_secs(60);
/// Largest time from the new leader's first answer to the first contact that it records.
pub(crate) const TAKEOVER_MAX: Duration = Duration::from_secs(3);

/// The running supervisor and robots.
pub(crate) struct Stage {
    pub(crate) robots: Robots,
    supervisor: Process,
    http: u16,
    log: PathBuf,
    _folder: TempDir,
}

/// Comparison of the robots' record with the database.
pub(crate) struct Verdict {
    pub(crate) contacts: ledger::Verdict,
    pub(crate) setpoints: obedience::Verdict,
}

impl Stage {
    /// Starts a supervisor with this database, and robots.
    pub(crate) async fn start(database_url: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (mqtt, http, log) = (free_port(), free_port(), folder.path().join("supervisor.log"));
        let arguments = [
            "run",
            "--fleet",
            FLEET,
            "--database-url",
            database_url,
            "--mqtt-port",
            &mqtt.to_string(),
            "--http-listen",
            &format!("127.0.0.1:{http}"),
            "--detection-cold-start-contacts",
            "20",
        ];
        let supervisor = Process::start(Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.map(str::to_owned).to_vec(),
            environment: vec![("RUST_LOG".to_owned(), "info,rumqttc=warn".to_owned())],
            log: log.clone(),
        });
        let robots = Robots::start(&[scenario()], &[Broker::new("127.0.0.1", mqtt)]).unwrap();
        Self { robots, supervisor, http, log, _folder: folder }
    }

    /// Log of the supervisor.
    pub(crate) fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap_or_default()
    }

    /// Value of a metric without labels.
    pub(crate) async fn metric(&self, name: &str) -> Option<f64> {
        let text = ask(([127, 0, 0, 1], self.http).into(), "GET", "/metrics", &[]).await.ok()?.body;
        let line = text.lines().find(|line| line.strip_prefix(name).is_some_and(|rest| rest.starts_with(' ')))?;
        line.rsplit_once(' ')?.1.parse().ok()
    }

    /// Waits until a metric without labels has a value.
    pub(crate) async fn until_metric(&self, name: &str, holds: impl Fn(f64) -> bool) -> f64 {
        until_within(LONG, name, async || self.metric(name).await.filter(|&value| holds(value))).await
    }

    /// Waits until robots have applied setpoints and the database has contacts.
    pub(crate) async fn until_busy(&self, database: &PgConnectOptions) {
        until_within(LONG, "setpoints that were applied", async || {
            let applied = count(database, "SELECT count(*) FROM setpoints WHERE state = 'APPLIED'").await?;
            (applied >= 2).then_some(())
        })
        .await;
    }

    /// Waits until a server records contacts; the time from now on.
    pub(crate) async fn until_recorded(&self, database: &PgConnectOptions) -> Duration {
        let begun = Instant::now();
        let mut before = None;
        until_within(LONG, "contacts recorded by the leader", async || {
            let now = contacts(database).await?;
            let is_more = before.is_some_and(|before| now > before);
            before.get_or_insert(now);
            is_more.then_some(())
        })
        .await;
        begun.elapsed()
    }

    /// Waits until a node of a cluster accepts writes and the supervisor records contacts there. Prints both times since
    /// `failed`, and checks the second.
    pub(crate) async fn taken_over(&self, cluster: &Patroni, node: usize, what: &str, failed: Instant) {
        cluster.until_leader(node).await;
        let led = failed.elapsed();
        let recorded = self.until_recorded(&cluster.connect(node)).await;
        println!(
            "{what}: a new leader after {:.1} s, contacts recorded {:.1} s later",
            led.as_secs_f64(),
            recorded.as_secs_f64()
        );
        assert!(recorded < TAKEOVER_MAX, "{what}: {recorded:?}\n{}", self.log());
    }

    /// Stops the contacts, waits until robots have nothing left to send, and compares.
    pub(crate) async fn end(mut self, database: &PgConnectOptions) -> Verdict {
        self.robots.rest();
        until_within(LONG, "receipts of all messages", async || (self.robots.undelivered() == 0).then_some(())).await;
        // Setpoints may still be on their way.
        let mut before = None;
        until_within(LONG, "the last row", async || {
            let now = contacts(database).await;
            sleep(Duration::from_millis(500)).await;
            let is_same = now.is_some() && now == std::mem::replace(&mut before, now);
            is_same.then_some(())
        })
        .await;
        assert!(self.supervisor.ended_already().is_none(), "the supervisor has ended: {}", self.log());
        let mut truth = self.robots.stop().await;
        let mut connection = database.connect().await.unwrap();
        recorded::contacts(&mut connection, &[], &mut truth.ledger).await.unwrap();
        let decided = recorded::setpoints(&mut connection, &[]).await.unwrap();
        let verdict = Verdict { contacts: truth.ledger.verdict(), setpoints: truth.obedience.verdict(&decided) };
        println!("{:?} {:?}", verdict.contacts, verdict.setpoints);
        let log = std::fs::read_to_string(&self.log).unwrap();
        assert!(!log.contains("panicked at"), "{log}");
        assert!(verdict.setpoints.applied >= 3, "robots applied only {} setpoints", verdict.setpoints.applied);
        verdict
    }
}

impl Verdict {
    /// Nothing is lost, nothing is twice, nothing is stale.
    pub(crate) fn is_clean(&self) {
        let Self { contacts, setpoints } = self;
        assert_eq!((contacts.missing, contacts.duplicate, contacts.wrong), (0, 0, 0), "{contacts:?}");
        assert_eq!((setpoints.twice, setpoints.stale, setpoints.uncommitted), (0, 0, 0), "{setpoints:?}");
        assert_eq!(setpoints.two_for_one, 0, "{setpoints:?}");
    }
}

/// Number of recorded contacts; `None` if the server does not answer.
pub(crate) async fn contacts(database: &PgConnectOptions) -> Option<i64> {
    count(database, "SELECT count(*) FROM contacts").await
}

/// A number of the database; `None` if the server does not answer.
pub(crate) async fn count(database: &PgConnectOptions, sql: &'static str) -> Option<i64> {
    let asked = async {
        let mut connection: PgConnection = database.connect().await.ok()?;
        sqlx::query_scalar(sql).fetch_one(&mut connection).await.ok()
    };
    timeout(Duration::from_secs(1), asked).await.ok()?
}

fn scenario() -> Scenario {
    let behaviour = Behaviour {
        contacts_per_second: RATE,
        contacts_per_message: 4,
        message_after_s: 0.5,
        kept_messages: 20_000,
        journal: true,
        ..Behaviour::default()
    };
    Scenario {
        calibration: None,
        seed: 1,
        fleet: name(FLEET),
        behaviour,
        noise: Noise::default(),
        calibration_error: 0.03,
        robots: (0..ROBOTS).map(robot).collect(),
    }
}

fn robot(number: usize) -> RobotScenario {
    let whisker = |whisker| WhiskerScenario {
        whisker,
        x_mm: 25.0 * f64::from(whisker),
        neighbours: (0..WHISKERS).filter(|&other| other != whisker).collect(),
        ..WhiskerScenario::default()
    };
    // Each whisker is cut three times.
    let cut = |turn: usize| {
        let at_s = FIRST_CUT_S + CUTS_APART_S * (number + turn * ROBOTS) as f64;
        let change = Change::Trim { length_mm: 67.5 - 2.5 * (turn / usize::from(WHISKERS)) as f64 };
        Event::whisker_at_s(at_s, name("left"), turn as u16 % WHISKERS, change)
    };
    RobotScenario {
        robot: name(&format!("r{number}")),
        model: "failover".to_owned(),
        on_supervisor_loss: OnSupervisorLoss::Hold,
        applies_gain: false,
        arrays: vec![ArrayScenario {
            array: name("left"),
            array_type: if number.is_multiple_of(2) { ArrayType::Type1 } else { ArrayType::Type2 },
            whiskers: (0..WHISKERS).map(whisker).collect(),
        }],
        events: (0..3 * usize::from(WHISKERS)).map(cut).collect(),
    }
}

fn name(text: &str) -> Name {
    Name::new(text).unwrap()
}
