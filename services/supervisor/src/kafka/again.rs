//! Reads records again, for a recovery.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use rskafka::client::partition::{OffsetAt, PartitionClient};
use rskafka::record::RecordAndOffset;
use tracing::error;

use super::client::{KafkaError, Log, within};
use super::topic::FleetTopic;
use crate::log_inbox::{LogRange, LogRecord, Skipped};

/// What a recovery has read ahead.
pub(super) struct Again {
    log: Log,
    partitions: BTreeMap<u32, Partition>,
}

/// A partition that is read again.
struct Partition {
    client: PartitionClient,
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
        f.debug_set().entries(self.partitions.keys()).finish()
    }
}

impl Partition {
    async fn open(log: &Log, topic: &str, range: LogRange) -> Result<Self, KafkaError> {
        let client = log.open(topic, range.partition).await?;
        let earliest = within(client.get_offset(OffsetAt::Earliest)).await?;
        let latest = within(client.get_offset(OffsetAt::Latest)).await?;
        Ok(Self { client, earliest, latest, begin: range.from, next: range.from, read: VecDeque::new() })
    }

    /// Whether the records of a range are still to come.
    fn is_before(&self, range: LogRange) -> bool {
        self.begin <= range.from && range.to <= self.latest
    }
}

impl Again {
    pub(super) fn new(log: Log) -> Self {
        Self { log, partitions: BTreeMap::new() }
    }

    /// The messages of records that were read before. Ranges of a partition in rising order are read together.
    pub(super) async fn records(&mut self, of: &FleetTopic, range: LogRange) -> Result<Vec<LogRecord>, KafkaError> {
        let partitions = self.log.partitions(&of.name)?;
        if !self.partitions.get(&range.partition).is_some_and(|partition| partition.is_before(range)) {
            let opened = Partition::open(&self.log, &of.name, range).await?;
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
            let read = of.fetch((&partition.client, partitions), partition.next).await?;
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
