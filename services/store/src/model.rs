//! A database in memory that answers in place of SQL. The laboratory implements it, and runs supervisors in simulated time
//! on it.
//!
//! A [`Writer`](crate::Writer) on it has the same time limits, lost answers and changes of the leader as one on PostgreSQL.
//! Queries of the REST API, Kafka's publisher, archive and upkeep are in SQL only, and fail.

use std::collections::BTreeMap;
use std::fmt::Debug;
use std::io;

use futures_util::future::BoxFuture;
use sqlx::error::{DatabaseError, ErrorKind};
use tokio::sync::watch;
use tokio::time::timeout;
use vibrissa_core::robot::Robot;
use vibrissa_protocol::Name;

use crate::actions::{Action, FleetWork};
use crate::allowed::{AllowedReading, TurnedAwayReading};
use crate::batch::{JournalRow, Owners, Rows as BatchRows};
use crate::black_boxes::NewBlackBox;
use crate::calibrations::ActiveCalibration;
use crate::database::ACQUIRE_PATIENCE;
use crate::decommission::Registered;
use crate::policies::PolicyReading;
use crate::refusals::RefusalRow;
use crate::rollouts::{RobotError, RolloutRow};
use crate::webhooks::WebhookRow;
use crate::webhooks::queue::{Due, Holding, Job, Outcome, Queue};
use crate::{
    ClockReport, FleetsHeard, JournalReading, Lease, LeaseCounts, LogPositions, NumberedWhisker, Renewal, SignedIn,
    StoreError, StoredRobots, Supervisor, failed,
};

/// The way of a request or of an answer.
pub type Way<'a> = BoxFuture<'a, io::Result<()>>;

/// A supervisor's way to the data.
pub trait ModelServer: Send + Sync + Debug {
    /// Waits until a request has reached the server. It may fail, or never end.
    fn reach(&self) -> Way<'_>;

    /// Waits until the answer has come back. If it fails or never ends, the request has had its effect all the same.
    fn answer(&self) -> Way<'_>;

    /// Runs a request on the data; a server that has ended meanwhile does not run it.
    fn with(&self, work: &mut dyn FnMut(&mut dyn Model));

    /// Counts the changes of the leader among several servers.
    fn leader_changes(&self) -> watch::Receiver<u64>;
}

impl dyn ModelServer {
    /// Sends a request and waits for its answer.
    pub(crate) async fn ask<T>(
        &self,
        what: &'static str,
        work: impl FnOnce(&mut dyn Model) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        self.reach().await.map_err(sqlx::Error::Io).map_err(failed(what))?;
        self.answered(what, work).await
    }

    /// As [`Self::ask`], as with a pool of connections: only the way to the server has a time limit.
    pub(crate) async fn query<T>(
        &self,
        what: &'static str,
        work: impl FnOnce(&mut dyn Model) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let reached = timeout(ACQUIRE_PATIENCE, self.reach()).await.map_err(|_| sqlx::Error::PoolTimedOut);
        reached.and_then(|reached| reached.map_err(sqlx::Error::Io)).map_err(failed(what))?;
        self.answered(what, work).await
    }

    async fn answered<T>(
        &self,
        what: &'static str,
        work: impl FnOnce(&mut dyn Model) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let broken = |problem| failed(what)(sqlx::Error::Io(problem));
        let (mut work, mut done) = (Some(work), None);
        self.with(&mut |model| done = work.take().map(|work| work(model)));
        self.answer().await.map_err(broken)?;
        done.unwrap_or_else(|| Err(broken(io::ErrorKind::NotConnected.into())))
    }
}

/// A row that breaks a rule of its table, or has no room on the disk.
#[derive(Debug, Clone, thiserror::Error)]
#[error("{text}")]
pub struct Violation {
    /// Code of PostgreSQL for it (SQLSTATE).
    pub code: &'static str,
    /// The table and the rule, or the file.
    pub text: String,
}

impl DatabaseError for Violation {
    fn message(&self) -> &str {
        &self.text
    }

    fn code(&self) -> Option<std::borrow::Cow<'_, str>> {
        Some(self.code.into())
    }

    fn as_error(&self) -> &(dyn std::error::Error + Send + Sync + 'static) {
        self
    }

    fn as_error_mut(&mut self) -> &mut (dyn std::error::Error + Send + Sync + 'static) {
        self
    }

    fn into_error(self: Box<Self>) -> Box<dyn std::error::Error + Send + Sync + 'static> {
        self
    }

    fn kind(&self) -> ErrorKind {
        ErrorKind::Other
    }
}

impl From<Violation> for StoreError {
    fn from(violation: Violation) -> Self {
        failed("write rows")(sqlx::Error::Database(Box::new(violation)))
    }
}

/// The answer of a model to what is done in SQL only.
pub(crate) fn none<T>(_: &mut dyn Model) -> Result<T, StoreError> {
    Err(failed("ask a model for what is in SQL only")(sqlx::Error::PoolClosed))
}

/// Runs work as a transaction, or as a part of one that can be undone alone. An error undoes it.
pub(crate) fn atomically<T>(
    model: &mut dyn Model,
    work: impl FnOnce(&mut dyn Model) -> Result<T, StoreError>,
) -> Result<T, StoreError> {
    model.begin();
    let done = work(model);
    model.end(done.is_ok());
    done
}

/// The data, with PostgreSQL's meaning of each operation.
pub trait Model: Leases + Rows + Robots + Fleets + Webhooks + Debug + Send {
    /// Begins a transaction, or within one a part that can be undone alone.
    fn begin(&mut self);
    /// Ends what was begun last: keeps its changes, or undoes them.
    fn end(&mut self, is_kept: bool);
}

/// Members and leases. Their times are by the database's clock.
pub trait Leases {
    /// Registers a supervisor and renews its leases.
    fn sign_in(
        &mut self,
        supervisor: &Supervisor,
        held: &[Lease],
        hearing: &FleetsHeard,
        clock: ClockReport,
    ) -> SignedIn;
    /// Begins a new epoch, at least the highest known one plus a step (both in `at_least`), if the fleet's lease is the supervisor's or free. It is free if its row is `seen`;
    /// without one, if it has expired by the database's clock.
    fn acquire(
        &mut self,
        supervisor: &Supervisor,
        fleet: &Name,
        at_least: [u64; 2],
        seen: Option<Renewal>,
    ) -> Option<i64>;
    /// Frees a lease.
    fn release(&mut self, lease: &Lease);
    /// Removes a supervisor from the members.
    fn sign_out(&mut self, supervisor: &Supervisor);
    /// The lease's counters; `None` if it does not hold any more.
    fn counts(&self, lease: &Lease) -> Option<LeaseCounts>;
    /// Advances the number of transactions, and renews the lease. Returns false if the number was not the known one, or if
    /// fewer transactions assigned numbers than known.
    fn count_commit(&mut self, lease: &Lease, known: LeaseCounts) -> bool;
    /// Advances the number of transactions that assigned numbers, and returns it; `None` if it was below `least`, or if the
    /// lease does not hold any more.
    fn count_numbers(&mut self, lease: &Lease, least: i64) -> Option<i64>;
    /// Whether the fleet had an owner at this epoch or earlier.
    fn has_epoch_until(&self, fleet: &Name, epoch: u64) -> bool;
}

/// The rows of batches.
pub trait Rows {
    /// Writes rows.
    ///
    /// # Errors
    /// A row breaks a rule of its table.
    fn write(&mut self, lease: &Lease, rows: &BatchRows<'_>) -> Result<(), Violation>;
    /// Writes a row of the journal, or appends its entries to the row of this number.
    ///
    /// # Errors
    /// The row exists and nothing shall be appended.
    fn write_journal(&mut self, lease: &Lease, row: &JournalRow, appends: bool) -> Result<(), Violation>;
    /// Deletes the journal's rows up to a number.
    fn forget_journal(&mut self, lease: &Lease, last: i64);
    /// At most `most` rows of the fleet's journal after a number.
    fn journal(&self, lease: &Lease, after: i64, most: i64) -> Vec<JournalReading>;
    /// Sets positions in the log.
    fn set_log_positions(&mut self, lease: &Lease, positions: &LogPositions);
    /// Positions of the fleet in a topic, by partition.
    fn log_positions(&self, lease: &Lease, topic: &str) -> BTreeMap<u32, i64>;
    /// The robots of whiskers, actions and setpoints.
    fn owners(&self, whiskers: &[i64], actions: &[i64], commands: &[String]) -> Owners;
}

/// Robots with their whiskers, boots and black boxes.
pub trait Robots {
    /// At most `most` robots of the fleet with numbers above `after`.
    fn robots(&self, lease: &Lease, after: i64, most: i64) -> StoredRobots;
    /// Registers a robot; `None` if it was decommissioned in this boot.
    fn register(&mut self, lease: &Lease, robot: &str, boot_id: &str) -> Option<Registered>;
    /// Number of a robot's boot.
    ///
    /// # Errors
    /// There is no such robot.
    fn boot(&mut self, robot_id: i64, boot_id: &str) -> Result<i64, Violation>;
    /// Numbers of a robot's whiskers.
    ///
    /// # Errors
    /// There is no such robot.
    fn whisker_ids(&mut self, robot_id: i64, robot: &Robot) -> Result<Vec<NumberedWhisker>, Violation>;
    /// Whether the fleet has or had a robot.
    fn has_robots(&self, fleet: &Name) -> bool;
    /// Numbers of the fleet's robots with a standing alarm of this kind about them.
    fn robots_with_alarm(&self, lease: &Lease, kind: &str) -> Vec<i64>;
    /// The mean error of each robot over the decisions since a time.
    fn errors_since(&self, lease: &Lease, since_us: i64) -> Vec<RobotError>;
    /// Adds to the counts of refused messages.
    ///
    /// # Errors
    /// There is no such robot.
    fn add_refusals(&mut self, lease: &Lease, rows: &[RefusalRow]) -> Result<(), Violation>;
    /// Writes or replaces a black box.
    ///
    /// # Errors
    /// There is no such robot or whisker.
    fn write_black_box(&mut self, lease: &Lease, one: &NewBlackBox) -> Result<(), Violation>;
    /// Marks unfinished black boxes as partial.
    fn end_black_boxes(&mut self, lease: &Lease);
}

/// What operators set for fleets, and request.
pub trait Fleets {
    /// The newest policy of the fleet.
    fn policy(&self, lease: &Lease) -> Option<PolicyReading>;
    /// The calibrations that are active in the fleet.
    fn calibrations(&self, lease: &Lease) -> Vec<ActiveCalibration>;
    /// The newest list of allowed robots, if it is newer than version `after`.
    fn allowed_robots(&self, lease: &Lease, after: i64) -> Option<AllowedReading>;
    /// Replaces the fleet's robots that were turned away.
    fn write_turned_away(&mut self, lease: &Lease, rows: &[TurnedAwayReading]);
    /// Time of receipt before which no contact may be written, µs since 1970 UTC; 0 without an archive.
    fn archive_floor(&self, fleet: &Name) -> i64;
    /// Raises this time.
    fn state_horizon(&mut self, lease: &Lease, written_to_us: i64);
    /// The roll-out of the fleet that has not ended.
    fn open_rollout(&self, lease: &Lease) -> Option<RolloutRow>;
    /// At most `most` pending actions of the fleet, without those of some robots.
    fn pending(&self, lease: &Lease, most: i64, without: &[Name]) -> Vec<Action>;
    /// The fleets with pending actions, or a list of allowed robots.
    fn fleets_with_work(&self) -> Vec<FleetWork>;
    /// The action of this number.
    fn action(&self, action_id: i64) -> Option<Action>;
}

/// Webhooks, with their positions in the log of events.
pub trait Webhooks {
    /// The targets with something to do now.
    fn due(&self) -> Vec<Due>;
    /// Takes hold of a target, and returns its next event; `None`, and no hold, if there is nothing to do or another supervisor
    /// holds it.
    fn take_job(&mut self, webhook_id: i64, holding: &Holding<'_>) -> Option<Job>;
    /// Stores the result of an attempt. Returns false, and stores nothing, if another supervisor holds the target now.
    fn finish_job(&mut self, job: &Job, holder: &str, outcome: &Outcome) -> bool;
    /// Lets go of all targets of a supervisor.
    fn release_holds(&mut self, holder: &str);
    /// All targets, in the order of their names.
    fn webhooks(&self) -> Vec<WebhookRow>;
    /// The queues of targets, in their order.
    fn queues(&self, webhooks: &[WebhookRow]) -> Vec<Queue>;
}
