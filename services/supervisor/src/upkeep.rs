//! Upkeep of the tables while the service runs: creates partitions ahead, and deletes rows that are too old.

use crate::clocks::HoldBack;
use crate::metrics::Metrics;
use crate::readiness::Readiness;
use tokio::sync::watch;
use tokio::time::{Duration, timeout};
use tracing::{debug, info, warn};
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::Name;
use vibrissa_store::retention::{Done, Retention};
use vibrissa_store::time::Time;
use vibrissa_store::{Store, StoreError};

/// Interval between rounds of upkeep.
const EVERY: Duration = Duration::from_secs(3600);
/// Pause after a failed round.
const AGAIN: Duration = Duration::from_secs(300);
/// Pause between deletions of pieces of old rows.
const PAUSE: Duration = Duration::from_millis(400);

/// Time limit for a round: an index of a day takes hours at most. Without an answer, the server's host may have vanished.
const LONGEST: Duration = Duration::from_secs(12 * 3600);

/// An archive that is so far behind has stopped, µs: an alert tells of two hours.
const STOPPED_US: i64 = 86_400_000_000;
/// Part of the readiness that names an archive which has stopped.
const ARCHIVE: &str = "archive";

/// Runs upkeep until the service stops.
///
/// Contacts of the fleets `archived` are not deleted before they are archived.
pub(crate) async fn run(
    store: Store,
    (retention, hold_back): (Retention, HoldBack),
    archived: Vec<Name>,
    (metrics, readiness): (Metrics, Readiness),
    mut stop: watch::Receiver<bool>,
) {
    loop {
        let round = look_after(&store, (retention, &hold_back), &archived, (&metrics, &readiness));
        let pause = match within(LONGEST, store.with_leader(round)).await {
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

/// The result of a round that ends in time.
async fn within(longest: Duration, round: impl Future<Output = Result<bool, StoreError>>) -> Result<bool, StoreError> {
    const WHAT: &str = "look after the tables";
    timeout(longest, round).await.unwrap_or(Err(StoreError::NoAnswer { what: WHAT, patience: longest }))
}

async fn look_after(
    store: &Store,
    (retention, hold_back): (Retention, &HoldBack),
    archived: &[Name],
    (metrics, readiness): (&Metrics, &Readiness),
) -> Result<bool, StoreError> {
    let now_us = wall_clock().0 as i64;
    store.begin_archives(archived, now_us).await?;
    note_stopped(readiness, (store.last_archive().await?, store.archive_ahead(now_us).await?), now_us);
    let mut note = |done| note_done(&done, metrics);
    store.make_partitions(now_us, &mut note).await?;
    let old_by_us = hold_back.old_by_us(now_us);
    let is_more = store.look_after(retention, old_by_us, &mut note).await?;
    Ok(store.forget_announced(old_by_us, &mut note).await? || is_more)
}

/// A fleet, and the position of its archive.
type Standing = Option<(String, i64)>;

/// Tells people of an archive that has stopped, as that of a fleet which no supervisor has any more: contacts of all fleets stay in
/// the database. The position of another one is in the future if a clock was ahead.
fn note_stopped(readiness: &Readiness, (last, ahead): (Standing, Standing), now_us: i64) {
    let stopped = last.filter(|(_, archived_us)| now_us - archived_us > STOPPED_US);
    let early = ahead.map(|(fleet, archived_us)| {
        format!(
            "the archive of fleet {fleet} stands at {}, which is in the future: a clock was ahead. Correct the clocks, and start a \
             supervisor of this fleet with archive.url (docs/archive.md, Guarantees)",
            Time(archived_us)
        )
    });
    let notice = stopped.map(|(fleet, archived_us)| {
        format!(
            "the archive of fleet {fleet} stands at {}, so the contacts of all fleets since then stay in the database: start a \
             supervisor of this fleet with archive.url, or end its archive (docs/archive.md, End an archive)",
            Time(archived_us)
        )
    });
    let notice = notice.or(early);
    if let Some(notice) = &notice {
        warn!("{notice}");
    }
    readiness.notice(ARCHIVE, notice);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing told of it: the supervisor that would has no such fleet.
    #[test]
    fn regress_an_archive_that_has_stopped_is_named_until_it_goes_on() {
        let (readiness, now_us) = (Readiness::default(), 1_800_000_000_000_000);
        note_stopped(&readiness, (Some(("gone".to_owned(), now_us - STOPPED_US - 1)), None), now_us);
        let notices = readiness.notices();
        assert!(notices[0].starts_with("the archive of fleet gone stands at 2027-01-14T07:59:59"), "{notices:?}");
        note_stopped(&readiness, (Some(("lab".to_owned(), now_us - STOPPED_US)), None), now_us);
        assert!(readiness.notices().is_empty());
        note_stopped(&readiness, (None, Some(("early".to_owned(), now_us + STOPPED_US))), now_us);
        let notices = readiness.notices();
        assert!(notices[0].starts_with("the archive of fleet early stands at 2027-01-16T08:00:00"), "{notices:?}");
        note_stopped(&readiness, (None, None), now_us);
        assert!(readiness.notices().is_empty());
    }

    /// The host of the server vanished, and no packet came any more: there was no upkeep until a restart.
    #[tokio::test(start_paused = true)]
    async fn regress_a_round_without_an_answer_ends_with_an_error() {
        let unanswered = within(LONGEST, std::future::pending()).await;
        assert!(matches!(unanswered, Err(StoreError::NoAnswer { .. })), "{unanswered:?}");
        assert!(within(LONGEST, std::future::ready(Ok(true))).await.unwrap());
    }
}
