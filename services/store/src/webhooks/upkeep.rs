//! Keeps the outbox small, and mends its order after a restored backup.

use super::EVENTS_MAX;
use super::dead::lose;
use crate::database::{Either, on};
use crate::{Store, StoreError, failed};

/// Time for which the outbox keeps events, µs: a week.
const KEPT_US: i64 = 7 * 86_400_000_000;

const WHAT: &str = "remove old events of webhooks";

impl Store {
    /// Removes events that are older than a week, or beyond the newest [`EVENTS_MAX`]. Undelivered ones are counted as lost
    /// at each target that wants them.
    ///
    /// # Errors
    /// The database cannot be used.
    pub async fn trim_webhook_events(&self, now_us: i64) -> Result<(), StoreError> {
        const LAST: &str = "SELECT coalesce(max(event_id), 0) FROM webhook_events WHERE occurred_us < $1 \
             OR event_id <= (SELECT max(event_id) FROM webhook_events) - $2";
        const DEAD: &str = "UPDATE webhooks SET lost = lost + (SELECT count(*) FROM webhook_dead_letters d \
             WHERE d.webhook_id = webhooks.webhook_id AND d.event_id <= $1)";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        if let Either::Postgres(tx) = &mut tx {
            // Two supervisors at once would count twice.
            let locked = sqlx::query("LOCK TABLE webhooks IN SHARE ROW EXCLUSIVE MODE").execute(&mut **tx).await;
            locked.map_err(failed(WHAT))?;
        }
        let last: i64 = on!(&mut tx, |tx| sqlx::query_scalar(LAST)
            .bind(now_us - KEPT_US)
            .bind(EVENTS_MAX)
            .fetch_one(&mut **tx)
            .await)
        .map_err(failed(WHAT))?;
        if last == 0 {
            return Ok(());
        }
        for webhook in self.webhooks().await? {
            let (mut after, mut lost, interest) = (webhook.done(), 0, webhook.interest());
            loop {
                let events = self.brief_events(after, Some(last)).await?;
                let Some(newest) = events.last() else { break };
                after = newest.at();
                lost += events.iter().filter(|event| event.is_in(&interest)).count() as i64;
            }
            if lost > 0 {
                lose(&mut tx, webhook.webhook_id, lost).await.map_err(failed(WHAT))?;
            }
        }
        for sql in [
            DEAD,
            "DELETE FROM webhook_dead_letters WHERE event_id <= $1",
            "DELETE FROM webhook_events WHERE event_id <= $1",
        ] {
            on!(&mut tx, |tx| sqlx::query(sql).bind(last).execute(&mut **tx).await.map(drop)).map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))
    }

    /// Prepares the queues when a supervisor starts. A file has one supervisor at a time, so nobody holds a target of it now. A
    /// PostgreSQL server that was restored from a dump begins to count transactions anew: events and targets that name
    /// transactions of the former server come before all new ones then.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn prepare_webhook_queues(&self) -> Result<(), StoreError> {
        const MINE: &str = "pg_snapshot_xmax(pg_current_snapshot())::text::bigint";
        let pool = match &self.pool {
            Either::Sqlite(pool) => {
                const RELEASE: &str = "UPDATE webhooks SET holder = NULL, held_until_us = 0 WHERE holder IS NOT NULL";
                return sqlx::query(RELEASE).execute(pool).await.map(drop).map_err(failed("release the webhooks"));
            }
            Either::Postgres(pool) => pool,
        };
        for sql in [
            format!("UPDATE webhook_events SET tx = 0 WHERE tx >= {MINE}"),
            format!("UPDATE webhooks SET done_tx = 0 WHERE done_tx >= {MINE}"),
        ] {
            sqlx::query(sqlx::AssertSqlSafe(sql)).execute(pool).await.map_err(failed("mend the order of events"))?;
        }
        Ok(())
    }
}
