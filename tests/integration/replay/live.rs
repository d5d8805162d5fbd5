//! Records a fleet with a trim while a supervisor works with it, and replays the recording.

use std::path::{Path, PathBuf};

use nix::sys::signal::Signal;
use serde_json::{Value, json};
use sqlx::Row;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool, SqlitePoolOptions, SqliteRow};
use tempfile::TempDir;
use tokio::sync::OnceCell;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_protocol::Name;
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_store::DatabaseAddress;
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::{PATIENCE, until_true};

use crate::program::{PROGRAM, effects, replay, run};

/// Whisker 0 is cut to 65 mm and compensates itself. Whisker 2 is cut too short for that, and whisker 1 compensates it.
const SCENARIO: &str = r#"
fleet = "f"
seed = 5
[behaviour]
contacts_per_second = 80.0
message_after_s = 0.1
[[robots]]
robot = "r"
[[robots.arrays]]
array = "left"
type = "TYPE_1"
whiskers = [
    { whisker = 0, length_mm = 70.0, neighbours = [1] },
    { whisker = 1, length_mm = 65.0, neighbours = [0, 2] },
    { whisker = 2, length_mm = 70.0, neighbours = [1] },
]
[[robots.events]]
at_contact = 100
array = "left"
whisker = 0
change = { kind = "TRIM", length_mm = 65.0 }
[[robots.events]]
at_contact = 130
array = "left"
whisker = 2
change = { kind = "TRIM", length_mm = 54.0 }
"#;
/// Contacts per second of each whisker.
const RATE: f64 = 80.0;
/// Contacts that the robot may be ahead of the database.
const BEHIND_MAX: u64 = 100;
const CONTACTS: &str = "SELECT count(*) FROM contacts";
const COLD_START: u32 = 60;
/// Flags with the parameters of the recording supervisor.
const AS_THEN: [&str; 2] = ["--detection-cold-start-contacts", "60"];

/// A recording, and the database of the supervisor that worked at the same time.
struct Recording {
    folder: TempDir,
    log: String,
}

impl Recording {
    fn file(&self) -> PathBuf {
        self.folder.path().join("recording.jsonl")
    }

    async fn rows(&self, sql: &'static str, row: impl Fn(&SqliteRow) -> Value) -> Vec<Value> {
        let pool = reader(&self.folder.path().join("v.sqlite3")).await;
        let rows = sqlx::query(sql).fetch_all(&pool).await.unwrap();
        rows.iter().map(row).collect()
    }
}

async fn reader(path: &Path) -> SqlitePool {
    let options = SqliteConnectOptions::new().filename(path).read_only(true);
    SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap()
}

async fn count(pool: &SqlitePool, sql: &'static str) -> u64 {
    let count: i64 = sqlx::query_scalar(sql).fetch_one(pool).await.unwrap();
    count as u64
}

/// The recording is made once for all tests.
async fn recording() -> &'static Recording {
    static RECORDING: OnceCell<Recording> = OnceCell::const_new();
    RECORDING.get_or_init(record).await
}

async fn record() -> Recording {
    let folder = tempfile::tempdir().unwrap();
    let broker = Mosquitto::start();
    let mut recorder = recorder(&folder, broker.port());
    let log = folder.path().join("log");
    let said = |what: &str| std::fs::read_to_string(&log).is_ok_and(|text| text.contains(what));
    until_true("the recorder's connection", async || said("MQTT broker: receiving")).await;
    let service = service(&folder, broker.port()).await;
    let fleet =
        Fleet::start(&Scenario::from_toml_str(SCENARIO).unwrap(), &Broker::new("127.0.0.1", broker.port())).unwrap();
    let pool = reader(&folder.path().join("v.sqlite3")).await;
    const APPLIED: &str = "SELECT count(*) FROM setpoints WHERE state = 'APPLIED'";
    let mut is_resting = false;
    until_true("both setpoints applied", async || {
        keep_pace(&fleet, &pool, &mut is_resting).await;
        count(&pool, APPLIED).await == 2
    })
    .await;
    let more = fleet.contacts_made() + 300;
    until_true("contacts at the new pressures, and a status", async || {
        keep_pace(&fleet, &pool, &mut is_resting).await;
        fleet.contacts_made() >= more
    })
    .await;
    fleet.rest();
    until_true("every contact recorded", async || count(&pool, CONTACTS).await == fleet.contacts_made()).await;
    fleet.stop().await;
    service.stop().await;
    recorder.signal(Signal::SIGTERM);
    assert!(recorder.ended(PATIENCE).await.expect("the recorder must end").success());
    let log = std::fs::read_to_string(&log).unwrap();
    Recording { folder, log }
}

/// Lets the robot rest while the supervisor is behind. On a busy machine it would make so many contacts at a pressure
/// that the supervisor refines it, and these tests expect one setpoint for each whisker.
async fn keep_pace(fleet: &Fleet, pool: &SqlitePool, is_resting: &mut bool) {
    let is_behind = fleet.contacts_made() > count(pool, CONTACTS).await + BEHIND_MAX;
    if is_behind != *is_resting {
        *is_resting = is_behind;
        for robot in fleet.robots() {
            robot.with(|robot| if is_behind { robot.rest() } else { robot.touch_at_rate(RATE, now_us()) });
        }
    }
}

fn recorder(folder: &TempDir, port: u16) -> Process {
    let broker = format!("mqtt://127.0.0.1:{port}");
    let out = folder.path().join("recording.jsonl");
    let arguments = ["record", "--broker", &broker, "--fleet", "f", "--out", out.to_str().unwrap()];
    Process::start(Launch {
        program: PROGRAM.into(),
        arguments: arguments.map(str::to_owned).to_vec(),
        environment: vec![("RUST_LOG".to_owned(), "info".to_owned())],
        log: folder.path().join("log"),
    })
}

async fn service(folder: &TempDir, port: u16) -> Service {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = COLD_START;
    let fleet = Name::new("f").unwrap();
    let service = Service::start(ServiceOptions {
        kafka: vibrissa_supervisor::service::KafkaOptions::default(),
        access: vibrissa_supervisor::http::access::AccessOptions::default(),
        name: "s".to_owned(),
        fleets: vec![fleet.clone()],
        database: DatabaseAddress::Sqlite(folder.path().join("v.sqlite3")),
        is_new_installation: true,
        lease_time_to_live: LEASE_TIME_TO_LIVE,
        limits: vibrissa_supervisor::service::LimitOptions::default(),
        history: vibrissa_supervisor::service::HistoryOptions::default(),
        black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
        metrics_per_whisker: false,
        broker: Some(BrokerAddress::new("127.0.0.1", port)),
        mqtt_port: 0,
        mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
        http: "127.0.0.1:0".parse().unwrap(),
        webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
        traces: None,
        params,
    })
    .await
    .unwrap();
    let connected = service.metrics.of_fleet(&fleet).broker_connected;
    until_true("the connection to the broker", async || connected.get() == 1).await;
    service
}

/// Selected fields of lines, for comparison with rows.
fn fields(lines: &[Value], names: &[&str]) -> Vec<Value> {
    lines.iter().map(|line| names.iter().map(|&name| line[name].clone()).collect()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_replay_finds_the_trims_that_were_found_and_decides_as_was_decided() {
    let recording = recording().await;
    let text = replay(&recording.file(), &AS_THEN);
    let trims = recording
        .rows(
            "SELECT whisker, length_before_mm, length_after_mm, length_after_sd_mm, contacts_to_detect \
             FROM trims t JOIN whiskers w USING (whisker_id) ORDER BY trim_id",
            |row| {
                json!([
                    row.get::<i64, _>(0),
                    row.get::<f64, _>(1),
                    row.get::<f64, _>(2),
                    row.get::<f64, _>(3),
                    row.get::<i64, _>(4)
                ])
            },
        )
        .await;
    assert_eq!(trims.len(), 2, "{trims:?}");
    let names = ["whisker", "length_before_mm", "length_after_mm", "length_after_sd_mm", "contacts_to_detect"];
    assert_eq!(fields(&effects(&text, "TRIM"), &names), trims);
    let setpoints = recording
        .rows(
            "SELECT whisker, s.pressure_mpa, reason FROM setpoints s \
             JOIN whiskers w USING (whisker_id) ORDER BY version",
            |row| json!([row.get::<i64, _>(0), row.get::<f64, _>(1), row.get::<String, _>(2)]),
        )
        .await;
    assert_eq!(setpoints.len(), 2);
    assert_eq!(fields(&effects(&text, "SETPOINT"), &["whisker", "pressure_mpa", "reason"]), setpoints);
    let states = recording
        .rows(
            "SELECT state, pressure_mpa FROM setpoint_states WHERE state <> 'PENDING' ORDER BY setpoint_state_id",
            |row| json!([row.get::<String, _>(0), row.get::<Option<f64>, _>(1)]),
        )
        .await;
    assert_eq!(fields(&effects(&text, "SETPOINT_STATE"), &["state", "pressure_mpa"]), states);
    assert!(!text.contains("\"assumed\""), "all setpoints must be recorded ones");
}

#[tokio::test(flavor = "multi_thread")]
async fn property_every_length_after_every_contact_is_what_it_was_and_twice_the_bytes_are_the_same() {
    let recording = recording().await;
    let text = replay(&recording.file(), &AS_THEN);
    assert!(text == replay(&recording.file(), &AS_THEN), "two replays must give the same bytes");
    let contacts = recording
        .rows(
            "SELECT seq, c.position, t_us, used, residual, c.length_mm, c.length_sd_mm FROM contacts c ORDER BY contact_id",
            |row| {
                json!([
                    row.get::<i64, _>(0),
                    row.get::<i64, _>(1),
                    row.get::<i64, _>(2),
                    row.get::<String, _>(3),
                    row.get::<Option<f64>, _>(4),
                    row.get::<f64, _>(5),
                    row.get::<f64, _>(6)
                ])
            },
        )
        .await;
    assert!(contacts.len() > 300, "{}", contacts.len());
    let names = ["seq", "position", "t_us", "used", "residual", "length_mm", "length_sd_mm"];
    assert_eq!(fields(&effects(&text, "CONTACT"), &names), contacts);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_recording_has_what_robots_and_supervisors_said_and_tells_how_much() {
    let recording = recording().await;
    let text = std::fs::read_to_string(recording.file()).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert!(recording.log.contains(&format!("{} messages recorded", lines.len())), "{}", recording.log);
    for topic in ["connection", "factsheet", "contacts", "status", "receipt", "setpoint", "setpoint_state"] {
        let topic = format!("whisker/v1/f/r/{topic}");
        assert!(lines.iter().any(|line| line["topic"] == topic && line["payload"]["boot_id"].is_string()), "{topic}");
    }
    assert!(lines.is_sorted_by_key(|line| line["received_us"].as_u64().unwrap()));
    assert_eq!(replay(&recording.file(), &["--fleet", "other"]), "", "other fleets must be ignored");
}

#[tokio::test(flavor = "multi_thread")]
async fn two_policies_are_compared_on_the_same_traffic() {
    let recording = recording().await;
    let other = recording.folder.path().join("other.toml");
    std::fs::write(&other, "[policy]\nobjective = \"mean\"\n").unwrap();
    let compared = replay(&recording.file(), &[&AS_THEN[..], &["--policy", other.to_str().unwrap()]].concat());
    assert!(compared.contains("decisions that differ: 2"), "{compared}");
    assert!(compared.contains("f/r/left/0 (70 mm)\n  this: whisker 0 (SELF_COMPENSATION) at 0.0"), "{compared}");
    let row = |name: &str| {
        let line = compared.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{compared}"));
        line.split_whitespace().skip(1).map(|field| field.parse::<f64>().unwrap()).collect::<Vec<_>>()
    };
    let (ours, theirs) = (row("this "), row("other.toml "));
    // Compensated, uncompensated, ended; mean error; setpoints, in force.
    assert_eq!((&ours[..3], &ours[4..]), (&[2.0, 0.0, 0.0][..], &[2.0, 2.0][..]), "{compared}");
    assert_eq!((&theirs[..3], &theirs[4..]), (&[2.0, 0.0, 0.0][..], &[2.0, 2.0][..]), "{compared}");
    assert!(theirs[3] < ours[3], "the objective mean must give a smaller mean error: {compared}");

    std::fs::write(&other, "[policy]\nobjective = \"tip\"\n").unwrap();
    let compared = replay(&recording.file(), &[&AS_THEN[..], &["--policy", other.to_str().unwrap()]].concat());
    assert!(compared.contains("decisions that differ: 0"), "{compared}");
}

#[tokio::test(flavor = "multi_thread")]
async fn setpoints_that_were_never_sent_are_taken_to_be_applied() {
    let recording = recording().await;
    // No predicted error is below this limit, so there is no compensation, although the supervisor had sent two
    // setpoints.
    let nobody = replay(&recording.file(), &[&AS_THEN[..], &["--policy-predicted-error-max", "0.05"]].concat());
    assert_eq!(effects(&nobody, "SETPOINT"), Vec::<Value>::new());
    let alarms = effects(&nobody, "ALARM");
    assert_eq!(alarms.iter().filter(|line| line["kind"] == "UNCOMPENSATED").count(), 2, "{alarms:?}");
    // Pressures differ from the recorded ones, so the recorded answers are replaced.
    let other = replay(&recording.file(), &[&AS_THEN[..], &["--policy-objective", "mean"]].concat());
    let applied = effects(&other, "SETPOINT_STATE").into_iter().filter(|line| line["state"] == "APPLIED");
    let applied: Vec<Value> = applied.collect();
    let commanded = effects(&other, "SETPOINT");
    assert_eq!(commanded.len(), 2, "one setpoint per whisker");
    assert_eq!(fields(&applied, &["pressure_mpa"]), fields(&commanded, &["pressure_mpa"]));
    assert!(applied.iter().all(|line| line["assumed"] == true), "{applied:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_recorder_touches_no_file_that_is_there_and_ends_by_itself_when_its_time_is_over() {
    let broker = Mosquitto::start();
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let output = run(&["record", "--broker", &url, "--fleet", "f", "--for", "300ms"]);
    assert!(output.status.success() && output.stdout.is_empty(), "{output:?}");
    assert!(crate::program::errors(&output).contains("0 messages recorded"), "{output:?}");
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("there");
    std::fs::write(&file, "precious").unwrap();
    let output = run(&["record", "--broker", &url, "--out", file.to_str().unwrap(), "--for", "300ms"]);
    assert!(
        !output.status.success() && crate::program::errors(&output).contains("cannot create the recording"),
        "{output:?}"
    );
    assert_eq!(std::fs::read_to_string(&file).unwrap(), "precious");
    let output = run(&["record", "--for", "300ms"]);
    assert!(crate::program::errors(&output).contains("--broker mqtt://HOST:1883"), "{output:?}");
}
