//! Lists of the REST API: filtered, sorted and paged by the database, over closed sets of columns.
//!
//! A [`List`] (see [`lists`](super::lists)) is a query with the columns that may sort it. A [`Selection`] is what a
//! request asks of it. Only values come from outside; columns and operators are part of the program.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;
use sqlx::{ColumnIndex, Database, Decode, Encode, FromRow, Postgres, QueryBuilder, Row, Sqlite, Type};

use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_edge::guidance::{BY_URGENCY, urgency};
use vibrissa_edge::labels::{LabelCondition, LabelConditions};
use vibrissa_edge::words::Word;

use super::database::Either;
use super::{Store, StoreError, failed};

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
    /// Columns that may sort the list; the first one is the default. None of them is ever null.
    pub sorts: &'static [Sort],
    /// A whole-numbered column with a unique value in each row, which breaks ties.
    pub id: &'static str,
}

/// A column that may sort a list.
#[derive(Debug, Clone, Copy)]
pub struct Sort {
    /// Name of the column in the query, which is also its name in requests.
    pub column: &'static str,
    /// Type of its values.
    pub kind: Kind,
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
pub enum Kind {
    /// Values are texts.
    Text,
    /// Values are integers.
    Whole,
    /// Values are floating-point numbers.
    Real,
}

/// A value to compare a column with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// An integer value.
    Whole(i64),
    /// A floating-point number.
    Real(f64),
    /// A boolean value.
    Flag(bool),
    /// A text value.
    Text(String),
}

impl Value {
    /// Whether it is a text with a NUL character, which PostgreSQL refuses.
    #[must_use]
    pub fn has_nul(&self) -> bool {
        matches!(self, Self::Text(text) if text.contains('\0'))
    }

    /// Whether the value has the type of a column.
    #[must_use]
    pub fn is_a(&self, kind: Kind) -> bool {
        match (self, kind) {
            (Self::Whole(_), Kind::Whole) | (Self::Real(_), Kind::Real) | (Self::Text(_), Kind::Text) => true,
            (Self::Whole(_) | Self::Real(_) | Self::Text(_) | Self::Flag(_), _) => false,
        }
    }
}

/// A condition that the rows of a selection must meet.
#[derive(Debug, Clone, PartialEq)]
pub enum Filter {
    /// The column equals the value.
    Is(&'static str, Value),
    /// The column equals one of the values; no row matches an empty list.
    IsOneOf(&'static str, Vec<String>),
    /// The column equals one of the numbers; no row matches an empty list.
    IsOneOfNumbers(&'static str, Vec<i64>),
    /// The column is at least the value.
    AtLeast(&'static str, Value),
    /// The column is less than the value.
    Below(&'static str, Value),
    /// The column is null (true), or is not (false).
    IsNull(&'static str, bool),
    /// The robot whose number is in the column has a label that meets the condition.
    HasLabel(&'static str, LabelCondition),
    /// At least one of the columns contains the text, in upper or lower case.
    Contains(&'static [&'static str], String),
    /// One of the conditions holds; none holds of an empty list.
    AnyOf(Vec<Filter>),
    /// The column is one of those that a query selects, of the rows of which at least one column contains the text.
    /// Faster than `Contains` where the names are in a shorter table.
    IsNamed {
        /// Column of the list.
        column: &'static str,
        /// Query of one column, without a condition.
        select: &'static str,
        /// Columns of the query's tables that are searched.
        names: &'static [&'static str],
        /// Text to look for.
        text: String,
    },
}

impl Filter {
    /// The conditions on the labels of the robot whose number is in a column.
    pub fn labels(column: &'static str, conditions: Option<&LabelConditions>) -> impl Iterator<Item = Self> {
        let all = conditions.into_iter().flat_map(LabelConditions::iter);
        all.map(move |condition| Self::HasLabel(column, condition.clone()))
    }
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

    /// Adds the condition that a column equals a number, if one is given.
    pub fn is_number(&mut self, column: &'static str, number: Option<impl Into<i64>>) {
        self.filters.extend(number.map(|number| Filter::Is(column, Value::Whole(number.into()))));
    }

    /// Adds the condition that at least one column contains a text, if one is given.
    pub fn contains(&mut self, columns: &'static [&'static str], text: Option<impl ToString>) {
        self.filters.extend(text.map(|text| Filter::Contains(columns, text.to_string())));
    }

    /// Adds the conditions on the labels of the robot whose number is in a column.
    pub fn has_labels(&mut self, column: &'static str, conditions: Option<&LabelConditions>) {
        self.filters.extend(Filter::labels(column, conditions));
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

/// Appends a value as a parameter.
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

/// Appends conditions to the WHERE clause of a statement.
pub(super) fn push_filters<DB: Database>(sql: &mut QueryBuilder<DB>, filters: &[Filter])
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    for filter in filters {
        sql.push(" AND ");
        push_filter(sql, filter);
    }
}

fn push_filter<DB: Database>(sql: &mut QueryBuilder<DB>, filter: &Filter)
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
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
        Filter::IsOneOfNumbers(column, values) => {
            sql.push(*column).push(" IN (NULL");
            for value in values {
                sql.push(", ").push_bind(*value);
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
        Filter::HasLabel(column, condition) => {
            sql.push(*column).push(" IN (SELECT robot_id FROM robots WHERE replace(").push(LABEL_LINES).push(", ");
            sql.push_bind(condition.needle()).push(", '') <> ").push(LABEL_LINES).push(")");
        }
        Filter::Contains(columns, text) => push_contains(sql, columns, text),
        Filter::IsNamed { column, select, names, text } => {
            sql.push(*column).push(" IN (").push(*select).push(" WHERE ");
            push_contains(sql, names, text);
            sql.push(")");
        }
        Filter::AnyOf(filters) => {
            sql.push("(false");
            for filter in filters {
                sql.push(" OR ");
                push_filter(sql, filter);
            }
            sql.push(")");
        }
    }
}

/// The labels of a robot, each between two line breaks. LIKE would not tell `Hall` from `hall` in SQLite.
const LABEL_LINES: &str = "'\n' || labels || '\n'";

/// Appends the condition that at least one column contains a text.
fn push_contains<DB: Database>(sql: &mut QueryBuilder<DB>, columns: &[&'static str], text: &str)
where
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let pattern = pattern(text);
    sql.push("(false");
    for column in columns {
        sql.push(" OR lower(").push(*column).push(") LIKE ").push_bind(pattern.clone()).push(" ESCAPE '!'");
    }
    sql.push(")");
}

/// The pattern of LIKE for a text in lower case anywhere in a column.
fn pattern(text: &str) -> String {
    let mut pattern = String::from("%");
    for letter in text.to_lowercase().chars() {
        if matches!(letter, '%' | '_' | '!') {
            pattern.push('!');
        }
        pattern.push(letter);
    }
    pattern.push('%');
    pattern
}

/// The place of conditions within a query.
const FILTERS: &str = "{filters}";

/// Appends a query, with conditions at the place that it has for them.
pub(super) fn push_select<DB: Database>(sql: &mut QueryBuilder<DB>, select: &str, filters: &[Filter])
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    // A number of this process, not of a client: whether times lie ahead is judged by this supervisor's clock.
    let now_us = vibrissa_edge::clock::wall_clock().0;
    let select = select.replace("{now_us}", &now_us.to_string()).replace("{urgency}", &URGENCY);
    match select.split_once(FILTERS) {
        None => drop(sql.push(select)),
        Some((before, after)) => {
            sql.push(before);
            push_filters(sql, filters);
            sql.push(after);
        }
    }
}

/// The place of the column `kind` in the order of alarms: greater is more urgent, and 0 is no kind of this program.
static URGENCY: LazyLock<String> = LazyLock::new(|| {
    let case = |kind: AlarmKind| format!(" WHEN '{}' THEN {}", kind.word(), urgency(kind));
    format!("CAST(CASE kind{} ELSE 0 END AS BIGINT)", BY_URGENCY.map(case).concat())
});

/// The statement of a selection after a text, which is empty or asks for the plan; it asks for one row more than the limit, to learn whether there is a next page.
fn statement<DB: Database>(list: &List, selection: &Selection, before: &str) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let mut sql = QueryBuilder::<DB>::new(format!("{before}SELECT q.*"));
    sql.push(list.details).push(" FROM (SELECT * FROM (");
    push_select(&mut sql, list.select, &selection.filters);
    sql.push(") q WHERE true");
    if !list.select.contains(FILTERS) {
        push_filters(&mut sql, &selection.filters);
    }
    let (sort, id) = (selection.sort.column, list.id);
    let (after, order) = if selection.descending { (" < (", " DESC") } else { (" > (", " ASC") };
    if let Some(position) = &selection.after {
        sql.push(" AND (").push(sort).push(", ").push(id).push(")").push(after);
        push_value(&mut sql, &position.value);
        sql.push(", ").push_bind(position.id).push(")");
    }
    let order = format!(" ORDER BY {sort}{order}, {id}{order}");
    sql.push(&order).push(" LIMIT ").push_bind(i64::from(selection.limit) + 1);
    sql.push(") q").push(&order);
    sql
}

/// Converts rows, without the one beyond the limit, which only shows that there is a next page.
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
        next: last.map(|row| position_of(row, selection.sort, list.id)).transpose()?,
        rows: shown.iter().map(T::from_row).collect::<sqlx::Result<_>>()?,
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
        Kind::Text => Value::Text(row.try_get(sort.column)?),
        Kind::Whole => Value::Whole(row.try_get(sort.column)?),
        Kind::Real => Value::Real(row.try_get(sort.column)?),
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
                sql.build().persistent(false).fetch_all(pool).await.and_then(|rows| rows_of(&rows, list, selection))
            }
            Either::Postgres(pool) => {
                let mut sql = statement::<Postgres>(list, selection, "");
                sql.build().persistent(false).fetch_all(pool).await.and_then(|rows| rows_of(&rows, list, selection))
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
