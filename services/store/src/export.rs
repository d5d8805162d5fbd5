//! Rows for export: contacts, aggregates, decisions and errors by fleet and time, one after the other.
//!
//! The rows come in the order in which the database stores them: it need not sort, and a reader needs memory for one row
//! only. An [`ExportTable`] declares the columns of its query with their types.

use futures_util::TryStreamExt as _;
use sqlx::{ColumnIndex, Database, Decode, Encode, Postgres, QueryBuilder, Row, Sqlite, Type};

use vibrissa_edge::fleets::FleetPattern;

use super::database::Either;
use super::list::{Filter, Value, push_filters};
use super::lists::compensations::COMPENSATIONS;
use super::lists::errors::ERRORS;
use super::lists::history::{HOURS, MINUTES};
use super::{Store, StoreError, failed};

/// A table that can be exported.
#[derive(Debug)]
pub struct ExportTable {
    /// Name for people and for the command line.
    pub name: &'static str,
    /// Purpose of the query, for errors.
    what: &'static str,
    /// Query whose rows have all columns.
    pub(super) select: &'static str,
    /// Whether the query names whiskers by `whisker_id` only, so that their names are added.
    lacks_names: bool,
    /// Column with the time of a row.
    at: &'static str,
    /// Columns in order.
    pub columns: &'static [ExportColumn],
}

/// A column of an exported table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExportColumn {
    /// Name, with the unit last.
    pub name: &'static str,
    /// Type of its values.
    pub kind: ExportKind,
    /// Whether values may be missing.
    pub nullable: bool,
}

/// Type of the values of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExportKind {
    /// Texts in UTF-8.
    Text,
    /// Whole numbers of 64 bits.
    Whole,
    /// Floating-point numbers of 64 bits.
    Real,
    /// Times, µs since 1970 UTC.
    Time,
}

/// A value of an exported row.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// An empty cell.
    Null,
    /// A text in UTF-8.
    Text(String),
    /// A whole number.
    Whole(i64),
    /// A floating-point number.
    Real(f64),
    /// A time, µs since 1970 UTC.
    Time(i64),
}

/// Selection of the rows to export.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Which {
    /// Fleets by names and patterns; all if empty.
    pub fleets: Vec<FleetPattern>,
    /// Earliest time, inclusive, µs since 1970 UTC.
    pub from_us: Option<i64>,
    /// Latest time, exclusive, µs since 1970 UTC.
    pub to_us: Option<i64>,
}

/// Declares columns: `name Kind`, and `name Kind or null` for one whose values may be missing.
macro_rules! columns {
    ($($name:ident $kind:ident $(or $null:ident)?),+ $(,)?) => {
        &[$(ExportColumn {
            name: stringify!($name),
            kind: ExportKind::$kind,
            nullable: is_nullable(&[$(stringify!($null))?]),
        }),+]
    };
}

const fn is_nullable(names: &[&str]) -> bool {
    !names.is_empty()
}

/// Contacts. `at` is the robot's clock, `received_at` the supervisor's; `used` says what the contact was used for, and
/// `residual` is ln(measured / predicted sensitivity).
pub static CONTACTS: ExportTable = ExportTable {
    name: "contacts",
    what: "read the contacts",
    select: "SELECT fleet, robot, \"array\", w.whisker, c.t_us AS at, c.received_us AS received_at, b.boot_id, c.seq, \
             c.position, c.place, c.ratio, c.distance_mm, c.deflection_mm, c.strain, c.pressure_mpa, c.temperature_c, \
             c.used, c.residual, c.length_mm, c.length_sd_mm \
             FROM contacts c JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id LEFT JOIN boots b ON b.boot = c.boot",
    lacks_names: false,
    at: "at",
    columns: columns![
        fleet Text, robot Text, array Text, whisker Whole, at Time, received_at Time, boot_id Text or null, seq Whole,
        position Whole, place Text, ratio Real or null, distance_mm Real or null, deflection_mm Real, strain Real, pressure_mpa Real,
        temperature_c Real or null, used Text, residual Real or null, length_mm Real, length_sd_mm Real,
    ],
};

/// Columns of minutes and hours, whose meaning is that of the REST API.
const ROLLUP: &[ExportColumn] = columns![
    fleet Text, robot Text, array Text, whisker Whole, start_at Time, contacts_used Whole, contacts_learning Whole,
    contacts_unused Whole, residual_mean Real or null, residual_sd Real or null, residual_min Real or null, residual_max Real or null,
    sensitivity_per_mm Real or null, ratio Real or null, length_mm Real or null, length_sd_mm Real or null, length_mean_mm Real or null, pressure_mpa Real or null,
    temperature_c Real or null, compensation_error Real or null,
];

/// All tables that can be exported.
pub static EXPORTS: [&ExportTable; 5] = [
    &CONTACTS,
    &ExportTable {
        name: "minutes",
        what: "read the minutes",
        select: MINUTES.select,
        lacks_names: true,
        at: "start_at",
        columns: ROLLUP,
    },
    &ExportTable {
        name: "hours",
        what: "read the hours",
        select: HOURS.select,
        lacks_names: true,
        at: "start_at",
        columns: ROLLUP,
    },
    &ExportTable {
        name: "decisions",
        what: "read the decisions",
        select: COMPENSATIONS.select,
        lacks_names: false,
        at: "decided_at",
        columns: columns![
            compensation_id Whole, fleet Text, robot Text, array Text, target_whisker Whole, target_length_mm Real,
            target_pressure_mpa Real, compensator_whisker Whole or null, approval Text, compensation_case Text or null,
            pressure_before_mpa Real or null, pressure_mpa Real or null, predicted_error Real or null, predicted_error_low Real or null,
            predicted_error_high Real or null, held_pressure_mpa Real or null, candidate_count Whole, look_count Whole, last_look Text or null,
            measured_error Real or null, measured_error_low Real or null, measured_error_high Real or null, measured_pressure_mpa Real or null,
            measured_error_with_gain Real or null, measured_error_with_gain_low Real or null, measured_error_with_gain_high Real or null,
            measured_air_error Real or null, measured_air_error_low Real or null, measured_air_error_high Real or null,
            measured_bins Whole or null, measured_contacts Whole or null, measured_at Time or null, setpoint_state Text or null,
            setpoint_error Text or null, decided_at Time, ended_at Time or null, end_reason Text or null,
        ],
    },
    &ExportTable {
        name: "errors",
        what: "read the errors",
        select: ERRORS.select,
        lacks_names: false,
        at: "recorded_at",
        columns: columns![
            compensation_error_id Whole, compensation_id Whole, fleet Text, robot Text, array Text, target_whisker Whole,
            compensator_whisker Whole or null, compensation_case Text or null, recorded_at Time, contacts Whole, bins Whole,
            pressure_mpa Real or null, error Real, error_low Real, error_high Real, error_with_gain Real or null,
            error_with_gain_low Real or null, error_with_gain_high Real or null, air_error Real or null,
            air_error_low Real or null, air_error_high Real or null,
        ],
    },
];

impl ExportTable {
    fn filters(&self, which: &Which) -> Vec<Filter> {
        let from = which.from_us.map(|from_us| Filter::AtLeast(self.at, Value::Whole(from_us)));
        let to = which.to_us.map(|to_us| Filter::Below(self.at, Value::Whole(to_us)));
        let fleets = Some(&which.fleets).filter(|fleets| !fleets.is_empty());
        let fleets = fleets.map(|fleets| Filter::fleets("fleet", fleets));
        from.into_iter().chain(to).chain(fleets).collect()
    }

    /// The statement that reads `what` of the rows.
    fn statement<DB: Database>(&self, what: &str, which: &Which) -> QueryBuilder<DB>
    where
        i64: for<'q> Encode<'q, DB> + Type<DB>,
        f64: for<'q> Encode<'q, DB> + Type<DB>,
        bool: for<'q> Encode<'q, DB> + Type<DB>,
        String: for<'q> Encode<'q, DB> + Type<DB>,
    {
        let mut sql = QueryBuilder::<DB>::new("SELECT ");
        sql.push(what).push(" FROM (");
        if self.lacks_names {
            sql.push("SELECT fleet, robot, \"array\", w.whisker, m.* FROM (").push(self.select).push(
                ") m JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
                 JOIN robots r ON r.robot_id = w.robot_id",
            );
        } else {
            sql.push(self.select);
        }
        sql.push(") q WHERE true");
        push_filters(&mut sql, &self.filters(which));
        sql
    }
}

pub(super) fn cell<R: Row>(row: &R, column: &ExportColumn) -> sqlx::Result<Cell>
where
    &'static str: ColumnIndex<R>,
    i64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    f64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    String: for<'r> Decode<'r, R::Database> + Type<R::Database>,
{
    let name = column.name;
    let cell = match column.kind {
        ExportKind::Text => row.try_get::<Option<String>, _>(name)?.map(Cell::Text),
        ExportKind::Whole => row.try_get::<Option<i64>, _>(name)?.map(Cell::Whole),
        ExportKind::Real => row.try_get::<Option<f64>, _>(name)?.map(Cell::Real),
        ExportKind::Time => row.try_get::<Option<i64>, _>(name)?.map(Cell::Time),
    };
    Ok(cell.unwrap_or(Cell::Null))
}

impl Store {
    /// Number of rows that an export has at present.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn count_export(&self, table: &ExportTable, which: &Which) -> Result<u64, StoreError> {
        const COUNT: &str = "count(*)";
        let count: sqlx::Result<i64> = match &self.pool {
            Either::Sqlite(pool) => {
                table.statement::<Sqlite>(COUNT, which).build_query_scalar().persistent(false).fetch_one(pool).await
            }
            Either::Postgres(pool) => {
                table.statement::<Postgres>(COUNT, which).build_query_scalar().persistent(false).fetch_one(pool).await
            }
        };
        Ok(count.map_err(failed(table.what))?.unsigned_abs())
    }

    /// Reads all rows of an export, and gives each to a function.
    ///
    /// # Errors
    /// The database cannot be read, or the function fails.
    pub async fn export<E: From<StoreError>>(
        &self,
        table: &ExportTable,
        which: &Which,
        mut each: impl FnMut(Vec<Cell>) -> Result<(), E>,
    ) -> Result<(), E> {
        // The two arms differ in their types only.
        macro_rules! stream {
            ($pool:expr, $database:ty) => {{
                let mut sql = table.statement::<$database>("*", which);
                let mut rows = sql.build().persistent(false).fetch($pool);
                while let Some(row) = rows.try_next().await.map_err(failed(table.what))? {
                    let cells: sqlx::Result<Vec<Cell>> =
                        table.columns.iter().map(|column| cell(&row, column)).collect();
                    each(cells.map_err(failed(table.what))?)?;
                }
            }};
        }
        match &self.pool {
            Either::Sqlite(pool) => stream!(pool, Sqlite),
            Either::Postgres(pool) => stream!(pool, Postgres),
        }
        Ok(())
    }
}
