//! Tokens of the API.

use super::database::on;
use super::readings::readings;
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

/// Tokens that are listed at the most.
const TOKENS_MAX: i64 = 1000;

impl Store {
    /// Keeps a new token.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn add_token(&self, row: &TokenRow) -> Result<(), StoreError> {
        on!(&self.pool, |pool| sqlx::query(
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
        .execute(pool)
        .await
        .map(drop))
        .map_err(failed("keep a token"))
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
        on!(&self.pool, |pool| sqlx::query(
            "UPDATE api_tokens SET revoked_us = $1 WHERE token_id = $2 AND revoked_us IS NULL",
        )
        .bind(now_us)
        .bind(token_id)
        .execute(pool)
        .await
        .map(|done| done.rows_affected() > 0))
        .map_err(failed("revoke a token"))
    }
}
