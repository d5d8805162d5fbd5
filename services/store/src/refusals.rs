//! Counts of each robot's refusals: messages, and contacts and other entries of messages.

use tokio::time::Duration;

use super::database::on;
use super::{Lease, Model, StoreError, Writer, failed};

/// Time limit for a transaction.
const PATIENCE: Duration = Duration::from_secs(5);

/// Refusals of a robot for one reason since they were last written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RefusalRow {
    /// Number of the robot in the database.
    pub robot_id: i64,
    /// Topic below the robot's level, such as `contacts`.
    pub topic: &'static str,
    /// Reason, as in the metrics.
    pub reason: &'static str,
    /// Number of messages and entries.
    pub refused: i64,
    /// Time of the newest one, µs since 1970 UTC by the supervisor's clock.
    pub refused_us: i64,
    /// The newest refusal in words.
    pub problem: String,
}

impl Writer {
    /// Adds to the counts of robots. A failed attempt may have added: the counts are for people, and no decision depends
    /// on them.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn add_refusals(&mut self, lease: &Lease, rows: &[RefusalRow]) -> Result<(), StoreError> {
        const WHAT: &str = "count refused messages";
        const SQL: &str = "INSERT INTO refusals (robot_id, topic, reason, refused, first_us, refused_us, problem) \
             VALUES ($1, $2, $3, $4, $5, $5, $6) ON CONFLICT (robot_id, topic, reason) DO UPDATE SET \
             refused = refusals.refused + excluded.refused, refused_us = excluded.refused_us, problem = excluded.problem";
        let model = |model: &mut dyn Model| Ok(lease.hold_in(model)?.add_refusals(lease, rows)?);
        self.attempt(WHAT, PATIENCE, model, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            for row in rows {
                on!(&mut tx, |tx| sqlx::query(SQL)
                    .bind(row.robot_id)
                    .bind(row.topic)
                    .bind(row.reason)
                    .bind(row.refused)
                    .bind(row.refused_us)
                    .bind(&row.problem)
                    .execute(&mut **tx)
                    .await
                    .map(drop))
                .map_err(failed(WHAT))?;
            }
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }
}
