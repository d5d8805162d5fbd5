//! Keeps the log of events small, and mends its order after a restored backup.

use sqlx::{AssertSqlSafe, SqlSafeStr as _};
use vibrissa_core::robot::effect::AlarmKind;
use vibrissa_edge::events::{EventKind, Interest, webhook_kinds};
use vibrissa_edge::guidance::Level;
use vibrissa_edge::words::{Word as _, Words as _, named};

use super::dead::lose;
use crate::database::{Either, Tx, on};
use crate::events::{EVENTS, Position, Positioned};
use crate::from_row::from_row;
use crate::{Store, StoreError, failed};

/// Number of events for webhooks that the log keeps, in fair shares of fleets and robots.
pub const EVENTS_MAX: i64 = 20_000;
/// Time for which the log keeps events for webhooks, µs: a week. After such a time without a sign of Kafka's publisher
/// no event waits for it any more.
const KEPT_US: i64 = 7 * 86_400_000_000;
/// Time for which the log keeps all other events, µs: a day.
const OTHERS_KEPT_US: i64 = 86_400_000_000;
/// Most events that are removed at once.
const PIECE: usize = 5000;

const WHAT: &str = "remove old events";

/// Condition for events that do not wait for Kafka. `$1` is the earliest sign of its publisher that counts.
const NOT_AWAITED: &str = "NOT EXISTS (SELECT 1 FROM event_positions p WHERE p.fleet = e.fleet AND p.seen_us >= $1 \
     AND (e.tx, e.event_id) > (p.tx, p.event_id))";

from_row! {
    /// The columns of an event that the filters of a webhook need.
    #[derive(Debug, Clone)]
    pub(crate) struct Brief {
        pub(crate) event_id: i64,
        tx: i64,
        pub(crate) recorded_us: i64,
        kind: String,
        word: Option<String>,
        fleet: String,
    }
}

impl Brief {
    pub(crate) fn position(&self) -> Position {
        Position { tx: self.tx, event_id: self.event_id }
    }

    pub(crate) fn is_in(&self, interest: &Interest) -> bool {
        named(&self.kind).is_some_and(|kind| interest.includes(&self.fleet, kind, self.word.as_deref()))
    }
}

/// The words of texts of this program, as a list in SQL.
fn listed(words: impl Iterator<Item = &'static str>) -> String {
    words.map(|word| format!("'{word}'")).collect::<Vec<_>>().join(", ")
}

/// 0 for events that somebody must act on soon, 1 for others.
fn urgency() -> String {
    let (of_alarms, others): (Vec<EventKind>, Vec<EventKind>) =
        webhook_kinds().into_iter().partition(|kind| matches!(kind, EventKind::AlarmRaised | EventKind::AlarmCleared));
    let is_urgent = |word: &&str| EventKind::AlarmRaised.level(Some(*word)) >= Level::Urgent;
    format!(
        "CASE WHEN kind IN ({}) OR kind IN ({}) AND word IN ({}) THEN 0 ELSE 1 END",
        listed(others.into_iter().filter(|kind| kind.level(None) >= Level::Urgent).map(EventKind::word)),
        listed(of_alarms.into_iter().map(EventKind::word)),
        listed(AlarmKind::all().into_iter().map(AlarmKind::word).filter(is_urgent)),
    )
}

/// Events for webhooks that are too old ($1), or beyond the largest number ($2) in fair shares: the fleets take turns, in each of
/// them the robots, and of each robot the urgent and then the newest events come first.
fn excess() -> String {
    format!(
        "SELECT event_id, tx, recorded_us, kind, word, fleet FROM (SELECT f.*, row_number() OVER \
         (ORDER BY fleet_turn, event_id DESC) AS turn FROM (SELECT r.*, row_number() OVER \
         (PARTITION BY fleet ORDER BY robot_turn, event_id DESC) AS fleet_turn FROM (SELECT e.*, row_number() OVER \
         (PARTITION BY robot_id ORDER BY {}, event_id DESC) AS robot_turn FROM events e WHERE e.audience = 'PEOPLE') r) f) e \
         WHERE (recorded_us < $1 OR turn > $2) AND {NOT_AWAITED} LIMIT {PIECE}",
        urgency()
    )
}

impl Store {
    /// Removes events for webhooks that are older than a week, or beyond [`EVENTS_MAX`] in fair shares. Undelivered ones are
    /// counted as lost at each webhook that wants them. Events that Kafka has not acknowledged stay.
    ///
    /// # Errors
    /// The database cannot be used.
    pub async fn trim_events_for_webhooks(&self, now_us: i64) -> Result<(), StoreError> {
        const ANY: &str = "SELECT count(*) FROM (SELECT 1 FROM events WHERE audience = 'PEOPLE' AND recorded_us < $1 \
             UNION ALL SELECT 1 FROM (SELECT count(*) AS n FROM events WHERE audience = 'PEOPLE') c WHERE n > $2) x";
        if let Some(model) = &self.model {
            // It keeps all events.
            return model.query(WHAT, |_| Ok(())).await;
        }
        let before_us = now_us - KEPT_US;
        loop {
            let any: i64 =
                on!(&self.pool, |pool| sqlx::query_scalar(ANY).bind(before_us).bind(EVENTS_MAX).fetch_one(pool).await)
                    .map_err(failed(WHAT))?;
            if any == 0 {
                return Ok(());
            }
            let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
            if let Either::Postgres(tx) = &mut tx {
                // Two supervisors at once would count twice.
                let locked = sqlx::query("LOCK TABLE webhooks IN SHARE ROW EXCLUSIVE MODE").execute(&mut **tx).await;
                locked.map_err(failed(WHAT))?;
            }
            let sql = AssertSqlSafe(excess());
            let events: Vec<Positioned<Brief>> =
                on!(&mut tx, |tx| sqlx::query_as(sql).bind(before_us).bind(EVENTS_MAX).fetch_all(&mut **tx).await)
                    .map_err(failed(WHAT))?;
            if events.is_empty() {
                return Ok(());
            }
            let ids: Vec<i64> = events.iter().map(|event| event.at.event_id).collect();
            let events: Vec<Brief> =
                events.into_iter().filter_map(|event| self.set_aside.read(EVENTS, event.event)).collect();
            for webhook in self.webhooks().await? {
                let (done, interest) = (webhook.done(), webhook.interest());
                let lost =
                    events.iter().filter(|event| event.position() > done && event.is_in(&interest)).count() as i64;
                if lost > 0 {
                    lose(&mut tx, webhook.webhook_id, lost).await.map_err(failed(WHAT))?;
                }
            }
            remove(&mut tx, &ids).await.map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))?;
        }
    }

    /// Removes events that are older than a day, without those for webhooks, and without those that Kafka has not acknowledged.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn forget_events(&self, now_us: i64) -> Result<(), StoreError> {
        let sql = format!(
            "DELETE FROM events WHERE event_id IN (SELECT event_id FROM events e WHERE e.recorded_us < $2 \
             AND e.audience <> 'PEOPLE' AND {NOT_AWAITED} LIMIT {PIECE})"
        );
        loop {
            let removed = on!(&self.pool, |pool| sqlx::query(AssertSqlSafe(sql.clone()))
                .bind(now_us - KEPT_US)
                .bind(now_us - OTHERS_KEPT_US)
                .execute(pool)
                .await
                .map(|done| done.rows_affected()))
            .map_err(failed(WHAT))?;
            if removed < PIECE as u64 {
                return Ok(());
            }
        }
    }

    /// Prepares the log when a supervisor starts. A file has one supervisor at a time, so nobody holds a webhook of it now. A
    /// PostgreSQL server that was restored from a dump counts transactions of its own: if a row names one that this server has not
    /// begun, all events and readers come before the new ones, in the order of the events' numbers.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn prepare_events(&self) -> Result<(), StoreError> {
        const MINE: &str = "pg_snapshot_xmax(pg_current_snapshot())::text::bigint";
        if let Some(model) = &self.model {
            return model.query("mend the order of events", |_| Ok(())).await;
        }
        let pool = match &self.pool {
            Either::Sqlite(pool) => {
                const RELEASE: &str = "UPDATE webhooks SET holder = NULL, held_until_us = 0 WHERE holder IS NOT NULL";
                return sqlx::query(RELEASE).execute(pool).await.map(drop).map_err(failed("release the webhooks"));
            }
            Either::Postgres(pool) => pool,
        };
        const WHAT: &str = "mend the order of events";
        let is_restored = AssertSqlSafe(format!(
            "SELECT EXISTS (SELECT 1 FROM events WHERE tx >= {MINE}) OR EXISTS (SELECT 1 FROM webhooks WHERE done_tx >= {MINE}) \
             OR EXISTS (SELECT 1 FROM event_positions WHERE tx >= {MINE})"
        ));
        let is_restored: bool = sqlx::query_scalar(is_restored).fetch_one(pool).await.map_err(failed(WHAT))?;
        if !is_restored {
            return Ok(());
        }
        // All of them, in one step: one event that kept its transaction would come after readers that did not.
        let mut tx = pool.begin().await.map_err(failed(WHAT))?;
        for sql in [
            "UPDATE events SET tx = 0 WHERE tx <> 0",
            "UPDATE webhooks SET done_tx = 0 WHERE done_tx <> 0",
            "UPDATE event_positions SET tx = 0 WHERE tx <> 0",
        ] {
            sqlx::query(sql).execute(&mut *tx).await.map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))
    }
}

/// Removes events with their dead letters, which are counted as lost.
async fn remove(tx: &mut Tx<'_>, events: &[i64]) -> sqlx::Result<()> {
    // The list contains only numbers, no text from outside.
    let list = events.iter().map(i64::to_string).collect::<Vec<_>>().join(", ");
    for sql in [
        format!(
            "UPDATE webhooks SET lost = lost + (SELECT count(*) FROM webhook_dead_letters d \
             WHERE d.webhook_id = webhooks.webhook_id AND d.event_id IN ({list}))"
        ),
        format!("DELETE FROM webhook_dead_letters WHERE event_id IN ({list})"),
        format!("DELETE FROM events WHERE event_id IN ({list})"),
    ] {
        let sql = AssertSqlSafe(sql).into_sql_str();
        on!(&mut *tx, |tx| sqlx::query(sql).persistent(false).execute(&mut **tx).await.map(drop))?;
    }
    Ok(())
}
