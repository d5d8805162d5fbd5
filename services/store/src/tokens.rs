//! Tokens of the API.

use serde_json::json;

use super::actions::{NewAction, record_done};
use super::database::on;
use super::readings::readings;
use super::time::Time;
use super::{Store, StoreError, failed};

readings! {
    /// A token of the API, as it is kept.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct TokenRow {
        /// The half that names it.
        pub token_id: String,
        /// What it is for, for people.
        pub name: String,
        /// What it allows.
        pub role: String,
        /// The fleets that it is bound to, separated by commas; none for all.
        pub fleets: Option<String>,
        /// BLAKE3 hash of the secret half.
        pub secret_hash: Vec<u8>,
        /// When it was made.
        pub created_us: i64,
        /// By whom.
        pub created_by: String,
        /// Until when it is good.
        pub expires_us: i64,
        /// Since when it is not any more, if somebody has said so.
        pub revoked_us: Option<i64>,
    }
}

/// The entry of the audit log; tokens are made and revoked on the command line, by whoever has the database.
fn audited(kind: &str, row: &TokenRow, now_us: i64) -> NewAction {
    let parameters = json!({
        "token_id": row.token_id, "name": row.name, "role": row.role, "fleets": row.fleets, "expires_at": Time(row.expires_us),
    });
    NewAction {
        fleet: None,
        robot: None,
        array: None,
        whisker: None,
        compensation_id: None,
        alarm_id: None,
        kind: kind.to_owned(),
        parameters: parameters.to_string(),
        reason: None,
        actor: "command line".to_owned(),
        role: "ADMIN".to_owned(),
        request_id: "command line".to_owned(),
        idempotency_key: None,
        asked_us: now_us,
        expires_us: now_us,
    }
}

/// Tokens that are listed at the most.
const TOKENS_MAX: i64 = 1000;

impl Store {
    /// Keeps a new token.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn add_token(&self, row: &TokenRow) -> Result<(), StoreError> {
        const WHAT: &str = "keep a token";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        record_done(&mut tx, &audited("TOKEN_CREATE", row, row.created_us), row.created_us).await?;
        on!(&mut tx, |tx| sqlx::query(
            "INSERT INTO api_tokens (token_id, name, role, fleets, secret_hash, created_us, created_by, expires_us) \
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
        )
        .bind(&row.token_id)
        .bind(&row.name)
        .bind(&row.role)
        .bind(&row.fleets)
        .bind(&row.secret_hash)
        .bind(row.created_us)
        .bind(&row.created_by)
        .bind(row.expires_us)
        .execute(&mut **tx)
        .await
        .map(drop))
        .map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))
    }

    /// The token of that name half.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn token(&self, token_id: &str) -> Result<Option<TokenRow>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT token_id, name, role, fleets, secret_hash, created_us, created_by, expires_us, revoked_us \
             FROM api_tokens WHERE token_id = $1",
        )
        .bind(token_id)
        .fetch_optional(pool)
        .await)
        .map_err(failed("look a token up"))
    }

    /// Every token, the newest first.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn tokens(&self) -> Result<Vec<TokenRow>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT token_id, name, role, fleets, secret_hash, created_us, created_by, expires_us, revoked_us \
             FROM api_tokens ORDER BY created_us DESC, token_id LIMIT $1",
        )
        .bind(TOKENS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("list the tokens"))
    }

    /// Ends a token; false if there is none that is still good.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn revoke_token(&self, token_id: &str, now_us: i64) -> Result<bool, StoreError> {
        const WHAT: &str = "revoke a token";
        let Some(row) = self.token(token_id).await? else { return Ok(false) };
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        let is_new = on!(&mut tx, |tx| sqlx::query(
            "UPDATE api_tokens SET revoked_us = $1 WHERE token_id = $2 AND revoked_us IS NULL",
        )
        .bind(now_us)
        .bind(token_id)
        .execute(&mut **tx)
        .await
        .map(|done| done.rows_affected() > 0))
        .map_err(failed(WHAT))?;
        if is_new {
            record_done(&mut tx, &audited("TOKEN_REVOKE", &row, now_us), now_us).await?;
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(is_new)
    }
}
