//! What is PostgreSQL's own: the session, and one statement for many rows.

use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool, PgPoolOptions};

use super::StoreError;
use super::batch::{ContactRow, RobotRow, WhiskerRow};
use super::database::{ACQUIRE_PATIENCE, Either, Options, Pool};
use super::error::failed;

/// The oldest server, as it numbers its versions.
const OLDEST: i32 = 150_000;

/// Connections for reading, made when they are needed.
pub(super) fn open(options: &PgConnectOptions, supervisor: &str) -> (Pool, Options) {
    let options = options.clone().application_name(&format!("vibrissa {supervisor}"));
    let pool =
        PgPoolOptions::new().max_connections(5).acquire_timeout(ACQUIRE_PATIENCE).connect_lazy_with(options.clone());
    (Pool::Postgres(pool), Either::Postgres(options))
}

/// Asks the server how old it is.
pub(super) async fn check_version(pool: &PgPool, database: &str) -> Result<(), StoreError> {
    let version: String = sqlx::query_scalar("SHOW server_version_num")
        .fetch_one(pool)
        .await
        .map_err(|source| StoreError::Open { database: database.to_owned(), source })?;
    if version.parse().is_ok_and(|version: i32| version < OLDEST) {
        let version: String =
            sqlx::query_scalar("SHOW server_version").fetch_one(pool).await.map_err(failed("ask for its version"))?;
        return Err(StoreError::TooOld { database: database.to_owned(), version });
    }
    Ok(())
}

/// What a writer's session rests on, whatever the server's defaults are: a commit is on the disk when it is
/// answered; a supervisor that freezes in a transaction does not keep its lease locked for longer than half the
/// shortest time to live; a forgotten statement ends.
pub(super) async fn prepare_writer(link: &mut PgConnection) -> sqlx::Result<()> {
    for setting in [
        "SET synchronous_commit = on",
        "SET default_transaction_isolation = 'read committed'",
        "SET idle_in_transaction_session_timeout = '500ms'",
        "SET statement_timeout = '20s'",
    ] {
        sqlx::query(setting).execute(&mut *link).await?;
    }
    Ok(())
}

/// One column of many rows.
fn column<'r, R, T>(rows: &'r [R], field: impl Fn(&'r R) -> T) -> Vec<T> {
    rows.iter().map(field).collect()
}

/// Brings robots up to date.
pub(super) async fn write_robots(tx: &mut PgConnection, robots: &[RobotRow]) -> sqlx::Result<()> {
    sqlx::query(
        "UPDATE robots r SET boot_id = n.boot_id, connection = n.connection, updated_us = n.updated_us, \
         state = n.state, held = n.held, journal_number = n.journal_number \
         FROM unnest($1::bigint[], $2::text[], $3::text[], $4::bigint[], $5::bytea[], $6::boolean[], $7::bigint[]) \
         AS n (robot_id, boot_id, connection, updated_us, state, held, journal_number) WHERE r.robot_id = n.robot_id",
    )
    .bind(column(robots, |row| row.robot_id))
    .bind(column(robots, |row| row.boot_id.as_deref()))
    .bind(column(robots, |row| row.connection))
    .bind(column(robots, |row| row.updated_us))
    .bind(column(robots, |row| row.state.as_slice()))
    .bind(column(robots, |row| row.held))
    .bind(column(robots, |row| row.journal_number))
    .execute(tx)
    .await
    .map(drop)
}

/// Brings whiskers up to date.
pub(super) async fn write_whiskers(tx: &mut PgConnection, whiskers: &[WhiskerRow]) -> sqlx::Result<()> {
    sqlx::query(
        "UPDATE whiskers w SET position = n.position, length_mm = n.length_mm, length_sd_mm = n.length_sd_mm, \
         condition = n.condition, fault = n.fault, pressure_mpa = n.pressure_mpa, setpoint_mpa = n.setpoint_mpa, \
         contacts = n.contacts, heard_us = n.heard_us, leak_per_s = n.leak_per_s, \
         leak_low_per_s = n.leak_low_per_s, leak_high_per_s = n.leak_high_per_s, \
         erosion_mm_per_contact = n.erosion_mm_per_contact, \
         erosion_low_mm_per_contact = n.erosion_low_mm_per_contact, \
         erosion_high_mm_per_contact = n.erosion_high_mm_per_contact, contacts_left = n.contacts_left, \
         contacts_left_low = n.contacts_left_low, contacts_left_high = n.contacts_left_high, state = n.state, \
         held = n.held \
         FROM unnest($1::bigint[], $2::bigint[], $3::float8[], $4::float8[], $5::text[], $6::text[], $7::float8[], \
         $8::float8[], $9::bigint[], $10::bigint[], $11::float8[], $12::float8[], $13::float8[], $14::float8[], \
         $15::float8[], $16::float8[], $17::float8[], $18::float8[], $19::float8[], $20::bytea[], $21::boolean[]) \
         AS n (whisker_id, position, length_mm, length_sd_mm, condition, fault, pressure_mpa, setpoint_mpa, contacts, \
         heard_us, leak_per_s, leak_low_per_s, leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact, \
         erosion_high_mm_per_contact, contacts_left, contacts_left_low, contacts_left_high, state, held) \
         WHERE w.whisker_id = n.whisker_id",
    )
    .bind(column(whiskers, |row| row.whisker_id))
    .bind(column(whiskers, |row| row.position))
    .bind(column(whiskers, |row| row.length_mm))
    .bind(column(whiskers, |row| row.length_sd_mm))
    .bind(column(whiskers, |row| row.condition))
    .bind(column(whiskers, |row| row.fault))
    .bind(column(whiskers, |row| row.pressure_mpa))
    .bind(column(whiskers, |row| row.setpoint_mpa))
    .bind(column(whiskers, |row| row.contacts))
    .bind(column(whiskers, |row| row.heard_us))
    .bind(column(whiskers, |row| row.leak_per_s.map(|one| one.mean)))
    .bind(column(whiskers, |row| row.leak_per_s.map(|one| one.low)))
    .bind(column(whiskers, |row| row.leak_per_s.map(|one| one.high)))
    .bind(column(whiskers, |row| row.erosion_mm_per_contact.map(|one| one.mean)))
    .bind(column(whiskers, |row| row.erosion_mm_per_contact.map(|one| one.low)))
    .bind(column(whiskers, |row| row.erosion_mm_per_contact.map(|one| one.high)))
    .bind(column(whiskers, |row| row.contacts_left[0]))
    .bind(column(whiskers, |row| row.contacts_left[1]))
    .bind(column(whiskers, |row| row.contacts_left[2]))
    .bind(column(whiskers, |row| row.state.as_slice()))
    .bind(column(whiskers, |row| row.held))
    .execute(tx)
    .await
    .map(drop)
}

/// Appends contacts.
pub(super) async fn append_contacts(tx: &mut PgConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
    sqlx::query(
        "INSERT INTO contacts (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, \
         pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) \
         SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::bigint[], $5::bigint[], $6::bigint[], \
         $7::float8[], $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::text[], $13::float8[], \
         $14::float8[], $15::float8[])",
    )
    .bind(column(contacts, |row| row.whisker_id))
    .bind(column(contacts, |row| row.boot))
    .bind(column(contacts, |row| row.seq))
    .bind(column(contacts, |row| row.position))
    .bind(column(contacts, |row| row.t_us))
    .bind(column(contacts, |row| row.received_us))
    .bind(column(contacts, |row| row.ratio))
    .bind(column(contacts, |row| row.deflection_mm))
    .bind(column(contacts, |row| row.strain))
    .bind(column(contacts, |row| row.pressure_mpa))
    .bind(column(contacts, |row| row.temperature_c))
    .bind(column(contacts, |row| row.used))
    .bind(column(contacts, |row| row.residual))
    .bind(column(contacts, |row| row.length_mm))
    .bind(column(contacts, |row| row.length_sd_mm))
    .execute(tx)
    .await
    .map(drop)
}
