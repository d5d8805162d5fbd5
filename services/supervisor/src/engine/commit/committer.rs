//! Writes one transaction at a time, while the engine fills the next batch. Retries while the database is unreachable,
//! and gives up when the lease is lost.

use tokio::time::{Duration, Instant};
use tracing::{error, info, warn};
use vibrissa_edge::full_name::FullName;
use vibrissa_edge::invariants::Invariant;
use vibrissa_protocol::Name;

use crate::backoff::Backoff;
use crate::metrics::{FleetMetrics, Metrics};
use vibrissa_store::batch::Owner;
use vibrissa_store::{Batch, Lease, LossCause, Refused, Rejection, StoreError, StoredRobot, Writer};

use crate::engine::commit::journal::records::{LogRecords, records_of};
use crate::engine::commit::journal::{self, StoredEntries};
use crate::engine::commit::transaction::SealedTransaction;
use crate::log_inbox::LogSource;

/// Writes the transactions of a fleet.
pub(crate) struct Committer {
    fleet: Name,
    lease: Lease,
    writer: Writer,
    program: Metrics,
    metrics: FleetMetrics,
    /// The partitioned log that contacts come from, if there is one.
    log: Option<LogSource>,
}

/// Result of one write.
pub(crate) struct Written {
    pub(in crate::engine) committer: Committer,
    pub(in crate::engine) transaction: SealedTransaction,
    pub(in crate::engine) result: Result<Committed, LeaseLost>,
}

/// Result of a commit.
pub(crate) struct Committed {
    /// Duration with all attempts.
    pub(crate) took: Duration,
    /// Whether the database was unreachable.
    pub(crate) was_away: bool,
    /// Robots whose rows the database rejects permanently: these rows were left out.
    pub(crate) offenders: Vec<Offender>,
}

/// A robot whose rows the database rejects, as of its last commit.
pub(crate) struct Offender {
    pub(crate) robot_id: i64,
    pub(crate) rejection: Rejection,
    pub(crate) stored: Option<StoredRobot>,
    /// Its journal entries, by rows, in order.
    pub(crate) journal: Vec<StoredEntries>,
    /// The records of the log to which these refer, by row.
    pub(crate) records: Vec<LogRecords>,
}

/// State of an outage of the database, if there is one.
#[derive(Debug, Default)]
pub(crate) struct Outage {
    since: Option<Instant>,
    backoff: Backoff,
}

/// A robot as of its last commit: its checkpoint, its journal entries by row, and the records of the log by row.
type Loaded = (Option<StoredRobot>, Vec<StoredEntries>, Vec<LogRecords>);

/// Another supervisor owns the fleet.
#[derive(Debug)]
pub(crate) struct LeaseLost;

impl Committer {
    pub(crate) fn new(lease: Lease, writer: Writer, program: Metrics, log: Option<LogSource>) -> Self {
        let fleet = lease.fleet().clone();
        let metrics = program.of_fleet(&fleet);
        Self { fleet, lease, writer, program, metrics, log }
    }

    /// The lease under which this supervisor writes.
    pub(crate) fn lease(&self) -> &Lease {
        &self.lease
    }

    /// The database, with the lease that each access needs.
    pub(crate) fn database(&mut self) -> (&mut Writer, &Lease) {
        (&mut self.writer, &self.lease)
    }

    /// Counts and logs a failed read or write that is not waited for.
    pub(crate) fn failed(&self, problem: &StoreError, what: &str) {
        self.program.database_failed();
        warn!(%problem, fleet = %self.fleet, "{what}, retrying");
    }

    /// Writes the rows of a transaction.
    pub(in crate::engine) async fn write(mut self, mut transaction: SealedTransaction) -> Written {
        let result = self.commit(&mut transaction.rows).await;
        Written { committer: self, transaction, result }
    }

    /// Writes the rows of a batch. Retries while the database is unreachable; meanwhile the inbox fills and then sheds.
    /// If the database rejects rows permanently, the batch is written without the rows of the robots concerned.
    async fn commit(&mut self, batch: &mut Batch) -> Result<Committed, LeaseLost> {
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

    /// Loads the robots whose rows were rejected, as of their last commit.
    async fn offenders(&mut self, outage: &mut Outage, refused: Vec<Refused>) -> Result<Vec<Offender>, LeaseLost> {
        let mut offenders = Vec::new();
        for Refused { owner, rejection } in refused {
            let (code, text) = (&rejection.code, &rejection.text);
            let Owner::Robot(robot_id) = owner else {
                error!(fleet = %self.fleet, code, text, "database rejects these rows for good, leaving them out");
                continue;
            };
            let (stored, journal, records) = loop {
                match self.load(robot_id).await {
                    Ok(loaded) => break loaded,
                    Err(problem) => self.wait_out(outage, problem, "cannot load a robot").await?,
                }
            };
            let name =
                stored.as_ref().map(|stored| FullName::robot(self.lease.fleet().as_str(), &stored.robot).to_string());
            error!(robot = name, code, text, "database rejects these rows of the robot for good, leaving them out");
            if rejection.is_of_setpoint_key() {
                let at = name.unwrap_or_else(|| self.fleet.to_string());
                self.metrics.violations.count(Invariant::SetpointNumberedOnce, &at, &rejection.text);
            }
            offenders.push(Offender { robot_id, rejection, stored, journal, records });
        }
        if let Some(log) = &self.log
            && !offenders.is_empty()
        {
            log.records_are_read().await;
        }
        Ok(offenders)
    }

    async fn load(&mut self, robot_id: i64) -> Result<Loaded, StoreError> {
        let stored = self.writer.robot(&self.lease, robot_id).await?;
        let mut after = stored.as_ref().map_or(i64::MAX, |stored| stored.journal_number);
        let (mut journal, mut all) = (Vec::new(), Vec::new());
        loop {
            let rows = self.writer.journal(&self.lease, after, journal::ROWS_AT_A_TIME).await?;
            let Some(last) = rows.last() else { return Ok((stored, journal, all)) };
            after = last.number;
            for row in rows {
                let own = StoredEntries::new(row).of_robot(robot_id);
                all.push(records_of(&own, self.log.as_ref(), &self.lease).await?);
                journal.push(own);
            }
        }
    }

    /// Reports a problem, and waits before the next attempt. A lost lease is an error.
    pub(crate) async fn wait_out(
        &mut self,
        outage: &mut Outage,
        problem: StoreError,
        so: &str,
    ) -> Result<(), LeaseLost> {
        if let StoreError::LeaseLost { cause, .. } = problem {
            if let LossCause::CommitsLost { commits } = cause {
                self.program.database_commits_lost.inc_by(commits);
            }
            warn!(%problem, "lease lost, writing stops");
            return Err(LeaseLost);
        }
        self.program.database_failed();
        error!(%problem, fleet = %self.fleet, "{so}, retrying");
        self.metrics.promises.failed(format!("{so}: {}", problem.message()));
        outage.since.get_or_insert_with(Instant::now);
        tokio::select! {
            () = outage.backoff.wait() => {}
            () = self.writer.new_leader() => {}
        }
        Ok(())
    }

    /// Ends an outage; returns true if there was one.
    pub(crate) fn end_of(&self, outage: &Outage) -> bool {
        let Some(since) = outage.since else { return false };
        info!(fleet = %self.fleet, seconds = since.elapsed().as_secs(), "database available again");
        self.metrics.promises.recorded();
        true
    }
}
