//! SQLite's part of the store: the file, and statements for many rows.

use std::fs::OpenOptions;
use std::iter::repeat_n;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqlitePoolOptions, SqliteSynchronous};
use sqlx::{QueryBuilder, Sqlite, SqliteConnection};

use super::batch::{ContactRow, ResponseRow, RobotRow, RollupRow, WhiskerRow};
use super::database::{ACQUIRE_PATIENCE, Either, Options, Pool};
use super::lock::FileLock;
use super::{StoreError, database};
use crate::Resolution;

/// Mode of a new database: readable by its owner only, because it contains hashes of tokens and the audit log.
const MODE: u32 = 0o600;

/// Most rows of one statement: each binds at most 22 values, and SQLite accepts 32,766.
const ROWS_A_STATEMENT: usize = 512;

/// Splits rows into the pieces of one statement each. A piece is padded to a power of two with copies of its last
/// row, which are marked false. So there are few different statements, each prepared once, and few executions, each
/// of which costs a round trip to SQLite's thread.
fn pieces<T>(rows: &[T]) -> impl Iterator<Item = impl Iterator<Item = (&T, bool)>> {
    rows.chunks(ROWS_A_STATEMENT).map(|piece| {
        let filling = piece.len().next_power_of_two() - piece.len();
        piece
            .iter()
            .map(|row| (row, true))
            .chain(piece.last().into_iter().flat_map(move |last| repeat_n((last, false), filling)))
    })
}

/// Opens or creates the file, and locks it for the supervisor.
pub(super) async fn open(path: &Path, name: &str, supervisor: &str) -> Result<(Pool, Options), StoreError> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.exists()) {
        return Err(StoreError::NoFolder { path: path.to_owned(), folder: folder.to_owned() });
    }
    let lock = FileLock::take(path, supervisor)?;
    // SQLite gives its other files the mode of this one. A failure is ignored here, because SQLite reports it.
    let _ = OpenOptions::new().write(true).create_new(true).mode(MODE).open(path);
    connect(path, name, Some(lock)).await
}

/// Opens the file without locking it, beside the supervisor that has locked it.
pub(super) async fn open_beside(path: &Path, name: &str) -> Result<(Pool, Options), StoreError> {
    connect(path, name, None).await
}

async fn connect(path: &Path, name: &str, lock: Option<FileLock>) -> Result<(Pool, Options), StoreError> {
    let options = SqliteConnectOptions::new()
        .filename(path)
        .create_if_missing(true)
        .foreign_keys(true)
        .journal_mode(SqliteJournalMode::Wal)
        // A receipted commit must survive a loss of power.
        .synchronous(SqliteSynchronous::Full)
        // A checkpoint of the write-ahead log every 4,000 pages (16 MB): the same pages are written again and again.
        .pragma("wal_autocheckpoint", "4000")
        .busy_timeout(Duration::from_secs(10));
    let pool = SqlitePoolOptions::new()
        .max_connections(4)
        .acquire_timeout(ACQUIRE_PATIENCE)
        .connect_with(options.clone())
        .await
        .map_err(|source| StoreError::Open { database: name.to_owned(), source })?;
    Ok((database::Pool::Sqlite(pool), Either::Sqlite((options, lock))))
}

/// Updates robots with their checkpoints.
pub(super) async fn write_robots(tx: &mut SqliteConnection, robots: &[RobotRow]) -> sqlx::Result<()> {
    for robots in pieces(robots) {
        let mut update = QueryBuilder::<Sqlite>::new(
            "UPDATE robots SET boot_id = v.column2, connection = v.column3, held = v.column4, updated_us = v.column5, \
             journal_number = v.column6, state = v.column7 FROM (",
        );
        update.push_values(robots, |mut row, (robot, counts)| {
            row.push_bind(counts.then_some(robot.robot_id))
                .push_bind(&robot.boot_id)
                .push_bind(robot.connection)
                .push_bind(robot.held)
                .push_bind(robot.updated_us)
                .push_bind(robot.journal_number)
                .push_bind(&robot.state);
        });
        update.push(") AS v WHERE robot_id = v.column1");
        update.build().execute(&mut *tx).await?;
    }
    Ok(())
}

/// Updates whiskers with their checkpoints.
pub(super) async fn write_whiskers(tx: &mut SqliteConnection, whiskers: &[WhiskerRow]) -> sqlx::Result<()> {
    for whiskers in pieces(whiskers) {
        let mut update = QueryBuilder::<Sqlite>::new(
            "UPDATE whiskers SET position = v.column2, length_mm = v.column3, length_sd_mm = v.column4, \
             condition = v.column5, fault = v.column6, pressure_mpa = v.column7, setpoint_mpa = v.column8, \
             contacts = v.column9, heard_us = v.column10, held = v.column11, leak_per_s = v.column12, \
             leak_low_per_s = v.column13, leak_high_per_s = v.column14, erosion_mm_per_contact = v.column15, \
             erosion_low_mm_per_contact = v.column16, erosion_high_mm_per_contact = v.column17, \
             contacts_left = v.column18, contacts_left_low = v.column19, contacts_left_high = v.column20, \
             state = v.column21, rollup = v.column22 FROM (",
        );
        update.push_values(whiskers, |mut row, (whisker, counts)| {
            row.push_bind(counts.then_some(whisker.whisker_id))
                .push_bind(whisker.position)
                .push_bind(whisker.length_mm)
                .push_bind(whisker.length_sd_mm)
                .push_bind(whisker.condition)
                .push_bind(whisker.fault)
                .push_bind(whisker.pressure_mpa)
                .push_bind(whisker.setpoint_mpa)
                .push_bind(whisker.contacts)
                .push_bind(whisker.heard_us)
                .push_bind(whisker.held)
                .push_bind(whisker.leak_per_s.map(|one| one.mean))
                .push_bind(whisker.leak_per_s.map(|one| one.low))
                .push_bind(whisker.leak_per_s.map(|one| one.high))
                .push_bind(whisker.erosion_mm_per_contact.map(|one| one.mean))
                .push_bind(whisker.erosion_mm_per_contact.map(|one| one.low))
                .push_bind(whisker.erosion_mm_per_contact.map(|one| one.high))
                .push_bind(whisker.contacts_left[0])
                .push_bind(whisker.contacts_left[1])
                .push_bind(whisker.contacts_left[2])
                .push_bind(&whisker.state)
                .push_bind(&whisker.rollup);
        });
        update.push(") AS v WHERE whisker_id = v.column1");
        update.build().execute(&mut *tx).await?;
    }
    Ok(())
}

/// Inserts single contacts.
pub(super) async fn append_contacts(tx: &mut SqliteConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
    for contacts in pieces(contacts) {
        let mut insert = QueryBuilder::<Sqlite>::new(
            "INSERT INTO contacts (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, \
             pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) \
             SELECT * FROM (",
        );
        insert.push_values(contacts, |mut row, (contact, counts)| {
            row.push_bind(counts.then_some(contact.whisker_id))
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
        insert.push(") WHERE column1 IS NOT NULL");
        insert.build().execute(&mut *tx).await?;
    }
    Ok(())
}

/// Inserts responses of compensators.
pub(super) async fn append_responses(tx: &mut SqliteConnection, responses: &[ResponseRow]) -> sqlx::Result<()> {
    for responses in pieces(responses) {
        let mut insert = QueryBuilder::<Sqlite>::new(
            "INSERT INTO compensation_responses (compensation_id, t_us, ratio, deflection_mm, after_strain, \
             before_strain, before_origin, target_strain, target_origin) \
             SELECT * FROM (",
        );
        insert.push_values(responses, |mut row, (response, counts)| {
            row.push_bind(counts.then_some(response.compensation_id))
                .push_bind(response.t_us)
                .push_bind(response.ratio)
                .push_bind(response.deflection_mm)
                .push_bind(response.after_strain)
                .push_bind(response.before_strain)
                .push_bind(response.before_origin)
                .push_bind(response.target_strain)
                .push_bind(response.target_origin);
        });
        insert.push(") WHERE column1 IS NOT NULL");
        insert.build().execute(&mut *tx).await?;
    }
    Ok(())
}

/// Inserts aggregates of minutes or hours; existing rows are left unchanged. Returns the number of rows that did not
/// exist before.
pub(super) async fn append_rollups(
    tx: &mut SqliteConnection,
    resolution: Resolution,
    rows: &[&RollupRow],
) -> sqlx::Result<u64> {
    let table = match resolution {
        Resolution::Minute => "contact_minutes",
        Resolution::Hour => "contact_hours",
    };
    let mut written = 0;
    for rows in pieces(rows) {
        let mut insert = QueryBuilder::<Sqlite>::new("INSERT INTO ");
        insert.push(table).push(
            " (whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, \
             residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, \
             pressure_mpa, temperature_c, compensation_error) \
             SELECT * FROM (",
        );
        insert.push_values(rows, |mut values, (row, counts)| {
            values.push_bind(counts.then_some(row.whisker_id)).push_bind(row.start_us);
            for count in row.contacts {
                values.push_bind(count);
            }
            for number in row.residual {
                values.push_bind(number);
            }
            values
                .push_bind(row.sensitivity_per_mm)
                .push_bind(row.ratio)
                .push_bind(row.length_mm)
                .push_bind(row.length_sd_mm)
                .push_bind(row.length_mean_mm)
                .push_bind(row.pressure_mpa)
                .push_bind(row.temperature_c)
                .push_bind(row.compensation_error);
        });
        insert.push(") WHERE column1 IS NOT NULL ON CONFLICT DO NOTHING");
        written += insert.build().execute(&mut *tx).await?.rows_affected();
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_are_all_rows_in_order_and_of_few_sizes() {
        for count in [0, 1, 7, 8, 9, 63, 64, 511, 512, 1100] {
            let rows: Vec<usize> = (0..count).collect();
            let pieces: Vec<Vec<(&usize, bool)>> = pieces(&rows).map(Iterator::collect).collect();
            assert_eq!(pieces.len(), count.div_ceil(512));
            assert!(pieces.iter().all(|piece| piece.len().is_power_of_two() && piece.len() <= 512));
            let counting = pieces.iter().flatten().filter(|(_, counts)| *counts).map(|(row, _)| **row);
            assert_eq!(counting.collect::<Vec<_>>(), rows);
        }
    }
}
