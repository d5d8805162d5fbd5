//! The queues of the targets: the next event, the result of an attempt, and the number of waiting events.
//!
//! A supervisor that delivers to a target holds it: no other one does until it lets go, or until its time is up. That time
//! is measured by the monotonic clock of the other one, see `lease_watch`: the database's clock may be stepped. The result
//! of an attempt counts only if the supervisor still holds the target. If the last attempt is in the future, the database's clock
//! was stepped back, and the pause after it is over. So is the wait of a mail that has no failed attempt and waits longer than any.

use std::sync::PoisonError;
use std::time::Duration;

use sqlx::AssertSqlSafe;
use tokio::time::Instant;

pub use super::job::Job;
use super::upkeep::Brief;
use super::{COLUMNS, WebhookRow, now_us, now_us_of};
use crate::database::{Tx, on};
use crate::events::{EVENTS, EVENTS_A_QUERY, Position, Positioned, StoredEvent, select, settled};
use crate::from_row::from_row;
use crate::lease_watch::Reading;
use crate::maintenance;
use crate::set_aside::{SetAside, Tried};
use crate::{Store, StoreError, failed};

from_row! {
    /// The keys that sign requests to a target.
    #[derive(Clone)]
    struct Keys {
        secret: Vec<u8>,
        previous_secret: Option<Vec<u8>>,
        previous_until_us: Option<i64>,
        attempts: i64,
    }

    /// A target with something to do.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct Due {
        /// Number of the target.
        pub webhook_id: i64,
        /// The supervisor that holds it.
        pub holder: Option<String>,
        /// End of the hold, µs since 1970 UTC by the database's clock; 0 if nobody holds it.
        pub held_until_us: i64,
    }
}

const KEYS: &str = "SELECT secret, previous_secret, previous_until_us, attempts FROM webhooks WHERE webhook_id = $1";

impl Keys {
    /// The newest key, and the one before it while it signs requests, too.
    fn valid(self, now_us: i64) -> Vec<Vec<u8>> {
        let previous =
            self.previous_secret.filter(|_| self.previous_until_us.is_some_and(|until_us| until_us > now_us));
        [self.secret].into_iter().chain(previous).collect()
    }
}

/// Result of an attempt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The target has taken the event.
    Delivered {
        /// HTTP status of the answer.
        status: u16,
    },
    /// It is too early: the next mail leaves after this time, with all events until then. The target is released.
    Postponed {
        /// Time until then, µs.
        pause_us: i64,
    },
    /// The target has not taken the event. It is tried again after `pause_us`.
    Failed {
        /// HTTP status of the answer; `None` without an answer.
        status: Option<u16>,
        /// Why it failed.
        problem: String,
        /// Whether the event becomes a dead letter.
        is_dead: bool,
        /// Time until the next attempt, µs.
        pause_us: i64,
    },
}

/// The queue of a target.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Queue {
    /// Number of waiting events.
    pub waiting: i64,
    /// Time of the oldest one, µs since 1970 UTC.
    pub oldest_us: Option<i64>,
    /// Number of dead letters, without those that are delivered again.
    pub dead: i64,
}

/// Condition for targets whose pause is over at `$1`. A mail that has not failed waits for 10 minutes at most, not an
/// hour: `mail.per_hour_max`.
const IS_TIME: &str = "(next_us <= $1 OR last_us > $1 OR (streak = 0 AND next_us > $1 + 3600000000))";
/// Most events that one mail tells.
const MAIL_EVENTS_MAX: usize = 500;

const WHAT: &str = "deliver to a webhook";

impl Store {
    /// Numbers of the targets with something to do now that no other supervisor holds. A hold lasts for `hold`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn due_webhooks(&self, holder: &str, hold: Duration) -> Result<Vec<i64>, StoreError> {
        let due = self.due().await?;
        let (mut holds, now) = (self.holds.lock().unwrap_or_else(PoisonError::into_inner), Instant::now());
        holds.retain_holds(|webhook_id| due.iter().any(|due| due.webhook_id == webhook_id));
        let mut is_free = |due: &Due| {
            let (renewal, time_to_live) = (due.held_until_us, hold);
            // Also at the first reading: the database's clock may have been stepped.
            let left_us = i64::MAX;
            let has_lapsed = holds.has_lapsed(due.webhook_id, &Reading { renewal, left_us, time_to_live }, now);
            renewal == 0 || due.holder.as_deref() == Some(holder) || has_lapsed
        };
        Ok(due.iter().filter(|due| is_free(due)).map(|due| due.webhook_id).collect())
    }

    /// The targets with something to do now.
    async fn due(&self) -> Result<Vec<Due>, StoreError> {
        const WHAT: &str = "read the queues of the webhooks";
        if let Some(model) = &self.model {
            return model.query(WHAT, |model| Ok(model.due())).await;
        }
        let now_us = now_us_of(&self.pool).await.map_err(failed(WHAT))?;
        let sql = format!(
            "SELECT webhook_id, holder, held_until_us FROM webhooks h WHERE enabled AND {IS_TIME} AND (EXISTS (SELECT 1 FROM events e WHERE e.audience = 'PEOPLE' AND (e.tx, e.event_id) > (h.done_tx, h.done_event) {}) OR EXISTS (SELECT 1 FROM webhook_dead_letters d WHERE d.webhook_id = h.webhook_id AND d.again))",
            settled(&self.pool)
        );
        let due: Vec<Due> =
            on!(&self.pool, |pool| sqlx::query_as(AssertSqlSafe(sql)).bind(now_us).fetch_all(pool).await)
                .map_err(failed(WHAT))?;
        Ok(due)
    }

    /// Takes hold of a target, and returns its next event; `None`, and no hold, if there is nothing to do or
    /// another supervisor holds it.
    ///
    /// # Errors
    /// The database cannot be used.
    pub async fn take_webhook_job(
        &self,
        webhook_id: i64,
        holder: &str,
        hold: Duration,
    ) -> Result<Option<Job>, StoreError> {
        let seen = self.holds.lock().unwrap_or_else(PoisonError::into_inner).lapsed_hold(webhook_id, Instant::now());
        let holding = Holding { holder, hold_us: i64::try_from(hold.as_micros()).unwrap_or(i64::MAX), seen };
        if let Some(model) = &self.model {
            return model.query(WHAT, |model| Ok(model.take_job(webhook_id, &holding))).await;
        }
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let job = take(&mut tx, webhook_id, &holding, &self.set_aside).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(job)
    }

    /// Stores the result of an attempt. Returns false, and stores nothing, if another supervisor holds the target now.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn finish_webhook_job(&self, job: &Job, holder: &str, outcome: &Outcome) -> Result<bool, StoreError> {
        if let Some(model) = &self.model {
            return model.query(WHAT, |model| Ok(model.finish_job(job, holder, outcome))).await;
        }
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let is_held = finish(&mut tx, job, holder, outcome).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(is_held)
    }

    /// Keys that sign requests to a target now, the newest first; empty if there is no such target.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn webhook_secrets(&self, webhook_id: i64) -> Result<Vec<Vec<u8>>, StoreError> {
        const WHAT: &str = "read the keys of a webhook";
        let now_us = now_us_of(&self.pool).await.map_err(failed(WHAT))?;
        let keys: Option<Keys> =
            on!(&self.pool, |pool| sqlx::query_as(KEYS).bind(webhook_id).fetch_optional(pool).await)
                .map_err(failed(WHAT))?;
        Ok(keys.map(|keys| keys.valid(now_us)).unwrap_or_default())
    }

    /// Lets go of all targets of a supervisor that stops.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn release_webhooks(&self, holder: &str) -> Result<(), StoreError> {
        const SQL: &str = "UPDATE webhooks SET holder = NULL, held_until_us = 0 WHERE holder = $1";
        if let Some(model) = &self.model {
            return model
                .query(WHAT, |model| {
                    model.release_holds(holder);
                    Ok(())
                })
                .await;
        }
        on!(&self.pool, |pool| sqlx::query(SQL).bind(holder).execute(pool).await.map(drop)).map_err(failed(WHAT))
    }

    /// The queues of targets, in their order. The log is read once for all.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn webhook_queues(&self, webhooks: &[WebhookRow]) -> Result<Vec<Queue>, StoreError> {
        const WHAT: &str = "read the queues of the webhooks";
        if let Some(model) = &self.model {
            return model.query(WHAT, |model| Ok(model.queues(webhooks))).await;
        }
        const DEAD: &str =
            "SELECT webhook_id, count(*) AS dead FROM webhook_dead_letters WHERE NOT again GROUP BY webhook_id";
        let dead: Vec<(i64, i64)> =
            on!(&self.pool, |pool| sqlx::query_as(DEAD).fetch_all(pool).await).map_err(failed(WHAT))?;
        let dead: std::collections::HashMap<i64, i64> = dead.into_iter().collect();
        let of = |webhook: &WebhookRow| Queue {
            dead: dead.get(&webhook.webhook_id).copied().unwrap_or_default(),
            ..Queue::default()
        };
        let mut queues: Vec<Queue> = webhooks.iter().map(of).collect();
        let interests: Vec<_> = webhooks.iter().map(|webhook| (webhook.done(), webhook.interest())).collect();
        let Some(mut after) = interests.iter().map(|(done, _)| *done).min() else { return Ok(queues) };
        loop {
            let events = self.brief_events(after).await?;
            let last = events.last().map(|event| event.at).filter(|_| events.len() as i64 == EVENTS_A_QUERY);
            for event in events {
                let Some(event) = self.set_aside.read(EVENTS, event.event) else { continue };
                for (queue, (done, interest)) in queues.iter_mut().zip(&interests) {
                    if event.position() > *done && event.is_in(interest) {
                        queue.waiting += 1;
                        queue.oldest_us =
                            Some(queue.oldest_us.map_or(event.recorded_us, |old| old.min(event.recorded_us)));
                    }
                }
            }
            match last {
                Some(last) => after = last,
                None => return Ok(queues),
            }
        }
    }

    /// The oldest events after a position, without their details.
    async fn brief_events(&self, after: Position) -> Result<Vec<Positioned<Brief>>, StoreError> {
        let sql = format!(
            "SELECT event_id, tx, recorded_us, kind, word, fleet FROM events e \
             WHERE (e.tx, e.event_id) > ($1, $2) AND e.audience = 'PEOPLE' ORDER BY e.tx, e.event_id \
             LIMIT {EVENTS_A_QUERY}"
        );
        on!(&self.pool, |pool| sqlx::query_as(AssertSqlSafe(sql))
            .bind(after.tx)
            .bind(after.event_id)
            .fetch_all(pool)
            .await)
        .map_err(failed("read the events for webhooks"))
    }
}

/// A supervisor that takes hold of a target.
#[derive(Debug, Clone, Copy)]
pub struct Holding<'a> {
    /// Its identifier.
    pub holder: &'a str,
    /// How long the hold lasts, µs.
    pub hold_us: i64,
    /// The hold of another supervisor that has lapsed, or -1.
    pub seen: i64,
}

async fn take(
    tx: &mut Tx<'_>,
    webhook_id: i64,
    holding: &Holding<'_>,
    set_aside: &SetAside,
) -> sqlx::Result<Option<Job>> {
    let hold = format!(
        "UPDATE webhooks SET holder = $3, held_until_us = $1 + $4 \
         WHERE webhook_id = $2 AND enabled AND {IS_TIME} AND (holder = $3 OR held_until_us IN (0, $5))"
    );
    let now_us = now_us(tx).await?;
    let held = on!(&mut *tx, |tx| sqlx::query(AssertSqlSafe(hold))
        .bind(now_us)
        .bind(webhook_id)
        .bind(holding.holder)
        .bind(holding.hold_us)
        .bind(holding.seen)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected()))?;
    if held == 0 {
        return Ok(None);
    }
    let sql = format!("SELECT {COLUMNS} FROM webhooks WHERE webhook_id = $1");
    let webhook: Tried<WebhookRow> =
        on!(&mut *tx, |tx| sqlx::query_as(AssertSqlSafe(sql)).bind(webhook_id).fetch_one(&mut **tx).await)?;
    // It stays held: nobody can deliver to it.
    let Some(webhook) = set_aside.read("webhooks", webhook) else { return Ok(None) };
    let keys: Keys = on!(&mut *tx, |tx| sqlx::query_as(KEYS).bind(webhook_id).fetch_one(&mut **tx).await)?;
    let again = next_dead(tx, &webhook, set_aside).await?;
    let is_again = !again.is_empty();
    let events = if is_again { again } else { next_new(tx, &webhook, set_aside).await? };
    let mut events = events.into_iter();
    let Some(event) = events.next() else {
        const RELEASE: &str = "UPDATE webhooks SET holder = NULL, held_until_us = 0 WHERE webhook_id = $1";
        on!(&mut *tx, |tx| sqlx::query(RELEASE).bind(webhook_id).execute(&mut **tx).await.map(drop))?;
        return Ok(None);
    };
    let (age_us, attempts) = (now_us - event.recorded_us, keys.attempts);
    let (secrets, more) = (keys.valid(now_us), events.collect());
    Ok(Some(Job { webhook, event, more, secrets, attempts, is_again, age_us }))
}

/// The oldest dead letters that shall be delivered again: one, or those of a mail. One that cannot be read stays a dead letter.
async fn next_dead(tx: &mut Tx<'_>, webhook: &WebhookRow, set_aside: &SetAside) -> sqlx::Result<Vec<StoredEvent>> {
    const GIVEN_UP: &str = "UPDATE webhook_dead_letters SET again = FALSE WHERE webhook_id = $1 AND event_id = $2";
    let (webhook_id, many) = (webhook.webhook_id, events_at_once(webhook));
    let end = format!(
        "JOIN webhook_dead_letters d ON d.event_id = e.event_id WHERE d.webhook_id = $1 AND d.again \
         ORDER BY e.tx, e.event_id LIMIT {many}"
    );
    loop {
        let letters: Vec<Positioned<StoredEvent>> =
            on!(&mut *tx, |tx| sqlx::query_as(select(&end)).bind(webhook_id).fetch_all(&mut **tx).await)?;
        let (count, mut events) = (letters.len(), Vec::new());
        for letter in letters {
            if let Some(event) = set_aside.read(EVENTS, letter.event) {
                events.push(event);
                continue;
            }
            let event_id = letter.at.event_id;
            on!(&mut *tx, |tx| sqlx::query(GIVEN_UP)
                .bind(webhook_id)
                .bind(event_id)
                .execute(&mut **tx)
                .await
                .map(drop))?;
        }
        if count == 0 || !events.is_empty() {
            return Ok(events);
        }
    }
}

/// Number of events that a target gets at once.
fn events_at_once(webhook: &WebhookRow) -> usize {
    if webhook.is_mail() { MAIL_EVENTS_MAX } else { 1 }
}

/// The next event that the target wants, and for a mail those after it. The ones before it are done: the target does not
/// want them, or they cannot be read and are lost.
async fn next_new(tx: &mut Tx<'_>, webhook: &WebhookRow, set_aside: &SetAside) -> sqlx::Result<Vec<StoredEvent>> {
    let (interest, many) = (webhook.interest(), events_at_once(webhook));
    let end = format!(
        "WHERE (e.tx, e.event_id) > ($1, $2) AND e.audience = 'PEOPLE' {} ORDER BY e.tx, e.event_id LIMIT {EVENTS_A_QUERY}",
        settled(tx)
    );
    let windows = maintenance::windows(tx, set_aside).await?;
    let (mut done, mut found) = (webhook.done(), Vec::new());
    let mut after = done;
    loop {
        let events: Vec<Positioned<StoredEvent>> = on!(&mut *tx, |tx| sqlx::query_as(select(&end))
            .bind(after.tx)
            .bind(after.event_id)
            .fetch_all(&mut **tx)
            .await)?;
        let is_last = (events.len() as i64) < EVENTS_A_QUERY;
        for Positioned { at, event } in events {
            after = at;
            match set_aside.read(EVENTS, event) {
                Some(event)
                    if event.is_in(&interest) && !maintenance::is_muted(&windows, &event, webhook.is_mail()) =>
                {
                    found.push(event);
                }
                // An event behind the first one is met again, because the position stays before that one.
                _ if !found.is_empty() => {}
                Some(event) if event.event_kind().is_none() => {
                    let (event_id, kind) = (event.event_id, &event.kind);
                    set_aside.note(format!("the row event_id = {event_id} of {EVENTS}: unknown kind {kind:?}"));
                    super::dead::lose(tx, webhook.webhook_id, 1).await?;
                }
                Some(_) => {}
                None => super::dead::lose(tx, webhook.webhook_id, 1).await?,
            }
            if found.is_empty() {
                done = at;
            }
            if found.len() >= many {
                break;
            }
        }
        if is_last || found.len() >= many {
            advance(tx, webhook.webhook_id, done).await?;
            return Ok(found);
        }
    }
}

async fn advance(tx: &mut Tx<'_>, webhook_id: i64, done: Position) -> sqlx::Result<()> {
    const SQL: &str = "UPDATE webhooks SET done_tx = $2, done_event = $3 WHERE webhook_id = $1";
    on!(tx, |tx| sqlx::query(SQL).bind(webhook_id).bind(done.tx).bind(done.event_id).execute(&mut **tx).await.map(drop))
}

async fn finish(tx: &mut Tx<'_>, job: &Job, holder: &str, outcome: &Outcome) -> sqlx::Result<bool> {
    const SQL: &str = "UPDATE webhooks SET last_us = $3, last_status = $4, last_problem = $5, \
         last_success_us = CASE WHEN $6 THEN $3 ELSE last_success_us END, \
         delivered = delivered + CASE WHEN $6 THEN $9 ELSE 0 END, failed = failed + CASE WHEN $6 THEN 0 ELSE 1 END, \
         attempts = CASE WHEN $7 THEN 0 ELSE attempts + 1 END, streak = CASE WHEN $6 THEN 0 ELSE streak + 1 END, \
         next_us = $8, holder = CASE WHEN $6 THEN holder ELSE NULL END, \
         held_until_us = CASE WHEN $6 THEN held_until_us ELSE 0 END WHERE webhook_id = $1 AND holder = $2";
    let now_us = now_us(tx).await?;
    let (is_delivered, is_over, status, problem, pause_us) = match outcome {
        Outcome::Postponed { pause_us } => return postpone(tx, job, holder, now_us + pause_us).await,
        Outcome::Delivered { status } => (true, true, Some(*status), None, 0),
        Outcome::Failed { status, problem, is_dead, pause_us } => {
            (false, *is_dead, *status, Some(problem.as_str()), *pause_us)
        }
    };
    let status = status.map(i64::from);
    let held = on!(&mut *tx, |tx| sqlx::query(SQL)
        .bind(job.webhook.webhook_id)
        .bind(holder)
        .bind(now_us)
        .bind(status)
        .bind(problem)
        .bind(is_delivered)
        .bind(is_over)
        .bind(if is_delivered { 0 } else { now_us + pause_us })
        .bind(job.events().count() as i64)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected()))?;
    if held == 0 {
        return Ok(false);
    }
    match (is_delivered, is_over, job.is_again) {
        (true, _, true) => super::dead::forget(tx, job).await?,
        (false, true, _) => {
            for event in job.events() {
                super::dead::bury(tx, (job, event), status, problem.unwrap_or_default(), now_us).await?;
            }
        }
        (true, _, false) | (false, false, _) => {}
    }
    if is_over && !job.is_again {
        advance(tx, job.webhook.webhook_id, job.more.last().unwrap_or(&job.event).position()).await?;
    }
    Ok(true)
}

/// Releases a target until a time, µs since 1970 UTC, without an attempt.
async fn postpone(tx: &mut Tx<'_>, job: &Job, holder: &str, until_us: i64) -> sqlx::Result<bool> {
    const SQL: &str = "UPDATE webhooks SET next_us = $3, holder = NULL, held_until_us = 0 \
         WHERE webhook_id = $1 AND holder = $2";
    let held = on!(tx, |tx| sqlx::query(SQL)
        .bind(job.webhook.webhook_id)
        .bind(holder)
        .bind(until_us)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected()))?;
    Ok(held > 0)
}
