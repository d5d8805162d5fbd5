//! Upkeep of the tables while the service runs: creates partitions ahead, and deletes rows that are too old.

use crate::clocks::HoldBack;
use crate::metrics::Metrics;
use tokio::sync::watch;
use tokio::time::{Duration, timeout};
use tracing::{debug, info, warn};
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::Name;
use vibrissa_store::retention::{Done, Retention};
use vibrissa_store::{Store, StoreError};

/// Interval between rounds of upkeep.
const EVERY: Duration = Duration::from_secs(3600);
/// Pause after a failed round.
const AGAIN: Duration = Duration::from_secs(300);
/// Pause between deletions of pieces of old rows.
const PAUSE: Duration = Duration::from_millis(400);

/// Runs upkeep until the service stops.
///
/// Contacts of the fleets `archived` are not deleted before they are archived.
pub(crate) async fn run(
    store: Store,
    (retention, hold_back): (Retention, HoldBack),
    archived: Vec<Name>,
    metrics: Metrics,
    mut stop: watch::Receiver<bool>,
) {
    loop {
        let round = look_after(&store, (retention, &hold_back), &archived, &metrics);
        let pause = match store.with_leader(round).await {
            Ok(true) => PAUSE,
            Ok(false) => {
                metrics.upkeep_timestamp_seconds.set(wall_clock().as_s());
                EVERY
            }
            Err(problem) => {
                metrics.upkeep_errors.inc();
                warn!(%problem, "upkeep of the tables failed, trying again later");
                AGAIN
            }
        };
        if timeout(pause, stop.wait_for(|&stop| stop)).await.is_ok() {
            return;
        }
    }
}

async fn look_after(
    store: &Store,
    (retention, hold_back): (Retention, &HoldBack),
    archived: &[Name],
    metrics: &Metrics,
) -> Result<bool, StoreError> {
    let now_us = wall_clock().0 as i64;
    store.begin_archives(archived, now_us).await?;
    let mut note = |done| note_done(&done, metrics);
    store.make_partitions(now_us, &mut note).await?;
    let old_by_us = hold_back.old_by_us(now_us);
    let is_more = store.look_after(retention, old_by_us, &mut note).await?;
    Ok(store.forget_announced(old_by_us, &mut note).await? || is_more)
}

fn note_done(done: &Done, metrics: &Metrics) {
    match done {
        Done::Made { partition } => info!(partition, "partition created"),
        Done::Indexed { partition } => info!(partition, "partition indexed"),
        Done::Dropped { partition, bytes } => {
            metrics.partitions_dropped.inc();
            info!(partition, bytes, "old partition dropped");
        }
        Done::Removed { table, rows } => {
            metrics.old_rows_removed.inc_by(*rows);
            debug!(table, rows, "old rows deleted");
        }
    }
}
