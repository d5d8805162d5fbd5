//! Acknowledging and shelving of alarms, each with its entry in the audit log in one transaction.

use super::actions::{Asked, NewAction, record_done};
use super::database::{Tx, on};
use super::events::write::EventRow;
use super::from_row::from_row;
use super::{Lease, Store, StoreError, Writer, events, failed};
use vibrissa_edge::events::EventKind;

const WHAT: &str = "update an alarm";
/// Time limit for one attempt to read alarms.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(10);

impl Writer {
    /// The robots of a fleet with a standing alarm of this kind about the robot as a whole, by their numbers.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn robots_with_alarm(&mut self, lease: &Lease, kind: &str) -> Result<Vec<i64>, StoreError> {
        const WHAT: &str = "read the standing alarms";
        const SQL: &str = "SELECT a.robot_id FROM alarms a JOIN robots r ON r.robot_id = a.robot_id \
             WHERE a.kind = $2 AND a.cleared_us IS NULL AND fleet = $1";
        self.attempt(
            WHAT,
            PATIENCE,
            |model| Ok(model.robots_with_alarm(lease, kind)),
            async |link| {
                on!(link, |link| sqlx::query_scalar(SQL).bind(lease.fleet().as_str()).bind(kind).fetch_all(link).await)
                    .map_err(failed(WHAT))
            },
        )
        .await
    }
}

from_row! {
    /// The whisker or robot and the kind of an alarm, and what operators have done about it.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct AlarmSubject {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array; `None` for an alarm about the robot as a whole.
        pub array: Option<String>,
        /// Number of the whisker in its array; `None` for an alarm about the robot as a whole.
        pub whisker: Option<i64>,
        /// Number of the whisker in the database; `None` for an alarm about the robot as a whole.
        pub whisker_id: Option<i64>,
        /// Number of the robot in the database; `None` for an alarm about a whisker.
        pub robot_id: Option<i64>,
        /// Kind of alarm, such as `UNCOMPENSATED`.
        pub kind: String,
        /// Person or token that acknowledged it; `None` if it was not acknowledged.
        pub acknowledged_by: Option<String>,
        /// Time until which alarms of this kind about this whisker or robot are shelved, µs since 1970 UTC. It may be in the
        /// past.
        pub shelved_until_us: Option<i64>,
    }
}

/// An operator's decision about an alarm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Said {
    /// Acknowledges the alarm.
    Acknowledged,
    /// Shelves the alarm, and all alarms of its kind about its whisker or robot, for a while.
    Shelved {
        /// End of the shelving, µs since 1970 UTC by the supervisor's clock.
        until_us: i64,
    },
    /// Ends the shelving.
    Unshelved,
}

impl Store {
    /// Whisker or robot and kind of the alarm of this number; `None` if there is no such alarm.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn alarm_subject(&self, alarm_id: i64) -> Result<Option<AlarmSubject>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT fleet, robot, \"array\", w.whisker, l.whisker_id, l.robot_id, l.kind, acknowledged_by, \
             (SELECT until_us FROM alarm_shelves s WHERE (s.whisker_id = l.whisker_id OR s.robot_id = l.robot_id) \
              AND s.kind = l.kind ORDER BY alarm_shelf_id DESC LIMIT 1) AS shelved_until_us \
             FROM alarms l LEFT JOIN whiskers w ON w.whisker_id = l.whisker_id \
             LEFT JOIN arrays y ON y.array_id = w.array_id \
             JOIN robots r ON r.robot_id = coalesce(l.robot_id, w.robot_id) WHERE alarm_id = $1",
        )
        .bind(alarm_id)
        .fetch_optional(pool)
        .await)
        .map_err(failed("read an alarm"))
    }

    /// Acknowledges, shelves or unshelves an alarm at most once, and records the action in the audit log. `None` if there was
    /// nothing to change: somebody has acknowledged the alarm already, or no person has shelved it.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn say_to_alarm(
        &self,
        subject: &AlarmSubject,
        said: Said,
        action: &NewAction,
    ) -> Result<Option<Asked>, StoreError> {
        let now_us = action.asked_us;
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, now_us).await?;
        if let Asked::New(_) = asked {
            if write(&mut tx, subject, said, action).await.map_err(failed(WHAT))? == 0 {
                return Ok(None);
            }
            let event = EventRow {
                whisker_id: subject.whisker_id,
                robot_id: subject.robot_id,
                ..EventRow::new(EventKind::AlarmHandled, now_us)
            };
            events::write::write(&mut tx, &subject.fleet, &[event]).await.map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Some(asked))
    }
}

/// Returns the number of changed rows.
async fn write(tx: &mut Tx<'_>, subject: &AlarmSubject, said: Said, action: &NewAction) -> sqlx::Result<u64> {
    match said {
        Said::Acknowledged => on!(tx, |tx| sqlx::query(
            "UPDATE alarms SET acknowledged_us = $1, acknowledged_by = $2, acknowledged_reason = $3 \
             WHERE alarm_id = $4 AND acknowledged_us IS NULL",
        )
        .bind(action.asked_us)
        .bind(&action.actor)
        .bind(&action.reason)
        .bind(action.alarm_id)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected())),
        Said::Shelved { until_us } => on!(tx, |tx| sqlx::query(
            "INSERT INTO alarm_shelves (whisker_id, robot_id, kind, shelved_us, until_us, shelved_by, reason) \
             VALUES ($1, $2, $3, $4, $5, $6, $7)",
        )
        .bind(subject.whisker_id)
        .bind(subject.robot_id)
        .bind(&subject.kind)
        .bind(action.asked_us)
        .bind(until_us)
        .bind(&action.actor)
        .bind(action.reason.as_deref().unwrap_or_default())
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected())),
        Said::Unshelved => on!(tx, |tx| sqlx::query(
            "UPDATE alarm_shelves SET until_us = $1 WHERE (whisker_id = $2 OR robot_id = $3) AND kind = $4 \
             AND until_us > $1",
        )
        .bind(action.asked_us)
        .bind(subject.whisker_id)
        .bind(subject.robot_id)
        .bind(&subject.kind)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected())),
    }
}
