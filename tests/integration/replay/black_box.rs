//! Black boxes: recorded by a supervisor around cuts, downloaded, and replayed.

use std::path::PathBuf;
use std::time::Duration;

use nix::sys::signal::Signal;
use serde_json::{Value, json};
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::ask;

use crate::program::{PROGRAM, effects, replay, run};

/// Whisker 0 is cut after seconds of contacts, so that the box begins with a learned state. No whisker can compensate for
/// whisker 2, which raises an alarm.
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
    { whisker = 1, length_mm = 65.0, neighbours = [0] },
    { whisker = 2, length_mm = 70.0, neighbours = [] },
]
[[robots.events]]
at_contact = 640
array = "left"
whisker = 0
change = { kind = "TRIM", length_mm = 65.0 }
[[robots.events]]
at_contact = 680
array = "left"
whisker = 2
change = { kind = "TRIM", length_mm = 50.0 }
"#;
/// Flags with the parameters of the recording supervisor.
const AS_THEN: [&str; 2] = ["--detection-cold-start-contacts", "60"];

/// Topics of the robot's messages.
const FROM_ROBOT: [&str; 5] = ["connection", "factsheet", "contacts", "status", "setpoint_state"];

struct Stage {
    folder: tempfile::TempDir,
    broker: Mosquitto,
    http: u16,
    process: Process,
}

impl Stage {
    fn start(seconds: u32) -> Self {
        let (folder, broker, http) = (tempfile::tempdir().unwrap(), Mosquitto::start(), free_port());
        let process = launch(&folder, &broker, http, seconds);
        Self { folder, broker, http, process }
    }

    /// A file in the folder of this test.
    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    async fn get(&self, path: &str) -> Option<Value> {
        Some(ask(([127, 0, 0, 1], self.http).into(), "GET", path, &[]).await.ok()?.json())
    }

    async fn items(&self, path: &str) -> Vec<Value> {
        self.get(path).await.and_then(|page| page["items"].as_array().cloned()).unwrap_or_default()
    }

    async fn ready(&self) {
        let says = async || {
            ask(([127, 0, 0, 1], self.http).into(), "GET", "/readyz", &[]).await.is_ok_and(|one| one.status == 200)
        };
        until_true("the supervisor is ready", says).await;
    }

    /// The first box in this state.
    async fn black_box(&self, state: &str) -> Value {
        let found = async || self.items("/v1/black-boxes").await.into_iter().find(|one| one["state"] == state);
        until(&format!("a box in the state {state}"), found).await
    }

    /// Saves the recording of a box, and returns its lines.
    async fn save(&self, one: &Value, name: &str) -> Vec<Value> {
        let path = format!("/v1/black-boxes/{}/recording", one["black_box_id"]);
        let answer = ask(([127, 0, 0, 1], self.http).into(), "GET", &path, &[]).await.unwrap();
        assert_eq!(answer.status, 200);
        std::fs::write(self.file(name), &answer.body).unwrap();
        answer.body.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }
}

fn launch(folder: &tempfile::TempDir, broker: &Mosquitto, http: u16, seconds: u32) -> Process {
    let database = format!("sqlite:{}", folder.path().join("v.sqlite3").display());
    let arguments = [
        "run".to_owned(),
        "--fleet=f".to_owned(),
        format!("--broker=mqtt://127.0.0.1:{}", broker.port()),
        format!("--http=127.0.0.1:{http}"),
        format!("--database-url={database}"),
        format!("--black-box-seconds={seconds}"),
        "--detection-cold-start-contacts=60".to_owned(),
    ];
    Process::start(Launch {
        program: PROGRAM.into(),
        arguments: arguments.to_vec(),
        environment: vec![("RUST_LOG".to_owned(), "info".to_owned())],
        log: folder.path().join("log"),
    })
}

fn fleet(stage: &Stage) -> Fleet {
    Fleet::start(&Scenario::from_toml_str(SCENARIO).unwrap(), &Broker::new("127.0.0.1", stage.broker.port())).unwrap()
}

/// Selected fields, for comparison.
fn fields(rows: &[Value], names: &[&str]) -> Vec<Value> {
    rows.iter().map(|row| names.iter().map(|&name| row[name].clone()).collect()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_box_of_a_cut_has_what_was_said_and_its_replay_finds_the_same_cut() {
    let stage = Stage::start(3);
    stage.ready().await;
    let fleet = fleet(&stage);
    let one = stage.black_box("COMPLETE").await;
    fleet.rest();
    assert_eq!(
        (&one["cause"], &one["has_state"], &one["left_out"]),
        (&json!("TRIM"), &json!(true), &json!(0)),
        "{one}"
    );
    let lines = stage.save(&one, "box.jsonl").await;
    // The supervisor's own lines have the time at which they were made, and messages that waited meanwhile earlier ones.
    let received = |line: &&Value| FROM_ROBOT.iter().any(|topic| line["topic"] == format!("whisker/v1/f/r/{topic}"));
    let received = lines.iter().filter(received);
    assert!(received.is_sorted_by_key(|line| line["received_us"].as_u64().unwrap()));
    assert_eq!(lines[0]["topic"], "vibrissa/black-box/f/r");
    assert_eq!(lines[0]["payload"]["state"], "COMPLETE");
    assert_eq!(lines[1]["topic"], "vibrissa/robot-state/f/r");
    let has = |topic: &str| lines.iter().any(|line| line["topic"] == format!("whisker/v1/f/r/{topic}"));
    for topic in FROM_ROBOT.into_iter().chain(["receipt", "setpoint"]) {
        assert!(has(topic), "{topic}");
    }
    // At least three seconds before and after, by the times of the messages.
    let us = |line: &Value| line["received_us"].as_u64().unwrap();
    let event = lines[0]["payload"]["event_us"].as_u64().unwrap();
    assert!(us(&lines[1]) + 3_000_000 <= event, "{one}");
    assert!(us(lines.last().unwrap()) + 500_000 > event + 3_000_000, "{one}");

    // The truth is what the supervisor found at that time.
    let text = replay(&stage.file("box.jsonl"), &AS_THEN);
    let names = ["whisker", "length_before_mm", "length_after_mm", "contacts_to_detect"];
    let mut trims = stage.items("/v1/trims?sort=detected_at").await;
    trims.sort_by_key(|trim| trim["trim_id"].as_i64());
    let ends = lines.last().unwrap()["received_us"].as_u64().unwrap();
    let replayed = fields(&effects(&text, "TRIM"), &names);
    assert!(!replayed.is_empty() && replayed.len() <= trims.len(), "{replayed:?} until {ends}");
    assert_eq!(replayed, fields(&trims[..replayed.len()], &names));
    let setpoints = effects(&text, "SETPOINT");
    let applied = stage.items("/v1/setpoints").await;
    assert!(
        applied.iter().any(|state| state["pressure_mpa"] == setpoints[0]["pressure_mpa"]),
        "{setpoints:?} {applied:?}"
    );
    assert!(!text.contains("\"assumed\""), "the answers are in the box");

    // Each trim and each alarm about a whisker links to a box, and MCAP files are made of it as of any recording.
    assert!(trims.iter().all(|trim| trim["black_box_id"].is_i64()), "{trims:?}");
    let mcap = stage.file("box.mcap");
    let written = run(&["export", "--mcap", stage.file("box.jsonl").to_str().unwrap(), mcap.to_str().unwrap()]);
    assert!(written.status.success() && std::fs::metadata(&mcap).unwrap().len() > 1000, "{written:?}");
    fleet.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn after_a_kill_the_box_is_partial_and_still_shows_the_cut() {
    let mut stage = Stage::start(60);
    stage.ready().await;
    let fleet = fleet(&stage);
    let begun = stage.black_box("RECORDING").await;
    stage.process.signal(Signal::SIGKILL);
    stage.process.ended(Duration::from_secs(10)).await.expect("killed");
    fleet.rest();
    stage.process = launch(&stage.folder, &stage.broker, stage.http, 60);
    let one = stage.black_box("PARTIAL").await;
    assert_eq!(one["black_box_id"], begun["black_box_id"]);
    let lines = stage.save(&one, "box.jsonl").await;
    assert_eq!(lines[0]["payload"]["state"], "PARTIAL");
    let text = replay(&stage.file("box.jsonl"), &AS_THEN);
    assert_eq!(effects(&text, "TRIM").len(), 1, "the box was written at the cut");
    fleet.stop().await;
}
