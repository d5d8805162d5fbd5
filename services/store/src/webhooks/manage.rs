//! Creates, changes and removes targets, each with its entry in the audit log.

use sqlx::AssertSqlSafe;

use super::{COLUMNS, WEBHOOKS_MAX, WEBHOOKS_PER_FLEET_MAX, WebhookRow};
use crate::actions::{Asked, NewAction, record_done};
use crate::database::{Either, Tx, on};
use crate::set_aside::Tried;
use crate::{Store, StoreError, failed};

/// Properties of a target.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WebhookSettings {
    /// Name for people, unique.
    pub name: String,
    /// URL that receives the events.
    pub url: String,
    /// Names and patterns of the fleets of its events, separated by commas; `None` for all.
    pub fleets: Option<String>,
    /// Kinds of its events, separated by commas; `None` for all.
    pub kinds: Option<String>,
    /// Its least urgent events.
    pub level: String,
    /// Whether events are delivered; otherwise they wait.
    pub enabled: bool,
}

/// Result of creating or changing a target.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Set {
    /// The target with this number is as asked.
    Done(i64),
    /// The same request was executed before, or its key belongs to a different action.
    Known(Box<Asked>),
    /// There is no such target.
    Absent,
    /// Another target has this name.
    NameTaken,
    /// There are as many targets as possible: of this fleet, or else in all, or for all fleets and patterns.
    Full(Option<String>),
}

const WHAT: &str = "change a webhook";

impl Store {
    /// All targets, in the order of their names.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn webhooks(&self) -> Result<Vec<WebhookRow>, StoreError> {
        if let Some(model) = &self.model {
            return model.query("list the webhooks", |model| Ok(model.webhooks())).await;
        }
        let sql = format!("SELECT {COLUMNS} FROM webhooks ORDER BY name LIMIT {WEBHOOKS_MAX}");
        let rows: Vec<Tried<WebhookRow>> =
            on!(&self.pool, |pool| sqlx::query_as(AssertSqlSafe(sql)).fetch_all(pool).await)
                .map_err(failed("list the webhooks"))?;
        Ok(self.set_aside.readable("webhooks", rows))
    }

    /// The target of this number; `None` if there is none.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn webhook(&self, webhook_id: i64) -> Result<Option<WebhookRow>, StoreError> {
        let sql = format!("SELECT {COLUMNS} FROM webhooks WHERE webhook_id = $1");
        on!(&self.pool, |pool| sqlx::query_as(AssertSqlSafe(sql)).bind(webhook_id).fetch_optional(pool).await)
            .map_err(failed("read a webhook"))
    }

    /// Creates a target, which gets the events from now on.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn add_webhook(
        &self,
        new: &WebhookSettings,
        secret: &[u8],
        action: &NewAction,
    ) -> Result<Set, StoreError> {
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        if !matches!(asked, Asked::New(_)) {
            return Ok(Set::Known(Box::new(asked)));
        }
        if is_taken(&mut tx, &new.name, 0).await.map_err(failed(WHAT))? {
            return Ok(Set::NameTaken);
        }
        if let Some(full) = full(&mut tx, new.fleets.as_deref(), 0).await.map_err(failed(WHAT))? {
            return Ok(full);
        }
        let webhook_id = insert(&mut tx, new, secret, action).await.map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Set::Done(webhook_id))
    }

    /// Changes the properties of a target.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn change_webhook(
        &self,
        webhook_id: i64,
        new: &WebhookSettings,
        action: &NewAction,
    ) -> Result<Set, StoreError> {
        const SQL: &str = "UPDATE webhooks SET name = $2, url = $3, fleets = $4, kinds = $5, level = $6, enabled = $7, \
             changed_us = $8, changed_by = $9, next_us = 0, attempts = 0, streak = 0 WHERE webhook_id = $1";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        if !matches!(asked, Asked::New(_)) {
            return Ok(Set::Known(Box::new(asked)));
        }
        if is_taken(&mut tx, &new.name, webhook_id).await.map_err(failed(WHAT))? {
            return Ok(Set::NameTaken);
        }
        if let Some(full) = full(&mut tx, new.fleets.as_deref(), webhook_id).await.map_err(failed(WHAT))? {
            return Ok(full);
        }
        let changed = on!(&mut tx, |tx| sqlx::query(SQL)
            .bind(webhook_id)
            .bind(&new.name)
            .bind(&new.url)
            .bind(&new.fleets)
            .bind(&new.kinds)
            .bind(&new.level)
            .bind(new.enabled)
            .bind(action.asked_us)
            .bind(&action.actor)
            .execute(&mut **tx)
            .await
            .map(|done| done.rows_affected()))
        .map_err(failed(WHAT))?;
        if changed == 0 {
            return Ok(Set::Absent);
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(Set::Done(webhook_id))
    }

    /// Removes a target with its dead letters.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn remove_webhook(&self, webhook_id: i64, action: &NewAction) -> Result<Asked, StoreError> {
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        if matches!(asked, Asked::New(_)) {
            for sql in
                ["DELETE FROM webhook_dead_letters WHERE webhook_id = $1", "DELETE FROM webhooks WHERE webhook_id = $1"]
            {
                on!(&mut tx, |tx| sqlx::query(sql).bind(webhook_id).execute(&mut **tx).await.map(drop))
                    .map_err(failed(WHAT))?;
            }
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(asked)
    }

    /// Gives a target a new secret. The present one signs requests, too, until `previous_until_us`.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn renew_webhook_secret(
        &self,
        webhook_id: i64,
        secret: &[u8],
        previous_until_us: i64,
        action: &NewAction,
    ) -> Result<Asked, StoreError> {
        const SQL: &str = "UPDATE webhooks SET previous_secret = secret, previous_until_us = $3, secret = $2, \
             changed_us = $4, changed_by = $5 WHERE webhook_id = $1";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        if matches!(asked, Asked::New(_)) {
            on!(&mut tx, |tx| sqlx::query(SQL)
                .bind(webhook_id)
                .bind(secret)
                .bind(previous_until_us)
                .bind(action.asked_us)
                .bind(&action.actor)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(asked)
    }

    /// Records an action about a target that changes no row of it, such as a test.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn record_webhook_action(&self, action: &NewAction) -> Result<Asked, StoreError> {
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let asked = record_done(&mut tx, action, action.asked_us).await?;
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(asked)
    }
}

async fn is_taken(tx: &mut Tx<'_>, name: &str, but: i64) -> sqlx::Result<bool> {
    const SQL: &str = "SELECT count(*) FROM webhooks WHERE name = $1 AND webhook_id <> $2";
    let others: i64 = on!(tx, |tx| sqlx::query_scalar(SQL).bind(name).bind(but).fetch_one(&mut **tx).await)?;
    Ok(others > 0)
}

/// Whether there is no place for a target of these fleets, separated by commas, beside the others. A pattern counts as
/// all fleets, because fleets that match it may begin later.
async fn full(tx: &mut Tx<'_>, fleets: Option<&str>, but: i64) -> sqlx::Result<Option<Set>> {
    const SQL: &str = "SELECT fleets FROM webhooks WHERE webhook_id <> $1";
    let others: Vec<Option<String>> = on!(tx, |tx| sqlx::query_scalar(SQL).bind(but).fetch_all(&mut **tx).await)?;
    if others.len() as i64 >= WEBHOOKS_MAX {
        return Ok(Some(Set::Full(None)));
    }
    let is_of_many = |fleets: Option<&str>| fleets.is_none_or(|fleets| fleets.contains('*'));
    let of_many = others.iter().filter(|fleets| is_of_many(fleets.as_deref())).count();
    if is_of_many(fleets) && of_many >= WEBHOOKS_PER_FLEET_MAX {
        return Ok(Some(Set::Full(None)));
    }
    let Some(fleets) = fleets else { return Ok(None) };
    let count = |fleet: &str| {
        let has = |one: &&String| one.split(',').any(|named| named == fleet);
        others.iter().flatten().filter(has).count()
    };
    let mut names = fleets.split(',').filter(|fleet| !fleet.contains('*'));
    let full = names.find(|fleet| count(fleet) >= WEBHOOKS_PER_FLEET_MAX);
    Ok(full.map(|fleet| Set::Full(Some(fleet.to_owned()))))
}

/// The target's queue begins behind the events of all transactions that began before this one.
async fn insert(tx: &mut Tx<'_>, new: &WebhookSettings, secret: &[u8], action: &NewAction) -> sqlx::Result<i64> {
    const COLUMNS: &str = "INSERT INTO webhooks (name, url, fleets, kinds, level, enabled, secret, created_us, changed_us, \
         changed_by, done_tx, done_event) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $8, $9,";
    let done = match tx {
        Either::Sqlite(_) => "0, coalesce((SELECT seq FROM sqlite_sequence WHERE name = 'events'), 0))",
        Either::Postgres(_) => "pg_current_xact_id()::text::bigint, 0)",
    };
    let sql = format!("{COLUMNS} {done} RETURNING webhook_id");
    on!(tx, |tx| sqlx::query_scalar(AssertSqlSafe(sql))
        .bind(&new.name)
        .bind(&new.url)
        .bind(&new.fleets)
        .bind(&new.kinds)
        .bind(&new.level)
        .bind(new.enabled)
        .bind(secret)
        .bind(action.asked_us)
        .bind(&action.actor)
        .fetch_one(&mut **tx)
        .await)
}
