//! PostgreSQL's part of the store: sessions, `COPY`, and a statement for a whole transaction.

mod audit_log;
mod copy;
mod parts;
mod pooler;
mod replication;
mod role;
mod route;
mod sorted;
pub(super) mod whole;

use sqlx::postgres::{PgArguments, PgConnection, Postgres};

use super::StoreError;
use super::address::PostgresAddress;
use super::database::Pool;
use super::error::failed;

pub(super) use audit_log::protect as protect_audit_log;
pub(super) use copy::{are_copied, copy_contacts};
pub(super) use parts::COUNTED;
pub use replication::Replication;
pub(super) use route::Route;

/// A statement whose parameters are being bound.
pub(super) type Query = sqlx::query::Query<'static, Postgres, PgArguments>;

/// Version number of the oldest supported server (`server_version_num`).
const OLDEST: i32 = 150_000;

/// Connection pool for queries, and the servers; connections are opened when they are needed.
pub(super) fn open(address: &PostgresAddress, supervisor: &str) -> (Pool, Route) {
    let route = Route::new(address.clone().named(&format!("vibrissa {supervisor}")));
    (Pool::Postgres(route.pool().clone()), route)
}

/// A pool that is closed, and a way to no server.
pub(super) fn closed() -> (Pool, Route) {
    let (pool, route) = open(&PostgresAddress::nowhere(), "model");
    // It is closed from now on. There is no connection whose end must be awaited.
    drop(route.pool().close());
    (pool, route)
}

/// Finds the server that accepts writes, and checks that it is not too old and that sessions are whole.
pub(super) async fn check(route: &Route, database: &str) -> Result<(), StoreError> {
    let opened = |source| StoreError::Open { database: database.to_owned(), source };
    let mut link = route.connect().await.map_err(|none| none.keeping_closed(database))?;
    check_version(&mut link, database).await?;
    check_encoding(&mut link, database).await?;
    check_tables(&mut link, database).await?;
    let mut other = route.connect().await.map_err(|none| none.keeping_closed(database))?;
    if pooler::shares_sessions(&mut link, &mut other).await.map_err(opened)? {
        return Err(StoreError::SharedSessions { database: database.to_owned() });
    }
    Ok(())
}

/// Checks that the server is not too old.
async fn check_version(link: &mut PgConnection, database: &str) -> Result<(), StoreError> {
    let version: String = pooler::text(link, "SHOW server_version_num")
        .await
        .map_err(|source| StoreError::Open { database: database.to_owned(), source })?;
    if version.parse().is_ok_and(|version: i32| version < OLDEST) {
        let version = pooler::text(link, "SHOW server_version").await.map_err(failed("read the server's version"))?;
        return Err(StoreError::TooOld { database: database.to_owned(), version });
    }
    Ok(())
}

/// Checks that the database can store every text: names of robots, labels and notes.
async fn check_encoding(link: &mut PgConnection, database: &str) -> Result<(), StoreError> {
    let encoding = pooler::text(link, "SHOW server_encoding").await.map_err(failed("read the server's encoding"))?;
    if encoding == "UTF8" {
        return Ok(());
    }
    Err(StoreError::NotUtf8 { database: database.to_owned(), encoding })
}

/// Checks that no table is lost of a database that has been migrated.
async fn check_tables(link: &mut PgConnection, database: &str) -> Result<(), StoreError> {
    const IS_NEW: &str = "SELECT (to_regclass('_sqlx_migrations') IS NULL)::text";
    const LOST: &str = "SELECT coalesce((SELECT t FROM unnest(ARRAY['robots', 'whiskers', 'contacts', 'setpoints']) AS t \
         WHERE to_regclass(t) IS NULL AND EXISTS (SELECT FROM _sqlx_migrations WHERE success) LIMIT 1), '')";
    let looking = failed("look for the tables");
    if pooler::text(link, IS_NEW).await.map_err(looking)? == "true" {
        return Ok(());
    }
    let table = pooler::text(link, LOST).await.map_err(failed("look for the tables"))?;
    if table.is_empty() { Ok(()) } else { Err(StoreError::Incomplete { database: database.to_owned(), table }) }
}

/// Settings that a writer's session needs whatever the server's defaults are: an acknowledged commit is on the disk;
/// a supervisor that freezes within a transaction does not keep its lease's row locked for longer than half the
/// shortest time to live; a statement that hangs ends.
pub(super) async fn prepare_writer(link: &mut PgConnection) -> sqlx::Result<()> {
    for setting in [
        "SET synchronous_commit = on",
        "SET default_transaction_isolation = 'read committed'",
        "SET idle_in_transaction_session_timeout = '500ms'",
        "SET statement_timeout = '20s'",
        // The same few statements with access by keys are repeated, so each is planned once. Other plans are disabled
        // because the planner would choose them while the tables are empty.
        "SET plan_cache_mode = force_generic_plan",
        "SET enable_hashjoin = off",
        "SET enable_mergejoin = off",
        "SET enable_seqscan = off",
        "SET enable_material = off",
        "SET jit = off",
    ] {
        sqlx::query(setting).execute(&mut *link).await?;
    }
    Ok(())
}
