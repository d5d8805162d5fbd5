//! Reads a fleet's partition of the log: for the engine, and again for its recovery.
//!
//! Consumer groups are not used: the owner of a fleet's lease reads, and the position is in the database.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rskafka::client::partition::{OffsetAt, PartitionClient};
use rskafka::record::RecordAndOffset;
use tokio::sync::{Mutex, mpsc};
use tracing::{error, info, warn};
use vibrissa_protocol::{Name, RobotTopic, Topic};

use super::client::{Connector, KafkaError, within};
use crate::backoff::Backoff;
use crate::log_inbox::{LogBatch, LogRecord, LogStart, Skipped};
use crate::metrics::FleetMetrics;
use crate::readiness::Readiness;
use crate::set_aside::Reader;

/// Most records that the engine steps at a time.
const RECORDS_AT_A_TIME: usize = 512;
/// Headers with the MQTT topic, as bridges name them.
const TOPIC_HEADERS: [&str; 3] = ["topic", "mqtt_topic", "mqtt.topic"];
/// The part of a fleet that is not ready then.
const PART: &str = "log";

/// Reads the partition of one fleet.
#[derive(Debug, Clone)]
pub(crate) struct LogReader {
    connector: Connector,
    topic: Arc<str>,
    pub(super) fleet: Name,
    metrics: FleetMetrics,
    readiness: Readiness,
    again: Arc<Mutex<Option<Again>>>,
    is_connected: Arc<AtomicBool>,
}

/// Records that a recovery reads again.
struct Again {
    /// Number of the partition.
    number: i64,
    partition: Arc<PartitionClient>,
    /// First and next offset of the partition when it was opened.
    earliest: i64,
    latest: i64,
    /// Records before this offset are gone from `read`.
    begin: i64,
    /// Next offset to read.
    next: i64,
    read: VecDeque<RecordAndOffset>,
}

impl fmt::Debug for Again {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Again").field("begin", &self.begin).field("next", &self.next).finish_non_exhaustive()
    }
}

impl LogReader {
    pub(super) fn new(
        connector: Connector,
        topic: &str,
        fleet: Name,
        metrics: FleetMetrics,
        readiness: Readiness,
    ) -> Self {
        Self {
            connector,
            topic: topic.into(),
            fleet,
            metrics,
            readiness,
            again: Arc::default(),
            is_connected: Arc::default(),
        }
    }

    /// Name of the topic.
    pub(crate) fn topic(&self) -> &str {
        &self.topic
    }

    /// Whether the log answers.
    pub(crate) fn is_connected(&self) -> bool {
        self.is_connected.load(Ordering::Relaxed)
    }

    fn set_connected(&self, is_connected: bool) {
        self.is_connected.store(is_connected, Ordering::Relaxed);
        self.metrics.log_connected.set(is_connected.into());
    }

    /// Connects to a partition.
    async fn open(&self, partition: u32) -> Result<Arc<PartitionClient>, KafkaError> {
        self.connector.connect().await?.partition(&self.topic, partition).await
    }

    /// The messages of the records `from`..`to` of a partition, which were read before. Waits for the log, however long that takes: they are
    /// part of the fleet's state. Ranges in rising order are read together.
    pub(crate) async fn records(&self, partition: i64, (from, to): (i64, i64)) -> Vec<LogRecord> {
        let mut again = self.again.lock().await;
        let (mut backoff, mut is_failing) = (Backoff::default(), false);
        loop {
            match self.try_records(&mut again, partition, (from, to)).await {
                Ok(records) => return records,
                Err(problem) => {
                    *again = None;
                    if !std::mem::replace(&mut is_failing, true) {
                        error!(%problem, fleet = %self.fleet, "cannot read the log again for the recovery, retrying");
                    }
                    backoff.wait().await;
                }
            }
        }
    }

    async fn try_records(
        &self,
        again: &mut Option<Again>,
        number: i64,
        (from, to): (i64, i64),
    ) -> Result<Vec<LogRecord>, KafkaError> {
        let again = match again {
            Some(again) if again.number == number && again.begin <= from && to <= again.latest => again,
            other => {
                let partition = self.open(u32::try_from(number).unwrap_or_default()).await?;
                let earliest = within(partition.get_offset(OffsetAt::Earliest)).await?;
                let latest = within(partition.get_offset(OffsetAt::Latest)).await?;
                other.insert(Again {
                    number,
                    partition,
                    earliest,
                    latest,
                    begin: from,
                    next: from,
                    read: VecDeque::new(),
                })
            }
        };
        let (first, end) = (from.max(again.earliest), to.min(again.latest));
        let lost = (to - from) - (end - first).max(0);
        if lost > 0 {
            self.skipped(Skipped::Deleted, lost as u64);
            error!(
                fleet = %self.fleet, topic = %self.topic, from, to, lost,
                "the log has deleted records that the recovery needs: the state lacks their contacts. Keep records longer"
            );
        }
        again.begin = to;
        again.next = again.next.max(first);
        while again.next < end {
            let read = self.fetch(&again.partition, again.next).await?;
            if read.next == again.next {
                break;
            }
            again.next = read.next;
            again.read.extend(read.records);
        }
        let mut records = Vec::new();
        while again.read.front().is_some_and(|record| record.offset < end) {
            records.extend(
                again
                    .read
                    .pop_front()
                    .filter(|record| record.offset >= from)
                    .and_then(|record| self.message(record).ok()),
            );
        }
        Ok(records)
    }

    /// Reads from a position until the engine is gone.
    pub(crate) async fn run(self, start: LogStart, batches: mpsc::Sender<LogBatch>) {
        self.metrics.log_ingest.set(1);
        let mut next = match start {
            LogStart::Earliest => None,
            LogStart::At(next) => Some(next),
        };
        let (mut backoff, mut told) = (Backoff::default(), None);
        while !batches.is_closed() {
            let before = next;
            let Err(problem) = self.read(&mut next, &batches).await else { return };
            self.set_connected(false);
            let text = problem.to_string();
            if told.as_ref() != Some(&text) {
                warn!(problem = text, fleet = %self.fleet, topic = %self.topic, "cannot read the log, retrying");
                told = Some(text);
            }
            if next != before {
                backoff = Backoff::default();
            }
            backoff.wait().await;
        }
    }

    /// Reads over one connection. Returns without an error when the engine is gone.
    async fn read(&self, next: &mut Option<i64>, batches: &mpsc::Sender<LogBatch>) -> Result<(), KafkaError> {
        let partition = self.open(0).await?;
        let earliest = within(partition.get_offset(OffsetAt::Earliest)).await?;
        let latest = within(partition.get_offset(OffsetAt::Latest)).await?;
        let mut at = next.unwrap_or(earliest);
        if at < earliest {
            self.skipped(Skipped::Deleted, at.abs_diff(earliest));
            error!(
                fleet = %self.fleet, topic = %self.topic, at, earliest,
                "the log has deleted records before they were read: robots send contacts without a receipt again. Keep \
                 records longer"
            );
            at = earliest;
        } else if at > latest {
            error!(
                fleet = %self.fleet, topic = %self.topic, at, latest,
                "the log ends before the stored position, because it was created anew: reading from its first record"
            );
            at = earliest;
        }
        info!(fleet = %self.fleet, topic = %self.topic, at, latest, "reading contacts from the log");
        loop {
            *next = Some(at);
            let read = self.fetch(&partition, at).await?;
            self.set_connected(true);
            let (after, end) = (read.next, read.end);
            let mut read = read.records.into_iter().peekable();
            while read.peek().is_some() {
                let from = at;
                let mut records = Vec::new();
                for record in read.by_ref().take(RECORDS_AT_A_TIME) {
                    at = record.offset + 1;
                    match self.message(record) {
                        Ok(record) => records.push(record),
                        Err(reason) => self.skipped(reason, 1),
                    }
                }
                if batches.send(LogBatch { from, to: at, records }).await.is_err() {
                    return Ok(());
                }
                *next = Some(at);
            }
            at = after;
            self.metrics.log_lag.set((end - at).max(0));
            if batches.is_closed() {
                return Ok(());
            }
        }
    }

    pub(super) fn skipped(&self, reason: Skipped, count: u64) {
        self.metrics.log_skipped.of([reason.word()]).inc_by(count);
    }

    /// Tells for a while that records were set aside.
    pub(super) fn tell_set_aside(&self, from: i64, to: i64, why: &str) {
        let (last, topic) = (to - 1, &self.topic);
        let problem = format!("records {from} to {last} of {topic:?} cannot be read and are set aside: {why}");
        self.metrics.set_aside(Reader::Log, to.abs_diff(from));
        self.readiness.tell_set_aside(&self.fleet, PART, problem);
    }

    /// The message of a record.
    pub(super) fn message(&self, record: RecordAndOffset) -> Result<LogRecord, Skipped> {
        let RecordAndOffset { record, offset } = record;
        let topic = address(record.key.as_deref(), &record.headers)?;
        let Topic::Robot { fleet, robot, kind } = &topic else { return Err(Skipped::NoTopic) };
        if *fleet != self.fleet {
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
