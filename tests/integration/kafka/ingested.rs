//! Contacts that come from the log.

use std::collections::BTreeSet;
use std::sync::Arc;

use vibrissa_protocol::{ArrayType, Contacts, RobotTopic, SetpointOutcome};
use vibrissa_tests::kafka::{Bridge, BridgeOptions, Compression, Kafka, record};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::bridge::{MESSAGES, record_of, records};
use crate::stage::{LEARNED, Program};

/// Arguments of a supervisor whose contacts come from the log.
fn from_log(kafka: &Kafka) -> Vec<String> {
    ["--ingest", "kafka", "--kafka-url", &kafka.url()].map(str::to_owned).to_vec()
}

pub(crate) async fn program(kafka: &Kafka, broker: &Mosquitto, more: &[&str]) -> Program {
    let arguments = from_log(kafka);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).chain(more.iter().copied()).collect();
    Program::start(broker.port(), &arguments).await
}

/// A robot that has connected, and whose factsheet is known.
pub(crate) async fn robot(broker: &Mosquitto, program: &Program) -> HandRobot {
    let mut robot = HandRobot::connect(broker.port(), "r", array(ArrayType::Type1, &[70.0, 68.0, 65.0])).await;
    robot.birth().await;
    until_true("a known robot", async || {
        program.list("whiskers").await.len() == 3 && program.metric("vibrissa_kafka_connected{").await == 1.0
    })
    .await;
    robot
}

/// Messages that nobody has sent.
pub(crate) fn messages(robot: &mut HandRobot, count: usize) -> Vec<Contacts> {
    (0..count)
        .map(|number| {
            let contacts = (0..10).map(|_| robot.contact((number % 3) as u16)).collect();
            robot.message(contacts)
        })
        .collect()
}

/// The contacts of messages, as the database names them.
pub(crate) fn named(messages: &[Contacts]) -> BTreeSet<(String, i64, i64)> {
    let contacts = messages.iter().flat_map(|message| {
        let name = |position| (message.boot_id.as_str().to_owned(), message.seq as i64, position);
        (0..message.contacts.len() as i64).map(name)
    });
    contacts.collect()
}

/// Waits until the database has the contacts of these messages, each once, and the states of the whiskers count them.
pub(crate) async fn stored(program: &Program, messages: &[Contacts]) {
    let expected = named(messages);
    let mut found = BTreeSet::new();
    let begun = std::time::Instant::now();
    while found != expected {
        assert!(
            begun.elapsed() < vibrissa_tests::wait::PATIENCE,
            "{} of {} contacts; {}",
            found.len(),
            expected.len(),
            program.log().lines().rev().take(12).collect::<Vec<_>>().join("\n")
        );
        tokio::time::sleep(std::time::Duration::from_millis(100)).await;
        found = program.stored_contacts().await;
    }
    assert_eq!(program.stored_count().await, expected.len(), "each once");
}

#[tokio::test]
async fn a_fleet_whose_contacts_come_from_the_log_is_compensated_as_over_mqtt() {
    let Some(kafka) = Kafka::start(1).await else { return };
    let kafka = Arc::new(kafka);
    kafka.create_topic(MESSAGES, 1).await;
    let broker = Mosquitto::start();
    let program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    // Without the bridge nothing is heard.
    robot.touch(0, 20).await;
    let options = BridgeOptions {
        mqtt: broker.port(),
        topic: MESSAGES,
        partitions: 1,
        fleet: "f",
        robots: vec!["r".to_owned()],
        repeats: false,
    };
    let bridge = Bridge::start(&kafka, options).await;
    robot.status().await;
    for whisker in 0..3 {
        robot.touch(whisker, LEARNED + 20).await;
    }
    until_true("contacts", async || program.stored_contacts().await.len() == 3 * (LEARNED + 20)).await;
    robot.cut(1, 62.0);
    robot.touch(1, 100).await;
    let (setpoint, _) = robot.setpoint().await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    until_true("an applied setpoint", async || {
        program.list("setpoints").await.iter().any(|one| one["state"] == "APPLIED")
    })
    .await;
    assert_eq!(program.list("trims").await.len(), 1);
    drop(bridge);
}

#[tokio::test]
async fn chaos_killed_supervisors_and_brokers_lose_no_record_and_apply_none_twice() {
    let Some(mut kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, 1).await;
    let broker = Mosquitto::start();
    let mut program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let mut all = Vec::new();
    for round in 0..6 {
        let some = messages(&mut robot, 50);
        kafka.write(MESSAGES, 0, records("r", &some)).await;
        all.extend(some);
        match round % 3 {
            // Nobody sends these records again.
            0 => program.kill_and_restart().await,
            1 => {
                kafka.kill(0);
                program.kill_and_restart().await;
                kafka.restart(0).await;
            }
            _ => stored(&program, &all).await,
        }
    }
    stored(&program, &all).await;
    // A kill before the next checkpoints: the state comes from a replay of the log.
    let used = program.used_contacts().await;
    assert!(used.iter().sum::<i64>() > 1000, "{used:?}");
    program.kill_and_restart().await;
    until_true("replayed states", async || {
        program.estimates().await.iter().map(|(contacts, _, _)| *contacts).eq(used.iter().copied())
    })
    .await;
    let last = program.last_estimates().await;
    let of_state: Vec<(f64, f64)> = program.estimates().await.iter().map(|(_, mm, sd_mm)| (*mm, *sd_mm)).collect();
    assert_eq!(of_state, last, "the estimates after the last contacts, to the last bit");
}

#[tokio::test]
async fn replayed_offsets_and_malformed_records_change_nothing_and_are_counted() {
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, 1).await;
    let broker = Mosquitto::start();
    let mut program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let all = messages(&mut robot, 60);
    kafka.write(MESSAGES, 0, records("r", &all[..30])).await;
    let mut bad = vec![
        record_of("r", RobotTopic::Contacts, b"no JSON".to_vec()),
        record("r", "elsewhere/r", b"{}".to_vec()),
        record("r", "whisker/v1/other/r/contacts", b"{}".to_vec()),
        record_of("r", RobotTopic::Factsheet, b"{}".to_vec()),
        record_of("nobody", RobotTopic::Contacts, b"{}".to_vec()),
    ];
    bad[0].headers.insert("dup".to_owned(), b"x".to_vec());
    let mut empty = record_of("r", RobotTopic::Contacts, Vec::new());
    empty.value = None;
    bad.push(empty);
    kafka.write(MESSAGES, 0, bad).await;
    // A producer that repeats what it has written.
    kafka.write(MESSAGES, 0, records("r", &all[..30])).await;
    kafka.write(MESSAGES, 0, records("r", &all[30..])).await;
    stored(&program, &all).await;
    for (reason, count) in [("NO_TOPIC", 1.0), ("CONTRADICTION", 1.0), ("OTHER_MESSAGE", 1.0), ("NO_VALUE", 1.0)] {
        let name = format!("vibrissa_kafka_records_skipped_total{{fleet=\"f\",reason=\"{reason}\"");
        assert_eq!(program.metric(&name).await, count, "{reason}");
    }
    assert_eq!(program.metric("vibrissa_messages_duplicate_total{").await, 30.0);
    // An operator sets the position back.
    program.process.kill();
    sqlx::query("UPDATE log_positions SET next = 0").execute(&mut program.database().await).await.unwrap();
    program.process.restart();
    program.answers().await;
    until_true("all records again", async || program.metric("vibrissa_messages_duplicate_total{").await == 90.0).await;
    stored(&program, &all).await;
}

#[tokio::test]
async fn regress_a_damaged_batch_is_set_aside_and_compressed_ones_are_read() {
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, 1).await;
    let broker = Mosquitto::start();
    let mut program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let all = messages(&mut robot, 60);
    for (compression, part) in [(Compression::Gzip, &all[..10]), (Compression::Snappy, &all[10..20])] {
        kafka.write_compressed(MESSAGES, 0, records("r", part), compression).await;
    }
    stored(&program, &all[..20]).await;
    program.process.kill();
    for part in [&all[20..30], &all[30..40], &all[40..]] {
        kafka.write(MESSAGES, 0, records("r", part)).await;
    }
    kafka.damage(format!("\"seq\":{},", all[35].seq).as_bytes());
    program.process.restart();
    program.answers().await;
    let kept: Vec<Contacts> = all[..30].iter().chain(&all[40..]).cloned().collect();
    stored(&program, &kept).await;
    for name in [
        "vibrissa_kafka_records_skipped_total{fleet=\"f\",reason=\"UNREADABLE\"",
        "vibrissa_items_set_aside_total{fleet=\"f\",reader=\"LOG\"",
    ] {
        assert_eq!(program.metric(name).await, 10.0, "{name}");
    }
    assert!(program.log().contains("records of the log cannot be read and are set aside"));
}

/// Kafka's own implementations of the codecs have packed these batches.
#[tokio::test]
async fn regress_batches_of_each_codec_are_read_and_one_of_each_that_unpacks_to_too_much_is_set_aside() {
    /// Longer than what the supervisor unpacks; packed by snappy it is still shorter than the broker's limit of 1 MiB.
    const LONG: usize = 18 * 1024 * 1024;
    let Some(mut kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, 1).await;
    let broker = Mosquitto::start();
    let program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let all = messages(&mut robot, 40);
    for (at, (codec, part)) in ["lz4", "zstd", "gzip", "snappy"].into_iter().zip(all.chunks(10)).enumerate() {
        kafka.restart_with_codec(0, codec).await;
        kafka.write(MESSAGES, 0, records("r", &part[..5])).await;
        let long = vec![record_of("r", RobotTopic::Contacts, vec![b' '; LONG])];
        kafka.write_compressed(MESSAGES, 0, long, Compression::Gzip).await;
        kafka.write(MESSAGES, 0, records("r", &part[5..])).await;
        stored(&program, &all[..10 * (at + 1)]).await;
        let problem = format!("a batch unpacks by {codec} to more than 16 MiB");
        let (_, readyz) = vibrissa_tests::web::try_get(program.http, "/readyz").await.unwrap();
        assert!(readyz.contains(&problem) && program.log().contains(&problem), "{readyz}");
        let counted = "vibrissa_items_set_aside_total{fleet=\"f\",reader=\"LOG\"";
        // A write without an answer is repeated.
        assert!(program.metric(counted).await >= (at + 1) as f64, "{codec}");
    }
}

#[tokio::test]
async fn negative_control_a_position_before_the_state_loses_contacts() {
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, 1).await;
    let broker = Mosquitto::start();
    let mut program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    program.plant_fault("offset_before_state").await;
    until_true("the log", async || program.metric("vibrissa_kafka_connected{").await == 1.0).await;
    let all = messages(&mut robot, 60);
    let mut database = program.database().await;
    let next = async |database: &mut sqlx::sqlite::SqliteConnection| -> i64 {
        let sql = "SELECT next FROM log_positions";
        let next: Option<i64> = sqlx::query_scalar(sql).fetch_optional(database).await.unwrap();
        next.unwrap_or_default()
    };
    kafka.write(MESSAGES, 0, records("r", &all)).await;
    // Not more than some milliseconds after the position, and before the state, which waits for its group of messages.
    while next(&mut database).await < 60 {
        tokio::task::yield_now().await;
    }
    program.process.kill();
    let stored = program.stored_contacts().await.len();
    assert!(stored < 600, "the fault lost nothing: {stored}");
    program.remove_fault().await;
    let more = messages(&mut robot, 1);
    kafka.write(MESSAGES, 0, records("r", &more)).await;
    until_true("later contacts", async || named(&more).is_subset(&program.stored_contacts().await)).await;
    assert_eq!(program.stored_contacts().await.len(), stored + 10, "the records are lost for good");
}

/// The engine asked a reader that never read whether the log is away, and excused all silence.
#[tokio::test]
async fn regress_a_robot_falls_silent_while_the_log_answers() {
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, 1).await;
    let broker = Mosquitto::start();
    let program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let all = messages(&mut robot, 10);
    kafka.write(MESSAGES, 0, records("r", &all)).await;
    stored(&program, &all).await;
    until_true("an alarm", async || program.list("alarms").await.iter().any(|alarm| alarm["kind"] == "ROBOT_SILENT"))
        .await;
}
