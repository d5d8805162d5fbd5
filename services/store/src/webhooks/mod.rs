//! Webhooks: targets, each with its position in the log of events, and dead letters.
//!
//! [`manage`] creates and changes targets, [`queue`] hands the next event to the supervisor that delivers, and [`dead`] has the
//! events that were given up.

pub mod dead;
mod job;
pub mod manage;
pub mod queue;
#[cfg(test)]
mod tests;
pub mod upkeep;

use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::events::Interest;

use super::database::{Either, Pool, Tx};
use super::events::Position;
use super::from_row::from_row;

/// Largest number of webhooks. Each may hold a thread, of which there are 512.
pub const WEBHOOKS_MAX: i64 = 200;
/// Largest number of webhooks of a fleet, and of those for all fleets or with a pattern.
pub const WEBHOOKS_PER_FLEET_MAX: usize = 50;
/// Number of dead letters that each target keeps.
pub const DEAD_LETTERS_MAX: i64 = 1000;

/// Beginning of the URL of a person's address.
pub const MAIL: &str = "mailto:";

from_row! {
    /// A target, without its secrets.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct WebhookRow {
        /// Number of the target.
        pub webhook_id: i64,
        /// Name for people, unique.
        pub name: String,
        /// URL that receives the events: of a program, or `mailto:` and a person's address.
        pub url: String,
        /// Names and patterns of the fleets of its events, separated by commas; `None` for all.
        pub fleets: Option<String>,
        /// Kinds of its events, separated by commas; `None` for all.
        pub kinds: Option<String>,
        /// Its least urgent events.
        pub level: String,
        /// Whether events are delivered; otherwise they wait.
        pub enabled: bool,
        /// Until when the previous secret signs requests, too, µs since 1970 UTC.
        pub previous_until_us: Option<i64>,
        /// Time of its creation, µs since 1970 UTC.
        pub created_us: i64,
        /// Time of the last change, µs since 1970 UTC.
        pub changed_us: i64,
        /// Actor of the last change.
        pub changed_by: String,
        /// Transaction of the last event that is done.
        pub done_tx: i64,
        /// Number of that event.
        pub done_event: i64,
        /// Failed attempts since the last success.
        pub streak: i64,
        /// Earliest time of the next attempt, µs since 1970 UTC.
        pub next_us: i64,
        /// Time of the last attempt, µs since 1970 UTC.
        pub last_us: Option<i64>,
        /// HTTP status of the last answer; `None` without an answer.
        pub last_status: Option<i64>,
        /// Why the last attempt failed; `None` after a success.
        pub last_problem: Option<String>,
        /// Time of the last success, µs since 1970 UTC.
        pub last_success_us: Option<i64>,
        /// Number of successful attempts.
        pub delivered: i64,
        /// Number of failed attempts.
        pub failed: i64,
        /// Number of events that were removed undelivered.
        pub lost: i64,
    }
}

/// Columns of [`WebhookRow`].
const COLUMNS: &str = "webhook_id, name, url, fleets, kinds, level, enabled, previous_until_us, created_us, changed_us, \
     changed_by, done_tx, done_event, streak, next_us, last_us, last_status, last_problem, last_success_us, \
     delivered, failed, lost";

impl WebhookRow {
    /// Whether the target is a person's address, which gets mails instead of requests.
    #[must_use]
    pub fn is_mail(&self) -> bool {
        self.url.starts_with(MAIL)
    }

    /// The events that the target wants.
    #[must_use]
    pub fn interest(&self) -> Interest {
        Interest::stored(self.fleets.as_deref(), self.kinds.as_deref(), &self.level)
    }

    /// Position of the last event that is done: delivered, given up, or not wanted.
    pub(crate) fn done(&self) -> Position {
        Position { tx: self.done_tx, event_id: self.done_event }
    }
}

/// The present time by the clock that all supervisors of the database share, µs since 1970 UTC.
async fn now_us(tx: &mut Tx<'_>) -> sqlx::Result<i64> {
    match tx {
        Either::Sqlite(_) => Ok(wall_clock().0 as i64),
        Either::Postgres(tx) => {
            const SQL: &str = "SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::bigint";
            sqlx::query_scalar(SQL).fetch_one(&mut **tx).await
        }
    }
}

/// As [`now_us`], outside of a transaction.
async fn now_us_of(pool: &Pool) -> sqlx::Result<i64> {
    match pool {
        Either::Sqlite(_) => Ok(wall_clock().0 as i64),
        Either::Postgres(pool) => {
            const SQL: &str = "SELECT (extract(epoch FROM clock_timestamp()) * 1000000)::bigint";
            sqlx::query_scalar(SQL).fetch_one(pool).await
        }
    }
}
