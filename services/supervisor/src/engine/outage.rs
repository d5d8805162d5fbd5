//! A database that is away is waited for; a fleet that is somebody else's is not.

use tokio::time::Instant;
use tracing::{error, info, warn};

use super::{Engine, wall_clock};
use crate::backoff::Backoff;
use crate::store::StoreError;

/// The part of readiness that is kept here.
const PART: &str = "database";

/// An outage of the database, if there is one.
#[derive(Debug, Default)]
pub(super) struct Outage {
    since: Option<Instant>,
    backoff: Backoff,
}

/// The fleet is somebody else's.
#[derive(Debug)]
pub(super) struct LeaseLost;

impl Engine {
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

    /// The database answers again.
    pub(super) fn end_of(&mut self, outage: &Outage) {
        let Some(since) = outage.since else { return };
        info!(fleet = %self.fleet, seconds = since.elapsed().as_secs(), "the database takes what is written again");
        self.readiness.set_of(&self.fleet, PART, None);
        self.listen_anew();
    }

    /// No robot was silent while we were deaf.
    pub(super) fn listen_anew(&mut self) {
        let now = wall_clock();
        for known in self.robots.values_mut() {
            known.robot.listen_from(now);
        }
    }
}
