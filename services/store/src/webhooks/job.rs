//! An event on its way to a target.

use super::WebhookRow;
use crate::events::StoredEvent;

/// An event to deliver now.
#[derive(Clone)]
pub struct Job {
    /// Target that gets the event.
    pub webhook: WebhookRow,
    /// Event as the log has it.
    pub event: StoredEvent,
    /// Events after it that the same mail tells; none for other targets, which get one event at a time.
    pub more: Vec<StoredEvent>,
    /// Keys that sign the request, the newest first. Neither logged nor shown.
    pub secrets: Vec<Vec<u8>>,
    /// Failed attempts of this event.
    pub attempts: i64,
    /// Whether it is a dead letter that is delivered again.
    pub is_again: bool,
    /// Time since the event, µs.
    pub age_us: i64,
}

impl Job {
    /// Its events, in order.
    pub fn events(&self) -> impl Iterator<Item = &StoredEvent> {
        std::iter::once(&self.event).chain(&self.more)
    }
}
