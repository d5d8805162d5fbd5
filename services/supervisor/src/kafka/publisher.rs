//! Carries the events of a fleet from the log of the database to Kafka: in order, and the position advances only after all
//! replicas in sync have them.
//!
//! After a failure, or at the next owner, the events since the position are written again. They keep their numbers, so readers
//! recognise those that they have read.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use futures_util::future::try_join_all;
use rskafka::chrono::{DateTime, Utc};
use rskafka::client::partition::{Compression, PartitionClient};
use rskafka::record::Record;
use tokio::sync::Notify;
use tokio::time::{Instant, timeout};
use tracing::{error, info, warn};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::partition::robot_hash;
use vibrissa_protocol::Name;
use vibrissa_store::Store;
use vibrissa_store::events::StoredEvent;

use super::client::{Connector, KafkaError, Log, within};
use crate::backoff::Backoff;
use crate::events::{OutboxRoom, published};
use crate::kafka_options::EventTopics;
use crate::metrics::FleetMetrics;

/// Polling interval of the log of events without a notice.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// Interval between two measurements of the waiting events while Kafka takes them.
const MEASURE_EVERY: Duration = Duration::from_secs(60);
/// Bytes of the records of one write, less than the brokers' usual limit of 1 MiB.
const WRITE_BYTES: usize = 512 * 1024;

/// Publishes the events of one fleet.
pub(super) struct Publisher {
    pub(super) connector: Connector,
    pub(super) topics: EventTopics,
    pub(super) store: Store,
    pub(super) fleet: Name,
    pub(super) metrics: FleetMetrics,
    pub(super) room: Arc<OutboxRoom>,
}

/// Why a round failed.
#[derive(Debug, thiserror::Error)]
enum RoundError {
    #[error("{0}")]
    Log(#[from] KafkaError),
    #[error("{0}")]
    Store(#[from] vibrissa_store::StoreError),
}

impl Publisher {
    /// Publishes again and again; never ends.
    pub(super) async fn run(self, committed: Arc<Notify>) {
        let (mut log, mut backoff, mut is_failing) = (None, Backoff::default(), false);
        let mut measured = Instant::now();
        self.measure().await;
        loop {
            if measured.elapsed() >= MEASURE_EVERY {
                measured = Instant::now();
                self.measure().await;
            }
            match self.round(&mut log).await {
                Ok(rows) => {
                    if is_failing {
                        info!(fleet = %self.fleet, "events are published again");
                    }
                    (backoff, is_failing) = (Backoff::default(), false);
                    if rows == 0 {
                        self.metrics.outbox_events.set(0);
                        self.show_bytes(0);
                        // Without a notice, for instance of events that the last owner has left.
                        let _ = timeout(LOOK_EVERY, committed.notified()).await;
                    }
                }
                Err(problem) => {
                    self.metrics.event_writes_failed.inc();
                    if !std::mem::replace(&mut is_failing, true) {
                        warn!(%problem, fleet = %self.fleet, "cannot publish events, they wait in the database; retrying");
                    }
                    log = None;
                    backoff.wait().await;
                    measured = Instant::now();
                    self.measure().await;
                }
            }
        }
    }

    /// Measures the waiting events, and states that they are awaited. Without an answer of the database the last size, and what
    /// was added to it, go on to count.
    async fn measure(&self) {
        let fleet = self.fleet.as_str();
        let measured = async {
            self.store.follow_events(fleet, wall_clock().0 as i64).await?;
            self.store.waiting_size(fleet).await
        };
        if let Ok(waiting) = measured.await {
            self.metrics.outbox_events.set(waiting.events);
            self.show_bytes(waiting.bytes);
        }
    }

    fn show_bytes(&self, bytes: i64) {
        self.room.bytes.store(bytes, Ordering::Relaxed);
        self.metrics.outbox_bytes.set(bytes);
    }

    /// Publishes the oldest events; returns the number of rows.
    async fn round(&self, log: &mut Option<Log>) -> Result<usize, RoundError> {
        let fleet = self.fleet.as_str();
        let waiting = self.store.waiting_events(fleet).await?;
        let Some(last) = waiting.last else { return Ok(0) };
        let log = match log {
            Some(log) => log,
            none => none.insert(self.connector.connect().await?),
        };
        if waiting.unreadable > 0 {
            self.metrics.events_lost.inc_by(waiting.unreadable);
            error!(%fleet, events = waiting.unreadable, "cannot read some events of the log, they are lost for Kafka");
        }
        let mut writes = Vec::new();
        for ((topic, partition), records) in self.records(log, &waiting.events)? {
            writes.push(self.write(log.partition(topic, partition).await?, records));
        }
        try_join_all(writes).await?;
        self.store.events_are_published(fleet, last).await?;
        let bytes: usize = waiting.events.iter().map(|event| event.data.len()).sum();
        self.room.bytes.fetch_sub(bytes as i64, Ordering::Relaxed);
        Ok(waiting.events.len() + waiting.unreadable as usize)
    }

    /// The records of events by topic and partition, in order.
    fn records(
        &self,
        log: &Log,
        events: &[StoredEvent],
    ) -> Result<BTreeMap<(&str, u32), VecDeque<Record>>, KafkaError> {
        let mut all: BTreeMap<(&str, u32), VecDeque<Record>> = BTreeMap::new();
        for event in events {
            let is_contacts = event.event_kind().is_some_and(EventKind::is_of_contacts);
            let topic = match (&self.topics.contacts, is_contacts) {
                (_, false) => self.topics.events.as_str(),
                (Some(topic), true) => topic.as_str(),
                // Contacts were published until the last restart.
                (None, true) => continue,
            };
            let robot = event.robot.as_deref().unwrap_or_default();
            let partition = robot_hash(&event.fleet, robot) % log.partitions(topic)?;
            all.entry((topic, partition)).or_default().push_back(record(event));
        }
        Ok(all)
    }

    /// Writes records to a partition, one write after the other. A record that the log refuses for good is lost, and
    /// counted: it must not hold up all others.
    async fn write(&self, partition: Arc<PartitionClient>, mut records: VecDeque<Record>) -> Result<(), KafkaError> {
        let mut most = usize::MAX;
        while !records.is_empty() {
            let (mut count, mut bytes) = (0, 0);
            for record in &records {
                bytes += record.approximate_size();
                if count > 0 && (bytes > WRITE_BYTES || count >= most) {
                    break;
                }
                count += 1;
            }
            let next: Vec<Record> = records.range(..count).cloned().collect();
            match within(partition.produce(next, Compression::NoCompression)).await {
                Ok(_) => self.metrics.events_published.inc_by(count as u64),
                Err(problem) if problem.is_refusal() && count > 1 => {
                    most = count / 2;
                    continue;
                }
                Err(problem) if problem.is_refusal() => {
                    self.metrics.events_lost.inc();
                    error!(%problem, fleet = %self.fleet, "the log refuses an event for good, it is lost");
                }
                Err(problem) => return Err(problem),
            }
            records.drain(..count);
            most = usize::MAX;
        }
        Ok(())
    }
}

/// The record of an event. Its key is the fleet and the robot, or the fleet alone.
fn record(event: &StoredEvent) -> Record {
    let key = event.robot.as_ref().map_or_else(|| event.fleet.clone(), |robot| format!("{}/{robot}", event.fleet));
    Record {
        key: Some(key.into_bytes()),
        value: Some(published(event).into_bytes()),
        headers: BTreeMap::new(),
        timestamp: DateTime::<Utc>::from_timestamp_micros(wall_clock().0 as i64).unwrap_or_default(),
    }
}
