//! Writes a batch: one transaction, all or nothing.

use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

use super::batch::{ContactRow, DecisionRow, ErrorRow, LayoutRow, Record, RobotRow, SetpointRow, WhiskerRow};
use super::{Batch, Store, StoreError, failed};

/// Rows of one statement: 16 values each, SQLite takes 32,766.
const CONTACTS_A_STATEMENT: usize = 1000;

impl Store {
    /// Writes a batch in one transaction; after an error nothing of it is written.
    ///
    /// # Errors
    /// The database cannot take it now.
    pub async fn commit(&self, batch: &Batch) -> Result<(), StoreError> {
        let mut transaction = self.pool.begin().await.map_err(failed("begin a transaction"))?;
        let tx = &mut *transaction;
        for layout in &batch.layouts {
            write_layout(tx, layout).await.map_err(failed("write a layout"))?;
        }
        for robot in &batch.robots {
            write_robot(tx, robot).await.map_err(failed("write a robot"))?;
        }
        for whisker in &batch.whiskers {
            write_whisker(tx, whisker).await.map_err(failed("write a whisker"))?;
        }
        for contacts in batch.contacts.chunks(CONTACTS_A_STATEMENT) {
            append_contacts(tx, contacts).await.map_err(failed("append contacts"))?;
        }
        for record in &batch.records {
            write_record(tx, record).await?;
        }
        transaction.commit().await.map_err(failed("commit"))
    }
}

async fn write_layout(tx: &mut SqliteConnection, layout: &LayoutRow) -> sqlx::Result<()> {
    sqlx::query("UPDATE robots SET model = ? WHERE robot_id = ?")
        .bind(&layout.model)
        .bind(layout.robot_id)
        .execute(&mut *tx)
        .await?;
    sqlx::query("UPDATE whiskers SET position = NULL, state = NULL WHERE robot_id = ?")
        .bind(layout.robot_id)
        .execute(&mut *tx)
        .await
        .map(drop)
}

async fn write_robot(tx: &mut SqliteConnection, robot: &RobotRow) -> sqlx::Result<()> {
    sqlx::query("UPDATE robots SET boot_id = ?, connection = ?, updated_us = ?, state = ? WHERE robot_id = ?")
        .bind(&robot.boot_id)
        .bind(robot.connection)
        .bind(robot.updated_us)
        .bind(&robot.state)
        .bind(robot.robot_id)
        .execute(tx)
        .await
        .map(drop)
}

async fn write_whisker(tx: &mut SqliteConnection, whisker: &WhiskerRow) -> sqlx::Result<()> {
    sqlx::query(
        "UPDATE whiskers SET position = ?, length_mm = ?, length_sd_mm = ?, condition = ?, fault = ?, \
         pressure_mpa = ?, setpoint_mpa = ?, contacts = ?, heard_us = ?, state = ? WHERE whisker_id = ?",
    )
    .bind(whisker.position)
    .bind(whisker.length_mm)
    .bind(whisker.length_sd_mm)
    .bind(whisker.condition)
    .bind(whisker.fault)
    .bind(whisker.pressure_mpa)
    .bind(whisker.setpoint_mpa)
    .bind(whisker.contacts)
    .bind(whisker.heard_us)
    .bind(&whisker.state)
    .bind(whisker.whisker_id)
    .execute(tx)
    .await
    .map(drop)
}

async fn append_contacts(tx: &mut SqliteConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
    let mut insert = QueryBuilder::<Sqlite>::new(
        "INSERT INTO contacts (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, \
         pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) ",
    );
    insert.push_values(contacts, |mut row, contact| {
        row.push_bind(contact.whisker_id)
            .push_bind(contact.boot)
            .push_bind(contact.seq)
            .push_bind(contact.position)
            .push_bind(contact.t_us)
            .push_bind(contact.received_us)
            .push_bind(contact.ratio)
            .push_bind(contact.deflection_mm)
            .push_bind(contact.strain)
            .push_bind(contact.pressure_mpa)
            .push_bind(contact.temperature_c)
            .push_bind(contact.used)
            .push_bind(contact.residual)
            .push_bind(contact.length_mm)
            .push_bind(contact.length_sd_mm);
    });
    insert.build().persistent(false).execute(tx).await.map(drop)
}

async fn write_record(tx: &mut SqliteConnection, record: &Record) -> Result<(), StoreError> {
    match record {
        Record::Decision(decision) => write_decision(tx, decision).await.map_err(failed("write a decision")),
        Record::Setpoint(setpoint) => write_setpoint(tx, setpoint).await.map_err(failed("write a setpoint")),
        Record::Error(error) => write_error(tx, error).await.map_err(failed("write a compensation error")),
        Record::SetpointState { command_id, recorded_us, state, error, pressure_mpa } => {
            write_setpoint_state(tx, command_id, *recorded_us, state, *error, *pressure_mpa)
                .await
                .map_err(failed("write what became of a setpoint"))
        }
        Record::Health { .. }
        | Record::Trim { .. }
        | Record::Ended { .. }
        | Record::Response(_)
        | Record::Alarm { .. } => write_simple(tx, record).await.map_err(failed("write a record")),
    }
}

/// Records of one statement each.
async fn write_simple(tx: &mut SqliteConnection, record: &Record) -> sqlx::Result<()> {
    match record {
        Record::Health { whisker_id, recorded_us, kind, was, becomes } => {
            sqlx::query(
                "INSERT INTO health_changes (whisker_id, recorded_us, kind, was, becomes) VALUES (?, ?, ?, ?, ?)",
            )
            .bind(whisker_id)
            .bind(recorded_us)
            .bind(*kind)
            .bind(*was)
            .bind(*becomes)
            .execute(tx)
            .await?;
        }
        Record::Trim {
            trim_id,
            robot_id,
            whisker_id,
            detected_us,
            length_before_mm,
            length_after_mm,
            length_after_sd_mm,
            contacts_to_detect,
        } => {
            sqlx::query(
                "INSERT INTO trims (trim_id, robot_id, whisker_id, detected_us, length_before_mm, \
                 length_after_mm, length_after_sd_mm, contacts_to_detect) VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
            )
            .bind(trim_id)
            .bind(robot_id)
            .bind(whisker_id)
            .bind(detected_us)
            .bind(length_before_mm)
            .bind(length_after_mm)
            .bind(length_after_sd_mm)
            .bind(contacts_to_detect)
            .execute(tx)
            .await?;
        }
        Record::Ended { compensation_id, ended_us, end_reason } => {
            sqlx::query("UPDATE compensations SET ended_us = ?, end_reason = ? WHERE compensation_id = ?")
                .bind(ended_us)
                .bind(*end_reason)
                .bind(compensation_id)
                .execute(tx)
                .await?;
        }
        Record::Response(response) => {
            sqlx::query(
                "INSERT INTO compensation_responses (compensation_id, t_us, ratio, deflection_mm, after_strain, \
                 before_strain, before_origin, target_strain, target_origin) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
            )
            .bind(response.compensation_id)
            .bind(response.t_us)
            .bind(response.ratio)
            .bind(response.deflection_mm)
            .bind(response.after_strain)
            .bind(response.before_strain)
            .bind(response.before_origin)
            .bind(response.target_strain)
            .bind(response.target_origin)
            .execute(tx)
            .await?;
        }
        Record::Alarm { whisker_id, raised_us, kind } => {
            sqlx::query("INSERT INTO alarms (whisker_id, raised_us, kind) VALUES (?, ?, ?)")
                .bind(whisker_id)
                .bind(raised_us)
                .bind(*kind)
                .execute(tx)
                .await?;
        }
        Record::Decision(_) | Record::Setpoint(_) | Record::SetpointState { .. } | Record::Error(_) => {}
    }
    Ok(())
}

async fn write_decision(tx: &mut SqliteConnection, decision: &DecisionRow) -> sqlx::Result<()> {
    let chosen = decision.candidates.iter().find(|candidate| candidate.chosen);
    sqlx::query(
        "INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, \
         target_pressure_mpa, compensator_whisker_id, compensation_case, pressure_before_mpa, pressure_mpa, \
         predicted_error, decided_us) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
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
    .bind(decision.decided_us)
    .execute(&mut *tx)
    .await?;
    for (ordinal, candidate) in decision.candidates.iter().enumerate() {
        sqlx::query(
            "INSERT INTO compensation_candidates (compensation_id, ordinal, whisker_id, compensation_case, \
             length_mm, length_sd_mm, pressure_before_mpa, pressure_mpa, predicted_error, \
             predicted_error_by_ratio, gives_up_own_role, chosen, refused) \
             VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
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
        .bind(&candidate.predicted_error_by_ratio)
        .bind(candidate.gives_up_own_role)
        .bind(candidate.chosen)
        .bind(candidate.refused)
        .execute(&mut *tx)
        .await?;
    }
    Ok(())
}

async fn write_setpoint(tx: &mut SqliteConnection, setpoint: &SetpointRow) -> sqlx::Result<()> {
    sqlx::query(
        "INSERT INTO setpoints (command_id, robot_id, whisker_id, compensation_id, epoch, version, robot_boot_id, \
         pressure_mpa, slew_mpa_per_s, issued_us, expires_us, reason, gain, state) \
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, 'PENDING')",
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
    .execute(&mut *tx)
    .await?;
    write_setpoint_state(tx, &setpoint.command_id, setpoint.issued_us, "PENDING", None, None).await
}

async fn write_setpoint_state(
    tx: &mut SqliteConnection,
    command_id: &str,
    recorded_us: i64,
    state: &'static str,
    error: Option<&'static str>,
    pressure_mpa: Option<f64>,
) -> sqlx::Result<()> {
    sqlx::query(
        "UPDATE setpoints SET state = ?, error = ?, reached_mpa = COALESCE(?, reached_mpa) WHERE command_id = ?",
    )
    .bind(state)
    .bind(error)
    .bind(pressure_mpa)
    .bind(command_id)
    .execute(&mut *tx)
    .await?;
    sqlx::query(
        "INSERT INTO setpoint_states (command_id, recorded_us, state, error, pressure_mpa) VALUES (?, ?, ?, ?, ?)",
    )
    .bind(command_id)
    .bind(recorded_us)
    .bind(state)
    .bind(error)
    .bind(pressure_mpa)
    .execute(tx)
    .await
    .map(drop)
}

async fn write_error(tx: &mut SqliteConnection, error: &ErrorRow) -> sqlx::Result<()> {
    let written = sqlx::query(
        "INSERT INTO compensation_errors (compensation_id, recorded_us, contacts, bins, error, error_low, \
         error_high) VALUES (?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(error.compensation_id)
    .bind(error.recorded_us)
    .bind(error.contacts)
    .bind(error.bins.len() as i64)
    .bind(error.error.mean)
    .bind(error.error.low)
    .bind(error.error.high)
    .execute(&mut *tx)
    .await?;
    let mut insert = QueryBuilder::<Sqlite>::new(
        "INSERT INTO compensation_error_bins (compensation_error_id, ratio, contacts, after_per_mm, \
         before_per_mm, before_origin, target_per_mm, target_origin, error, error_low, error_high) ",
    );
    insert.push_values(&error.bins, |mut row, bin| {
        row.push_bind(written.last_insert_rowid())
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
    insert.build().persistent(false).execute(tx).await.map(drop)
}
