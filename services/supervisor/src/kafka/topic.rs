//! A fleet's topic: what its partitions are known to do, and the messages of its records.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;
use vibrissa_protocol::{Name, RobotTopic, Topic};

use super::client::Connector;
use super::record::Record;
use crate::link_state::LinkState;
use crate::log_inbox::{LogRecord, Skipped};
use crate::metrics::FleetMetrics;
use crate::readiness::Readiness;
use crate::set_aside::Reader;

/// The part of a fleet that is not ready then.
const PART: &str = "log";

/// The topic of one fleet. Clones share their state.
#[derive(Debug, Clone)]
pub(super) struct FleetTopic {
    pub(super) connector: Connector,
    pub(super) name: Arc<str>,
    pub(super) fleet: Name,
    pub(super) metrics: FleetMetrics,
    /// Whether all partitions of the log answer.
    pub(super) link: LinkState,
    /// Number of records that could not be read.
    pub(super) set_aside: Arc<AtomicU64>,
    readiness: Readiness,
    partitions: Arc<Mutex<BTreeMap<u32, PartitionState>>>,
}

/// What is known about a partition.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct PartitionState {
    /// Whether it has answered the last read.
    pub(super) is_connected: bool,
    /// Number of its records that are not read.
    pub(super) lag: i64,
}

impl FleetTopic {
    pub(super) fn new(
        connector: Connector,
        name: &str,
        fleet: Name,
        metrics: FleetMetrics,
        readiness: Readiness,
    ) -> Self {
        let (link, set_aside) = (LinkState::default(), Arc::default());
        Self { connector, name: name.into(), fleet, metrics, link, set_aside, readiness, partitions: Arc::default() }
    }

    /// The same topic, with its own number of records that could not be read.
    pub(super) fn counting_anew(&self) -> Self {
        Self { set_aside: Arc::default(), ..self.clone() }
    }

    /// Changes what is known about a partition. Returns the number of partitions.
    pub(super) fn note(&self, partition: u32, change: impl FnOnce(&mut PartitionState)) -> u32 {
        let mut partitions = self.partitions.lock().unwrap_or_else(PoisonError::into_inner);
        change(partitions.entry(partition).or_default());
        let is_connected = are_connected(&partitions);
        self.link.set(is_connected);
        self.metrics.log_connected.set(is_connected.into());
        self.metrics.log_lag.set(partitions.values().map(|state| state.lag).sum());
        partitions.len() as u32
    }

    pub(super) fn skipped(&self, reason: Skipped, count: u64) {
        self.metrics.log_skipped.of([reason.word()]).inc_by(count);
    }

    /// Tells for a while that records were set aside.
    pub(super) fn tell_set_aside(&self, partition: i32, (from, to): (i64, i64), why: &str) {
        let (last, topic) = (to - 1, &self.name);
        let problem = format!(
            "records {from} to {last} of partition {partition} of {topic:?} cannot be read and are set aside: {why}"
        );
        self.set_aside.fetch_add(to.abs_diff(from), Ordering::Relaxed);
        self.metrics.set_aside(Reader::Log, to.abs_diff(from));
        self.readiness.tell_set_aside(&self.fleet, PART, &problem);
    }

    /// The message of a record.
    pub(super) fn message(&self, record: Record) -> Result<LogRecord, Skipped> {
        let topic = address(record.key.as_deref(), &record.topics)?;
        let Topic::Robot { fleet, robot, kind } = &topic else { return Err(Skipped::NoTopic) };
        if *fleet != self.fleet {
            return Err(Skipped::OtherFleet);
        }
        if !matches!(kind, RobotTopic::Contacts | RobotTopic::Status) {
            return Err(Skipped::OtherMessage);
        }
        let (robot, kind) = (robot.clone(), *kind);
        // A part of the batch would keep all of the batch in memory.
        let payload = Bytes::copy_from_slice(&record.value.ok_or(Skipped::NoValue)?);
        Ok(LogRecord { offset: record.offset, topic, robot, kind, payload })
    }
}

fn are_connected(partitions: &BTreeMap<u32, PartitionState>) -> bool {
    !partitions.is_empty() && partitions.values().all(|state| state.is_connected)
}

/// The MQTT topic of a record. A key names the robot, and a header must not name another one: brokers and bridges protect
/// keys, while anybody who writes may add headers.
fn address(key: Option<&[u8]>, headers: &[Option<Bytes>]) -> Result<Topic, Skipped> {
    let text = |bytes: &[u8]| std::str::from_utf8(bytes).ok().map(str::to_owned);
    let topic_in = |text: &str| Topic::parse(text).ok().filter(|topic| matches!(topic, Topic::Robot { .. }));
    let values = headers.iter().flatten().filter_map(|value| text(value));
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
        let addressed = |key: Option<&str>, headers: &[&'static str]| {
            let headers: Vec<_> = headers.iter().map(|value| Some(Bytes::from(*value))).collect();
            address(key.map(str::as_bytes), &headers).map(|topic| topic.to_string())
        };
        let found = Ok(TOPIC.to_owned());
        assert_eq!(addressed(Some("f/r"), &[TOPIC]), found);
        assert_eq!(addressed(Some("r"), &[TOPIC]), found, "a key with the robot alone");
        assert_eq!(addressed(Some(TOPIC), &[]), found);
        assert_eq!(addressed(None, &[TOPIC]), found);
        assert_eq!(addressed(Some("some key"), &[TOPIC]), found, "a key of another form");
        assert_eq!(addressed(Some(TOPIC), &["vibrissa.messages"]), found, "a header of another meaning");
        assert_eq!(addressed(None, &["vibrissa.messages", TOPIC]), found);
        for key in ["f/other", "g/r", "other", "r2", "whisker/v1/f/other/contacts", "whisker/v1/f/r/status"] {
            assert_eq!(addressed(Some(key), &[TOPIC]), Err(Skipped::Contradiction), "{key}");
        }
        assert_eq!(addressed(Some("f/r"), &[]), Err(Skipped::NoTopic));
        assert_eq!(addressed(None, &["whisker/v1/f/supervisor/state"]), Err(Skipped::NoTopic));
    }
}
