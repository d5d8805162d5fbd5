//! Lists that people ask for: filtered, sorted and paged by the database, over closed lists of columns.
//!
//! A [`List`] (they are in `lists`) is a query with the names of its columns that may sort it. What a request wants of it is a
//! [`Selection`]; only values come from outside, columns and operators are the program's own.

use serde::{Deserialize, Serialize};
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;
use sqlx::{ColumnIndex, Database, Decode, Encode, FromRow, Postgres, QueryBuilder, Row, Sqlite, Type};

use super::database::Either;
use super::{Store, StoreError, failed};

/// What a list is of and how it may be sorted.
#[derive(Debug)]
pub struct List {
    /// What it is for, for errors: `list the whiskers`.
    pub what: &'static str,
    /// The query, without order and limit; `{now_us}` in it is the moment of asking.
    pub select: &'static str,
    /// Its columns that may sort it; the first one does unless another is asked for. None may be null.
    pub sorts: &'static [Sort],
    /// A whole-numbered column that no two rows share.
    pub id: &'static str,
}

/// A column that may sort a list.
#[derive(Debug, Clone, Copy)]
pub struct Sort {
    /// Column of the query, and its name for people.
    pub column: &'static str,
    /// What it holds.
    pub kind: Kind,
    /// Whether the last comes first unless it is asked for otherwise.
    pub descending: bool,
}

/// Which way a list runs unless it is asked for otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// The least first.
    Up,
    /// The greatest or newest first.
    Down,
}

impl Way {
    /// Whether the greatest comes first.
    #[must_use]
    pub const fn is_descending(self) -> bool {
        matches!(self, Self::Down)
    }
}

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A text.
    Text,
    /// A whole number.
    Whole,
    /// A number.
    Real,
}

/// A value to compare a column with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// A whole number.
    Whole(i64),
    /// A number.
    Real(f64),
    /// A truth value.
    Flag(bool),
    /// A text.
    Text(String),
}

impl Value {
    /// Whether it is a text with a NUL character, which PostgreSQL does not take.
    #[must_use]
    pub fn has_nul(&self) -> bool {
        matches!(self, Self::Text(text) if text.contains('\0'))
    }

    /// Whether it is what such a column holds.
    #[must_use]
    pub fn is_a(&self, kind: Kind) -> bool {
        match (self, kind) {
            (Self::Whole(_), Kind::Whole) | (Self::Real(_), Kind::Real) | (Self::Text(_), Kind::Text) => true,
            (Self::Whole(_) | Self::Real(_) | Self::Text(_) | Self::Flag(_), _) => false,
        }
    }
}

/// What rows must be to be in the list.
#[derive(Debug, Clone, PartialEq)]
pub enum Filter {
    /// The column is this.
    Is(&'static str, Value),
    /// The column is one of these; of none if there are none.
    IsOneOf(&'static str, Vec<String>),
    /// The column is at least this.
    AtLeast(&'static str, Value),
    /// The column is below this.
    Below(&'static str, Value),
    /// The column is null, or is not.
    IsNull(&'static str, bool),
}

/// Where the last page ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// The sorting column's value.
    pub value: Value,
    /// The row's number.
    pub id: i64,
}

/// What a request wants of a list.
#[derive(Debug, Clone)]
pub struct Selection {
    /// All of them must hold.
    pub filters: Vec<Filter>,
    /// One of the list's.
    pub sort: Sort,
    /// The last first.
    pub descending: bool,
    /// Only what comes after this.
    pub after: Option<Place>,
    /// Rows at the most.
    pub limit: u32,
}

impl Selection {
    /// Everything, in the list's own order.
    #[must_use]
    pub fn all(list: &List, limit: u32) -> Self {
        let sort = list.sorts[0];
        Self { filters: Vec::new(), sort, descending: sort.descending, after: None, limit }
    }

    /// Keeps to rows whose column has that text, if there is one.
    pub fn is(&mut self, column: &'static str, text: Option<impl ToString>) {
        self.filters.extend(text.map(|text| Filter::Is(column, Value::Text(text.to_string()))));
    }

    /// Keeps to rows whose column has that number, if there is one.
    pub fn is_number(&mut self, column: &'static str, number: Option<impl Into<i64>>) {
        self.filters.extend(number.map(|number| Filter::Is(column, Value::Whole(number.into()))));
    }

    /// With one more filter.
    #[must_use]
    pub fn with(mut self, filter: Filter) -> Self {
        self.filters.push(filter);
        self
    }
}

/// Rows, and where they end if there are more.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows<T> {
    /// At most the limit.
    pub rows: Vec<T>,
    /// Where the next ones begin.
    pub next: Option<Place>,
}

/// Adds a value, as a parameter.
fn push_value<DB: Database>(sql: &mut QueryBuilder<DB>, value: &Value)
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    match value {
        Value::Whole(value) => sql.push_bind(*value),
        Value::Real(value) => sql.push_bind(*value),
        Value::Flag(value) => sql.push_bind(*value),
        Value::Text(value) => sql.push_bind(value.clone()),
    };
}

/// Adds conditions to those of a statement.
pub(super) fn push_filters<DB: Database>(sql: &mut QueryBuilder<DB>, filters: &[Filter])
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    for filter in filters {
        sql.push(" AND ");
        match filter {
            Filter::Is(column, value) => {
                sql.push(*column).push(" = ");
                push_value(sql, value);
            }
            Filter::IsOneOf(column, values) => {
                sql.push(*column).push(" IN (NULL");
                for value in values {
                    sql.push(", ").push_bind(value.clone());
                }
                sql.push(")");
            }
            Filter::AtLeast(column, value) => {
                sql.push(*column).push(" >= ");
                push_value(sql, value);
            }
            Filter::Below(column, value) => {
                sql.push(*column).push(" < ");
                push_value(sql, value);
            }
            Filter::IsNull(column, is_null) => {
                sql.push(*column).push(if *is_null { " IS NULL" } else { " IS NOT NULL" });
            }
        }
    }
}

/// The statement for a selection.
fn statement<DB: Database>(list: &List, selection: &Selection) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new("SELECT * FROM (");
    // A number of ours: what lies ahead is told by the clock of the supervisor that is asked.
    let now_us = vibrissa_edge::clock::wall_clock().0;
    sql.push(list.select.replace("{now_us}", &now_us.to_string())).push(") q WHERE true");
    push_filters(&mut sql, &selection.filters);
    let (sort, id) = (selection.sort.column, list.id);
    let (after, order) = if selection.descending { (" < (", " DESC") } else { (" > (", " ASC") };
    if let Some(place) = &selection.after {
        sql.push(" AND (").push(sort).push(", ").push(id).push(")").push(after);
        push_value(&mut sql, &place.value);
        sql.push(", ").push_bind(place.id).push(")");
    }
    sql.push(" ORDER BY ").push(sort).push(order).push(", ").push(id).push(order);
    sql.push(" LIMIT ").push_bind(i64::from(selection.limit) + 1);
    sql
}

/// What the rows are, and where they end if there are more than the limit.
fn rows_of<T, R: Row>(rows: &[R], list: &List, selection: &Selection) -> sqlx::Result<Rows<T>>
where
    T: for<'r> FromRow<'r, R>,
    &'static str: ColumnIndex<R>,
    i64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    f64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    String: for<'r> Decode<'r, R::Database> + Type<R::Database>,
{
    let limit = selection.limit as usize;
    let shown = &rows[..rows.len().min(limit)];
    let last = shown.last().filter(|_| rows.len() > limit);
    Ok(Rows {
        next: last.map(|row| place_of(row, selection.sort, list.id)).transpose()?,
        rows: shown.iter().map(T::from_row).collect::<sqlx::Result<_>>()?,
    })
}

/// Where a row stands.
fn place_of<R: Row>(row: &R, sort: Sort, id: &'static str) -> sqlx::Result<Place>
where
    &'static str: ColumnIndex<R>,
    i64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    f64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    String: for<'r> Decode<'r, R::Database> + Type<R::Database>,
{
    let value = match sort.kind {
        Kind::Text => Value::Text(row.try_get(sort.column)?),
        Kind::Whole => Value::Whole(row.try_get(sort.column)?),
        Kind::Real => Value::Real(row.try_get(sort.column)?),
    };
    Ok(Place { value, id: row.try_get(id)? })
}

impl Store {
    /// What is selected of a list.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn list<T>(&self, list: &List, selection: &Selection) -> Result<Rows<T>, StoreError>
    where
        T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin,
    {
        let rows = match &self.pool {
            Either::Sqlite(pool) => {
                let mut sql = statement::<Sqlite>(list, selection);
                sql.build().persistent(false).fetch_all(pool).await.and_then(|rows| rows_of(&rows, list, selection))
            }
            Either::Postgres(pool) => {
                let mut sql = statement::<Postgres>(list, selection);
                sql.build().persistent(false).fetch_all(pool).await.and_then(|rows| rows_of(&rows, list, selection))
            }
        };
        rows.map_err(failed(list.what))
    }

    /// The one row that a selection has, if there is one.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn first<T>(&self, list: &List, filters: Vec<Filter>) -> Result<Option<T>, StoreError>
    where
        T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin,
    {
        let selection = Selection { filters, ..Selection::all(list, 1) };
        Ok(self.list(list, &selection).await?.rows.into_iter().next())
    }
}
