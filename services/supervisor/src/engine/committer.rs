//! The writing half: one transaction at a time, while the engine gathers for the next one. A database that is away is waited
//! for; a fleet that is somebody else's is not.

use tokio::time::{Duration, Instant};
use tracing::{error, info, warn};
use vibrissa_protocol::Name;

use crate::backoff::Backoff;
use crate::metrics::{FleetMetrics, Metrics};
use crate::readiness::Readiness;
use crate::store::{Batch, Lease, StoreError, Writer};

/// The part of readiness that is kept here.
const PART: &str = "database";

/// Whoever writes for a fleet.
pub(super) struct Committer {
    pub(super) fleet: Name,
    pub(super) lease: Lease,
    pub(super) writer: Writer,
    pub(super) program: Metrics,
    pub(super) metrics: FleetMetrics,
    pub(super) readiness: Readiness,
}

/// What is to be written in a transaction.
#[derive(Debug, Clone, Copy)]
pub(super) enum Work<'a> {
    /// A batch.
    Rows(&'a Batch),
    /// The bytes of one, with its number: it is committed then, and only its rows are still to be written.
    Bytes(i64, &'a [u8]),
}

impl Work<'_> {
    fn is_empty(self) -> bool {
        match self {
            Self::Rows(batch) => batch.is_empty(),
            Self::Bytes(..) => false,
        }
    }
}

/// What is known of a commit.
pub(super) struct Committed {
    /// How long it took, with all attempts.
    pub(super) took: Duration,
    /// Whether the database was away.
    pub(super) was_away: bool,
}

/// An outage of the database, if there is one.
#[derive(Debug, Default)]
pub(super) struct Outage {
    since: Option<Instant>,
    backoff: Backoff,
}

/// The fleet is somebody else's.
#[derive(Debug)]
pub(super) struct LeaseLost;

impl Committer {
    /// Writes something; a database that is away is waited for, while the inbox fills and then sheds.
    pub(super) async fn commit(&mut self, work: Work<'_>) -> Result<Committed, LeaseLost> {
        let mut outage = Outage::default();
        let first = Instant::now();
        while !work.is_empty() {
            let begun = Instant::now();
            let written = match work {
                Work::Rows(batch) => self.writer.commit(&self.lease, batch).await,
                Work::Bytes(number, bytes) => self.writer.keep(&self.lease, number, bytes).await,
            };
            match written {
                Ok(()) => {
                    self.metrics.database_commit_seconds.observe(begun.elapsed().as_secs_f64());
                    break;
                }
                Err(problem) => self.wait_out(&mut outage, problem, "nothing is recorded").await?,
            }
        }
        let was_away = self.end_of(&outage);
        Ok(Committed { took: first.elapsed(), was_away })
    }

    /// Waits before the next attempt, and says why; a lost lease is not waited for.
    pub(super) async fn wait_out(
        &mut self,
        outage: &mut Outage,
        problem: StoreError,
        so: &str,
    ) -> Result<(), LeaseLost> {
        if let StoreError::LeaseLost { .. } = problem {
            warn!(%problem, "nothing more is written");
            return Err(LeaseLost);
        }
        self.program.database_failed();
        error!(%problem, fleet = %self.fleet, "{so}; trying again");
        self.readiness.set_of(&self.fleet, PART, Some(format!("{so}: {problem}")));
        outage.since.get_or_insert_with(Instant::now);
        outage.backoff.wait().await;
        Ok(())
    }

    /// The database answers again; true if it did not before.
    pub(super) fn end_of(&self, outage: &Outage) -> bool {
        let Some(since) = outage.since else { return false };
        info!(fleet = %self.fleet, seconds = since.elapsed().as_secs(), "the database takes what is written again");
        self.readiness.set_of(&self.fleet, PART, None);
        true
    }
}
