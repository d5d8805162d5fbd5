//! Lists of the REST API: filtered, sorted and paged by the database, over closed sets of columns.
//!
//! A [`List`] (see [`lists`](super::lists)) is a query with the columns that may sort it. A [`Selection`] is what a
//! request asks of it: conditions of [`filter`], an order, and a page. [`statement`] makes the SQL of both. Only values come
//! from outside; columns and operators are part of the program.

mod filter;
mod statement;

use serde::{Deserialize, Serialize};
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;
use sqlx::{ColumnIndex, Decode, FromRow, Postgres, Row, Sqlite, Type};

use vibrissa_edge::fleets::FleetSelection;

use super::database::Either;
use super::set_aside::{SetAside, Tried};
use super::{Store, StoreError, failed};

pub(super) use filter::push_filters;
pub use filter::{Filter, Value};
use statement::statement;

/// A query whose rows can be filtered, sorted and paged.
#[derive(Debug)]
pub struct List {
    /// Purpose of the query, for errors: `list the whiskers`.
    pub what: &'static str,
    /// The query, without order and limit. In it `{now_us}` is replaced by the present time, µs since 1970 UTC, `{urgency}`
    /// by the place of `kind` in the order of alarms, and `{filters}` by conditions that begin with AND. Without `{filters}`
    /// the conditions apply to the query's rows.
    pub select: &'static str,
    /// More columns, each after a comma, that are computed for the rows of a page alone, from the columns of `q`. They
    /// cannot filter or sort.
    pub details: &'static str,
    /// Narrower queries of some of the rows' columns, the narrowest first. The first that has all columns of a selection's
    /// conditions and order chooses the rows of the page, so that the database reads the other tables for these rows alone.
    pub keys: &'static [Keys],
    /// Columns that may sort the list; the first one is the default. None of them is ever null.
    pub sorts: &'static [Sort],
    /// A whole-numbered column with a unique value in each row, which breaks ties.
    pub id: &'static str,
}

/// A query of the same rows as a list, with few columns.
#[derive(Debug)]
pub struct Keys {
    /// The query, with the list's `id` and the columns below.
    pub select: &'static str,
    /// Columns by which it can filter and sort.
    pub columns: &'static [&'static str],
}

/// A column that may sort a list.
#[derive(Debug, Clone, Copy)]
pub struct Sort {
    /// Name of the column in the query, which is also its name in requests.
    pub column: &'static str,
    /// Type of its values.
    pub kind: ColumnKind,
    /// Whether the greatest value comes first by default.
    pub descending: bool,
}

/// Default direction of a sort.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// Ascending: the least first.
    Up,
    /// Descending: the greatest or newest first.
    Down,
}

impl Way {
    /// Whether the greatest value comes first.
    #[must_use]
    pub const fn is_descending(self) -> bool {
        matches!(self, Self::Down)
    }
}

/// Type of a column's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Values are texts.
    Text,
    /// Values are integers.
    Whole,
    /// Values are floating-point numbers.
    Real,
}

/// Position in a sorted list: the last row of a page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Position {
    /// Value of the sorting column.
    pub value: Value,
    /// Value of the list's `id` column.
    pub id: i64,
}

/// Filters, order and page of a list.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Conditions, all of which must hold.
    pub filters: Vec<Filter>,
    /// Column to sort by, one of the list's.
    pub sort: Sort,
    /// Whether the greatest value comes first.
    pub descending: bool,
    /// Position after which the page begins; `None` for the first page.
    pub after: Option<Position>,
    /// Most rows of the page.
    pub limit: u32,
}

impl Selection {
    /// The first `limit` rows of a list, in its default order.
    #[must_use]
    pub fn all(list: &List, limit: u32) -> Self {
        let sort = list.sorts[0];
        Self { filters: Vec::new(), sort, descending: sort.descending, after: None, limit }
    }

    /// Adds the condition that a column equals a text, if one is given.
    pub fn is(&mut self, column: &'static str, text: Option<impl ToString>) {
        self.filters.extend(text.map(|text| Filter::Is(column, Value::Text(text.to_string()))));
    }

    /// Adds the condition that the column `fleet` is one of these fleets, if some are given.
    pub fn of_fleets(&mut self, fleets: Option<&FleetSelection>) {
        self.filters.extend(fleets.map(|fleets| Filter::fleets("fleet", fleets.iter())));
    }

    /// Adds the condition that a column equals a number, if one is given.
    pub fn is_number(&mut self, column: &'static str, number: Option<impl Into<i64>>) {
        self.filters.extend(number.map(|number| Filter::Is(column, Value::Whole(number.into()))));
    }

    /// Adds the condition that at least one column contains a text, if one is given.
    pub fn contains(&mut self, columns: &'static [&'static str], text: Option<impl ToString>) {
        self.filters.extend(text.map(|text| Filter::Contains(columns, text.to_string())));
    }

    /// Adds a condition.
    #[must_use]
    pub fn with(mut self, filter: Filter) -> Self {
        self.filters.push(filter);
        self
    }
}

/// A row of a list, which both databases can read.
pub trait Listed: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin {}

impl<T> Listed for T where T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin {}

/// A page of rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows<T> {
    /// Rows, at most as many as the limit.
    pub rows: Vec<T>,
    /// Position after which the next page begins; `None` if this is the last page.
    pub next: Option<Position>,
}

/// Converts the readable rows, without the one beyond the limit, which only shows that there is a next page.
fn rows_of<T, R: Row>(rows: &[R], (list, selection): (&List, &Selection), set_aside: &SetAside) -> sqlx::Result<Rows<T>>
where
    T: for<'r> FromRow<'r, R>,
    &'static str: ColumnIndex<R>,
    usize: ColumnIndex<R>,
    i64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    f64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    String: for<'r> Decode<'r, R::Database> + Type<R::Database>,
{
    let limit = selection.limit as usize;
    let shown = &rows[..rows.len().min(limit)];
    let last = shown.last().filter(|_| rows.len() > limit);
    let tried = |row: &R| Tried::from_row(row).map(|tried| tried.named(list.id, row.try_get(list.id).ok()));
    let tried = shown.iter().map(tried).collect::<sqlx::Result<_>>()?;
    Ok(Rows {
        next: last.map(|row| position_of(row, selection.sort, list.id)).transpose()?,
        rows: set_aside.readable(list.what.trim_start_matches("list the "), tried),
    })
}

/// Position of a row in a sorted list.
fn position_of<R: Row>(row: &R, sort: Sort, id: &'static str) -> sqlx::Result<Position>
where
    &'static str: ColumnIndex<R>,
    i64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    f64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    String: for<'r> Decode<'r, R::Database> + Type<R::Database>,
{
    let value = match sort.kind {
        ColumnKind::Text => Value::Text(row.try_get(sort.column)?),
        ColumnKind::Whole => Value::Whole(row.try_get(sort.column)?),
        ColumnKind::Real => Value::Real(row.try_get(sort.column)?),
    };
    Ok(Position { value, id: row.try_get(id)? })
}

impl Store {
    /// Reads a page of a list.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn list<T: Listed>(&self, list: &List, selection: &Selection) -> Result<Rows<T>, StoreError> {
        let rows = match &self.pool {
            Either::Sqlite(pool) => {
                let mut sql = statement::<Sqlite>(list, selection, "");
                sql.build()
                    .persistent(false)
                    .fetch_all(pool)
                    .await
                    .and_then(|rows| rows_of(&rows, (list, selection), &self.set_aside))
            }
            Either::Postgres(pool) => {
                let mut sql = statement::<Postgres>(list, selection, "");
                sql.build()
                    .persistent(false)
                    .fetch_all(pool)
                    .await
                    .and_then(|rows| rows_of(&rows, (list, selection), &self.set_aside))
            }
        };
        rows.map_err(failed(list.what))
    }

    /// How the database would read a page of a list: one line for each step, with the names of the indices.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn plan(&self, list: &List, selection: &Selection) -> Result<Vec<String>, StoreError> {
        match &self.pool {
            Either::Sqlite(pool) => {
                let mut sql = statement::<Sqlite>(list, selection, "EXPLAIN QUERY PLAN ");
                let rows = sql.build().persistent(false).fetch_all(pool).await;
                rows.and_then(|rows| rows.iter().map(|row| row.try_get("detail")).collect())
            }
            Either::Postgres(pool) => {
                let mut sql = statement::<Postgres>(list, selection, "EXPLAIN ");
                let rows = sql.build().persistent(false).fetch_all(pool).await;
                rows.and_then(|rows| rows.iter().map(|row| row.try_get(0)).collect())
            }
        }
        .map_err(failed(list.what))
    }

    /// Reads the first row that passes the filters, if there is one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn first<T: Listed>(&self, list: &List, filters: Vec<Filter>) -> Result<Option<T>, StoreError> {
        let selection = Selection { filters, ..Selection::all(list, 1) };
        Ok(self.list(list, &selection).await?.rows.into_iter().next())
    }
}
