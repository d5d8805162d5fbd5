//! Reads records past those that cannot be read: a batch that is damaged, compressed in an unknown way, or has impossible
//! times must not keep the records after it away.

use rskafka::client::partition::{OffsetAt, PartitionClient};
use rskafka::record::RecordAndOffset;
use tracing::error;

use super::client::{KafkaError, within};
use super::reader::LogReader;
use crate::log_inbox::Skipped;

/// Bytes of one read.
const READ_BYTES: i32 = 1024 * 1024;
/// A read of so many bytes answers with one batch, however long it is.
const ONE_BATCH: i32 = 1;
/// Time for which a broker waits for new records, ms. It bounds the delay after a change of the leader, not that of records.
const WAIT_MS: i32 = 500;
/// The tries of one read. If an answer cannot be read, its first batch is tried alone, and once more.
const TRIES: [i32; 3] = [READ_BYTES, ONE_BATCH, ONE_BATCH];

/// Some records.
pub(super) struct Fetched {
    pub(super) records: Vec<RecordAndOffset>,
    /// Offset from which the next read begins.
    pub(super) next: i64,
    /// Offset after the last record of the partition.
    pub(super) end: i64,
}

impl LogReader {
    /// Reads records from an offset on. Records that cannot be read are set aside after some tries: counted, and logged.
    pub(super) async fn fetch(&self, partition: &PartitionClient, at: i64) -> Result<Fetched, KafkaError> {
        let mut problem = None;
        for bytes in TRIES {
            match within(partition.fetch_records(at, 1..bytes + 1, WAIT_MS)).await {
                Ok((records, end)) => {
                    // A batch without records is a mark of a transaction.
                    let after_mark = if bytes == ONE_BATCH && at < end { at + 1 } else { at };
                    let next = records.last().map_or(after_mark, |last| last.offset + 1);
                    return Ok(Fetched { records, next, end });
                }
                Err(why) if why.is_unreadable() => problem = Some(why),
                Err(why) => return Err(why),
            }
        }
        let end = within(partition.get_offset(OffsetAt::Latest)).await?.max(at + 1);
        let mut search = Search::new(at, end);
        while let Some(next) = search.next() {
            search.tell(next, can_read(partition, next).await?);
        }
        let next = search.readable;
        self.skipped(Skipped::Unreadable, next.abs_diff(at));
        let problem = problem.map(|why| why.to_string()).unwrap_or_default();
        error!(
            fleet = %self.fleet, topic = self.topic(), from = at, to = next, problem,
            "records of the log cannot be read and are set aside: robots send contacts without a receipt again"
        );
        self.tell_set_aside(at, next, &problem);
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

async fn can_read(partition: &PartitionClient, at: i64) -> Result<bool, KafkaError> {
    match within(partition.fetch_records(at, 1..ONE_BATCH + 1, WAIT_MS)).await {
        Ok(_) => Ok(true),
        Err(why) if why.is_unreadable() => Ok(false),
        Err(why) => Err(why),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
