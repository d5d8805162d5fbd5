//! A bridge from MQTT to the log, as brokers have them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use tokio::sync::oneshot;
use vibrissa_edge::partition::robot_hash;
use vibrissa_protocol::{Message, RobotTopic};

use super::{Kafka, record_of};
use crate::observer::Observer;

/// Robots and topic of a bridge.
#[derive(Debug, Clone)]
pub struct BridgeOptions {
    /// Port of the broker.
    pub mqtt: u16,
    /// Topic of the log.
    pub topic: &'static str,
    /// Number of its partitions.
    pub partitions: u32,
    /// Name of the robots' fleet.
    pub fleet: &'static str,
    /// Names of the robots whose messages it carries.
    pub robots: Vec<String>,
    /// Whether each record is written twice, as after a lost confirmation.
    pub repeats: bool,
}

/// Carries contacts and statuses of robots from the broker to the log, in a thread of its own, until it is dropped.
#[derive(Debug)]
pub struct Bridge {
    is_stopped: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Bridge {
    /// Starts it, and waits until it hears.
    ///
    /// # Panics
    /// The broker does not answer.
    pub async fn start(kafka: &Arc<Kafka>, options: BridgeOptions) -> Self {
        let (stop, kafka) = (Arc::new(AtomicBool::new(false)), kafka.clone());
        let (is_stopped, (ready, begun)) = (stop.clone(), oneshot::channel());
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
            runtime.block_on(async {
                let fleet = options.fleet;
                let mut observers = Vec::new();
                for robot in &options.robots {
                    let filters = ["contacts", "status"].map(|kind| format!("whisker/v1/{fleet}/{robot}/{kind}"));
                    let filters: Vec<&str> = filters.iter().map(String::as_str).collect();
                    let name = format!("bridge-{robot}");
                    observers.push((robot, Observer::subscribed(options.mqtt, &name, &filters).await));
                }
                let _ = ready.send(());
                let patience = Duration::from_millis(200) / observers.len() as u32;
                while !is_stopped.load(Ordering::Relaxed) {
                    for (robot, observer) in &mut observers {
                        let mut records = Vec::new();
                        while let Some(heard) = observer.next(patience).await {
                            let kind = match heard.message {
                                Message::Contacts(_) => RobotTopic::Contacts,
                                _ => RobotTopic::Status,
                            };
                            let record = record_of(fleet, robot, kind, heard.payload);
                            records.extend(options.repeats.then(|| record.clone()));
                            records.push(record);
                        }
                        if !records.is_empty() {
                            let partition = robot_hash(fleet, robot) % options.partitions;
                            kafka.write(options.topic, partition, records).await;
                        }
                    }
                }
            });
        });
        begun.await.expect("a bridge");
        Self { is_stopped: stop, thread: Some(thread) }
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.is_stopped.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
