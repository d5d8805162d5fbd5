//! Tokens of the REST API.

use serde_json::json;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_edge::words::Word as _;

use super::actions::{NewAction, record_done};
use super::database::on;
use super::from_row::from_row;
use super::set_aside::Tried;
use super::time::Time;
use super::{Store, StoreError, failed};

const TABLE: &str = "api_tokens";

from_row! {
    /// A token of the REST API.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct TokenRow {
        /// Public half of the token, which identifies it.
        pub token_id: String,
        /// Purpose of the token, for people.
        pub name: String,
        /// Role of its bearer: `VIEWER`, `OPERATOR`, `ENGINEER` or `ADMIN`.
        pub role: String,
        /// Fleets that it is restricted to, separated by commas; `None` for all fleets.
        pub fleets: Option<String>,
        /// BLAKE3 hash of the secret half.
        pub secret_hash: Vec<u8>,
        /// Time of its creation, µs since 1970 UTC.
        pub created_us: i64,
        /// Creator, as in the audit log: `command line`.
        pub created_by: String,
        /// Time of its expiry, µs since 1970 UTC.
        pub expires_us: i64,
        /// Time of its revocation, µs since 1970 UTC; `None` if it was not revoked.
        pub revoked_us: Option<i64>,
    }
}

/// The entry in the audit log. Tokens are created and revoked on the command line, by anyone with access to the
/// database.
fn audited(kind: RecordedKind, row: &TokenRow, now_us: i64) -> NewAction {
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
        kind: kind.word().to_owned(),
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

/// Most tokens of a list.
pub const TOKENS_MAX: i64 = 1000;

impl Store {
    /// Stores a new token, and records it in the audit log.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn add_token(&self, row: &TokenRow) -> Result<(), StoreError> {
        const WHAT: &str = "store a token";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        record_done(&mut tx, &audited(RecordedKind::TokenCreate, row, row.created_us), row.created_us).await?;
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

    /// The token with this public half; `None` if it is unknown.
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
        .map_err(failed("read a token"))
    }

    /// Tokens, those first that are valid at `now_us`, and of each kind the newest first; at most 1,000.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn tokens(&self, now_us: i64) -> Result<Vec<TokenRow>, StoreError> {
        let rows = on!(&self.pool, |pool| sqlx::query_as(
            "SELECT token_id, name, role, fleets, secret_hash, created_us, created_by, expires_us, revoked_us \
             FROM api_tokens ORDER BY CASE WHEN revoked_us IS NULL AND expires_us > $2 THEN 0 ELSE 1 END, \
             created_us DESC, token_id LIMIT $1",
        )
        .bind(TOKENS_MAX)
        .bind(now_us)
        .fetch_all(pool)
        .await)
        .map_err(failed("list the tokens"))?;
        Ok(self.set_aside.readable(TABLE, rows))
    }

    /// Hashes by which all valid credentials are known: of the secrets of tokens, and of the identifiers of sessions.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn credential_hashes(&self, now_us: i64, hashes_max: u32) -> Result<Vec<[u8; 32]>, StoreError> {
        let hashes: Vec<Tried<(Vec<u8>,)>> = on!(&self.pool, |pool| sqlx::query_as(
            "SELECT secret_hash FROM api_tokens WHERE revoked_us IS NULL AND expires_us > $1 \
             UNION ALL SELECT session_id FROM console_sessions WHERE expires_us > $1 LIMIT $2",
        )
        .bind(now_us)
        .bind(i64::from(hashes_max))
        .fetch_all(pool)
        .await)
        .map_err(failed("read the hashes of credentials"))?;
        let hashes = self.set_aside.readable(TABLE, hashes);
        Ok(hashes.into_iter().filter_map(|(hash,)| hash.try_into().ok()).collect())
    }

    /// Revokes a token, and records it in the audit log. Returns false if there is no such token or it was revoked
    /// before.
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
            record_done(&mut tx, &audited(RecordedKind::TokenRevoke, &row, now_us), now_us).await?;
        }
        tx.commit().await.map_err(failed(WHAT))?;
        Ok(is_new)
    }
}
