//! The intent log (table `redo`): a batch is first committed as one row of bytes, and its rows follow later.

use sqlx::Row;
use tokio::time::Instant;

use super::database::{Either, Link, Tx, on};
use super::{Lease, StoreError, Writer, failed, postgres};
use crate::fault::{self, Fault};

/// Time limit for one attempt.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(10);

impl Writer {
    /// Commits a serialized batch as one row under `number`, unless an earlier attempt was committed and only its
    /// answer was lost. The batch is durable from then on; [`Self::commit`] writes its rows, here or at whichever
    /// supervisor recovers the shard.
    ///
    /// # Errors
    /// The database cannot be written now, or the lease is lost.
    pub async fn write_intent(&mut self, lease: &Lease, number: i64, rows: &[u8]) -> Result<(), StoreError> {
        self.attempt("commit", PATIENCE, async |link| write(link, lease, number, rows).await).await
    }

    /// The shard's oldest intent whose rows are not written, with its number.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn pending_intent(&mut self, lease: &Lease) -> Result<Option<(i64, Vec<u8>)>, StoreError> {
        const WHAT: &str = "read the intent log";
        const SQL: &str = "SELECT number, rows FROM redo WHERE fleet = $1 AND shard = $2 ORDER BY number LIMIT 1";
        self.attempt(WHAT, PATIENCE, async |link| {
            on!(link, |link| sqlx::query_as(SQL)
                .bind(lease.fleet().as_str())
                .bind(lease.shard_number())
                .fetch_optional(link)
                .await)
            .map_err(failed(WHAT))
        })
        .await
    }
}

async fn write(link: &mut Link, lease: &Lease, number: i64, rows: &[u8]) -> Result<(), StoreError> {
    let asked = Instant::now();
    if let Either::Postgres(link) = link
        && !fault::is(Fault::NoFence)
    {
        let statement = lease.bind(sqlx::query(postgres::intent()), None);
        let statement = statement.bind(lease.fleet().as_str()).bind(lease.shard_number()).bind(number).bind(rows);
        let row = statement.fetch_one(link).await.map_err(failed("commit"))?;
        if row.try_get::<i64, _>(0).map_err(failed("commit"))? == 1 {
            lease.committed(Some(asked));
            return Ok(());
        }
    }
    let mut tx = link.begin().await.map_err(failed("begin a transaction"))?;
    let is_new = lease.begin(&mut tx).await?;
    if is_new {
        const SQL: &str =
            "INSERT INTO redo (fleet, shard, number, rows) VALUES ($1, $2, $3, $4) ON CONFLICT DO NOTHING";
        on!(&mut tx, |tx| sqlx::query(SQL)
            .bind(lease.fleet().as_str())
            .bind(lease.shard_number())
            .bind(number)
            .bind(rows)
            .execute(&mut **tx)
            .await
            .map(drop))
        .map_err(failed("write an intent"))?;
    }
    tx.commit().await.map_err(failed("commit"))?;
    lease.committed(is_new.then_some(asked));
    Ok(())
}

/// Deletes an intent whose rows are written.
pub(super) async fn forget(tx: &mut Tx<'_>, lease: &Lease, number: i64) -> sqlx::Result<()> {
    on!(tx, |tx| sqlx::query("DELETE FROM redo WHERE fleet = $1 AND shard = $2 AND number = $3")
        .bind(lease.fleet().as_str())
        .bind(lease.shard_number())
        .bind(number)
        .execute(&mut **tx)
        .await
        .map(drop))
}
