//! Writes the rows of a batch with one statement for each kind of row, or for each of the rarer rows. SQLite writes all
//! rows in this way, PostgreSQL those of batches that `postgres/whole.rs` cannot write as a single statement.

use tracing::warn;
use vibrissa_edge::clock::wall_clock;

use super::batch::{DecisionRow, ErrorRow, LayoutRow, Record, RollupRow, Rows, SetpointRow, SetpointStateRow};
use super::database::{Tx, on};
use super::events::write::{Whose, clear_alarms};
use super::tables::{
    ALARMS, ANSWERED, BINS, CANDIDATES, CLEARED, DECISIONS, ENDED, ERRORS, HEALTH, POLICIES, REFINEMENTS, RESPONSES,
    ROBOT_ALARMS, ROBOT_CLEARED, ROBOTS, SETPOINTS, STATES, TOUCH_TEST_PROGRESS, TOUCH_TESTS, TRIMS, WHISKERS,
};
use super::{StoreError, actions, calibrations, decommission, failed, quarantine, rollouts, tables};
use crate::Resolution;

/// Writes the rows of all tables except contacts and the journal.
pub(super) async fn write(tx: &mut Tx<'_>, fleet: &str, rows: &Rows<'_>) -> Result<(), StoreError> {
    for layout in rows.layouts {
        write_layout(tx, layout).await.map_err(failed("write a layout"))?;
    }
    ROBOTS.write(tx, rows.robots).await.map_err(failed("write robots"))?;
    WHISKERS.write(tx, rows.whiskers).await.map_err(failed("write whiskers"))?;
    for layout in rows.layouts {
        count_whiskers(tx, layout.robot_id).await.map_err(failed("count the whiskers of a layout"))?;
        note_absence(tx, layout.robot_id).await.map_err(failed("note the whiskers that are gone"))?;
    }
    write_rollups(tx, rows.rollups).await.map_err(failed("write aggregates of minutes and hours"))?;
    for record in rows.records {
        write_record(tx, fleet, record).await?;
    }
    RESPONSES.write(tx, rows.responses).await.map_err(failed("append responses")).map(drop)
}

async fn write_rollups(tx: &mut Tx<'_>, rollups: &[RollupRow]) -> sqlx::Result<()> {
    for resolution in Resolution::ALL {
        let rows: Vec<&RollupRow> = rollups.iter().filter(|row| row.resolution == resolution).collect();
        let written = tables::rollups(resolution).write(tx, &rows).await?;
        tell_of_rollups(resolution, rows.len(), written);
    }
    Ok(())
}

/// Warns if aggregates existed already. No span is closed twice, but an operator may have restored a single table;
/// that must not stop the fleet.
pub(super) fn tell_of_rollups(resolution: Resolution, rows: usize, written: u64) {
    if written < rows as u64 {
        warn!(?resolution, rows, written, "skipped aggregates of minutes or hours that exist already");
    }
}

/// Takes all whiskers off a robot; the batch's whisker rows put the present ones back.
async fn write_layout(tx: &mut Tx<'_>, layout: &LayoutRow) -> sqlx::Result<()> {
    on!(&mut *tx, |tx| sqlx::query("UPDATE robots SET model = $1 WHERE robot_id = $2")
        .bind(&layout.model)
        .bind(layout.robot_id)
        .execute(&mut **tx)
        .await
        .map(drop))?;
    on!(&mut *tx, |tx| sqlx::query(
        "UPDATE whiskers SET position = NULL, state = NULL, held = FALSE WHERE robot_id = $1"
    )
    .bind(layout.robot_id)
    .execute(&mut **tx)
    .await
    .map(drop))?;
    for (whisker_id, rollup) in &layout.gone {
        on!(&mut *tx, |tx| sqlx::query("UPDATE whiskers SET rollup = $1 WHERE whisker_id = $2")
            .bind(rollup.as_slice())
            .bind(whisker_id)
            .execute(&mut **tx)
            .await
            .map(drop))?;
    }
    Ok(())
}

/// Counts the whiskers that are on each array of a robot now.
async fn count_whiskers(tx: &mut Tx<'_>, robot_id: i64) -> sqlx::Result<()> {
    on!(&mut *tx, |tx| {
        sqlx::query(
        "UPDATE arrays SET whiskers = (SELECT count(*) FROM whiskers w WHERE w.array_id = arrays.array_id AND position IS NOT NULL) \
         WHERE robot_id = $1"
    )
    .bind(robot_id)
    .execute(&mut **tx)
    .await
    .map(drop)
    })
}

/// Notes the time for whiskers that are on the robot no more.
async fn note_absence(tx: &mut Tx<'_>, robot_id: i64) -> sqlx::Result<()> {
    const SQL: &str =
        "UPDATE whiskers SET absent_us = $2 WHERE robot_id = $1 AND position IS NULL AND absent_us IS NULL";
    let now_us = wall_clock().0 as i64;
    on!(tx, |tx| sqlx::query(SQL).bind(robot_id).bind(now_us).execute(&mut **tx).await.map(drop))
}

/// Writes one of the rarer rows.
async fn write_record(tx: &mut Tx<'_>, fleet: &str, record: &Record) -> Result<(), StoreError> {
    let (written, what) = match record {
        Record::Health(row) => (HEALTH.write(tx, &[row]).await.map(drop), "write a change of health"),
        Record::Trim(row) => (TRIMS.write(tx, &[row]).await.map(drop), "write a trim"),
        Record::Decision(row) => (write_decision(tx, row).await, "write a decision"),
        Record::Approved { compensation_id } => (write_approved(tx, *compensation_id).await, "approve a compensation"),
        Record::Ended(row) => (ENDED.write(tx, &[row]).await.map(drop), "end a compensation"),
        Record::Setpoint(row) => (write_setpoint(tx, row).await, "write a setpoint"),
        Record::SetpointState(row) => (write_setpoint_state(tx, row).await, "write a state of a setpoint"),
        Record::Error(row) => (write_error(tx, row).await, "write a compensation error"),
        Record::Refinement(row) => {
            (REFINEMENTS.write(tx, &[&**row]).await.map(drop), "write an evaluation of a setpoint")
        }
        Record::Alarm(row) => (ALARMS.write(tx, &[row]).await.map(drop), "write an alarm"),
        Record::AlarmCleared(row) => (CLEARED.write(tx, &[row]).await.map(drop), "clear an alarm"),
        Record::RobotAlarm(row) => (ROBOT_ALARMS.write(tx, &[row]).await.map(drop), "write an alarm about a robot"),
        Record::RobotAlarmCleared(row) => {
            (ROBOT_CLEARED.write(tx, &[row]).await.map(drop), "clear an alarm about a robot")
        }
        Record::Gone { robot_id, array, whisker, cleared_us } => {
            let whose = Whose::Whisker { robot_id: *robot_id, array, whisker: *whisker };
            (clear_alarms(tx, whose, *cleared_us).await, "clear the alarms of a whisker")
        }
        Record::AlarmsForgotten { robot_id, cleared_us } => {
            (write_forgotten(tx, *robot_id, *cleared_us).await, "clear the alarms of a robot")
        }
        Record::Decommissioned { robot_id, left_us } => {
            (decommission::write(tx, *robot_id, *left_us).await, "decommission a robot")
        }
        Record::Answer { action_id, state, problem, done_us, .. } => {
            let answer = (*action_id, *state, problem.as_deref());
            (actions::write_answer(tx, answer, *done_us).await, "answer an action")
        }
        Record::Activation(row) => (calibrations::write_activation(tx, row).await, "activate a calibration"),
        Record::Policy(row) => (POLICIES.write(tx, &[&**row]).await.map(drop), "write a policy"),
        Record::Quarantined(row) => (quarantine::write(tx, fleet, row).await, "put a message into quarantine"),
        Record::TouchTest(row) => (TOUCH_TESTS.write(tx, &[&**row]).await.map(drop), "write a touch test"),
        Record::TouchTestProgress(row) => {
            (TOUCH_TEST_PROGRESS.write(tx, &[&**row]).await.map(drop), "write the progress of a touch test")
        }
        Record::TestOfAction { action_id, test_id, .. } => {
            (actions::write_test(tx, *action_id, test_id).await, "write the touch test of an action")
        }
        Record::Rollout(change) => (rollouts::write(tx, change).await, "write a roll-out"),
    };
    written.map_err(failed(what))
}

async fn write_decision(tx: &mut Tx<'_>, row: &DecisionRow) -> sqlx::Result<()> {
    DECISIONS.write(tx, &[row]).await?;
    CANDIDATES.write(tx, &row.rows().collect::<Vec<_>>()).await.map(drop)
}

async fn write_setpoint(tx: &mut Tx<'_>, row: &SetpointRow) -> sqlx::Result<()> {
    SETPOINTS.write(tx, &[row]).await?;
    STATES.write(tx, &[row.first_state()]).await.map(drop)
}

async fn write_setpoint_state(tx: &mut Tx<'_>, row: &SetpointStateRow) -> sqlx::Result<()> {
    ANSWERED.write(tx, &[row]).await?;
    STATES.write(tx, &[row]).await.map(drop)
}

async fn write_error(tx: &mut Tx<'_>, row: &ErrorRow) -> sqlx::Result<()> {
    ERRORS.write(tx, &[row]).await?;
    BINS.write(tx, &row.rows().collect::<Vec<_>>()).await.map(drop)
}

async fn write_approved(tx: &mut Tx<'_>, compensation_id: i64) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE compensations SET approval = 'APPROVED' WHERE compensation_id = $1";
    on!(tx, |tx| sqlx::query(SQL).bind(compensation_id).execute(&mut **tx).await.map(drop))
}

/// Clears all alarms of a robot and its whiskers, and ends its touch tests: nobody follows them any more.
async fn write_forgotten(tx: &mut Tx<'_>, robot_id: i64, cleared_us: i64) -> sqlx::Result<()> {
    const TESTS: &str = "UPDATE touch_tests SET state = 'ABANDONED', updated_us = $1, ended_us = $1 \
         WHERE ended_us IS NULL AND robot_id = $2";
    clear_alarms(tx, Whose::Robot(robot_id), cleared_us).await?;
    on!(tx, |tx| sqlx::query(TESTS).bind(cleared_us).bind(robot_id).execute(&mut **tx).await.map(drop))
}
