//! The writing half: one transaction at a time, while the engine gathers for the next one. A database that is away is waited
//! for; a fleet that is somebody else's is not.

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

/// The part of readiness that is kept here.
const PART: &str = "database";

/// Whoever writes for a fleet.
pub(in crate::engine) struct Committer {
    pub(in crate::engine) fleet: Name,
    pub(in crate::engine) lease: Lease,
    pub(in crate::engine) writer: Writer,
    pub(in crate::engine) program: Metrics,
    pub(in crate::engine) metrics: FleetMetrics,
    pub(in crate::engine) readiness: Readiness,
}

/// What is known of a commit.
pub(in crate::engine) struct Committed {
    /// How long it took, with all attempts.
    pub(in crate::engine) took: Duration,
    /// Whether the database was away.
    pub(in crate::engine) was_away: bool,
    /// Robots whose rows the database refuses for good: these rows were left out.
    pub(in crate::engine) offenders: Vec<Offender>,
}

/// A robot whose rows the database refuses, as it was committed last.
pub(in crate::engine) struct Offender {
    pub(in crate::engine) robot_id: i64,
    pub(in crate::engine) rejection: Rejection,
    pub(in crate::engine) stored: Option<StoredRobot>,
    /// Rows of the journal with its entries, with their numbers, in order.
    pub(in crate::engine) journal: Vec<(i64, Vec<u8>)>,
}

/// The database refuses bytes for good.
#[derive(Debug)]
pub(in crate::engine) struct BytesRefused;

/// An outage of the database, if there is one.
#[derive(Debug, Default)]
pub(in crate::engine) struct Outage {
    since: Option<Instant>,
    backoff: Backoff,
}

/// The fleet is somebody else's.
#[derive(Debug)]
pub(in crate::engine) struct LeaseLost;

impl Committer {
    /// Writes a batch; a database that is away is waited for, while the inbox fills and then sheds. If the database refuses
    /// rows for good, the batch is written without the rows of the robots that they belong to.
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
                    error!(%problem, fleet = %self.fleet, "the database refuses rows: writing robot by robot");
                    is_apart = true;
                }
                Err(problem) => self.wait_out(&mut outage, problem, "nothing is recorded").await?,
            }
        }
        let offenders = self.offenders(&mut outage, refused).await?;
        let was_away = self.end_of(&outage);
        Ok(Committed { took: first.elapsed(), was_away, offenders })
    }

    /// Writes a batch's bytes under its number, which commits it; only its rows are still to be written. Waits until the
    /// database is available.
    pub(in crate::engine) async fn keep(
        &mut self,
        number: i64,
        bytes: &[u8],
    ) -> Result<Result<Committed, BytesRefused>, LeaseLost> {
        let mut outage = Outage::default();
        let first = Instant::now();
        loop {
            let begun = Instant::now();
            match self.writer.keep(&self.lease, number, bytes).await {
                Ok(()) => {
                    self.metrics.database_commit_seconds.observe(begun.elapsed().as_secs_f64());
                    break;
                }
                Err(problem) if problem.rejection().is_some() => {
                    error!(%problem, fleet = %self.fleet, "the database refuses a transaction's bytes: writing its rows first");
                    return Ok(Err(BytesRefused));
                }
                Err(problem) => self.wait_out(&mut outage, problem, "nothing is recorded").await?,
            }
        }
        let was_away = self.end_of(&outage);
        Ok(Ok(Committed { took: first.elapsed(), was_away, offenders: Vec::new() }))
    }

    /// The robots whose rows were refused, as they were committed last.
    async fn offenders(&mut self, outage: &mut Outage, refused: Vec<Refused>) -> Result<Vec<Offender>, LeaseLost> {
        let mut offenders = Vec::new();
        for Refused { owner, rejection } in refused {
            let (code, text) = (&rejection.code, &rejection.text);
            error!(fleet = %self.fleet, ?owner, code, text, "the database refuses these rows for good: they are left out");
            let Owner::Robot(robot_id) = owner else { continue };
            let (stored, journal) = loop {
                match self.load(robot_id).await {
                    Ok(loaded) => break loaded,
                    Err(problem) => self.wait_out(outage, problem, "a robot cannot be loaded").await?,
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

    /// Waits before the next attempt, and says why; a lost lease is not waited for.
    pub(in crate::engine) async fn wait_out(
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
        self.readiness.set_of(&self.fleet, PART, Some(format!("{so}: {}", problem.told())));
        outage.since.get_or_insert_with(Instant::now);
        outage.backoff.wait().await;
        Ok(())
    }

    /// The database answers again; true if it did not before.
    pub(in crate::engine) fn end_of(&self, outage: &Outage) -> bool {
        let Some(since) = outage.since else { return false };
        info!(fleet = %self.fleet, seconds = since.elapsed().as_secs(), "the database takes what is written again");
        self.readiness.set_of(&self.fleet, PART, None);
        true
    }
}
