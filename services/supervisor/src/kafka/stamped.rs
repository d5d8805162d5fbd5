//! Reads a shard's partition for the archive: records with the times at which the log got them.

use std::sync::Arc;

use rskafka::client::partition::{OffsetAt, PartitionClient};
use tracing::error;

use super::client::{KafkaError, within};
use super::reader::LogReader;
use crate::log_inbox::{LogRecord, Skipped};

/// A message with its time of receipt.
#[derive(Debug)]
pub(crate) struct StampedRecord {
    /// Timestamp of the record, µs since 1970 UTC: that of the bridge, or of the log.
    pub(crate) received_us: i64,
    pub(crate) record: LogRecord,
}

/// A partition with its present ends.
pub(crate) struct OpenLog {
    reader: LogReader,
    partition: Arc<PartitionClient>,
    /// Offset of the first record.
    pub(crate) earliest: i64,
    /// Offset after the last record.
    pub(crate) latest: i64,
}

impl LogReader {
    /// Connects to the partition.
    ///
    /// # Errors
    /// The log does not answer, or the topic has not as many partitions as the fleet has shards.
    pub(crate) async fn open_log(&self) -> Result<OpenLog, KafkaError> {
        let partition = self.open().await?;
        let earliest = within(partition.get_offset(OffsetAt::Earliest)).await?;
        let latest = within(partition.get_offset(OffsetAt::Latest)).await?;
        Ok(OpenLog { reader: self.clone(), partition, earliest, latest })
    }
}

impl OpenLog {
    /// Reads the ends of the partition again.
    ///
    /// # Errors
    /// The log does not answer.
    pub(crate) async fn refresh(&mut self) -> Result<(), KafkaError> {
        self.earliest = within(self.partition.get_offset(OffsetAt::Earliest)).await?;
        self.latest = within(self.partition.get_offset(OffsetAt::Latest)).await?;
        Ok(())
    }

    /// Some messages from an offset on, and the offset after them; `to` if there are no more before it.
    ///
    /// # Errors
    /// The log does not answer.
    pub(crate) async fn read(&self, from: i64, to: i64) -> Result<(Vec<StampedRecord>, i64), KafkaError> {
        let at = from.max(self.earliest);
        let read = self.reader.fetch(&self.partition, at).await?;
        // An answer may begin before the offset, with the first record of a batch.
        let later = read.records.into_iter().skip_while(|record| record.offset < from).collect::<Vec<_>>();
        // A record exists before the end of the log, unless only marks of transactions follow.
        let next = if read.next == at { to } else { read.next.min(to) };
        let stamped = later.into_iter().filter(|record| record.offset < to).filter_map(|one| {
            let received_us = one.record.timestamp.timestamp_micros();
            // The engine counts and tells the records that it skips.
            self.reader.message(one).ok().map(|record| StampedRecord { received_us, record })
        });
        Ok((stamped.collect(), next))
    }

    /// Tells that the log has deleted records before they were archived.
    pub(crate) fn tell_deleted(&self, from: i64) {
        self.reader.skipped(Skipped::Deleted, from.abs_diff(self.earliest));
        error!(
            fleet = %self.reader.shard, topic = self.reader.topic(), from, earliest = self.earliest,
            "the log has deleted records before they were archived: the archive lacks their contacts. Keep records longer"
        );
    }
}
