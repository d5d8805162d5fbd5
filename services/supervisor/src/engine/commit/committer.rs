//! Writes one transaction at a time, while the engine fills the next batch. Retries while the database is unreachable,
//! and gives up when the lease is lost.

use tokio::time::{Duration, Instant};
use tracing::{error, info, warn};
use vibrissa_protocol::Name;

use crate::backoff::Backoff;
use crate::metrics::{FleetMetrics, Metrics};
use crate::readiness::Readiness;
use vibrissa_store::batch::Owner;
use vibrissa_store::{Batch, Lease, Refused, Rejection, StoreError, StoredRobot, Writer};

use crate::engine::commit::journal;
use crate::engine::commit::recovery::ROWS_AT_A_TIME;

/// Name of this part in the service's readiness.
const PART: &str = "database";

/// Writes the transactions of a fleet.
pub(in crate::engine) struct Committer {
    pub(in crate::engine) fleet: Name,
    pub(in crate::engine) lease: Lease,
    pub(in crate::engine) writer: Writer,
    pub(in crate::engine) program: Metrics,
    pub(in crate::engine) metrics: FleetMetrics,
    pub(in crate::engine) readiness: Readiness,
}

/// Result of a commit.
pub(in crate::engine) struct Committed {
    /// Duration with all attempts.
    pub(in crate::engine) took: Duration,
    /// Whether the database was unreachable.
    pub(in crate::engine) was_away: bool,
    /// Robots whose rows the database rejects permanently: these rows were left out.
    pub(in crate::engine) offenders: Vec<Offender>,
}

/// A robot whose rows the database rejects, as of its last commit.
pub(in crate::engine) struct Offender {
    pub(in crate::engine) robot_id: i64,
    pub(in crate::engine) rejection: Rejection,
    pub(in crate::engine) stored: Option<StoredRobot>,
    /// Its journal entries, by rows with their numbers, in order.
    pub(in crate::engine) journal: Vec<(i64, Vec<u8>)>,
}

/// The database rejects an intent permanently.
#[derive(Debug)]
pub(in crate::engine) struct BytesRefused;

/// State of an outage of the database, if there is one.
#[derive(Debug, Default)]
pub(in crate::engine) struct Outage {
    since: Option<Instant>,
    backoff: Backoff,
}

/// Another supervisor owns the fleet.
#[derive(Debug)]
pub(in crate::engine) struct LeaseLost;

impl Committer {
    /// Writes the rows of a batch. Retries while the database is unreachable; meanwhile the inbox fills and then sheds.
    /// If the database rejects rows permanently, the batch is written without the rows of the robots concerned.
    pub(in crate::engine) async fn commit(&mut self, batch: &mut Batch) -> Result<Committed, LeaseLost> {
        let mut outage = Outage::default();
        let first = Instant::now();
        let (mut refused, mut is_apart) = (Vec::new(), false);
        while !batch.is_empty() {
            let begun = Instant::now();
            let written = if is_apart {
                self.writer.commit_apart(&self.lease, batch, journal::by_robot, &mut refused).await
            } else {
                self.writer.commit(&self.lease, batch).await
            };
            match written {
                Ok(()) => {
                    self.metrics.database_commit_seconds.observe(begun.elapsed().as_secs_f64());
                    break;
                }
                Err(problem) if !is_apart && problem.rejection().is_some() => {
                    error!(%problem, fleet = %self.fleet, "database rejects rows, writing robot by robot");
                    is_apart = true;
                }
                Err(problem) => self.wait_out(&mut outage, problem, "nothing is recorded").await?,
            }
        }
        let offenders = self.offenders(&mut outage, refused).await?;
        let was_away = self.end_of(&outage);
        Ok(Committed { took: first.elapsed(), was_away, offenders })
    }

    /// Writes a batch's bytes to the intent log, which commits the transaction; its rows are written later. Retries
    /// while the database is unreachable.
    pub(in crate::engine) async fn keep(
        &mut self,
        number: i64,
        bytes: &[u8],
    ) -> Result<Result<Committed, BytesRefused>, LeaseLost> {
        let mut outage = Outage::default();
        let first = Instant::now();
        loop {
            let begun = Instant::now();
            match self.writer.write_intent(&self.lease, number, bytes).await {
                Ok(()) => {
                    self.metrics.database_commit_seconds.observe(begun.elapsed().as_secs_f64());
                    break;
                }
                Err(problem) if problem.rejection().is_some() => {
                    error!(%problem, fleet = %self.fleet, "database rejects an intent, writing the rows first");
                    return Ok(Err(BytesRefused));
                }
                Err(problem) => self.wait_out(&mut outage, problem, "nothing is recorded").await?,
            }
        }
        let was_away = self.end_of(&outage);
        Ok(Ok(Committed { took: first.elapsed(), was_away, offenders: Vec::new() }))
    }

    /// Loads the robots whose rows were rejected, as of their last commit.
    async fn offenders(&mut self, outage: &mut Outage, refused: Vec<Refused>) -> Result<Vec<Offender>, LeaseLost> {
        let mut offenders = Vec::new();
        for Refused { owner, rejection } in refused {
            let (code, text) = (&rejection.code, &rejection.text);
            error!(fleet = %self.fleet, ?owner, code, text, "database rejects these rows for good, leaving them out");
            let Owner::Robot(robot_id) = owner else { continue };
            let (stored, journal) = loop {
                match self.load(robot_id).await {
                    Ok(loaded) => break loaded,
                    Err(problem) => self.wait_out(outage, problem, "cannot load a robot").await?,
                }
            };
            offenders.push(Offender { robot_id, rejection, stored, journal });
        }
        Ok(offenders)
    }

    async fn load(&mut self, robot_id: i64) -> Result<(Option<StoredRobot>, Vec<(i64, Vec<u8>)>), StoreError> {
        let stored = self.writer.robot(&self.lease, robot_id).await?;
        let mut after = stored.as_ref().map_or(i64::MAX, |stored| stored.journal_number);
        let mut journal = Vec::new();
        loop {
            let rows = self.writer.journal(&self.lease, after, ROWS_AT_A_TIME).await?;
            let Some((last, _)) = rows.last() else { return Ok((stored, journal)) };
            after = *last;
            for (number, entries) in &rows {
                let own = journal::by_robot(entries).into_iter().find(|(robot, _)| *robot == robot_id);
                journal.extend(own.map(|(_, entries)| (*number, entries)));
            }
        }
    }

    /// Reports a problem, and waits before the next attempt. A lost lease is an error.
    pub(in crate::engine) async fn wait_out(
        &mut self,
        outage: &mut Outage,
        problem: StoreError,
        so: &str,
    ) -> Result<(), LeaseLost> {
        if let StoreError::LeaseLost { .. } = problem {
            warn!(%problem, "lease lost, writing stops");
            return Err(LeaseLost);
        }
        self.program.database_failed();
        error!(%problem, fleet = %self.fleet, "{so}, retrying");
        self.readiness.set_of(&self.fleet, PART, Some(format!("{so}: {}", problem.told())));
        outage.since.get_or_insert_with(Instant::now);
        outage.backoff.wait().await;
        Ok(())
    }

    /// Ends an outage; returns true if there was one.
    pub(in crate::engine) fn end_of(&self, outage: &Outage) -> bool {
        let Some(since) = outage.since else { return false };
        info!(fleet = %self.fleet, seconds = since.elapsed().as_secs(), "database available again");
        self.readiness.set_of(&self.fleet, PART, None);
        true
    }
}
