//! Reads records past those that cannot be read: a batch that is damaged, or unpacks to too many bytes, must not keep
//! the records after it away.

use std::ops::RangeInclusive;
use std::time::Duration;

use tracing::error;

use super::batch;
use super::client::KafkaError;
use super::record::Record;
use super::topic::FleetTopic;
use super::wire::{OffsetAt, Partition};
use crate::log_inbox::Skipped;

/// Bytes of one read, at least and at most.
const READ_BYTES: RangeInclusive<i32> = 64 * 1024..=1024 * 1024;
/// Bytes of one read of each partition together, as far as [`READ_BYTES`] allows. Each partition has at most one read
/// in memory.
const ALL_READS_BYTES: i32 = 16 * 1024 * 1024;
/// A read of so many bytes answers with one batch, however long it is.
const ONE_BATCH: i32 = 1;
/// Time for which a broker waits for new records. It bounds the delay after a change of the leader, not that of records.
const WAIT: Duration = Duration::from_millis(500);

/// Some records.
pub(super) struct Fetched {
    pub(super) records: Vec<Record>,
    /// Offset from which the next read begins.
    pub(super) next: i64,
    /// Offset after the last record of the partition.
    pub(super) end: i64,
}

/// Bytes of one read of a topic with so many partitions.
fn read_bytes(partitions: u32) -> i32 {
    let each = ALL_READS_BYTES / i32::try_from(partitions).unwrap_or(i32::MAX).max(1);
    each.clamp(*READ_BYTES.start(), *READ_BYTES.end())
}

/// Reads once, without a further try.
async fn read(partition: &Partition, at: i64, bytes: i32) -> Result<Fetched, KafkaError> {
    let (answer, end) = partition.fetch(at, bytes, WAIT).await?;
    let read = batch::read(answer, at, end)?;
    Ok(Fetched { records: read.records, next: read.next, end })
}

impl FleetTopic {
    /// Reads records of one of so many partitions from an offset on. Records that cannot be read are set aside after
    /// some tries: counted, and logged.
    pub(super) async fn fetch(
        &self,
        (partition, partitions): (&Partition, u32),
        at: i64,
    ) -> Result<Fetched, KafkaError> {
        let mut problem = None;
        // If an answer cannot be read, its first batch is tried alone, and once more.
        for bytes in [read_bytes(partitions), ONE_BATCH, ONE_BATCH] {
            match read(partition, at, bytes).await {
                Ok(fetched) => return Ok(fetched),
                Err(why) if why.is_unreadable() => problem = Some(why),
                Err(why) => return Err(why),
            }
        }
        let end = partition.offset(OffsetAt::Latest).await?.max(at + 1);
        let mut search = Search::new(at, end);
        while let Some(next) = search.next() {
            search.tell(next, can_read(partition, next).await?);
        }
        let next = search.readable;
        self.skipped(Skipped::Unreadable, next.abs_diff(at));
        let problem = problem.map(|why| why.to_string()).unwrap_or_default();
        error!(
            fleet = %self.fleet, topic = %self.name, partition = partition.number(), from = at, to = next, problem,
            "records of the log cannot be read and are set aside: robots send contacts without a receipt again"
        );
        self.tell_set_aside(partition.number(), (at, next), &problem);
        Ok(Fetched { records: Vec::new(), next, end })
    }
}

/// Search for the next offset that can be read. Of several unreadable spans close to each other, the readable records between
/// may be set aside, too.
struct Search {
    /// The last offset known to be unreadable.
    unreadable: i64,
    /// The first offset known to be readable, or the end of the partition.
    readable: i64,
    /// Distance of the next try; `None` once a readable offset is known.
    step: Option<i64>,
}

impl Search {
    fn new(at: i64, end: i64) -> Self {
        Self { unreadable: at, readable: end, step: Some(1) }
    }

    /// The offset to try; `None` if the result is known.
    fn next(&self) -> Option<i64> {
        let between = self.readable - self.unreadable;
        let ahead = self.step.map_or(between / 2, |step| step.min(between - 1));
        (between > 1).then_some(self.unreadable + ahead)
    }

    fn tell(&mut self, at: i64, is_readable: bool) {
        if is_readable {
            (self.readable, self.step) = (at, None);
        } else {
            self.unreadable = at;
            self.step = self.step.map(|step| 2 * step);
        }
    }
}

async fn can_read(partition: &Partition, at: i64) -> Result<bool, KafkaError> {
    match read(partition, at, ONE_BATCH).await {
        Ok(_) => Ok(true),
        Err(why) if why.is_unreadable() => Ok(false),
        Err(why) => Err(why),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_of_many_partitions_are_smaller() {
        assert_eq!([0, 1, 16].map(read_bytes), [1024 * 1024; 3]);
        assert_eq!(read_bytes(64), 256 * 1024);
        assert_eq!([1000, u32::MAX].map(read_bytes), [64 * 1024; 2]);
    }

    #[test]
    fn brute_force_an_unreadable_batch_is_passed_and_no_record_after_it() {
        for end in 1..40_i64 {
            for begin in 0..end {
                for after in begin + 1..=end {
                    for at in begin..after {
                        let (mut search, mut tries) = (Search::new(at, end), 0);
                        while let Some(next) = search.next() {
                            search.tell(next, !(begin..after).contains(&next));
                            tries += 1;
                        }
                        assert_eq!(search.readable, after, "{at} of {begin}..{after}");
                        assert!(tries < 15, "{tries}");
                    }
                }
            }
        }
    }
}
