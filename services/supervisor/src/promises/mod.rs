//! The promises to a fleet's robots, and for how long each has been open: the one source for readiness, metrics
//! and alerts about the way of a message.
//!
//! ```text
//! made by a robot ──RECEIVED──▶ received ──COMMITTED──▶ committed ──RECEIPTED──▶ receipted
//!                                                       setpoint sent ──ANSWERED──▶ answered
//! ```
//!
//! Each part of the service states its progress. The ages are computed when somebody reads them, so that they grow
//! also while a part hangs.

mod watermark;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;
use tokio::time::Instant;

use watermark::Watermark;

/// How long the supervisor's own promises may be open before it counts as not ready: longer than the slowest disk needs
/// for a commit.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// A promise to the fleet's robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Promise {
    /// Every message that a robot makes is received: open while the fleet is not heard, and while numbers are missing.
    Received,
    /// Every message that is received is committed.
    Committed,
    /// Every committed contact is receipted: open until the receipt is handed to the broker.
    Receipted,
    /// Every setpoint is answered by its robot.
    Answered,
}

impl Promise {
    /// All promises, in the order of a message's way.
    pub const ALL: [Self; 4] = [Self::Received, Self::Committed, Self::Receipted, Self::Answered];

    /// Its word in metrics and in `/readyz`.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Received => "RECEIVED",
            Self::Committed => "COMMITTED",
            Self::Receipted => "RECEIPTED",
            Self::Answered => "ANSWERED",
        }
    }
}

/// Ages of the oldest items for which a promise is open, s; null if there are none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub struct Ages {
    /// Since when the robots are not heard, or the oldest gap in the numbers of a robot's messages.
    pub received: Option<f64>,
    /// The oldest message that is not committed.
    pub committed: Option<f64>,
    /// The oldest receipt that the broker does not have.
    pub receipted: Option<f64>,
    /// The oldest setpoint without a final answer.
    pub answered: Option<f64>,
}

/// The open promises of a fleet. Clones share their state.
#[derive(Debug, Clone, Default)]
pub struct Promises(Arc<Mutex<Open>>);

#[derive(Debug, Default)]
struct Open {
    /// Since when robots may be unheard.
    deaf_since: Option<Instant>,
    /// Time of the oldest gap in the numbers of a robot's messages.
    gap_since: Option<Instant>,
    /// Messages from their receipt to their commit.
    uncommitted: Watermark,
    /// Why the last attempt to commit failed; `None` after a success.
    failure: Option<String>,
    /// Receipts from their commit until the broker has them.
    unreceipted: Watermark,
    /// Time of the oldest setpoint without a final answer.
    unanswered_since: Option<Instant>,
}

impl Open {
    fn oldest(&self, promise: Promise) -> Option<Instant> {
        match promise {
            Promise::Received => self.deaf_since.into_iter().chain(self.gap_since).min(),
            Promise::Committed => self.uncommitted.oldest(),
            Promise::Receipted => self.unreceipted.oldest(),
            Promise::Answered => self.unanswered_since,
        }
    }

    fn age(&self, promise: Promise, now: Instant) -> Option<Duration> {
        self.oldest(promise).map(|since| now.saturating_duration_since(since))
    }
    fn heard(&mut self, is_heard: bool, now: Instant) {
        self.deaf_since = if is_heard { None } else { self.deaf_since.or(Some(now)) };
    }

    fn surveyed(&mut self, gap: Option<Duration>, unanswered: Option<Duration>, now: Instant) {
        self.gap_since = gap.and_then(|age| now.checked_sub(age));
        self.unanswered_since = unanswered.and_then(|age| now.checked_sub(age));
    }

    fn problems(&self, now: Instant) -> Vec<String> {
        let overdue = |promise| self.age(promise, now).filter(|age| *age > PATIENCE);
        let recorded = match (&self.failure, overdue(Promise::Committed)) {
            (Some(why), _) => Some(why.clone()),
            (None, Some(age)) => Some(format!(
                "nothing is recorded: a message has waited for its commit for {} s; the database is too slow, or hangs",
                age.as_secs()
            )),
            (None, None) => None,
        };
        let receipted = overdue(Promise::Receipted).map(|age| {
            format!("a receipt has waited for {} s to be published; robots keep their contacts", age.as_secs())
        });
        recorded.into_iter().chain(receipted).collect()
    }
}

impl Promises {
    /// Notes whether the robots are heard.
    pub fn heard(&self, is_heard: bool) {
        self.open().heard(is_heard, Instant::now());
    }

    /// Notes that `count` messages were received.
    pub fn received(&self, count: u64) {
        self.open().uncommitted.enter(count, Instant::now());
    }

    /// Notes that `count` messages are committed, or need no commit.
    pub fn committed(&self, count: u64) {
        self.open().uncommitted.leave(count, Instant::now());
    }

    /// Notes that a transaction was committed: the database accepts writes.
    pub fn recorded(&self) {
        self.open().failure = None;
    }

    /// Notes why an attempt to commit failed.
    pub fn failed(&self, why: String) {
        self.open().failure = Some(why);
    }

    /// Notes that `count` receipts are due, because their contacts are committed.
    pub fn receipts_due(&self, count: u64) {
        self.open().unreceipted.enter(count, Instant::now());
    }

    /// Notes that `count` receipts are with the broker, or are not sent at all.
    pub fn receipted(&self, count: u64) {
        self.open().unreceipted.leave(count, Instant::now());
    }

    /// Notes the ages of the oldest gap in the numbers of a robot's messages, and of the oldest setpoint without a final
    /// answer.
    pub fn surveyed(&self, gap: Option<Duration>, unanswered: Option<Duration>) {
        self.open().surveyed(gap, unanswered, Instant::now());
    }

    /// Ends all promises, because the fleet is supervised elsewhere.
    pub fn end(&self) {
        *self.open() = Open::default();
    }

    /// The age of the oldest item for which a promise is open; `None` if there is none.
    #[must_use]
    pub fn age(&self, promise: Promise) -> Option<Duration> {
        self.open().age(promise, Instant::now())
    }

    /// The ages of all promises.
    #[must_use]
    pub fn ages(&self) -> Ages {
        let age_s = |promise| self.age(promise).map(|age| age.as_secs_f64());
        Ages {
            received: age_s(Promise::Received),
            committed: age_s(Promise::Committed),
            receipted: age_s(Promise::Receipted),
            answered: age_s(Promise::Answered),
        }
    }

    /// The supervisor's own promises that are not kept, in words. Whether robots are heard says the state of the
    /// connections, and a robot that does not answer is its own alarm.
    #[must_use]
    pub fn problems(&self) -> Vec<String> {
        self.open().problems(Instant::now())
    }

    fn open(&self) -> MutexGuard<'_, Open> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests;
