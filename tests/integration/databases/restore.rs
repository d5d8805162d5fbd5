//! A database is lost and restored from a backup that is older than the robots' state.

use std::collections::BTreeMap;
use std::path::Path;

use sqlx::{ConnectOptions, Row};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{ArrayType, Setpoint, SetpointError, SetpointOutcome, SetpointReason};
use vibrissa_store::DatabaseAddress;
use vibrissa_store::lists::setpoints::{SETPOINTS, Setpoint as Recorded};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::try_get;

use crate::backup::backup;
use crate::fleet;

/// Contacts until a whisker is learned.
const LEARNED: usize = 60;

/// Starts a supervisor of fleet `f` in this process.
async fn supervise(database: &DatabaseAddress, broker: &Mosquitto) -> Service {
    Service::start(options(database, broker)).await.unwrap()
}

/// Options of a supervisor of fleet `f`.
pub(crate) fn options(database: &DatabaseAddress, broker: &Mosquitto) -> ServiceOptions {
    let mut params = vibrissa_tests::robot::params();
    params.detection.cold_start_contacts = LEARNED as u32;
    params.command.resend_after = Micros::from_s(0.3);
    ServiceOptions {
        kafka: vibrissa_supervisor::service::KafkaOptions::default(),
        access: vibrissa_supervisor::http::access::AccessOptions::default(),
        name: "s".to_owned(),
        fleets: vec![fleet()],
        database: database.clone(),
        is_new_installation: true,
        lease_time_to_live: LEASE_TIME_TO_LIVE,
        limits: vibrissa_supervisor::service::LimitOptions::default(),
        history: vibrissa_supervisor::service::HistoryOptions::default(),
        black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
        metrics_per_whisker: false,
        webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
        traces: None,
        broker: Some(BrokerAddress::new("127.0.0.1", broker.port())),
        mqtt_port: 0,
        mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
        http: ([127, 0, 0, 1], 0).into(),
        params,
    }
}

/// A robot that obeys setpoints according to the contract and remembers them.
struct Obedient {
    robot: HandRobot,
    /// The highest (epoch, version) that it has received.
    seen: (u64, u64),
    /// Setpoints by command id.
    setpoints: BTreeMap<String, Setpoint>,
    pressure_mpa: f64,
}

impl Obedient {
    async fn born(broker: &Mosquitto) -> Self {
        let robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
        Self { robot, seen: (0, 0), setpoints: BTreeMap::new(), pressure_mpa: 0.1 }
    }

    /// Sends contacts and waits until every message is receipted.
    async fn touch(&mut self, contacts: usize) {
        self.robot.touch(0, contacts).await;
        self.robot.settle().await;
    }

    /// Answers setpoints according to the contract until it applies one, and returns that one.
    async fn obeys(&mut self) -> Setpoint {
        loop {
            let (setpoint, _) = self.robot.setpoint().await;
            if let Some(outcome) = self.judge(&setpoint).await {
                assert_eq!(outcome, SetpointOutcome::Applied, "{setpoint:?}");
                return setpoint;
            }
        }
    }

    /// Answers one setpoint. None for a repeated one, and for one that was pending when the robot restarted.
    async fn judge(&mut self, setpoint: &Setpoint) -> Option<SetpointOutcome> {
        if setpoint.robot_boot_id != self.robot.boot_id {
            self.robot.answer(setpoint, SetpointOutcome::Rejected, Some(SetpointError::WrongBoot)).await;
            return None;
        }
        if let Some(earlier) = self.setpoints.get(&setpoint.command_id) {
            let (one, other) = (unaddressed(earlier), unaddressed(setpoint));
            assert_eq!(one, other, "two setpoints have the same command id");
            // A repeated setpoint is answered again but not applied again.
            let again = Setpoint { pressure_mpa: self.pressure_mpa, ..setpoint.clone() };
            self.robot.answer(&again, SetpointOutcome::Applied, None).await;
            return None;
        }
        if (setpoint.epoch, setpoint.version) <= self.seen {
            self.robot.answer(setpoint, SetpointOutcome::Rejected, Some(SetpointError::Stale)).await;
            return Some(SetpointOutcome::Rejected);
        }
        self.seen = (setpoint.epoch, setpoint.version);
        self.setpoints.insert(setpoint.command_id.clone(), setpoint.clone());
        self.robot.answer(setpoint, SetpointOutcome::Applied, None).await;
        self.pressure_mpa = setpoint.pressure_mpa;
        self.robot.status().await;
        Some(SetpointOutcome::Applied)
    }

    /// Sends contacts until a setpoint for its own compensation arrives, and applies it; other setpoints are applied,
    /// too.
    async fn compensates(&mut self) -> Setpoint {
        until("a compensation", async || {
            self.touch(20).await;
            while !self.robot.setpoints_left().is_empty() {
                let (setpoint, _) = self.robot.setpoint().await;
                let outcome = self.judge(&setpoint).await;
                assert_ne!(outcome, Some(SetpointOutcome::Rejected), "{setpoint:?}");
                if outcome.is_some() && setpoint.reason == SetpointReason::SelfCompensation {
                    return Some(setpoint);
                }
            }
            None
        })
        .await
    }
}

/// The content of a setpoint, independent of its sender.
fn unaddressed(setpoint: &Setpoint) -> Setpoint {
    Setpoint { boot_id: vibrissa_protocol::BootId::new("any").unwrap(), seq: 0, ..setpoint.clone() }
}

async fn whisker(service: &Service) -> Whisker {
    service.store.all::<Whisker>(&WHISKERS, Vec::new()).await.unwrap().remove(0)
}

async fn is_ready(service: &Service) -> bool {
    try_get(service.http, "/readyz").await.is_ok_and(|(status, _)| status == 200)
}

/// Number of contacts, and of their different names.
async fn counted(database: &DatabaseAddress) -> (i64, i64) {
    const SQL: &str =
        "SELECT count(*) AS n, count(DISTINCT boot || ' ' || seq || ' ' || position) AS names FROM contacts";
    match database {
        DatabaseAddress::Sqlite(path) => {
            let mut link =
                sqlx::sqlite::SqliteConnectOptions::new().filename(path).read_only(true).connect().await.unwrap();
            let row = sqlx::query(SQL).fetch_one(&mut link).await.unwrap();
            (row.get(0), row.get(1))
        }
        DatabaseAddress::Postgres(options) => {
            let mut link = options.connect().await.unwrap();
            let row = sqlx::query(SQL).fetch_one(&mut link).await.unwrap();
            (row.get(0), row.get(1))
        }
    }
}

/// States of the setpoints in the database.
async fn setpoint_states(service: &Service) -> Vec<String> {
    let setpoints = service.store.all::<Recorded>(&SETPOINTS, Vec::new()).await.unwrap();
    setpoints.into_iter().map(|one| one.state).collect()
}

/// Works, is backed up while running, continues with a cut, a compensation, a takeover and another cut, and then loses
/// its database.
async fn works_and_loses(
    database: &DatabaseAddress,
    broker: &Mosquitto,
    back_up: impl FnOnce() + Send + 'static,
) -> Obedient {
    let service = supervise(database, broker).await;
    let mut robot = Obedient::born(broker).await;
    robot.touch(LEARNED + 20).await;
    let backed_up = tokio::task::spawn_blocking(back_up);
    while !backed_up.is_finished() {
        robot.touch(20).await;
    }
    backed_up.await.unwrap();
    robot.touch(20).await;
    robot.robot.cut(0, 66.0);
    let first = robot.compensates().await;
    until_true("applied", async || setpoint_states(&service).await == ["APPLIED"]).await;
    service.stop().await;
    // Another epoch, whose versions the restored database would use again.
    let service = supervise(database, broker).await;
    robot.robot.settle().await;
    robot.robot.status().await;
    // The error of the model at the new pressure is learned first.
    robot.touch(100).await;
    robot.robot.cut(0, 62.0);
    let second = robot.compensates().await;
    assert!(second.epoch > first.epoch && second.pressure_mpa < first.pressure_mpa - 0.005, "{second:?}");
    until_true("applied", async || setpoint_states(&service).await.iter().all(|state| state == "APPLIED")).await;
    service.stop().await;
    robot
}

/// A supervisor on the restored database continues without help: it resets pressures of unknown setpoints and detects
/// the cuts again.
async fn goes_on(database: &DatabaseAddress, broker: &Mosquitto, robot: &mut Obedient) {
    let of_the_backup = counted(database).await;
    assert!(of_the_backup.0 >= (LEARNED + 20) as i64, "{of_the_backup:?}");
    let seen = robot.seen;
    let service = supervise(database, broker).await;
    until_true("ready", async || is_ready(&service).await).await;
    assert_eq!(setpoint_states(&service).await, [""; 0], "the backup contains no setpoint");

    // Its contacts let this robot's clock pass faster than time. A new supervisor would wait for a rate that can be right.
    robot.robot.clock_us = vibrissa_edge::clock::wall_clock().0;
    robot.robot.settle().await;
    robot.robot.status().await;
    let released = robot.obeys().await;
    assert_eq!((released.reason, released.pressure_mpa), (SetpointReason::Release, 0.1));
    assert!((released.epoch, released.version) > seen, "{released:?} after {seen:?}");
    until_true("the true pressure known", async || {
        let known = whisker(&service).await;
        known.setpoint_mpa == robot.pressure_mpa && known.pressure_mpa == Some(robot.pressure_mpa)
    })
    .await;

    // The lost cut is detected again with the baseline in the backup, and compensated.
    robot.compensates().await;
    until_true("applied", async || setpoint_states(&service).await.iter().all(|state| state == "APPLIED")).await;
    let known = whisker(&service).await;
    assert_eq!(known.condition, "TRIMMED");
    assert!((known.length_mm - 62.0).abs() < 1.5, "{known:?}");
    robot.touch(100).await;
    until_true("each contact once", async || {
        let (contacts, names) = counted(database).await;
        contacts == names && contacts >= of_the_backup.0 + 100
    })
    .await;
    assert!(is_ready(&service).await);
    service.stop().await;
}

/// Restores a backup as described in docs/operations.md.
fn restore_sqlite(path: &Path, copy: &Path) {
    let lost = path.parent().unwrap().join("lost");
    std::fs::create_dir(&lost).unwrap();
    for ending in ["", "-wal", "-shm", ".lock"] {
        let name = format!("{}{ending}", path.file_name().unwrap().to_str().unwrap());
        if path.with_file_name(&name).exists() {
            std::fs::rename(path.with_file_name(&name), lost.join(&name)).unwrap();
        }
    }
    std::fs::copy(copy, path).unwrap();
}

#[tokio::test]
async fn a_restored_sqlite_goes_on_with_robots_that_have_seen_more() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let (path, copy) = (folder.path().join("v.sqlite3"), folder.path().join("copy.sqlite3"));
    let database = DatabaseAddress::Sqlite(path.clone());
    let (url, to) = (database.to_string(), copy.clone());
    let mut robot = works_and_loses(&database, &broker, move || {
        let ended = backup(&url, &to);
        assert!(ended.status.success(), "{ended:?}");
    })
    .await;
    restore_sqlite(&path, &copy);
    goes_on(&database, &broker, &mut robot).await;
}

#[tokio::test]
async fn a_restored_postgres_goes_on_with_robots_that_have_seen_more() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let server = Postgres::start_with_supervisor().await;
    let database: DatabaseAddress = Postgres::supervisor_url(server.port()).parse().unwrap();
    let dump = folder.path().join("vibrissa.dump");
    let mut dumping = server.client("pg_dump");
    dumping.args(["--format=custom", "--dbname=vibrissa", "--file"]).arg(&dump);
    let mut robot = works_and_loses(&database, &broker, move || {
        let ended = dumping.output().unwrap();
        assert!(ended.status.success(), "{ended:?}");
    })
    .await;
    let run = |program: &str, arguments: &[&str]| {
        let ended = server.client(program).args(arguments).output().unwrap();
        assert!(ended.status.success(), "{program}: {ended:?}");
    };
    run("dropdb", &["--force", "vibrissa"]);
    run("createdb", &["vibrissa"]);
    run("pg_restore", &["--dbname=vibrissa", "--exit-on-error", "--single-transaction", dump.to_str().unwrap()]);
    server.make_supervisor();
    goes_on(&database, &broker, &mut robot).await;
}

/// If epochs were ahead of the clock, the epochs of a restored database are lower than those that robots have seen. The
/// robots reject its setpoints, which the database records, until one SQL statement raises the epochs.
#[tokio::test]
async fn a_robot_that_has_seen_epochs_from_the_future_obeys_once_they_are_raised_by_hand() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let path = folder.path().join("v.sqlite3");
    let database = DatabaseAddress::Sqlite(path.clone());
    let service = supervise(&database, &broker).await;
    let mut robot = Obedient::born(&broker).await;
    robot.touch(LEARNED + 20).await;
    let tomorrow_ms = robot.robot.clock_us / 1000 + 86_400_000;
    robot.seen = (tomorrow_ms, 7);
    robot.robot.cut(0, 66.0);
    robot.touch(80).await;
    let (setpoint, _) = robot.robot.setpoint().await;
    assert_eq!(robot.judge(&setpoint).await, Some(SetpointOutcome::Rejected));
    until_true("given up", async || setpoint_states(&service).await == ["REJECTED"]).await;
    service.stop().await;

    let mut link = sqlx::sqlite::SqliteConnectOptions::new().filename(&path).connect().await.unwrap();
    sqlx::query("UPDATE leases SET epoch = epoch + 3155760000000").execute(&mut link).await.unwrap();
    sqlx::Connection::close(link).await.unwrap();
    let service = supervise(&database, &broker).await;
    robot.robot.restart();
    robot.robot.birth().await;
    robot.robot.settle().await;
    let taken = robot.compensates().await;
    assert!(taken.epoch > tomorrow_ms);
    until_true("applied", async || setpoint_states(&service).await.contains(&"APPLIED".to_owned())).await;
    service.stop().await;
}

/// The next supervisor starts at once, although something of the stopped one still holds its store.
#[tokio::test]
async fn regress_a_stopped_supervisor_unlocks_its_file() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let database = DatabaseAddress::Sqlite(folder.path().join("v.sqlite3"));
    let service = supervise(&database, &broker).await;
    let held = service.store.clone();
    service.stop().await;
    let next = supervise(&database, &broker).await;
    until_true("ready", async || is_ready(&next).await).await;
    assert!(held.ping().await.is_err(), "the stopped supervisor's store is closed");
    next.stop().await;
}
