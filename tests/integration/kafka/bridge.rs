//! A bridge from MQTT to the log, as brokers have them, and records that it would write.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rskafka::record::Record;
use tokio::sync::oneshot;
use vibrissa_edge::shard::robot_hash;
use vibrissa_protocol::{Contacts, Message, RobotTopic, encode};
use vibrissa_tests::kafka::{Kafka, record};
use vibrissa_tests::observer::Observer;

pub(crate) const MESSAGES: &str = "vibrissa.messages";

/// The record of a robot's message.
pub(crate) fn record_of(robot: &str, kind: RobotTopic, value: Vec<u8>) -> Record {
    record(robot, &format!("whisker/v1/f/{robot}/{kind}"), value)
}

pub(crate) fn records(robot: &str, messages: &[Contacts]) -> Vec<Record> {
    messages.iter().map(|message| record_of(robot, RobotTopic::Contacts, encode(message))).collect()
}

/// The partition of a robot.
pub(crate) fn partition(robot: &str, partitions: u32) -> u32 {
    robot_hash("f", robot) % partitions
}

/// Carries contacts and statuses of a robot from the broker to the log, in a thread of its own.
pub(crate) struct Bridge(Arc<AtomicBool>);

impl Bridge {
    pub(crate) async fn start(mqtt: u16, kafka: &Arc<Kafka>, robot: &'static str, partitions: u32) -> Self {
        let filters = [format!("whisker/v1/f/{robot}/contacts"), format!("whisker/v1/f/{robot}/status")];
        let (stop, kafka) = (Arc::new(AtomicBool::new(false)), kafka.clone());
        let (is_stopped, (ready, begun)) = (stop.clone(), oneshot::channel());
        std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let filters: Vec<&str> = filters.iter().map(String::as_str).collect();
                let mut observer = Observer::subscribed(mqtt, &format!("bridge-{robot}"), &filters).await;
                ready.send(()).unwrap();
                while !is_stopped.load(Ordering::Relaxed) {
                    let Some(heard) = observer.next(Duration::from_millis(200)).await else { continue };
                    let kind = match heard.message {
                        Message::Contacts(_) => RobotTopic::Contacts,
                        _ => RobotTopic::Status,
                    };
                    let record = record_of(robot, kind, heard.payload);
                    kafka.write(MESSAGES, partition(robot, partitions), vec![record]).await;
                }
            });
        });
        begun.await.unwrap();
        Self(stop)
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
