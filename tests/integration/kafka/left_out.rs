//! Contacts that are left out while the log is away for long.

use std::collections::BTreeSet;

use serde_json::Value;
use vibrissa_protocol::{ArrayType, SetpointOutcome};
use vibrissa_tests::kafka::Kafka;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::stage::{CONTACTS, EVENTS, Events, LEARNED, PARTITIONS, Program};

/// The limit of the test, bytes.
const LIMIT: f64 = 1024.0 * 1024.0;
const LEFT_OUT: &str = "vibrissa_kafka_contacts_left_out_total{";
const WAITING: &str = "vibrissa_kafka_outbox_bytes{";

/// Bytes of all waiting events in the database.
async fn waiting_bytes(program: &Program) -> f64 {
    let sql = "SELECT coalesce(sum(length(e.data)), 0) FROM events e JOIN event_positions p ON p.fleet = e.fleet \
         WHERE e.event_id > p.event_id";
    let bytes: i64 = sqlx::query_scalar(sql).fetch_one(&mut program.database().await).await.unwrap();
    bytes as f64
}

/// The events of the topic of contacts: sequence number of the message, `None` where contacts are missing.
fn messages(events: &Events) -> Vec<Option<i64>> {
    let of_contacts = events.all.iter().filter(|event| event["type"].as_str().unwrap().starts_with("CONTACTS"));
    of_contacts.map(|event| event["data"]["contacts"]["seq"].as_i64()).collect()
}

async fn published(events: &mut Events, what: &str, is_there: impl Fn(&Events) -> bool) {
    until_true(what, async || {
        events.read().await;
        is_there(events)
    })
    .await;
}

#[tokio::test]
async fn contacts_beyond_the_limit_are_left_out_and_told_and_all_else_is_kept() {
    let Some(mut kafka) = Kafka::start(1).await else { return };
    for topic in [EVENTS, CONTACTS] {
        kafka.create_topic(topic, PARTITIONS).await;
    }
    let broker = Mosquitto::start();
    let arguments = ["--publish", "kafka", "--kafka-url", &kafka.url(), "--kafka-waiting-mib-max", "1"];
    let mut program = Program::start(broker.port(), &arguments).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 68.0, 65.0])).await;
    for whisker in 0..3 {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.receipted().await;
    let mut events = Events::of(&kafka).await;
    published(&mut events, "the first contacts", |events| events.contacts().len() == 3 * (LEARNED + 20)).await;
    assert_eq!(program.metric(LEFT_OUT).await, 0.0);

    kafka.kill(0);
    until_true("the limit", async || {
        robot.touch(0, 200).await;
        robot.receipted().await;
        program.metric(LEFT_OUT).await > 0.0
    })
    .await;
    let full = waiting_bytes(&program).await;
    assert!((LIMIT..1.1 * LIMIT).contains(&full), "{full} bytes wait");
    let waiting = program.stored_count().await - 3 * (LEARNED + 20) - program.metric(LEFT_OUT).await as usize;
    eprintln!("{:.0} bytes of a waiting contact", full / waiting as f64);
    // Nothing but contacts is missing.
    robot.cut(1, 62.0);
    robot.touch(1, 100).await;
    let (setpoint, _) = robot.setpoint().await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.touch(1, 200).await;
    robot.receipted().await;
    let more = waiting_bytes(&program).await - full;
    assert!(more < 0.02 * LIMIT, "{more} bytes came after the limit");
    let before_kill = program.metric(LEFT_OUT).await;
    assert!(before_kill >= 300.0, "{before_kill} contacts are left out");

    // The next owner keeps the limit.
    program.kill_and_restart().await;
    until_true("a measured outbox", async || program.metric(WAITING).await >= LIMIT).await;
    robot.settle().await;
    robot.touch(0, 60).await;
    robot.receipted().await;
    let after_kill = program.metric(LEFT_OUT).await;
    assert!(after_kill >= 60.0, "{after_kill} contacts are left out");

    kafka.restart(0).await;
    until_true("an empty outbox", async || {
        program.metric(WAITING).await == 0.0 && waiting_bytes(&program).await == 0.0
    })
    .await;
    assert_eq!(program.metric(LEFT_OUT).await, after_kill);
    robot.touch(0, 40).await;
    robot.receipted().await;
    let stored = program.stored_contacts().await;
    let left_out = (before_kill + after_kill) as usize;
    published(&mut events, "all kept contacts", |events| events.contacts().len() == stored.len() - left_out).await;
    published(&mut events, "the applied setpoint", |events| {
        events.of_type("SETPOINT_STATE").any(|event| event["data"]["setpoint"]["state"] == "APPLIED")
    })
    .await;
    let setpoints = program.list("setpoints").await.len();
    published(&mut events, "each setpoint", |events| events.of_type("SETPOINT").count() >= setpoints).await;

    assert!(events.contacts().is_subset(&stored));
    let validator = jsonschema::validator_for(&vibrissa_supervisor::events::schema()).unwrap();
    for event in &events.all {
        assert!(validator.is_valid(event), "{event}");
    }
    let trims: BTreeSet<i64> =
        program.list("trims").await.iter().map(|trim| trim["trim_id"].as_i64().unwrap()).collect();
    let reported: BTreeSet<i64> =
        events.of_type("TRIM").map(|event| event["data"]["trim"]["trim_id"].as_i64().unwrap()).collect();
    assert!(!trims.is_empty() && reported == trims, "{reported:?} of {trims:?}");
    assert_eq!(events.of_type("SETPOINT").count(), setpoints);
    assert!(events.of_type("DECISION").count() > 0);
    // In order, with one event of each owner in the only gap, and the number in the next event.
    let order = messages(&events);
    let kept: Vec<i64> = order.iter().flatten().copied().collect();
    assert!(kept.is_sorted_by(|one, next| one < next), "{kept:?}");
    let gap: Vec<usize> = (0..order.len()).filter(|&at| order[at].is_none()).collect();
    assert!(matches!(gap[..], [one, other] if other == one + 1), "{gap:?} of {order:?}");
    let left_out_events: Vec<&Value> =
        events.of_type("CONTACTS").filter(|event| !event["data"]["contacts"]["left_out"].is_null()).collect();
    assert_eq!(left_out_events.len(), 1, "{left_out_events:?}");
    assert_eq!(left_out_events[0]["data"]["contacts"]["left_out"].as_f64(), Some(after_kill));
    assert_eq!(left_out_events[0]["data"]["contacts"]["seq"].as_i64(), order[gap[1] + 1]);
    let log = program.log();
    let lines = |text: &str| log.lines().filter(|line| line.contains(text)).count();
    assert_eq!((lines("contacts are left out"), lines("contacts are published again")), (2, 1), "{log}");
}
