//! Statements that write many rows of a kind: each column is an array parameter.
//!
//! Each statement has the word `OWNED` in the place of a condition, so it can be a part of a larger statement
//! ([`super::whole`]).

use sqlx::postgres::{PgArguments, PgConnection};
use sqlx::query::Query;
use sqlx::{AssertSqlSafe, Postgres};

use crate::Resolution;
use crate::batch::{ContactRow, ResponseRow, RobotRow, RollupRow, WhiskerRow};

/// A statement whose parameters are being bound.
pub(in super::super) type Statement = Query<'static, Postgres, PgArguments>;

/// Binds the next parameters of a statement: for each column an array with a value of each row.
macro_rules! bind_each {
    ($statement:expr, $rows:expr, |$row:pat_param| $($value:expr),+ $(,)?) => {
        $statement$(.bind($rows.iter().map(|$row| $value).collect::<Vec<_>>()))+
    };
}
pub(super) use bind_each;

/// A part as a statement on its own, without a condition.
pub(super) fn alone(sql: &str) -> Statement {
    sqlx::query(AssertSqlSafe(sql.replace("OWNED", "TRUE")))
}

/// Updates robots with their checkpoints.
pub(super) const ROBOTS: &str = "UPDATE robots r SET boot_id = n.boot_id, connection = n.connection, updated_us = n.updated_us, \
         state = n.state, held = n.held, journal_number = n.journal_number \
         FROM unnest($1::bigint[], $2::text[], $3::text[], $4::bigint[], $5::bytea[], $6::boolean[], $7::bigint[]) \
         AS n (robot_id, boot_id, connection, updated_us, state, held, journal_number) WHERE r.robot_id = n.robot_id AND OWNED";

pub(super) fn bind_robots(statement: Statement, robots: &[RobotRow]) -> Statement {
    bind_each!(
        statement,
        robots,
        |row| row.robot_id,
        row.boot_id.as_deref(),
        row.connection,
        row.updated_us,
        row.state.as_slice(),
        row.held,
        row.journal_number
    )
}

/// Updates robots with their checkpoints.
pub(in super::super) async fn write_robots(tx: &mut PgConnection, robots: &[RobotRow]) -> sqlx::Result<()> {
    bind_robots(alone(ROBOTS), robots).execute(tx).await.map(drop)
}

/// Updates whiskers with their checkpoints.
pub(super) const WHISKERS: &str = "UPDATE whiskers w SET position = n.position, length_mm = n.length_mm, length_sd_mm = n.length_sd_mm, \
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
         WHERE w.whisker_id = n.whisker_id AND OWNED";

pub(super) fn bind_whiskers(statement: Statement, whiskers: &[WhiskerRow]) -> Statement {
    bind_each!(
        statement,
        whiskers,
        |row| row.whisker_id,
        row.position,
        row.length_mm,
        row.length_sd_mm,
        row.condition,
        row.fault,
        row.pressure_mpa,
        row.setpoint_mpa,
        row.contacts,
        row.heard_us,
        row.leak_per_s.map(|one| one.mean),
        row.leak_per_s.map(|one| one.low),
        row.leak_per_s.map(|one| one.high),
        row.erosion_mm_per_contact.map(|one| one.mean),
        row.erosion_mm_per_contact.map(|one| one.low),
        row.erosion_mm_per_contact.map(|one| one.high),
        row.contacts_left[0],
        row.contacts_left[1],
        row.contacts_left[2],
        row.state.as_slice(),
        row.held,
        row.rollup.as_slice()
    )
}

/// Updates whiskers with their checkpoints.
pub(in super::super) async fn write_whiskers(tx: &mut PgConnection, whiskers: &[WhiskerRow]) -> sqlx::Result<()> {
    bind_whiskers(alone(WHISKERS), whiskers).execute(tx).await.map(drop)
}

/// Inserts single contacts.
pub(super) const CONTACTS: &str = "INSERT INTO contacts (whisker_id, boot, seq, position, t_us, received_us, ratio, deflection_mm, strain, \
         pressure_mpa, temperature_c, used, residual, length_mm, length_sd_mm) \
         SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::bigint[], $5::bigint[], $6::bigint[], \
         $7::float8[], $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::text[], $13::float8[], \
         $14::float8[], $15::float8[]) WHERE OWNED";

pub(super) fn bind_contacts(statement: Statement, contacts: &[ContactRow]) -> Statement {
    bind_each!(
        statement,
        contacts,
        |row| row.whisker_id,
        row.boot,
        row.seq,
        row.position,
        row.t_us,
        row.received_us,
        row.ratio,
        row.deflection_mm,
        row.strain,
        row.pressure_mpa,
        row.temperature_c,
        row.used,
        row.residual,
        row.length_mm,
        row.length_sd_mm
    )
}

/// Inserts responses of compensators.
pub(super) const RESPONSES: &str = "INSERT INTO compensation_responses (compensation_id, t_us, ratio, deflection_mm, after_strain, before_strain, \
         before_origin, target_strain, target_origin) SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::float8[], \
         $4::float8[], $5::float8[], $6::float8[], $7::text[], $8::float8[], $9::text[]) WHERE OWNED";

pub(super) fn bind_responses(statement: Statement, responses: &[ResponseRow]) -> Statement {
    bind_each!(
        statement,
        responses,
        |row| row.compensation_id,
        row.t_us,
        row.ratio,
        row.deflection_mm,
        row.after_strain,
        row.before_strain,
        row.before_origin,
        row.target_strain,
        row.target_origin
    )
}

/// Inserts responses of compensators.
pub(in super::super) async fn append_responses(tx: &mut PgConnection, responses: &[ResponseRow]) -> sqlx::Result<()> {
    bind_responses(alone(RESPONSES), responses).execute(tx).await.map(drop)
}

/// Columns and values of the statement that inserts aggregates. Existing rows are left unchanged.
macro_rules! rollup_values {
    () => {
        "(whisker_id, start_us, contacts_used, contacts_learning, contacts_unused, residual_mean, residual_sd, \
         residual_min, residual_max, sensitivity_per_mm, ratio, length_mm, length_sd_mm, length_mean_mm, pressure_mpa, \
         temperature_c, compensation_error) \
         SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::int4[], $4::int4[], $5::int4[], $6::float4[], $7::float4[], \
         $8::float4[], $9::float4[], $10::float4[], $11::float4[], $12::float4[], $13::float4[], $14::float4[], \
         $15::float4[], $16::float4[], $17::float4[]) WHERE OWNED ON CONFLICT DO NOTHING RETURNING start_us"
    };
}

/// Inserts aggregates of minutes.
pub(super) const MINUTES: &str = concat!("INSERT INTO contact_minutes ", rollup_values!());

/// Inserts aggregates of hours.
pub(super) const HOURS: &str = concat!("INSERT INTO contact_hours ", rollup_values!());

pub(super) fn bind_rollups(statement: Statement, rows: &[&RollupRow]) -> Statement {
    bind_each!(
        statement,
        rows,
        |row| row.whisker_id,
        row.start_us,
        row.contacts[0],
        row.contacts[1],
        row.contacts[2],
        row.residual[0],
        row.residual[1],
        row.residual[2],
        row.residual[3],
        row.sensitivity_per_mm,
        row.ratio,
        row.length_mm,
        row.length_sd_mm,
        row.length_mean_mm,
        row.pressure_mpa,
        row.temperature_c,
        row.compensation_error
    )
}

/// Inserts aggregates of minutes or hours; returns the number of rows that did not exist before.
pub(in super::super) async fn append_rollups(
    tx: &mut PgConnection,
    resolution: Resolution,
    rows: &[&RollupRow],
) -> sqlx::Result<u64> {
    let sql = match resolution {
        Resolution::Minute => MINUTES,
        Resolution::Hour => HOURS,
    };
    bind_rollups(alone(sql), rows).execute(tx).await.map(|done| done.rows_affected())
}
