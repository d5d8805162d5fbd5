//! Detects a connection pooler that lets several clients share a session, such as PgBouncer in transaction mode.
//!
//! A writer relies on its session: settings, prepared statements and advisory locks belong to it. Two sessions without
//! such a pooler never have the same server process, and none changes it.

use std::time::Duration;

use sqlx::postgres::PgConnection;
use sqlx::{Executor, Row};
use tokio::time::timeout;

/// Number of comparisons. Other clients of the pooler may take the process between two queries, so one may not suffice.
const ROUNDS: usize = 5;
/// Time limit of a query. A pooler in session mode may have no free server process for the second session: then it is
/// not shared.
const PATIENCE: Duration = Duration::from_secs(1);

/// Whether two open sessions have used the same server process, or one has used two.
pub(super) async fn shares_sessions(one: &mut PgConnection, other: &mut PgConnection) -> sqlx::Result<bool> {
    let mut before = None;
    for _ in 0..ROUNDS {
        let first = process(one).await?;
        let Ok(second) = timeout(PATIENCE, process(other)).await else { return Ok(false) };
        let now = (first, second?);
        if now.0 == now.1 || before.is_some_and(|before| before != now) {
            return Ok(true);
        }
        before = Some(now);
    }
    Ok(false)
}

async fn process(link: &mut PgConnection) -> sqlx::Result<String> {
    text(link, "SELECT pg_backend_pid()::text").await
}

/// A text that the server answers. The query is sent without a prepared statement, which a pooler may refuse.
pub(super) async fn text(link: &mut PgConnection, sql: &'static str) -> sqlx::Result<String> {
    link.fetch_one(sqlx::raw_sql(sql)).await?.try_get(0)
}
