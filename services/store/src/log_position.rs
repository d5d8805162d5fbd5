//! Positions in a partitioned log: the first record of a fleet's partition whose effects are not committed.

use super::database::{Tx, on};
use super::{Lease, StoreError, Writer, failed};

/// Time limit for reading or setting a position.
const PATIENCE: std::time::Duration = std::time::Duration::from_secs(5);

impl Writer {
    /// The position of a fleet in a topic; `None` before the first record. That of another topic is forgotten.
    ///
    /// # Errors
    /// The database cannot be used, or the lease is lost.
    pub async fn log_position(&mut self, lease: &Lease, topic: &str) -> Result<Option<i64>, StoreError> {
        const WHAT: &str = "read the position in the log";
        const SQL: &str = "UPDATE leases SET log_next = CASE WHEN log_topic = $2 THEN log_next END, log_topic = $2 \
             WHERE fleet = $1 RETURNING log_next";
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            let next: Option<Option<i64>> = on!(&mut tx, |tx| sqlx::query_scalar(SQL)
                .bind(lease.fleet().as_str())
                .bind(topic)
                .fetch_optional(&mut **tx)
                .await)
            .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))?;
            Ok(next.flatten())
        })
        .await
    }

    /// Sets the position before the effects of its records are committed, for a fault planted by a test.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn set_log_position(&mut self, lease: &Lease, next: i64) -> Result<(), StoreError> {
        const WHAT: &str = "set the position in the log";
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            write(&mut tx, lease, Some(next)).await?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }
}

/// Writes the position, if it changes.
pub(super) async fn write(tx: &mut Tx<'_>, lease: &Lease, next: Option<i64>) -> Result<(), StoreError> {
    const SQL: &str = "UPDATE leases SET log_next = $1 WHERE fleet = $2";
    let Some(next) = next else { return Ok(()) };
    on!(tx, |tx| sqlx::query(SQL).bind(next).bind(lease.fleet().as_str()).execute(&mut **tx).await.map(drop))
        .map_err(failed("write the position in the log"))
}
