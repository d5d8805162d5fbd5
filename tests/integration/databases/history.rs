//! Contacts are stored according to the retention policy. Minute and hour aggregates are exact sums over all contacts,
//! even if the supervisor is killed.

use std::collections::BTreeMap;

use sqlx::ConnectOptions;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{ArrayType, SetpointOutcome};
use vibrissa_store::DatabaseAddress;
use vibrissa_store::Resolution;
use vibrissa_supervisor::engine::ContactRetention;
use vibrissa_supervisor::engine::rollup::{Open, Rollup};
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::service::{HistoryOptions, LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};

use crate::fleet;
use crate::supervisors::{Replica, start_fleet};

/// Rows of a query.
macro_rules! rows {
    ($address:expr, $row:ty, $sql:expr) => {
        match $address {
            DatabaseAddress::Sqlite(path) => {
                let mut link = sqlx::sqlite::SqliteConnectOptions::new().filename(path).connect().await.unwrap();
                sqlx::query_as::<_, $row>($sql).fetch_all(&mut link).await.unwrap()
            }
            DatabaseAddress::Postgres(options) => {
                let mut link = options.connect().await.unwrap();
                sqlx::query_as::<_, $row>($sql).fetch_all(&mut link).await.unwrap()
            }
        }
    };
}
pub(crate) use rows;

pub(crate) async fn count(address: &DatabaseAddress, sql: &'static str) -> i64 {
    rows!(address, (i64,), sql)[0].0
}

/// A row of contacts: whisker, time received, use, residual, ratio, deflection, strain, pressure, temperature, length
/// and its standard deviation.
type Felt = (i64, i64, String, Option<f64>, f64, f64, f64, f64, f64, f64, f64);
/// A minute or hour aggregate: whisker, start, contacts used, learning and unused, residual (mean, standard deviation,
/// min, max), sensitivity, ratio, length, its standard deviation, mean length, pressure, temperature.
type Row = (i64, i64, i32, i32, i32, [Option<f64>; 4], [Option<f64>; 7]);
/// The same without whisker and start.
type Means = ([i32; 3], [Option<f64>; 4], [Option<f64>; 7]);

fn means(numbers: &[f64]) -> Option<f64> {
    (!numbers.is_empty()).then(|| numbers.iter().sum::<f64>() / numbers.len() as f64)
}

/// Aggregates of each time span, computed from all contacts at once.
fn brute_force(contacts: &[Felt], span_us: i64) -> BTreeMap<(i64, i64), Means> {
    let mut spans: BTreeMap<(i64, i64), Vec<&Felt>> = BTreeMap::new();
    for one in contacts {
        spans.entry((one.0, one.1 / span_us * span_us)).or_default().push(one);
    }
    let add_up = |of: Vec<&Felt>| -> Means {
        let used = of.iter().filter(|one| one.2 == "USED").count() as i32;
        let learning = of.iter().filter(|one| one.2 == "LEARNING").count() as i32;
        let each = |which: fn(&Felt) -> f64| means(&of.iter().map(|one| which(one)).collect::<Vec<_>>());
        let heard: Vec<&Felt> = of.iter().copied().filter(|one| one.3.is_some()).collect();
        let residuals: Vec<f64> = heard.iter().filter_map(|one| one.3).collect();
        let mean = means(&residuals);
        let squares: f64 = residuals.iter().map(|one| (one - mean.unwrap()).powi(2)).sum();
        let sd = (residuals.len() > 1).then(|| (squares / (residuals.len() - 1) as f64).sqrt());
        let least = residuals.iter().copied().reduce(f64::min);
        let last = of[of.len() - 1];
        (
            [used, learning, of.len() as i32 - used - learning],
            [mean, sd, least, residuals.iter().copied().reduce(f64::max)],
            [
                means(&heard.iter().map(|one| one.6 / one.5).collect::<Vec<_>>()),
                means(&heard.iter().map(|one| one.4).collect::<Vec<_>>()),
                Some(last.9),
                Some(last.10),
                each(|one| one.9),
                each(|one| one.7),
                each(|one| one.8),
            ],
        )
    };
    spans.into_iter().map(|(name, of)| (name, add_up(of))).collect()
}

fn of_open(rollup: &Rollup) -> Means {
    let (response, contact) = (rollup.response, rollup.contact);
    (
        [rollup.used as i32, rollup.learning as i32, rollup.unused as i32],
        [
            response.map(|means| means.residual_mean),
            response.and_then(|means| means.residual_sd),
            response.map(|means| means.residual_min),
            response.map(|means| means.residual_max),
        ],
        [
            response.map(|means| means.sensitivity_per_mm),
            response.map(|means| means.ratio),
            contact.map(|means| means.length_mm),
            contact.map(|means| means.length_sd_mm),
            contact.map(|means| means.length_mean_mm),
            contact.map(|means| means.pressure_mpa),
            contact.map(|means| means.temperature_c),
        ],
    )
}

/// Aggregates in the table, and open aggregates from the stored bytes of each whisker.
async fn written(address: &DatabaseAddress, resolution: Resolution) -> BTreeMap<(i64, i64), Means> {
    type Counts = (i64, i64, i32, i32, i32);
    type Numbers = (
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
        Option<f64>,
    );
    let table = if resolution == Resolution::Minute { "contact_minutes" } else { "contact_hours" };
    let columns = ["residual_mean", "residual_sd", "residual_min", "residual_max", "sensitivity_per_mm", "ratio"];
    let columns: Vec<String> = columns
        .into_iter()
        .chain(["length_mm", "length_sd_mm", "length_mean_mm", "pressure_mpa", "temperature_c"])
        .map(|column| format!("CAST({column} AS DOUBLE PRECISION)"))
        .collect();
    let counts = format!(
        "SELECT whisker_id, start_us, contacts_used, contacts_learning, contacts_unused FROM {table} ORDER BY 1, 2"
    );
    let numbers = format!("SELECT {} FROM {table} ORDER BY whisker_id, start_us", columns.join(", "));
    let counts = rows!(address, Counts, sqlx::AssertSqlSafe(counts.clone()));
    let numbers = rows!(address, Numbers, sqlx::AssertSqlSafe(numbers.clone()));
    let row = |(counts, n): (Counts, Numbers)| -> Row {
        (counts.0, counts.1, counts.2, counts.3, counts.4, [n.0, n.1, n.2, n.3], [n.4, n.5, n.6, n.7, n.8, n.9, n.10])
    };
    let mut written = BTreeMap::new();
    for (id, start_us, used, learning, unused, residual, rest) in counts.into_iter().zip(numbers).map(row) {
        assert!(written.insert((id, start_us), ([used, learning, unused], residual, rest)).is_none());
    }
    for (id, bytes) in
        rows!(address, (i64, Vec<u8>), "SELECT whisker_id, rollup FROM whiskers WHERE rollup IS NOT NULL")
    {
        let mut closed = Vec::new();
        Open::from_bytes(Some(&bytes), Micros(0)).end(&mut closed);
        for rollup in closed.iter().filter(|rollup| rollup.resolution == resolution) {
            let before = written.insert((id, rollup.start.0 as i64), of_open(rollup));
            assert!(before.is_none(), "both open and in the table: {rollup:?}");
        }
    }
    written
}

fn is_close(one: Option<f64>, other: Option<f64>) -> bool {
    match (one, other) {
        // Aggregates are stored with four bytes per number.
        (Some(one), Some(other)) => (one - other).abs() <= 2e-7 * other.abs() + 1e-9,
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    }
}

/// Checks that closed and open aggregates agree with the contacts. Returns the number of contacts.
async fn assert_exact(address: &DatabaseAddress) -> usize {
    let contacts = rows!(
        address,
        Felt,
        "SELECT whisker_id, received_us, used, residual, ratio, deflection_mm, strain, pressure_mpa, temperature_c, length_mm, \
         length_sd_mm FROM contacts ORDER BY whisker_id, received_us, boot, seq, position"
    );
    for resolution in Resolution::ALL {
        let (expected, written) = (brute_force(&contacts, resolution.us() as i64), written(address, resolution).await);
        assert_eq!(expected.keys().collect::<Vec<_>>(), written.keys().collect::<Vec<_>>());
        for (name, (counts, residual, rest)) in &expected {
            let row = &written[name];
            assert_eq!(counts, &row.0, "{name:?}");
            let pairs = residual.iter().chain(rest).zip(row.1.iter().chain(&row.2));
            for (expected, written) in pairs {
                assert!(is_close(*written, *expected), "{name:?}: {residual:?} {rest:?} are not {row:?}");
            }
        }
    }
    contacts.len()
}

/// Supervises a fleet with a kill, a restart, and an orderly stop in between.
async fn killed_and_restarted(database: &str, broker: &Mosquitto) {
    let address: DatabaseAddress = database.parse().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let fleet = start_fleet("f", broker.port());
    let recorded = async || count(&address, "SELECT count(*) FROM contacts").await;
    let mut goal = 0;
    for turn in 0..3 {
        let mut supervisor = Replica::start(folder.path(), "s", "f", database, broker.port(), 0.8);
        supervisor.says(200, "OWNED").await;
        goal = recorded().await.max(goal) + 200;
        until_true("more contacts", async || recorded().await >= goal).await;
        match turn {
            0 => supervisor.kill(),
            1 => supervisor.terminate().await,
            _ => {
                fleet.rest();
                until_true("every message receipted", async || fleet.is_receipted()).await;
                supervisor.kill();
            }
        }
    }
    // The next owner replays the journal and leaves it empty.
    let mut supervisor = Replica::start(folder.path(), "s", "f", database, broker.port(), 0.8);
    supervisor.says(200, "OWNED").await;
    supervisor.terminate().await;
    assert_eq!(count(&address, "SELECT count(*) FROM journal").await, 0);
    assert_eq!(assert_exact(&address).await, fleet.contacts_made() as usize);
    fleet.stop().await;
}

#[tokio::test]
async fn brute_force_minutes_and_hours_outlive_a_kill_on_sqlite() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    killed_and_restarted(&format!("sqlite:{}", folder.path().join("v.sqlite3").display()), &broker).await;
}

#[tokio::test]
async fn brute_force_minutes_and_hours_outlive_a_kill_on_postgres() {
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    killed_and_restarted(&Postgres::url(server.port()), &broker).await;
}

/// Contacts until a whisker is learned.
const LEARNED: usize = 60;

async fn supervise(database: &DatabaseAddress, broker: &Mosquitto, keep: ContactRetention) -> Service {
    let mut params = vibrissa_tests::robot::params();
    params.detection.cold_start_contacts = LEARNED as u32;
    Service::start(ServiceOptions {
        kafka: vibrissa_supervisor::service::KafkaOptions::default(),
        access: vibrissa_supervisor::http::access::AccessOptions::default(),
        name: "s".to_owned(),
        fleets: vec![fleet()],
        database: database.clone(),
        is_new_installation: true,
        lease_time_to_live: LEASE_TIME_TO_LIVE,
        black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
        limits: vibrissa_supervisor::service::LimitOptions::default(),
        history: HistoryOptions { keep, ..HistoryOptions::default() },
        metrics_per_whisker: false,
        webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
        traces: None,
        broker: Some(BrokerAddress::new("127.0.0.1", broker.port())),
        mqtt_port: 0,
        mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
        http: ([127, 0, 0, 1], 0).into(),
        params,
    })
    .await
    .unwrap()
}

/// Lets a whisker learn, cuts it, and waits for its own compensation. Returns the number of contacts, and of those
/// before the setpoint.
async fn cut_and_compensated(broker: &Mosquitto) -> (i64, i64) {
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let mut sent = 0;
    let mut touch = async |robot: &mut HandRobot, contacts: usize| {
        robot.touch(0, contacts).await;
        robot.settle().await;
        sent += contacts as i64;
        sent
    };
    touch(&mut robot, 3 * LEARNED).await;
    robot.cut(0, 65.0);
    let mut before = 0;
    until("a setpoint", async || {
        before = touch(&mut robot, 20).await;
        (!robot.setpoints_left().is_empty()).then_some(())
    })
    .await;
    let (setpoint, _) = robot.setpoint().await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.status().await;
    (touch(&mut robot, 120).await, before)
}

/// Under each retention policy the right contacts are stored, and everything else is the same.
async fn policies(address: impl AsyncFn() -> (DatabaseAddress, Option<Postgres>)) {
    for keep in [ContactRetention::All, ContactRetention::Decisions, ContactRetention::None] {
        let broker = Mosquitto::start();
        let (address, server) = address().await;
        let service = supervise(&address, &broker, keep).await;
        let (sent, before) = cut_and_compensated(&broker).await;
        service.stop().await;
        let number = async |sql: &'static str| count(&address, sql).await;
        let kept = number("SELECT count(*) FROM contacts").await;
        let names = "SELECT count(*) FROM (SELECT DISTINCT boot, seq, position FROM contacts) n";
        assert_eq!(number(names).await, kept, "{keep:?}: a contact is stored twice");
        // Detection, decision, error and aggregates do not depend on the policy.
        assert_eq!(
            (number("SELECT count(*) FROM trims").await, number("SELECT count(*) FROM compensations").await),
            (1, 1)
        );
        let responses = number("SELECT count(*) FROM compensation_responses").await;
        assert!(responses > 100, "{responses}");
        let added: i32 = written(&address, Resolution::Hour).await.values().map(|row| row.0.iter().sum::<i32>()).sum();
        assert_eq!(i64::from(added), sent, "{keep:?}");
        match keep {
            ContactRetention::All => {
                assert_eq!(kept, sent);
                assert_eq!(assert_exact(&address).await as i64, sent);
            }
            ContactRetention::None => assert_eq!(kept, 0),
            ContactRetention::Decisions => {
                let of_responses = "SELECT count(*) FROM compensation_responses r JOIN contacts c ON c.t_us = r.t_us";
                assert_eq!(number(of_responses).await, responses, "contacts of compensators must be stored");
                // The contacts before the trim are stored, ordinary ones are not.
                let led = "SELECT count(*) FROM contacts, trims WHERE received_us <= detected_us";
                let took = number("SELECT contacts_to_detect FROM trims").await;
                let led = number(led).await;
                assert!(led >= took.min(32) && led < before && kept < sent - 50, "{led} {took} {before} {kept} {sent}");
            }
        }
        drop(server);
    }
}

#[tokio::test]
async fn contacts_are_kept_as_the_policy_says_on_sqlite() {
    let folder = tempfile::tempdir().unwrap();
    let number = std::cell::Cell::new(0);
    policies(async || {
        number.set(number.get() + 1);
        (DatabaseAddress::Sqlite(folder.path().join(format!("{}.sqlite3", number.get()))), None)
    })
    .await;
}

#[tokio::test]
async fn contacts_are_kept_as_the_policy_says_on_postgres() {
    policies(async || {
        let server = Postgres::start().await;
        (Postgres::url(server.port()).parse().unwrap(), Some(server))
    })
    .await;
}
