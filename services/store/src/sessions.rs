//! Sessions of the console, with the sealed tokens of the identity provider.

use super::actions::{NewAction, record_done};
use super::database::on;
use super::from_row::from_row;
use super::{Store, StoreError, failed};

/// Largest number of sessions; the oldest ones beyond end.
const SESSIONS_MAX: i64 = 10_000;
/// A session that begins further in the future was begun by a clock that was ahead, µs.
const AHEAD_US_MAX: i64 = 3_600_000_000;

from_row! {
    /// A session of the console.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct SessionRow {
        /// BLAKE3 hash of the identifier in the browser's cookie.
        pub session_id: Vec<u8>,
        /// Actor, as in the audit log.
        pub actor: String,
        /// Tokens of the provider, encrypted.
        pub sealed: Vec<u8>,
        /// Time of the sign-in, µs since 1970 UTC.
        pub created_us: i64,
        /// End of the session, µs since 1970 UTC.
        pub expires_us: i64,
    }
}

impl SessionRow {
    /// Whether the session holds at this time. One of a clock that was ahead does not: it would hold for as long as the clock was
    /// ahead.
    #[must_use]
    pub fn holds(&self, now_us: i64) -> bool {
        self.created_us <= now_us.saturating_add(AHEAD_US_MAX) && now_us < self.expires_us
    }
}

impl Store {
    /// Stores a new session, and records the sign-in in the audit log. Sessions that have ended are deleted.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn add_session(&self, row: &SessionRow, action: &NewAction) -> Result<(), StoreError> {
        const WHAT: &str = "store a session";
        const ENDED: &str = "DELETE FROM console_sessions WHERE expires_us <= $1 OR created_us > $3 OR session_id IN \
             (SELECT session_id FROM console_sessions ORDER BY created_us DESC LIMIT $2 OFFSET $2)";
        const INSERT: &str = "INSERT INTO console_sessions (session_id, actor, sealed, created_us, expires_us) \
             VALUES ($1, $2, $3, $4, $5)";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        record_done(&mut tx, action, action.asked_us).await?;
        on!(&mut tx, |tx| sqlx::query(ENDED)
            .bind(row.created_us)
            .bind(SESSIONS_MAX)
            .bind(row.created_us.saturating_add(AHEAD_US_MAX))
            .execute(&mut **tx)
            .await
            .map(drop))
        .map_err(failed(WHAT))?;
        on!(&mut tx, |tx| sqlx::query(INSERT)
            .bind(&row.session_id)
            .bind(&row.actor)
            .bind(&row.sealed)
            .bind(row.created_us)
            .bind(row.expires_us)
            .execute(&mut **tx)
            .await
            .map(drop))
        .map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))
    }

    /// The session with this hash; `None` if there is none.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn session(&self, session_id: &[u8]) -> Result<Option<SessionRow>, StoreError> {
        const SQL: &str = "SELECT session_id, actor, sealed, created_us, expires_us FROM console_sessions \
             WHERE session_id = $1";
        on!(&self.pool, |pool| sqlx::query_as(SQL).bind(session_id).fetch_optional(pool).await)
            .map_err(failed("read a session"))
    }

    /// Replaces the tokens of a session, unless others have replaced the old ones. Returns whether it has.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn reseal_session(&self, session_id: &[u8], old: &[u8], sealed: &[u8]) -> Result<bool, StoreError> {
        const SQL: &str = "UPDATE console_sessions SET sealed = $3 WHERE session_id = $1 AND sealed = $2";
        on!(&self.pool, |pool| sqlx::query(SQL)
            .bind(session_id)
            .bind(old)
            .bind(sealed)
            .execute(pool)
            .await
            .map(|done| done.rows_affected() > 0))
        .map_err(failed("renew a session"))
    }

    /// Ends a session that the provider does not continue, unless others have replaced its tokens.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn end_refused_session(&self, session_id: &[u8], sealed: &[u8]) -> Result<(), StoreError> {
        const SQL: &str = "DELETE FROM console_sessions WHERE session_id = $1 AND sealed = $2";
        on!(&self.pool, |pool| sqlx::query(SQL).bind(session_id).bind(sealed).execute(pool).await.map(drop))
            .map_err(failed("end a session"))
    }

    /// Ends a session, and records the sign-out in the audit log.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn end_session(&self, session_id: &[u8], action: &NewAction) -> Result<(), StoreError> {
        const WHAT: &str = "end a session";
        const SQL: &str = "DELETE FROM console_sessions WHERE session_id = $1";
        let mut tx = self.pool.begin().await.map_err(failed(WHAT))?;
        record_done(&mut tx, action, action.asked_us).await?;
        on!(&mut tx, |tx| sqlx::query(SQL).bind(session_id).execute(&mut **tx).await.map(drop))
            .map_err(failed(WHAT))?;
        tx.commit().await.map_err(failed(WHAT))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A clock was ahead by a year: once it was right again, sessions that had begun meanwhile held for a year.
    #[test]
    fn regress_a_session_of_a_clock_that_was_ahead_does_not_hold() {
        let row = |created_us| SessionRow {
            session_id: Vec::new(),
            actor: "ada".to_owned(),
            sealed: Vec::new(),
            created_us,
            expires_us: created_us + 12 * AHEAD_US_MAX,
        };
        let now_us = 1_795_248_000_000_000;
        let holds = |created_us| row(created_us).holds(now_us);
        assert!(holds(now_us) && holds(now_us + AHEAD_US_MAX) && holds(now_us - 12 * AHEAD_US_MAX + 1));
        assert!(!holds(now_us + AHEAD_US_MAX + 1) && !holds(now_us + 9_000 * AHEAD_US_MAX));
        assert!(!holds(now_us - 12 * AHEAD_US_MAX));
    }
}
