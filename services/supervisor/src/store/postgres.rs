//! What is PostgreSQL's own: the session, and one statement for many rows.

use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool, PgPoolOptions};

use super::StoreError;
use super::batch::{ContactRow, ResponseRow, RobotRow, RollupRow, WhiskerRow};
use super::database::{ACQUIRE_PATIENCE, Either, Options, Pool};
use super::error::failed;
use crate::engine::Resolution;

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

/// The rest of the statement that appends minutes or hours.
macro_rules! rollup_values {
    () => {
        "(whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, \
         residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, \
         temperature_c, compensation_error) \
         SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::int4[], $4::int4[], $5::int4[], $6::float4[], $7::float4[], \
         $8::float4[], $9::float4[], $10::float4[], $11::float4[], $12::float4[], $13::float4[], $14::float4[], \
         $15::float4[], $16::float4[], $17::float4[]) ON CONFLICT DO NOTHING"
    };
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
         held = n.held, rollup = n.rollup \
         FROM unnest($1::bigint[], $2::bigint[], $3::float8[], $4::float8[], $5::text[], $6::text[], $7::float8[], \
         $8::float8[], $9::bigint[], $10::bigint[], $11::float8[], $12::float8[], $13::float8[], $14::float8[], \
         $15::float8[], $16::float8[], $17::float8[], $18::float8[], $19::float8[], $20::bytea[], $21::boolean[], $22::bytea[]) \
         AS n (whisker_id, position, length_mm, length_sd_mm, condition, fault, pressure_mpa, setpoint_mpa, contacts, \
         heard_us, leak_per_s, leak_low_per_s, leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact, \
         erosion_high_mm_per_contact, contacts_left, contacts_left_low, contacts_left_high, state, held, rollup) \
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
    .bind(column(whiskers, |row| row.rollup.as_slice()))
    .execute(tx)
    .await
    .map(drop)
}

/// Contacts from which on a `COPY` is worth it.
const COPIED: usize = 2000;

/// Appends contacts: many by `COPY` in its binary format, at half of the server's work of an `INSERT`. But the library writes a
/// copy and its end one after the other, without TCP_NODELAY: the end waits for the acknowledgement of the rest, which the
/// system delays by 40 ms. So few are appended by one statement.
pub(super) async fn append_contacts(tx: &mut PgConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
    if contacts.len() < COPIED { insert_contacts(tx, contacts).await } else { copy_contacts(tx, contacts).await }
}

async fn insert_contacts(tx: &mut PgConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
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

async fn copy_contacts(tx: &mut PgConnection, contacts: &[ContactRow]) -> sqlx::Result<()> {
    let mut copy = tx
        .copy_in_raw(
            "COPY contacts (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, \
             pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) FROM STDIN (FORMAT BINARY)",
        )
        .await?;
    copy.send(copy_of(contacts)).await?;
    copy.finish().await.map(drop)
}

/// Appends the responses of whiskers that serve.
pub(super) async fn append_responses(tx: &mut PgConnection, responses: &[ResponseRow]) -> sqlx::Result<()> {
    sqlx::query(
        "INSERT INTO compensation_responses (compensation_id, t_us, ratio, deflection_mm, after_strain, before_strain, \
         before_origin, target_strain, target_origin) SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::float8[], \
         $4::float8[], $5::float8[], $6::float8[], $7::text[], $8::float8[], $9::text[])",
    )
    .bind(column(responses, |row| row.compensation_id))
    .bind(column(responses, |row| row.t_us))
    .bind(column(responses, |row| row.ratio))
    .bind(column(responses, |row| row.deflection_mm))
    .bind(column(responses, |row| row.after_strain))
    .bind(column(responses, |row| row.before_strain))
    .bind(column(responses, |row| row.before_origin))
    .bind(column(responses, |row| row.target_strain))
    .bind(column(responses, |row| row.target_origin))
    .execute(tx)
    .await
    .map(drop)
}

/// Columns of a contact.
const CONTACT_COLUMNS: u16 = 15;
/// Bytes of a contact in a copy at the most: each value has its length in front of it.
const CONTACT_BYTES: usize = 2 + CONTACT_COLUMNS as usize * (4 + 8) + 8;

/// Contacts in the binary format of `COPY`.
fn copy_of(contacts: &[ContactRow]) -> Vec<u8> {
    // Signature, flags, and the length of what else there would be in front.
    let mut copy = Vec::with_capacity(32 + contacts.len() * CONTACT_BYTES);
    copy.extend(b"PGCOPY\n\xff\r\n\0");
    copy.extend([0; 8]);
    for row in contacts {
        copy.extend(CONTACT_COLUMNS.to_be_bytes());
        for whole in [row.whisker_id, row.boot, row.seq, row.position, row.t_us, row.received_us] {
            push(&mut copy, &whole.to_be_bytes());
        }
        for number in [row.ratio, row.deflection_mm, row.strain, row.pressure_mpa, row.temperature_c] {
            push(&mut copy, &number.to_be_bytes());
        }
        push(&mut copy, row.used.as_bytes());
        match row.residual {
            Some(residual) => push(&mut copy, &residual.to_be_bytes()),
            None => copy.extend((-1_i32).to_be_bytes()),
        }
        push(&mut copy, &row.length_mm.to_be_bytes());
        push(&mut copy, &row.length_sd_mm.to_be_bytes());
    }
    copy.extend((-1_i16).to_be_bytes());
    copy
}

fn push(copy: &mut Vec<u8>, value: &[u8]) {
    copy.extend((value.len() as u32).to_be_bytes());
    copy.extend(value);
}

/// Appends minutes or hours. One that is there already is left as it is; tells how many were not.
pub(super) async fn append_rollups(
    tx: &mut PgConnection,
    resolution: Resolution,
    rows: &[&RollupRow],
) -> sqlx::Result<u64> {
    let sql = match resolution {
        Resolution::Minute => concat!("INSERT INTO contact_minutes ", rollup_values!()),
        Resolution::Hour => concat!("INSERT INTO contact_hours ", rollup_values!()),
    };
    sqlx::query(sql)
        .bind(column(rows, |row| row.whisker_id))
        .bind(column(rows, |row| row.start_us))
        .bind(column(rows, |row| row.contacts[0]))
        .bind(column(rows, |row| row.contacts[1]))
        .bind(column(rows, |row| row.contacts[2]))
        .bind(column(rows, |row| row.residual[0]))
        .bind(column(rows, |row| row.residual[1]))
        .bind(column(rows, |row| row.residual[2]))
        .bind(column(rows, |row| row.residual[3]))
        .bind(column(rows, |row| row.sensitivity_per_mm))
        .bind(column(rows, |row| row.ratio))
        .bind(column(rows, |row| row.length_mm))
        .bind(column(rows, |row| row.length_sd_mm))
        .bind(column(rows, |row| row.length_mean_mm))
        .bind(column(rows, |row| row.pressure_mpa))
        .bind(column(rows, |row| row.temperature_c))
        .bind(column(rows, |row| row.compensation_error))
        .execute(tx)
        .await
        .map(|done| done.rows_affected())
}
