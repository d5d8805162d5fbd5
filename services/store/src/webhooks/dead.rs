//! Dead letters: events that a target has not taken after all attempts.

use sqlx::{AssertSqlSafe, SqlSafeStr as _};

use super::DEAD_LETTERS_MAX;
use super::job::Job;
use crate::actions::{Asked, NewAction, record_done};
use crate::database::{Tx, on};
use crate::events::{EVENTS, Positioned, StoredEvent, select};
use crate::from_row::from_row;
use crate::set_aside::Tried;
use crate::{Store, StoreError, failed};

from_row! {
    /// Why an event was given up.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct DeadLetterRow {
        /// Number of the event.
        pub event_id: i64,
        /// Number of failed attempts.
        pub attempts: i64,
        /// Time of the last attempt, µs since 1970 UTC.
        pub dead_us: i64,
        /// HTTP status of the last answer; `None` without an answer.
        pub status: Option<i64>,
        /// Why the last attempt failed.
        pub problem: String,
        /// Whether it is delivered again.
        pub again: bool,
    }
}

/// What happens to dead letters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// They are delivered again, before newer events.
    Again,
    /// They are deleted.
    Discarded,
}

const WHAT: &str = "change dead letters";

impl Store {
    /// The dead letters of a target in the order of their events, each with its event.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn dead_letters(&self, webhook_id: i64) -> Result<Vec<(DeadLetterRow, StoredEvent)>, StoreError> {
        const WHAT: &str = "list the dead letters";
        const LETTERS: &str = "SELECT event_id, attempts, dead_us, status, problem, again FROM webhook_dead_letters \
             WHERE webhook_id = $1";
        let end = "JOIN webhook_dead_letters d ON d.event_id = e.event_id WHERE d.webhook_id = $1 \
             ORDER BY e.tx, e.event_id";
        let letters: Vec<Tried<DeadLetterRow>> =
            on!(&self.pool, |pool| sqlx::query_as(LETTERS).bind(webhook_id).fetch_all(pool).await)
                .map_err(failed(WHAT))?;
        let events: Vec<Positioned<StoredEvent>> =
            on!(&self.pool, |pool| sqlx::query_as(select(end)).bind(webhook_id).fetch_all(pool).await)
                .map_err(failed(WHAT))?;
        let letters = self.set_aside.readable("webhook_dead_letters", letters);
        let mut letters: std::collections::HashMap<i64, DeadLetterRow> =
            letters.into_iter().map(|letter| (letter.event_id, letter)).collect();
        let events = events.into_iter().filter_map(|event| self.set_aside.read(EVENTS, event.event));
        Ok(events.filter_map(|event| Some((letters.remove(&event.event_id)?, event))).collect())
    }

    /// Delivers dead letters of a target again or deletes them: those of the numbers, or all. Returns how many.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn settle_dead_letters(
        &self,
        webhook_id: i64,
        which: Option<&[i64]>,
        fate: Fate,
        action: &NewAction,
    ) -> Result<(Asked, u64), StoreError> {
        // The list contains only numbers, no text from outside.
        let list = which.map_or_else(String::new, |numbers| {
            let numbers: Vec<String> = numbers.iter().map(i64::to_string).collect();
            format!(" AND event_id IN ({})", if numbers.is_empty() { "NULL".to_owned() } else { numbers.join(", ") })
        });
        let sql = match fate {
            Fate::Again => format!("UPDATE webhook_dead_letters SET again = TRUE WHERE webhook_id = $1{list}"),
            Fate::Discarded => format!("DELETE FROM webhook_dead_letters WHERE webhook_id = $1{list}"),
        };
        let sql = AssertSqlSafe(sql).into_sql_str();
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        let mut changed = 0;
        if matches!(asked, Asked::New(_)) {
            changed = on!(&mut tx, |tx| sqlx::query(sql)
                .persistent(false)
                .bind(webhook_id)
                .execute(&mut **tx)
                .await
                .map(|done| done.rows_affected()))
            .map_err(failed(WHAT))?;
            // What was given up for a while begins anew at once.
            const AT_ONCE: &str = "UPDATE webhooks SET next_us = 0, attempts = 0, streak = 0 WHERE webhook_id = $1";
            on!(&mut tx, |tx| sqlx::query(AT_ONCE).bind(webhook_id).execute(&mut **tx).await.map(drop))
                .map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok((asked, changed))
    }
}

/// Deletes dead letters that were delivered.
pub(super) async fn forget(tx: &mut Tx<'_>, job: &Job) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM webhook_dead_letters WHERE webhook_id = $1 AND event_id = $2";
    for event in job.events() {
        on!(&mut *tx, |tx| sqlx::query(SQL)
            .bind(job.webhook.webhook_id)
            .bind(event.event_id)
            .execute(&mut **tx)
            .await
            .map(drop))?;
    }
    Ok(())
}

/// Makes an event a dead letter. Those of the oldest events beyond the limit are deleted, and counted as lost.
pub(super) async fn bury(
    tx: &mut Tx<'_>,
    (job, event): (&Job, &StoredEvent),
    status: Option<i64>,
    problem: &str,
    now_us: i64,
) -> sqlx::Result<()> {
    const INSERT: &str = "INSERT INTO webhook_dead_letters (webhook_id, event_id, attempts, dead_us, status, problem) \
         VALUES ($1, $2, $3, $4, $5, $6) ON CONFLICT (webhook_id, event_id) DO UPDATE SET \
         attempts = webhook_dead_letters.attempts + excluded.attempts, dead_us = excluded.dead_us, status = excluded.status, \
         problem = excluded.problem, again = FALSE";
    on!(&mut *tx, |tx| sqlx::query(INSERT)
        .bind(job.webhook.webhook_id)
        .bind(event.event_id)
        .bind(job.attempts + 1)
        .bind(now_us)
        .bind(status)
        .bind(problem)
        .execute(&mut **tx)
        .await
        .map(drop))?;
    keep_newest(tx, job.webhook.webhook_id).await
}

/// Deletes the dead letters of a target beyond the limit. Those of the oldest events go, by number: the clock may have been ahead.
pub(super) async fn keep_newest(tx: &mut Tx<'_>, webhook_id: i64) -> sqlx::Result<()> {
    let old = format!(
        "DELETE FROM webhook_dead_letters WHERE webhook_id = $1 AND event_id IN (SELECT event_id FROM webhook_dead_letters \
         WHERE webhook_id = $1 ORDER BY event_id DESC LIMIT {DEAD_LETTERS_MAX} OFFSET {DEAD_LETTERS_MAX})"
    );
    let lost = on!(&mut *tx, |tx| sqlx::query(AssertSqlSafe(old))
        .bind(webhook_id)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected()))?;
    if lost > 0 {
        lose(tx, webhook_id, lost as i64).await?;
    }
    Ok(())
}

/// Counts events that were removed undelivered.
pub(crate) async fn lose(tx: &mut Tx<'_>, webhook_id: i64, events: i64) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE webhooks SET lost = lost + $2 WHERE webhook_id = $1";
    on!(tx, |tx| sqlx::query(SQL).bind(webhook_id).bind(events).execute(&mut **tx).await.map(drop))
}
