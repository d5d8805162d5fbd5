//! Reads records again, for a recovery.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;

use rskafka::client::partition::{OffsetAt, PartitionClient};
use rskafka::record::RecordAndOffset;
use tracing::error;

use super::client::{KafkaError, Log, within};
use super::reader::LogReader;
use crate::backoff::Backoff;
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

impl LogReader {
    /// The messages of records that were read before. Waits for the log, however long that takes: they are part of the
    /// fleet's state. Ranges of a partition in rising order are read together.
    pub(crate) async fn records(&self, range: LogRange) -> Vec<LogRecord> {
        let mut again = self.again.lock().await;
        let (mut backoff, mut is_failing) = (Backoff::default(), false);
        loop {
            match self.try_records(&mut again, range).await {
                Ok(records) => return records,
                Err(problem) => {
                    *again = None;
                    if !std::mem::replace(&mut is_failing, true) {
                        let partition = range.partition;
                        error!(
                            %problem, fleet = %self.fleet, partition,
                            "cannot read the log again for the recovery, retrying"
                        );
                    }
                    backoff.wait().await;
                }
            }
        }
    }

    async fn try_records(&self, again: &mut Option<Again>, range: LogRange) -> Result<Vec<LogRecord>, KafkaError> {
        let again = match again {
            Some(again) => again,
            none => none.insert(Again { log: self.connector.connect().await?, partitions: BTreeMap::new() }),
        };
        let partitions = again.log.partitions(self.topic())?;
        if !again.partitions.get(&range.partition).is_some_and(|partition| partition.is_before(range)) {
            let opened = Partition::open(&again.log, self.topic(), range).await?;
            again.partitions.insert(range.partition, opened);
        }
        let Some(partition) = again.partitions.get_mut(&range.partition) else { return Ok(Vec::new()) };
        let LogRange { from, to, .. } = range;
        let (first, end) = (from.max(partition.earliest), to.min(partition.latest));
        let lost = (to - from) - (end - first).max(0);
        if lost > 0 {
            self.skipped(Skipped::Deleted, lost as u64);
            error!(
                fleet = %self.fleet, topic = self.topic(), partition = range.partition, from, to, lost,
                "the log has deleted records that the recovery needs: the state lacks their contacts. Keep records longer"
            );
        }
        partition.begin = to;
        partition.next = partition.next.max(first);
        while partition.next < end {
            let read = self.fetch((&partition.client, partitions), partition.next).await?;
            if read.next == partition.next {
                break;
            }
            partition.next = read.next;
            partition.read.extend(read.records);
        }
        let mut records = Vec::new();
        while let Some(record) = partition.read.pop_front_if(|record| record.offset < end) {
            if record.offset >= from {
                records.extend(self.message(record).ok());
            }
        }
        Ok(records)
    }
}
