//! Writes the rarer rows of a batch, with one or more statements for each row. SQLite writes all such rows in this
//! way, PostgreSQL only those of batches that `postgres/whole.rs` cannot write as a single statement.

use sqlx::QueryBuilder;

use super::batch::{DecisionRow, ErrorRow, LayoutRow, Record, RefinementRow, SetpointRow, SetpointStateRow};
use super::database::{Tx, on};
use super::{StoreError, actions, calibrations, failed, policies, quarantine};

/// Takes all whiskers off a robot; the batch's whisker rows put the present ones back.
pub(super) async fn write_layout(tx: &mut Tx<'_>, layout: &LayoutRow) -> sqlx::Result<()> {
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

/// Writes one of the rarer rows.
pub(super) async fn write_record(tx: &mut Tx<'_>, fleet: &str, record: &Record) -> Result<(), StoreError> {
    match record {
        Record::Decision(decision) => write_decision(tx, decision).await.map_err(failed("write a decision")),
        Record::Setpoint(setpoint) => write_setpoint(tx, setpoint).await.map_err(failed("write a setpoint")),
        Record::Error(error) => write_error(tx, error).await.map_err(failed("write a compensation error")),
        Record::Refinement(look) => {
            write_refinement(tx, look).await.map_err(failed("write an evaluation of a setpoint"))
        }
        Record::SetpointState(row) => {
            write_setpoint_state(tx, row).await.map_err(failed("write a state of a setpoint"))
        }
        Record::Answer { action_id, state, problem, done_us, .. } => {
            actions::write_answer(tx, (*action_id, state, problem.as_deref()), *done_us)
                .await
                .map_err(failed("answer an action"))
        }
        Record::Activation(row) => {
            calibrations::write_activation(tx, row).await.map_err(failed("activate a calibration"))
        }
        Record::Policy(policy) => policies::write(tx, policy).await.map_err(failed("write a policy")),
        Record::Quarantined(row) => {
            quarantine::write(tx, fleet, row).await.map_err(failed("put a message into quarantine"))
        }
        Record::Health(_)
        | Record::Trim(_)
        | Record::Ended(_)
        | Record::Approved { .. }
        | Record::Alarm(_)
        | Record::AlarmCleared(_)
        | Record::Gone { .. }
        | Record::AlarmsForgotten { .. } => write_simple(tx, record).await.map_err(failed("write a record")),
    }
}

/// Writes a record that needs a single statement.
async fn write_simple(tx: &mut Tx<'_>, record: &Record) -> sqlx::Result<()> {
    match record {
        Record::Health(row) => {
            on!(&mut *tx, |tx| sqlx::query(
                "INSERT INTO health_changes (whisker_id, recorded_us, kind, was, becomes) VALUES ($1, $2, $3, $4, $5)",
            )
            .bind(row.whisker_id)
            .bind(row.recorded_us)
            .bind(row.kind)
            .bind(row.was)
            .bind(row.becomes)
            .execute(&mut **tx)
            .await
            .map(drop))?;
        }
        Record::Trim(row) => {
            on!(&mut *tx, |tx| sqlx::query(
                "INSERT INTO trims (trim_id, robot_id, whisker_id, detected_us, length_before_mm, \
                 length_after_mm, length_after_sd_mm, contacts_to_detect) VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
            )
            .bind(row.trim_id)
            .bind(row.robot_id)
            .bind(row.whisker_id)
            .bind(row.detected_us)
            .bind(row.length_before_mm)
            .bind(row.length_after_mm)
            .bind(row.length_after_sd_mm)
            .bind(row.contacts_to_detect)
            .execute(&mut **tx)
            .await
            .map(drop))?;
        }
        Record::Approved { compensation_id } => {
            on!(&mut *tx, |tx| sqlx::query(
                "UPDATE compensations SET approval = 'APPROVED' WHERE compensation_id = $1"
            )
            .bind(compensation_id)
            .execute(&mut **tx)
            .await
            .map(drop))?;
        }
        Record::AlarmCleared(row) => {
            on!(&mut *tx, |tx| sqlx::query(
                "UPDATE alarms SET cleared_us = $1 WHERE whisker_id = $2 AND kind = $3 AND cleared_us IS NULL"
            )
            .bind(row.cleared_us)
            .bind(row.whisker_id)
            .bind(row.kind)
            .execute(&mut **tx)
            .await
            .map(drop))?;
        }
        Record::Gone { robot_id, array, whisker, cleared_us } => {
            write_gone(tx, *robot_id, array, *whisker, *cleared_us).await?;
        }
        Record::AlarmsForgotten { robot_id, cleared_us } => {
            on!(&mut *tx, |tx| sqlx::query(
                "UPDATE alarms SET cleared_us = $1 WHERE cleared_us IS NULL \
                 AND whisker_id IN (SELECT whisker_id FROM whiskers WHERE robot_id = $2)"
            )
            .bind(cleared_us)
            .bind(robot_id)
            .execute(&mut **tx)
            .await
            .map(drop))?;
        }
        Record::Ended(row) => {
            on!(&mut *tx, |tx| sqlx::query(
                "UPDATE compensations SET ended_us = $1, end_reason = $2, \
                 approval = CASE WHEN $2 = 'REFUSED' THEN 'REFUSED' ELSE approval END WHERE compensation_id = $3"
            )
            .bind(row.ended_us)
            .bind(row.end_reason)
            .bind(row.compensation_id)
            .execute(&mut **tx)
            .await
            .map(drop))?;
        }
        Record::Alarm(row) => {
            on!(&mut *tx, |tx| sqlx::query("INSERT INTO alarms (whisker_id, raised_us, kind) VALUES ($1, $2, $3)")
                .bind(row.whisker_id)
                .bind(row.raised_us)
                .bind(row.kind)
                .execute(&mut **tx)
                .await
                .map(drop))?;
        }
        Record::Decision(_)
        | Record::Setpoint(_)
        | Record::SetpointState(_)
        | Record::Error(_)
        | Record::Refinement(_)
        | Record::Answer { .. }
        | Record::Activation(_)
        | Record::Policy(_)
        | Record::Quarantined(_) => {}
    }
    Ok(())
}

/// Clears the alarms of a whisker that has left its robot. It is found by its name, because it has no index any more.
async fn write_gone(tx: &mut Tx<'_>, robot_id: i64, array: &str, whisker: i64, cleared_us: i64) -> sqlx::Result<()> {
    on!(&mut *tx, |tx| sqlx::query(
        "UPDATE alarms SET cleared_us = $1 WHERE cleared_us IS NULL AND whisker_id IN (SELECT whisker_id \
         FROM whiskers w JOIN arrays a ON a.array_id = w.array_id \
         WHERE w.robot_id = $2 AND a.\"array\" = $3 AND w.whisker = $4)",
    )
    .bind(cleared_us)
    .bind(robot_id)
    .bind(array)
    .bind(whisker)
    .execute(&mut **tx)
    .await
    .map(drop))
}

async fn write_decision(tx: &mut Tx<'_>, decision: &DecisionRow) -> sqlx::Result<()> {
    let chosen = decision.candidates.iter().find(|candidate| candidate.chosen);
    on!(&mut *tx, |tx| sqlx::query(
        "INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, \
         target_pressure_mpa, compensator_whisker_id, compensation_case, pressure_before_mpa, pressure_mpa, \
         predicted_error, predicted_error_low, predicted_error_high, decided_us, approval) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14)",
    )
    .bind(decision.compensation_id)
    .bind(decision.robot_id)
    .bind(decision.target_whisker_id)
    .bind(decision.target_length_mm)
    .bind(decision.target_pressure_mpa)
    .bind(chosen.map(|candidate| candidate.whisker_id))
    .bind(chosen.map(|candidate| candidate.case))
    .bind(chosen.map(|candidate| candidate.pressure_before_mpa))
    .bind(chosen.and_then(|candidate| candidate.pressure_mpa))
    .bind(chosen.and_then(|candidate| candidate.predicted_error))
    .bind(chosen.and_then(|candidate| candidate.predicted_error_interval).map(|interval| interval.0))
    .bind(chosen.and_then(|candidate| candidate.predicted_error_interval).map(|interval| interval.1))
    .bind(decision.decided_us)
    .bind(decision.approval)
    .execute(&mut **tx)
    .await
    .map(drop))?;
    for (ordinal, candidate) in decision.candidates.iter().enumerate() {
        on!(&mut *tx, |tx| sqlx::query(
            "INSERT INTO compensation_candidates (compensation_id, ordinal, whisker_id, compensation_case, \
             length_mm, length_sd_mm, pressure_before_mpa, pressure_mpa, predicted_error, \
             predicted_error_low, predicted_error_high, predicted_error_by_ratio, gives_up_own_role, chosen, refused) \
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15)",
        )
        .bind(decision.compensation_id)
        .bind(ordinal as i64)
        .bind(candidate.whisker_id)
        .bind(candidate.case)
        .bind(candidate.length_mm)
        .bind(candidate.length_sd_mm)
        .bind(candidate.pressure_before_mpa)
        .bind(candidate.pressure_mpa)
        .bind(candidate.predicted_error)
        .bind(candidate.predicted_error_interval.map(|interval| interval.0))
        .bind(candidate.predicted_error_interval.map(|interval| interval.1))
        .bind(&candidate.predicted_error_by_ratio)
        .bind(candidate.gives_up_own_role)
        .bind(candidate.chosen)
        .bind(candidate.refused)
        .execute(&mut **tx)
        .await
        .map(drop))?;
    }
    Ok(())
}

async fn write_setpoint(tx: &mut Tx<'_>, setpoint: &SetpointRow) -> sqlx::Result<()> {
    on!(&mut *tx, |tx| sqlx::query(
        "INSERT INTO setpoints (command_id, robot_id, whisker_id, compensation_id, epoch, version, robot_boot_id, \
         pressure_mpa, slew_mpa_per_s, issued_us, expires_us, reason, gain, state) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, 'PENDING')",
    )
    .bind(&setpoint.command_id)
    .bind(setpoint.robot_id)
    .bind(setpoint.whisker_id)
    .bind(setpoint.compensation_id)
    .bind(setpoint.epoch)
    .bind(setpoint.version)
    .bind(&setpoint.robot_boot_id)
    .bind(setpoint.pressure_mpa)
    .bind(setpoint.slew_mpa_per_s)
    .bind(setpoint.issued_us)
    .bind(setpoint.expires_us)
    .bind(setpoint.reason)
    .bind(&setpoint.gain)
    .execute(&mut **tx)
    .await
    .map(drop))?;
    append_setpoint_state(tx, &setpoint.command_id, setpoint.issued_us, "PENDING", None, None).await
}

async fn write_setpoint_state(tx: &mut Tx<'_>, row: &SetpointStateRow) -> sqlx::Result<()> {
    on!(&mut *tx, |tx| sqlx::query(
        "UPDATE setpoints SET state = $1, error = $2, reached_mpa = COALESCE($3, reached_mpa) WHERE command_id = $4",
    )
    .bind(row.state)
    .bind(row.error)
    .bind(row.pressure_mpa)
    .bind(&row.command_id)
    .execute(&mut **tx)
    .await
    .map(drop))?;
    append_setpoint_state(tx, &row.command_id, row.recorded_us, row.state, row.error, row.pressure_mpa).await
}

async fn append_setpoint_state(
    tx: &mut Tx<'_>,
    command_id: &str,
    recorded_us: i64,
    state: &'static str,
    error: Option<&'static str>,
    pressure_mpa: Option<f64>,
) -> sqlx::Result<()> {
    on!(&mut *tx, |tx| sqlx::query(
        "INSERT INTO setpoint_states (command_id, recorded_us, state, error, pressure_mpa) VALUES ($1, $2, $3, $4, $5)",
    )
    .bind(command_id)
    .bind(recorded_us)
    .bind(state)
    .bind(error)
    .bind(pressure_mpa)
    .execute(&mut **tx)
    .await
    .map(drop))
}

async fn write_error(tx: &mut Tx<'_>, error: &ErrorRow) -> sqlx::Result<()> {
    let written: i64 = on!(&mut *tx, |tx| sqlx::query_scalar(
        "INSERT INTO compensation_errors (compensation_id, recorded_us, contacts, bins, error, error_low, \
         error_high, pressure_mpa, error_with_gain, error_with_gain_low, error_with_gain_high) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11) RETURNING compensation_error_id",
    )
    .bind(error.compensation_id)
    .bind(error.recorded_us)
    .bind(error.contacts)
    .bind(error.bins.len() as i64)
    .bind(error.error.mean)
    .bind(error.error.low)
    .bind(error.error.high)
    .bind(error.pressure_mpa)
    .bind(error.with_gain.map(|with_gain| with_gain.mean))
    .bind(error.with_gain.map(|with_gain| with_gain.low))
    .bind(error.with_gain.map(|with_gain| with_gain.high))
    .fetch_one(&mut **tx)
    .await)?;
    on!(tx, |tx| {
        let mut insert = QueryBuilder::new(
            "INSERT INTO compensation_error_bins (compensation_error_id, ratio, contacts, after_per_mm, \
             before_per_mm, before_origin, target_per_mm, target_origin, error, error_low, error_high) ",
        );
        insert.push_values(&error.bins, |mut row, bin| {
            row.push_bind(written)
                .push_bind(bin.ratio)
                .push_bind(bin.contacts)
                .push_bind(bin.after_per_mm)
                .push_bind(bin.before_per_mm)
                .push_bind(bin.before_origin)
                .push_bind(bin.target_per_mm)
                .push_bind(bin.target_origin)
                .push_bind(bin.error.mean)
                .push_bind(bin.error.low)
                .push_bind(bin.error.high);
        });
        insert.build().persistent(false).execute(&mut **tx).await.map(drop)
    })
}

async fn write_refinement(tx: &mut Tx<'_>, look: &RefinementRow) -> sqlx::Result<()> {
    on!(&mut *tx, |tx| sqlx::query(
        "INSERT INTO compensation_refinements (compensation_id, recorded_us, contacts, outcome, pressure_from_mpa, \
         pressure_best_mpa, error, error_low, error_high, error_best, error_best_low, error_best_high, \
         error_with_gain, error_with_own_gain, gain_published) \
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15)",
    )
    .bind(look.compensation_id)
    .bind(look.recorded_us)
    .bind(look.contacts)
    .bind(look.outcome)
    .bind(look.pressure_from_mpa)
    .bind(look.pressure_best_mpa)
    .bind(look.error.mean)
    .bind(look.error.low)
    .bind(look.error.high)
    .bind(look.error_best.map(|best| best.mean))
    .bind(look.error_best.map(|best| best.low))
    .bind(look.error_best.map(|best| best.high))
    .bind(look.error_with_gain)
    .bind(look.error_with_own_gain)
    .bind(look.gain_published)
    .execute(&mut **tx)
    .await
    .map(drop))
}
