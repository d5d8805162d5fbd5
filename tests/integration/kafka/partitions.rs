//! The partitions of the topic that contacts come from.

use std::time::Duration;

use vibrissa_protocol::Contacts;
use vibrissa_tests::kafka::{Kafka, Writer};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::wait::{found_within, until_true};

use crate::bridge::{MESSAGES, records};
use crate::ingested::{messages, named, program, robot, stored};

/// Time limit of a write to a broker that runs.
const WRITTEN: Duration = Duration::from_secs(10);

/// Next offsets in the database, by partition.
async fn positions(program: &crate::stage::Program) -> Vec<(i64, i64)> {
    let sql = "SELECT log_partition, next FROM log_positions WHERE fleet = 'f' AND topic = $1 ORDER BY log_partition";
    sqlx::query_as(sql).bind(MESSAGES).fetch_all(&mut program.database().await).await.unwrap()
}

#[tokio::test]
async fn a_partition_that_is_added_is_read_from_its_first_record() {
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, 2).await;
    let broker = Mosquitto::start();
    let mut program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let all = messages(&mut robot, 30);
    kafka.write(MESSAGES, 1, records("r", &all[..10])).await;
    stored(&program, &all[..10]).await;
    kafka.raise_partitions(MESSAGES, 4).await;
    // The key of the robot leads to another partition now.
    kafka.write(MESSAGES, 3, records("r", &all[10..20])).await;
    until_true("the new partition", async || named(&all[..20]).is_subset(&program.stored_contacts().await)).await;
    until_true("all partitions answer", async || {
        program.metric("vibrissa_kafka_connected{").await == 1.0
            && program.metric("vibrissa_kafka_lag_records{").await == 0.0
    })
    .await;
    program.process.kill();
    kafka.write(MESSAGES, 2, records("r", &all[20..])).await;
    program.process.restart();
    program.answers().await;
    stored(&program, &all).await;
    assert_eq!(positions(&program).await, [(1, 10), (2, 10), (3, 10)]);
    assert_eq!(program.metric("vibrissa_messages_duplicate_total{").await, 0.0, "no partition is read twice");
}

/// A writer without keys.
#[tokio::test]
async fn contacts_of_a_robot_in_five_partitions_are_all_recorded_and_replayed_in_the_same_order() {
    const PARTITIONS: usize = 5;
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(MESSAGES, PARTITIONS as u32).await;
    let broker = Mosquitto::start();
    let mut program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let all = messages(&mut robot, 100);
    for part in all.chunks(25) {
        for partition in 0..PARTITIONS {
            let some: Vec<Contacts> = part.iter().skip(partition).step_by(PARTITIONS).cloned().collect();
            kafka.write(MESSAGES, partition as u32, records("r", &some)).await;
        }
        stored(&program, &named_before(&all, part)).await;
    }
    let used = program.used_contacts().await;
    program.kill_and_restart().await;
    until_true("replayed states", async || {
        program.estimates().await.iter().map(|(contacts, _, _)| *contacts).eq(used.iter().copied())
    })
    .await;
    let of_state: Vec<(f64, f64)> = program.estimates().await.iter().map(|(_, mm, sd_mm)| (*mm, *sd_mm)).collect();
    assert_eq!(of_state, program.last_estimates().await, "the estimates after the last contacts, to the last bit");
    assert_eq!(program.stored_count().await, named(&all).len());
}

/// All messages up to the last one of a part.
fn named_before(all: &[Contacts], part: &[Contacts]) -> Vec<Contacts> {
    let last = part.last().map_or(0, |message| message.seq);
    all.iter().filter(|message| message.seq <= last).cloned().collect()
}

/// Each broker leads a partition that the others do not have.
#[tokio::test]
async fn a_partition_without_a_broker_does_not_stop_the_others() {
    const PARTITIONS: u32 = 3;
    let Some(mut kafka) = Kafka::start(PARTITIONS as usize).await else { return };
    kafka.create_replicated_topic(MESSAGES, PARTITIONS, 1).await;
    let broker = Mosquitto::start();
    let program = program(&kafka, &broker, &[]).await;
    let mut robot = robot(&broker, &program).await;
    let mut all = Vec::new();
    let mut stopped = Vec::new();
    kafka.kill(0);
    until_true("the stopped partition", async || program.metric("vibrissa_kafka_connected{").await == 0.0).await;
    for partition in 0..PARTITIONS {
        let some = messages(&mut robot, 10);
        let mut writer = Writer::new(kafka.addresses(), MESSAGES, partition);
        let written = found_within(WRITTEN, async || writer.write(records("r", &some)).await.then_some(())).await;
        if written.is_some() {
            all.extend(some);
        } else {
            stopped.push((partition, some));
        }
    }
    assert_eq!(stopped.len(), 1, "one partition is without a broker");
    stored(&program, &all).await;
    assert_eq!(program.metric("vibrissa_kafka_connected{").await, 0.0);
    kafka.restart(0).await;
    for (partition, some) in stopped {
        kafka.write(MESSAGES, partition, records("r", &some)).await;
        all.extend(some);
    }
    // A write without an answer may have come to the broker, too.
    until_true("all contacts", async || program.stored_contacts().await == named(&all)).await;
    until_true("all partitions answer", async || program.metric("vibrissa_kafka_connected{").await == 1.0).await;
}

#[tokio::test]
async fn a_missing_topic_is_named_and_read_once_it_is_there() {
    let Some(kafka) = Kafka::start(1).await else { return };
    let broker = Mosquitto::start();
    let program = program(&kafka, &broker, &[]).await;
    let problem = format!("the log has no topic {MESSAGES:?}");
    until_true("the missing topic", async || program.log().contains(&problem)).await;
    assert_eq!(program.metric("vibrissa_kafka_connected{").await, 0.0);
    kafka.create_topic(MESSAGES, 3).await;
    let mut robot = robot(&broker, &program).await;
    let all = messages(&mut robot, 10);
    kafka.write(MESSAGES, 2, records("r", &all)).await;
    stored(&program, &all).await;
}
