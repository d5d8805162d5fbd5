//! Robots that leave for good, and come back.

use std::time::Duration;

use vibrissa_core::robot::Numbers;

use super::database::{Link, Tx, on};
use super::events::write::{Whose, clear_alarms};
use super::load::{next_number, numbering};
use super::{Lease, Model, StoreError, Writer, failed};

/// Time limit of one statement.
const PATIENCE: Duration = Duration::from_secs(5);

/// A robot that has sent its first factsheet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Registered {
    /// Number of the robot in the database.
    pub robot_id: i64,
    /// Next free numbers of its trims and compensations: it may have been here before.
    pub numbers: Numbers,
}

/// Statements that end all work for a decommissioned robot. `$1` is the robot's number, `$2` the time.
const LEAVE: [&str; 6] = [
    "UPDATE robots SET decommissioned_us = $2, state = NULL, held = FALSE, labels = '', connection = 'OFFLINE', updated_us = $2 \
     WHERE robot_id = $1",
    "UPDATE whiskers SET position = NULL, state = NULL, held = FALSE, rollup = NULL WHERE robot_id = $1 AND CAST($2 AS BIGINT) > 0",
    "UPDATE arrays SET whiskers = 0 WHERE robot_id = $1 AND CAST($2 AS BIGINT) > 0",
    "UPDATE touch_tests SET state = 'ABANDONED', updated_us = $2, ended_us = $2 WHERE ended_us IS NULL AND robot_id = $1",
    "UPDATE compensations SET ended_us = $2, end_reason = 'LAYOUT_CHANGED' WHERE ended_us IS NULL AND robot_id = $1",
    "UPDATE setpoints SET state = 'ABANDONED' WHERE state IN ('PENDING', 'RECEIVED', 'APPLYING') AND robot_id = $1 AND CAST($2 AS BIGINT) > 0",
];

/// Takes a robot out of all lists, and ends everything that is under way for it. Its history stays.
pub(crate) async fn write(tx: &mut Tx<'_>, robot_id: i64, left_us: i64) -> sqlx::Result<()> {
    clear_alarms(tx, Whose::Robot(robot_id), left_us).await?;
    for sql in LEAVE {
        on!(&mut *tx, |tx| sqlx::query(sql).bind(robot_id).bind(left_us).execute(&mut **tx).await.map(drop))?;
    }
    Ok(())
}

impl Writer {
    /// Registers a robot at its first factsheet, or puts a decommissioned one back into service. `None` if the robot was
    /// decommissioned in this boot: a retained message, or a robot that nobody has started again, must not bring it back.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn register(
        &mut self,
        lease: &Lease,
        (robot, boot_id): (&str, &str),
        now_us: i64,
    ) -> Result<Option<Registered>, StoreError> {
        const WHAT: &str = "assign a number to a robot";
        const FORMER: &str = "SELECT count(*) FROM robots JOIN boots USING (robot_id) \
             WHERE fleet = $1 AND robot = $2 AND decommissioned_us IS NOT NULL AND boots.boot_id = $3";
        // Sets the time, too, so that the robot is not deleted as merely announced before its first boot is inserted.
        const SQL: &str = "INSERT INTO robots (fleet, robot, updated_us) VALUES ($1, $2, $3) \
             ON CONFLICT (fleet, robot) DO UPDATE SET updated_us = excluded.updated_us, decommissioned_us = NULL \
             RETURNING robot_id";
        const LAST: &str = "SELECT (SELECT max(trim_id) FROM trims WHERE robot_id = $1), \
             (SELECT max(compensation_id) FROM compensations WHERE robot_id = $1)";
        let fleet = lease.fleet().as_str();
        let model =
            |model: &mut dyn Model| lease.numbering_in(model, |model| Ok(model.register(lease, robot, boot_id)));
        let work = async |link: &mut Link| {
            let (mut tx, numbers) = numbering(link, lease, WHAT).await?;
            let former: i64 = on!(&mut tx, |tx| sqlx::query_scalar(FORMER)
                .bind(fleet)
                .bind(robot)
                .bind(boot_id)
                .fetch_one(&mut **tx)
                .await)
            .map_err(failed(WHAT))?;
            if former > 0 {
                // Not left open: it would hold the lease's row, and block the fleet's commits.
                tx.commit().await.map_err(failed(WHAT))?;
                return Ok((None, numbers));
            }
            let robot_id: i64 = on!(&mut tx, |tx| sqlx::query_scalar(SQL)
                .bind(fleet)
                .bind(robot)
                .bind(now_us)
                .fetch_one(&mut **tx)
                .await)
            .map_err(failed(WHAT))?;
            let (trim, compensation): (Option<i64>, Option<i64>) =
                on!(&mut tx, |tx| sqlx::query_as(LAST).bind(robot_id).fetch_one(&mut **tx).await)
                    .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))?;
            let next = Numbers { next_trim: next_number(trim), next_compensation: next_number(compensation) };
            Ok((Some(Registered { robot_id, numbers: next }), numbers))
        };
        let (registered, numbers) = self.attempt(WHAT, PATIENCE, model, work).await?;
        lease.numbered(numbers);
        Ok(registered)
    }
}
