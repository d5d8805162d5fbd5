//! Events in the log.

use std::time::Duration;

use serde_json::Value;
use vibrissa_protocol::{ArrayType, Contacts, Message, RobotTopic, SetpointOutcome, encode};
use vibrissa_tests::kafka::Kafka;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::stage::{CONTACTS, EVENTS, Events, LEARNED, PARTITIONS, Program};

pub(crate) async fn topics(kafka: &Kafka) {
    for topic in [EVENTS, CONTACTS] {
        kafka.create_topic(topic, PARTITIONS).await;
    }
}

async fn robot(broker: &Mosquitto) -> HandRobot {
    HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 68.0, 65.0])).await
}

/// Learns the robot's whiskers, cuts one, and applies the setpoint.
async fn cut(robot: &mut HandRobot) {
    for whisker in 0..3 {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.receipted().await;
    robot.cut(1, 62.0);
    robot.touch(1, 100).await;
    let (setpoint, _) = robot.setpoint().await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.touch(1, 20).await;
    robot.receipted().await;
}

/// Sends contacts, which may be lost.
async fn contacts(robot: &mut HandRobot, whisker: u16) -> Vec<Contacts> {
    let mut sent = Vec::new();
    for _ in 0..3 {
        let contacts = (0..20).map(|_| robot.contact(whisker)).collect();
        sent.push(robot.send(contacts).await);
    }
    sent
}

/// Sends messages again until all are receipted.
async fn delivered(robot: &mut HandRobot, sent: &[Contacts]) {
    until_true("receipts", async || {
        for message in sent {
            robot.say(RobotTopic::Contacts, encode(message)).await;
        }
        while let Some(heard) = robot.mqtt.next(Duration::from_millis(700)).await {
            if let Message::Receipt(receipt) = &heard.message
                && sent.iter().all(|message| receipt.covers(message.seq))
            {
                return true;
            }
        }
        false
    })
    .await;
}

/// Waits until the events are those of the database.
async fn complete(program: &Program, events: &mut Events) {
    until_true("all contacts in the log", async || {
        events.read().await;
        let stored = program.stored_contacts().await;
        !stored.is_empty() && events.contacts() == stored
    })
    .await;
}

#[tokio::test]
async fn a_cut_is_told_from_its_contacts_to_its_setpoint_once_and_as_the_schema_says() {
    let Some(kafka) = Kafka::start(1).await else { return };
    topics(&kafka).await;
    let broker = Mosquitto::start();
    let program = Program::start(broker.port(), &["--publish", "kafka", "--kafka-url", &kafka.url()]).await;
    cut(&mut robot(&broker).await).await;
    let mut events = Events::of(&kafka).await;
    complete(&program, &mut events).await;
    until_true("the applied setpoint", async || {
        events.read().await;
        events.of_type("SETPOINT_STATE").any(|event| event["data"]["setpoint"]["state"] == "APPLIED")
    })
    .await;
    let validator = jsonschema::validator_for(&vibrissa_supervisor::events::schema()).unwrap();
    for event in &events.all {
        assert!(validator.is_valid(event), "{event}: {:?}", validator.iter_errors(event).next().map(|e| e.to_string()));
    }
    let trims = program.list("trims").await;
    let trim_events: Vec<&Value> = events.of_type("TRIM").collect();
    assert_eq!((trim_events.len(), trims.len()), (1, 1), "{trim_events:?}");
    assert_eq!((&trim_events[0]["data"]["array"], &trim_events[0]["data"]["whisker"]), (&"left".into(), &1.into()));
    let setpoints = program.list("setpoints").await;
    assert_eq!(events.of_type("SETPOINT").count(), setpoints.len());
    let decided: Vec<&Value> = events.of_type("DECISION").collect();
    let of_setpoint = events.of_type("SETPOINT").next().unwrap()["data"]["setpoint"]["compensation_id"].as_i64();
    assert!(
        decided.iter().any(|event| event["data"]["decision"]["compensation_id"].as_i64() == of_setpoint),
        "{decided:?}"
    );
    assert_eq!(events.repeated(), 0, "nothing failed");
}

#[tokio::test]
async fn chaos_kills_of_the_supervisor_and_of_the_broker_lose_no_event_and_repeat_none_for_a_reader() {
    let Some(mut kafka) = Kafka::start(1).await else { return };
    topics(&kafka).await;
    let broker = Mosquitto::start();
    let mut program = Program::start(broker.port(), &["--publish", "kafka", "--kafka-url", &kafka.url()]).await;
    let mut robot = robot(&broker).await;
    let mut events = Events::of(&kafka).await;
    for round in 0..6 {
        // A kill may come before and after the commit, the write to the log, and its acknowledgement.
        let sent = contacts(&mut robot, round % 3).await;
        if round % 2 == 0 {
            delivered(&mut robot, &sent).await;
        }
        match round % 3 {
            0 => program.kill_and_restart().await,
            1 => {
                kafka.kill(0);
                let more = contacts(&mut robot, 0).await;
                delivered(&mut robot, &more).await;
                kafka.restart(0).await;
            }
            _ => {
                kafka.kill(0);
                let more = contacts(&mut robot, 0).await;
                delivered(&mut robot, &more).await;
                program.kill_and_restart().await;
                kafka.restart(0).await;
            }
        }
        delivered(&mut robot, &sent).await;
        events.read().await;
    }
    complete(&program, &mut events).await;
    assert_eq!(events.contacts().len(), 10 * 60);
}

#[tokio::test]
async fn a_reader_recognises_events_whose_acknowledgement_was_lost() {
    let Some(kafka) = Kafka::start(1).await else { return };
    topics(&kafka).await;
    let broker = Mosquitto::start();
    let mut program = Program::start(broker.port(), &["--publish", "kafka", "--kafka-url", &kafka.url()]).await;
    // Keeps the events of contacts, as if their removal had failed.
    let mut database = program.database().await;
    let keep = "CREATE TRIGGER keep BEFORE DELETE ON events BEGIN SELECT RAISE(IGNORE); END";
    sqlx::query(keep).execute(&mut database).await.unwrap();
    let mut robot = robot(&broker).await;
    robot.touch(0, 60).await;
    robot.receipted().await;
    let mut events = Events::of(&kafka).await;
    complete(&program, &mut events).await;
    program.process.kill();
    sqlx::query("DROP TRIGGER keep").execute(&mut database).await.unwrap();
    sqlx::query("UPDATE event_positions SET event_id = 0").execute(&mut database).await.unwrap();
    drop(database);
    program.process.restart();
    program.answers().await;
    until_true("repeated events", async || {
        events.read().await;
        events.repeated() > 0
    })
    .await;
    robot.settle().await;
    robot.touch(0, 40).await;
    complete(&program, &mut events).await;
}

#[tokio::test]
async fn events_wait_for_a_log_without_their_topic() {
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(EVENTS, PARTITIONS).await;
    let broker = Mosquitto::start();
    let program = Program::start(broker.port(), &["--publish", "kafka", "--kafka-url", &kafka.url()]).await;
    let mut robot = robot(&broker).await;
    robot.touch(0, 60).await;
    robot.receipted().await;
    until_true("waiting events", async || {
        program.metric("vibrissa_kafka_outbox_events{").await > 0.0
            && program.metric("vibrissa_kafka_writes_failed_total{").await > 0.0
    })
    .await;
    assert!(program.log().contains("the log has no topic \"vibrissa.contacts\""), "{}", program.log());
    kafka.create_topic(CONTACTS, PARTITIONS).await;
    let mut events = Events::of(&kafka).await;
    complete(&program, &mut events).await;
    until_true("an empty outbox", async || program.metric("vibrissa_kafka_outbox_events{").await == 0.0).await;
}
