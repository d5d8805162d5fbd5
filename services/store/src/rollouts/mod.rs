//! Staged roll-outs: their state, which the fleet's owner writes, and the errors that they compare.

mod write;

pub(super) use write::write;

use serde::Serialize;
use tokio::time::Duration;
use utoipa::ToSchema;

use super::database::on;
use super::from_row::from_row;
use super::set_aside::Tried;
use super::time::Time;
use super::{Lease, Model, Store, StoreError, Writer, failed};

/// Time limit for a query of an engine.
const PATIENCE: Duration = Duration::from_secs(5);
/// Most events that [`Store::rollout_events`] returns.
pub const EVENTS_MAX: i64 = 200;
/// The error of a decision without a compensator, as a ratio: no better than doing nothing.
const UNSERVED: &str = "1.0";

/// The state of a roll-out; docs/schema.md documents the columns.
#[derive(Debug, Clone, PartialEq)]
pub struct RolloutRow {
    /// Number of the action that began it.
    pub rollout_id: i64,
    /// Name of the fleet.
    pub fleet: String,
    /// `POLICY` or `CALIBRATION`.
    pub kind: String,
    /// The change, as JSON.
    pub change: String,
    /// `RUNNING`, `PAUSED`, `ROLLED_BACK` or `COMPLETED`.
    pub state: String,
    /// `FEW`, `QUARTER` or `ALL`.
    pub stage: String,
    /// Greatest place of a robot that is changed.
    pub place_max: i64,
    /// Probability that a change without an effect is rolled back, at most.
    pub level: f64,
    /// Number of changed robots with a measured error that complete a stage.
    pub robots: i64,
    /// Comparisons in this stage so far.
    pub looks: i64,
    /// Result of the newest comparison.
    pub compared: Compared,
    /// Time at which it began, µs since 1970 UTC by the supervisor's clock.
    pub started_us: i64,
    /// Time at which its stage began, µs since 1970 UTC by the supervisor's clock.
    pub stage_us: i64,
    /// Time of the newest change, µs since 1970 UTC by the supervisor's clock.
    pub updated_us: i64,
    /// Person or token that began it.
    pub started_by: String,
    /// Reason that the person gave.
    pub reason: Option<String>,
}

/// Result of a comparison of changed and unchanged robots.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Compared {
    /// Probability that chance alone makes the changed robots look so much worse; `None` before the first comparison.
    pub probability: Option<f64>,
    /// Changed robots with an error in this stage.
    pub changed_robots: i64,
    /// Unchanged robots with an error in this stage.
    pub unchanged_robots: i64,
    /// Median error of the changed robots, as a ratio.
    pub changed_error: Option<f64>,
    /// Median error of the unchanged robots, as a ratio.
    pub unchanged_error: Option<f64>,
}

/// An event of a roll-out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RolloutEvent {
    /// Kind of event, such as `ADVANCED`.
    pub event: String,
    /// Person or token, or `supervisor`.
    pub actor: String,
    /// Why, in words.
    pub detail: String,
}

/// A new state of a roll-out, with its event.
#[derive(Debug, Clone, PartialEq)]
pub struct RolloutChange {
    /// State of the roll-out.
    pub row: RolloutRow,
    /// The event that led to it; `None` for new numbers alone.
    pub event: Option<RolloutEvent>,
}

from_row! {
    /// A roll-out as it is stored.
    #[derive(Debug, Clone, PartialEq)]
    struct Stored {
        rollout_id: i64,
        fleet: String,
        kind: String,
        change: String,
        state: String,
        stage: String,
        place_max: i64,
        level: f64,
        robots: i64,
        looks: i64,
        probability: Option<f64>,
        changed_robots: i64,
        unchanged_robots: i64,
        changed_error: Option<f64>,
        unchanged_error: Option<f64>,
        started_us: i64,
        stage_us: i64,
        updated_us: i64,
        started_by: String,
        reason: Option<String>,
    }

    /// Mean error of a robot's decisions.
    #[derive(Debug, Clone, PartialEq)]
    pub struct RobotError {
        /// Name of the robot.
        pub robot: String,
        /// Mean of the newest measured errors of its compensations, as a ratio.
        pub error: f64,
    }

    /// An event of a roll-out.
    #[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
    pub struct RolloutEventReading {
        /// Time of the event, by the supervisor's clock.
        pub at: Time,
        /// Kind of event: `STARTED`, `LOOKED`, `ADVANCED`, `PAUSED`, `RESUMED`, `ROLLED_BACK` or `COMPLETED`.
        pub event: String,
        /// Stage after the event: `FEW`, `QUARTER` or `ALL`.
        pub stage: String,
        /// Person or token, or `supervisor` if the event followed from the errors.
        pub actor: String,
        /// Why, in words.
        pub detail: String,
    }
}

impl From<Stored> for RolloutRow {
    fn from(row: Stored) -> Self {
        Self {
            rollout_id: row.rollout_id,
            fleet: row.fleet,
            kind: row.kind,
            change: row.change,
            state: row.state,
            stage: row.stage,
            place_max: row.place_max,
            level: row.level,
            robots: row.robots,
            looks: row.looks,
            compared: Compared {
                probability: row.probability,
                changed_robots: row.changed_robots,
                unchanged_robots: row.unchanged_robots,
                changed_error: row.changed_error,
                unchanged_error: row.unchanged_error,
            },
            started_us: row.started_us,
            stage_us: row.stage_us,
            updated_us: row.updated_us,
            started_by: row.started_by,
            reason: row.reason,
        }
    }
}

/// The roll-out of a fleet that is running or paused.
const OPEN: &str = "SELECT rollout_id, fleet, kind, change, state, stage, place_max, level, robots, looks, probability, \
     changed_robots, unchanged_robots, changed_error, unchanged_error, started_us, stage_us, updated_us, started_by, \
     reason FROM rollouts WHERE fleet = $1 AND state IN ('RUNNING', 'PAUSED')";

impl Writer {
    /// The roll-out of the lease's fleet that is running or paused; `None` without one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn open_rollout(&mut self, lease: &Lease) -> Result<Option<RolloutRow>, StoreError> {
        const WHAT: &str = "read the roll-out";
        let fleet = lease.fleet().as_str();
        let model = |model: &mut dyn Model| Ok(model.open_rollout(lease).map(Tried::Read));
        let stored: Option<Tried<RolloutRow>> = self
            .attempt(WHAT, PATIENCE, model, async |link| {
                let stored: Option<Tried<Stored>> =
                    on!(link, |link| sqlx::query_as(OPEN).bind(fleet).fetch_optional(link).await)
                        .map_err(failed(WHAT))?;
                Ok(stored.map(|row| row.map(Into::into)))
            })
            .await?;
        Ok(stored.and_then(|row| self.set_aside.read("rollouts", row)))
    }

    /// The mean error of each robot of the lease's fleet over the decisions since a time: the newest measured error of each
    /// compensation, and 100 % for each decision that found no compensator. Robots without any are left out.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn errors_since(&mut self, lease: &Lease, since_us: i64) -> Result<Vec<RobotError>, StoreError> {
        const WHAT: &str = "read the errors of a roll-out";
        let sql = format!(
            "SELECT robot, avg(error) AS error FROM (SELECT r.robot, \
             CASE WHEN c.compensator_whisker_id IS NULL THEN {UNSERVED} ELSE (SELECT e.error FROM compensation_errors e \
              WHERE e.compensation_id = c.compensation_id ORDER BY e.compensation_error_id DESC LIMIT 1) END AS error \
             FROM compensations c JOIN robots r ON r.robot_id = c.robot_id \
             WHERE c.decided_us >= $1 AND r.fleet = $2) m WHERE error IS NOT NULL GROUP BY robot ORDER BY robot"
        );
        let fleet = lease.fleet().as_str();
        self.attempt(
            WHAT,
            PATIENCE,
            |model| Ok(model.errors_since(lease, since_us)),
            async |link| {
                on!(link, |link| sqlx::query_as(sqlx::AssertSqlSafe(sql))
                    .bind(since_us)
                    .bind(fleet)
                    .fetch_all(link)
                    .await)
                .map_err(failed(WHAT))
            },
        )
        .await
    }
}

impl Store {
    /// The roll-out of a fleet that is running or paused; `None` without one, or if its row is set aside.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn open_rollout(&self, fleet: &str) -> Result<Option<RolloutRow>, StoreError> {
        let stored: Option<Tried<Stored>> =
            on!(&self.pool, |pool| sqlx::query_as(OPEN).bind(fleet).fetch_optional(pool).await)
                .map_err(failed("read the roll-out"))?;
        Ok(stored.and_then(|row| self.set_aside.read("rollouts", row.map(Into::into))))
    }

    /// The events of a roll-out, the newest first.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn rollout_events(&self, rollout_id: i64) -> Result<Vec<RolloutEventReading>, StoreError> {
        let sql = format!(
            "SELECT recorded_us AS at, event, stage, actor, detail FROM rollout_events WHERE rollout_id = $1 \
             ORDER BY rollout_event_id DESC LIMIT {EVENTS_MAX}"
        );
        on!(&self.pool, |pool| sqlx::query_as(sqlx::AssertSqlSafe(sql)).bind(rollout_id).fetch_all(pool).await)
            .map_err(failed("read the events of a roll-out"))
    }
}
