//! What is PostgreSQL's own: the session, one statement for many rows, and one for a whole transaction.

mod copy;
mod parts;
mod rows;
mod sorted;
pub(super) mod whole;

use sqlx::postgres::{PgConnection, PgPool, PgPoolOptions};

use super::StoreError;
use super::address::PostgresAddress;
use super::database::{ACQUIRE_PATIENCE, Either, Options, Pool};
use super::error::failed;

pub(super) use copy::append_contacts;
pub(super) use parts::{COUNTED, kept};
pub(super) use rows::{Statement, append_responses, append_rollups, write_robots, write_whiskers};

/// The oldest server, as it numbers its versions.
const OLDEST: i32 = 150_000;

/// Connections for reading, made when they are needed.
pub(super) fn open(address: &PostgresAddress, supervisor: &str) -> (Pool, Options) {
    let address = address.clone().named(&format!("vibrissa {supervisor}"));
    let pool =
        PgPoolOptions::new().max_connections(5).acquire_timeout(ACQUIRE_PATIENCE).connect_lazy_with((*address).clone());
    (Pool::Postgres(pool.clone()), Either::Postgres((address, pool)))
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
        // The same few statements again and again, by keys: they are planned once, and not for the tables being empty.
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
