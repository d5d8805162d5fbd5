//! Reads all partitions of a fleet's topic.
//!
//! Consumer groups are not used: the owner of the fleet's lease reads, and the positions are in the database.

use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

use rskafka::record::RecordAndOffset;
use tokio::sync::{Mutex, mpsc};
use tokio::task::JoinSet;
use tokio::time::sleep;
use tracing::warn;
use vibrissa_edge::shard::FleetShard;
use vibrissa_protocol::{Name, RobotTopic, Topic};

use super::again::Again;
use super::client::{Connector, KafkaError, SharedLog};
use super::partition::PartitionReader;
use crate::backoff::Backoff;
use crate::log_inbox::{LogBatch, LogRecord, NextOffsets, Skipped};
use crate::metrics::FleetMetrics;
use crate::readiness::Readiness;
use crate::set_aside::Reader;

/// Interval of the looks for new partitions.
const LOOK_EVERY: Duration = Duration::from_secs(30);
/// Headers with the MQTT topic, as bridges name them.
const TOPIC_HEADERS: [&str; 3] = ["topic", "mqtt_topic", "mqtt.topic"];
/// The part of a fleet that is not ready then.
const PART: &str = "log";

/// Reads the topic of one fleet. Clones share their state.
#[derive(Debug, Clone)]
pub(crate) struct LogReader {
    pub(super) connector: Connector,
    topic: Arc<str>,
    pub(super) fleet: FleetShard,
    metrics: FleetMetrics,
    readiness: Readiness,
    pub(super) again: Arc<Mutex<Option<Again>>>,
    partitions: Arc<std::sync::Mutex<BTreeMap<u32, PartitionState>>>,
}

/// What is known about a partition.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct PartitionState {
    /// Whether it has answered the last read.
    pub(super) is_connected: bool,
    /// Number of its records that are not read.
    pub(super) lag: i64,
}

impl LogReader {
    pub(super) fn new(
        connector: Connector,
        topic: &str,
        fleet: FleetShard,
        metrics: FleetMetrics,
        readiness: Readiness,
    ) -> Self {
        let (again, partitions) = (Arc::default(), Arc::default());
        Self { connector, topic: topic.into(), fleet, metrics, readiness, again, partitions }
    }

    /// Name of the topic.
    pub(crate) fn topic(&self) -> &str {
        &self.topic
    }

    /// Whether all partitions of the log answer.
    pub(crate) fn is_connected(&self) -> bool {
        are_connected(&self.partitions.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Changes what is known about a partition. Returns the number of partitions.
    pub(super) fn note(&self, partition: u32, change: impl FnOnce(&mut PartitionState)) -> u32 {
        let mut partitions = self.partitions.lock().unwrap_or_else(PoisonError::into_inner);
        change(partitions.entry(partition).or_default());
        self.metrics.log_connected.set(are_connected(&partitions).into());
        self.metrics.log_lag.set(partitions.values().map(|state| state.lag).sum());
        partitions.len() as u32
    }

    /// Reads from these offsets until the engine is gone: one task for each partition. New partitions are read from their
    /// first record.
    pub(crate) async fn run(self, mut from: NextOffsets, batches: mpsc::Sender<LogBatch>) {
        self.metrics.log_ingest.set(1);
        let (log, mut tasks) = (Arc::new(SharedLog::new(self.connector.clone())), JoinSet::new());
        let (mut known, mut backoff, mut told) = (0, Backoff::default(), None);
        loop {
            match self.count(&log).await {
                Ok(count) => {
                    (backoff, told) = (Backoff::default(), None);
                    // Known before one of them answers: the log is not connected until all do.
                    for partition in known..count {
                        self.note(partition, |_| ());
                    }
                    for partition in known..count {
                        let next = from.remove(&partition);
                        let reader = PartitionReader { of: self.clone(), log: log.clone(), partition, next };
                        tasks.spawn(reader.run(batches.clone()));
                    }
                    known = known.max(count);
                    tokio::select! {
                        () = batches.closed() => return,
                        () = sleep(LOOK_EVERY) => {}
                    }
                }
                Err(problem) => {
                    let text = problem.to_string();
                    if told.as_ref() != Some(&text) {
                        warn!(
                            problem = text, fleet = %self.fleet, topic = %self.topic,
                            "cannot learn the partitions of the log, retrying"
                        );
                        told = Some(text);
                    }
                    tokio::select! {
                        () = batches.closed() => return,
                        () = backoff.wait() => {}
                    }
                }
            }
        }
    }

    /// Number of partitions that the topic has now.
    async fn count(&self, shared: &SharedLog) -> Result<u32, KafkaError> {
        let log = shared.get().await?;
        let counted = log.partitions_now(&self.topic).await;
        if counted.is_err() {
            shared.forget(&log).await;
        }
        counted
    }

    pub(super) fn skipped(&self, reason: Skipped, count: u64) {
        self.metrics.log_skipped.of([reason.word()]).inc_by(count);
    }

    /// Tells for a while that records were set aside.
    pub(super) fn tell_set_aside(&self, partition: i32, (from, to): (i64, i64), why: &str) {
        let (last, topic) = (to - 1, &self.topic);
        let problem = format!(
            "records {from} to {last} of partition {partition} of {topic:?} cannot be read and are set aside: {why}"
        );
        self.metrics.set_aside(Reader::Log, to.abs_diff(from));
        self.readiness.tell_set_aside(&self.fleet, PART, problem);
    }

    /// The message of a record.
    pub(super) fn message(&self, record: RecordAndOffset) -> Result<LogRecord, Skipped> {
        let RecordAndOffset { record, offset } = record;
        let topic = address(record.key.as_deref(), &record.headers)?;
        let Topic::Robot { fleet, robot, kind } = &topic else { return Err(Skipped::NoTopic) };
        if fleet != self.fleet.fleet() {
            return Err(Skipped::OtherFleet);
        }
        if !matches!(kind, RobotTopic::Contacts | RobotTopic::Status) {
            return Err(Skipped::OtherMessage);
        }
        let (robot, kind) = (robot.clone(), *kind);
        let payload = record.value.ok_or(Skipped::NoValue)?.into();
        Ok(LogRecord { offset, topic, robot, kind, payload })
    }
}

fn are_connected(partitions: &BTreeMap<u32, PartitionState>) -> bool {
    !partitions.is_empty() && partitions.values().all(|state| state.is_connected)
}

/// The MQTT topic of a record. A key names the robot, and a header must not name another one: brokers and bridges protect
/// keys, while anybody who writes may add headers.
fn address(key: Option<&[u8]>, headers: &BTreeMap<String, Vec<u8>>) -> Result<Topic, Skipped> {
    let text = |bytes: &[u8]| std::str::from_utf8(bytes).ok().map(str::to_owned);
    let topic_in = |text: &str| Topic::parse(text).ok().filter(|topic| matches!(topic, Topic::Robot { .. }));
    let values = TOPIC_HEADERS.iter().filter_map(|&name| text(headers.get(name)?));
    let header = values.filter_map(|value| topic_in(&value)).next();
    let key = key.and_then(text).unwrap_or_default();
    if let Some(of_key) = topic_in(&key) {
        return if header.is_none_or(|header| header == of_key) { Ok(of_key) } else { Err(Skipped::Contradiction) };
    }
    let header = header.ok_or(Skipped::NoTopic)?;
    let Topic::Robot { fleet, robot, .. } = &header else { return Ok(header) };
    let is_same = match key.split_once('/') {
        Some((of_fleet, of_robot)) => match (Name::new(of_fleet), Name::robot(of_robot)) {
            (Ok(of_fleet), Ok(of_robot)) => (fleet, robot) == (&of_fleet, &of_robot),
            (Err(_), _) | (_, Err(_)) => true,
        },
        None => Name::robot(&key).map_or(true, |of_key| of_key == *robot),
    };
    if is_same { Ok(header) } else { Err(Skipped::Contradiction) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_header_does_not_name_another_robot_than_the_key() {
        const TOPIC: &str = "whisker/v1/f/r/contacts";
        let addressed = |key: Option<&str>, headers: &[(&str, &str)]| {
            let headers = headers.iter().map(|(name, value)| ((*name).to_owned(), value.as_bytes().to_vec())).collect();
            address(key.map(str::as_bytes), &headers).map(|topic| topic.to_string())
        };
        let found = Ok(TOPIC.to_owned());
        assert_eq!(addressed(Some("f/r"), &[("topic", TOPIC)]), found);
        assert_eq!(addressed(Some("r"), &[("topic", TOPIC)]), found, "a key with the robot alone");
        assert_eq!(addressed(Some(TOPIC), &[]), found);
        assert_eq!(addressed(None, &[("mqtt.topic", TOPIC)]), found);
        assert_eq!(addressed(Some("some key"), &[("mqtt_topic", TOPIC)]), found, "a key of another form");
        assert_eq!(addressed(Some(TOPIC), &[("topic", "vibrissa.messages")]), found, "a header of another meaning");
        assert_eq!(addressed(None, &[("topic", "vibrissa.messages"), ("mqtt_topic", TOPIC)]), found);
        for key in ["f/other", "g/r", "other", "r2", "whisker/v1/f/other/contacts", "whisker/v1/f/r/status"] {
            assert_eq!(addressed(Some(key), &[("topic", TOPIC)]), Err(Skipped::Contradiction), "{key}");
        }
        assert_eq!(addressed(Some("f/r"), &[]), Err(Skipped::NoTopic));
        assert_eq!(addressed(None, &[("topic", "whisker/v1/f/supervisor/state")]), Err(Skipped::NoTopic));
    }
}
