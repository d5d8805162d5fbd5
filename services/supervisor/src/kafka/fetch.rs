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
        let next = readable_after(at, end, async |at| can_read(partition, at).await).await?;
        self.skipped(Skipped::Unreadable, next.abs_diff(at));
        let problem = problem.map(|why| why.to_string());
        error!(
            fleet = %self.shard, topic = self.topic(), from = at, to = next, problem,
            "records of the log cannot be read and are set aside: robots send contacts without a receipt again"
        );
        self.tell_set_aside(at, next);
        Ok(Fetched { records: Vec::new(), next, end })
    }
}

/// The next offset after `at` that can be read, or `end`. Unreadable records after the next readable ones may be found first, if there
/// are several spans of them: the records between are set aside, too.
async fn readable_after(
    at: i64,
    end: i64,
    can_read: impl AsyncFn(i64) -> Result<bool, KafkaError>,
) -> Result<i64, KafkaError> {
    let (mut unreadable, mut step) = (at, 1);
    let mut readable = loop {
        let next = unreadable.saturating_add(step).min(end);
        if next == end || can_read(next).await? {
            break next;
        }
        unreadable = next;
        step *= 2;
    };
    while readable - unreadable > 1 {
        let middle = unreadable + (readable - unreadable) / 2;
        if can_read(middle).await? {
            readable = middle;
        } else {
            unreadable = middle;
        }
    }
    Ok(readable)
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

    #[tokio::test]
    async fn brute_force_an_unreadable_batch_is_passed_and_no_record_after_it() {
        for end in 1..40_i64 {
            for begin in 0..end {
                for after in begin + 1..=end {
                    for at in begin..after {
                        let found = readable_after(at, end, async |at| Ok(!(begin..after).contains(&at)));
                        assert_eq!(found.await.unwrap(), after, "{at} of {begin}..{after}");
                    }
                }
            }
        }
    }
}
