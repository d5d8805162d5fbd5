//! Aggregates over groups of a list's newest rows.

use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;
use sqlx::{Database, Encode, FromRow, Postgres, QueryBuilder, Sqlite, Type};

use super::database::Either;
use super::list::{Filter, List, push_filters};
use super::{Store, StoreError, failed};

/// A grouping of a list of measured errors.
#[derive(Debug)]
pub struct Group {
    /// The list whose rows are grouped.
    pub of: &'static List,
    /// Columns of the result, over the selected rows `g`.
    pub columns: &'static str,
    /// Further tables to join, or empty.
    pub from: &'static str,
    /// Columns that define a group.
    pub by: &'static str,
    /// Order of the groups.
    pub order: &'static str,
}

/// Most rows that are grouped; if there are more, the newest ones are.
pub const ROWS_GROUPED_MAX: i64 = 200_000;
/// Most groups of an answer.
pub const GROUPS_MAX: i64 = 1000;

/// The statement. Of each compensation, only the newest row in each span of time counts.
fn statement<DB: Database>(group: &Group, filters: &[Filter], bucket_us: i64) -> QueryBuilder<DB>
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let id = group.of.id;
    let mut sql = QueryBuilder::<DB>::new("SELECT ");
    sql.push(group.columns)
        .push(" FROM (SELECT b.*, row_number() OVER (PARTITION BY compensation_id, bucket ORDER BY ");
    sql.push(id).push(" DESC) AS newest FROM (SELECT f.*, recorded_at / bucket_us AS bucket FROM (SELECT q.*, ");
    // PostgreSQL infers a parameter's type from its first use, hence the cast.
    sql.push("CAST(").push_bind(bucket_us).push(" AS BIGINT) AS bucket_us FROM (");
    sql.push(group.of.select).push(") q WHERE true");
    push_filters(&mut sql, filters);
    sql.push(" ORDER BY ").push(id).push(" DESC LIMIT ").push_bind(ROWS_GROUPED_MAX).push(") f) b) g");
    sql.push(group.from).push(" WHERE newest = 1 GROUP BY ").push(group.by);
    sql.push(" ORDER BY ").push(group.order).push(" LIMIT ").push_bind(GROUPS_MAX);
    sql
}

impl Store {
    /// The groups of the rows that pass the filters. Of each compensation, only the newest row in each span of
    /// `bucket_us` µs counts.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn groups<T>(&self, group: &Group, filters: &[Filter], bucket_us: i64) -> Result<Vec<T>, StoreError>
    where
        T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin,
    {
        match &self.pool {
            Either::Sqlite(pool) => {
                let mut sql = statement::<Sqlite>(group, filters, bucket_us);
                sql.build_query_as().persistent(false).fetch_all(pool).await
            }
            Either::Postgres(pool) => {
                let mut sql = statement::<Postgres>(group, filters, bucket_us);
                sql.build_query_as().persistent(false).fetch_all(pool).await
            }
        }
        .map_err(failed(group.of.what))
    }
}
