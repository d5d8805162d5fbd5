//! Reads records again, for a recovery.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use tracing::error;

use super::client::KafkaError;
use super::record::Record;
use super::topic::FleetTopic;
use super::wire::{self, Brokers, OffsetAt};
use crate::log_inbox::{LogRange, LogRecord, Skipped};

/// What a recovery has read ahead.
pub(super) struct Again {
    brokers: Brokers,
    /// Number of partitions of the topic.
    count: u32,
    partitions: BTreeMap<u32, Partition>,
}

/// A partition that is read again.
struct Partition {
    client: wire::Partition,
    /// First and next offset of the partition when it was opened.
    earliest: i64,
    latest: i64,
    /// Records before this offset are gone from `read`.
    begin: i64,
    /// Next offset to read.
    next: i64,
    read: VecDeque<Record>,
}

impl fmt::Debug for Again {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.partitions.keys()).finish()
    }
}

impl Partition {
    async fn open(brokers: &Brokers, topic: &str, range: LogRange) -> Result<Self, KafkaError> {
        let client = brokers.open(topic, range.partition).await?;
        let earliest = client.offset(OffsetAt::Earliest).await?;
        let latest = client.offset(OffsetAt::Latest).await?;
        Ok(Self { client, earliest, latest, begin: range.from, next: range.from, read: VecDeque::new() })
    }

    /// Whether the records of a range are still to come.
    fn is_before(&self, range: LogRange) -> bool {
        self.begin <= range.from && range.to <= self.latest
    }
}

impl Again {
    /// Connects, and has read nothing.
    pub(super) async fn start(topic: &FleetTopic) -> Result<Self, KafkaError> {
        let brokers = topic.connector.brokers().await?;
        let count = brokers.partitions_now(&topic.name).await?;
        Ok(Self { brokers, count, partitions: BTreeMap::new() })
    }

    /// The messages of records that were read before. Ranges of a partition in rising order are read together.
    pub(super) async fn records(&mut self, of: &FleetTopic, range: LogRange) -> Result<Vec<LogRecord>, KafkaError> {
        if !self.partitions.get(&range.partition).is_some_and(|partition| partition.is_before(range)) {
            let opened = Partition::open(&self.brokers, &of.name, range).await?;
            self.partitions.insert(range.partition, opened);
        }
        let Some(partition) = self.partitions.get_mut(&range.partition) else { return Ok(Vec::new()) };
        let LogRange { from, to, .. } = range;
        let (first, end) = (from.max(partition.earliest), to.min(partition.latest));
        let lost = (to - from) - (end - first).max(0);
        if lost > 0 {
            of.skipped(Skipped::Deleted, lost as u64);
            error!(
                fleet = %of.fleet, topic = %of.name, partition = range.partition, from, to, lost,
                "the log has deleted records that the recovery needs: the state lacks their contacts. Keep records longer"
            );
        }
        partition.begin = to;
        partition.next = partition.next.max(first);
        while partition.next < end {
            let read = of.fetch((&partition.client, self.count), partition.next).await?;
            if read.next == partition.next {
                break;
            }
            partition.next = read.next;
            partition.read.extend(read.records);
        }
        let mut records = Vec::new();
        while let Some(record) = partition.read.pop_front_if(|record| record.offset < end) {
            if record.offset >= from {
                records.extend(of.message(record).ok());
            }
        }
        Ok(records)
    }
}
