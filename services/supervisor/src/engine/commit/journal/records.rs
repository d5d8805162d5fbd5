//! The records of a partitioned log to which a row of the journal refers.

use std::collections::{BTreeMap, BTreeSet};

use super::{JournalEvent, StoredEntries};
use crate::log_inbox::{LogRange, LogRecord, LogSource};
use vibrissa_store::{Lease, StoreError};

/// Records of the log by their range.
pub(crate) type LogRecords = BTreeMap<LogRange, Vec<LogRecord>>;

/// Reads the records that a row of the journal refers to.
///
/// # Errors
/// It refers to a log, and none is configured.
pub(crate) async fn records_of(
    row: &StoredEntries,
    log: Option<&LogSource>,
    lease: &Lease,
) -> Result<LogRecords, StoreError> {
    // Each partition is read once, in rising order. The entries of the engine's workers have the same ranges, and some
    // of them not all.
    let mut ranges = BTreeSet::new();
    for entry in row.entries().map_while(Result::ok) {
        if let JournalEvent::Log { range, .. } = entry.event {
            ranges.insert(range);
        }
    }
    let mut records = LogRecords::new();
    for range in ranges {
        let Some(log) = log else { return Err(StoreError::NoLog { fleet: lease.fleet().to_string() }) };
        records.insert(range, log.records(range).await);
    }
    Ok(records)
}
