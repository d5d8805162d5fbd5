//! The queue of received messages: bounded in messages and bytes, whatever robots send, and shared fairly among them
//! ([`fair`]). The broker's connection fills it through an `Intake`; the engine takes messages out.
//!
//! Messages that came together are handed over together: one lock, one wake-up and one allocation for all of them.

mod fair;
mod intake;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use tokio::sync::Notify;
use vibrissa_core::units::Micros;

pub use fair::{Filling, Shed};
pub(crate) use intake::{Intake, inbox};

use fair::{Bounds, Fair};

/// A message as it came from the broker.
#[derive(Debug)]
pub struct Incoming {
    /// The MQTT topic.
    pub topic: Bytes,
    /// The message itself: JSON if the robot keeps the contract.
    pub payload: Bytes,
    /// When, by the supervisor's clock.
    pub received: Micros,
}

/// A burst of 100,000 messages a second is through a commit of half a second before anything is shed.
const BOUNDS: Bounds =
    Bounds { messages: 100_000, messages_reserved: 10_000, bytes: 64 * 1024 * 1024, bytes_reserved: 8 * 1024 * 1024 };

/// What both ends see.
#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    /// Rings when something came, or when no more can come.
    arrived: Notify,
}

#[derive(Debug, Default)]
struct Waiting {
    messages: Fair,
    /// Request the broker's retained messages once more.
    wants_retained: bool,
    /// No more can come.
    ended: bool,
    /// Nobody takes anything any more.
    abandoned: bool,
}

impl Shared {
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn filling(&self) -> Filling {
        self.waiting().messages.held()
    }
}

impl Waiting {
    /// Gives up to `most` messages, and how many; none if nothing can be given now, but later.
    fn give(&mut self, most: usize, to: &mut impl FnMut(Incoming)) -> Option<usize> {
        let count = self.messages.give(most, to);
        (count > 0 || self.ended && self.messages.is_empty()).then_some(count)
    }
}

/// What was received and is not handled yet, bounded in messages and bytes.
#[derive(Debug)]
pub struct Inbox {
    shared: Arc<Shared>,
    bounds: Bounds,
}

impl Inbox {
    /// The next message; none when no more can come. Nothing is lost if it is not waited for to the end.
    pub async fn recv(&mut self) -> Option<Incoming> {
        let mut next = None;
        self.take(1, |message| next = Some(message)).await;
        next
    }

    /// Waits for at least one message, and gives up to `most` (at least 1) of those that are there: robots in turns, each one's in
    /// order. 0 when no more can come. Nothing is lost if it is not waited for to the end.
    pub async fn recv_many(&mut self, into: &mut Vec<Incoming>, most: usize) -> usize {
        self.take(most.max(1), |message| into.push(message)).await
    }

    async fn take(&mut self, most: usize, mut to: impl FnMut(Incoming)) -> usize {
        loop {
            // Asked for before the look, so that what comes between the two is not slept through.
            let arrived = self.shared.arrived.notified();
            if let Some(count) = self.shared.waiting().give(most, &mut to) {
                return count;
            }
            arrived.await;
        }
    }

    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.shared.waiting().messages.is_empty()
    }

    /// A transaction is gathered for, of this number: each robot has its share of it.
    pub fn begin_round(&self, number: u64) {
        self.shared.waiting().messages.begin_round(number);
    }

    /// Whether messages wait for another round.
    #[must_use]
    pub fn is_throttling(&self) -> bool {
        self.shared.waiting().messages.is_throttling()
    }

    /// When the oldest message was received that waits; those do not count that wait because their own robot sends too much.
    #[must_use]
    pub fn oldest(&self) -> Option<Micros> {
        self.shared.waiting().messages.oldest()
    }

    /// The robots whose messages were left out since the last look because they sent more than their share, and how many
    /// messages were left out because there was no room for anybody.
    pub fn take_shed(&self) -> (Vec<Shed>, u64) {
        self.shared.waiting().messages.take_shed()
    }

    /// Requests the broker's retained messages again: births and factsheets that were refused may be acceptable now.
    pub fn want_retained(&self) {
        self.shared.waiting().wants_retained = true;
    }

    /// How much waits.
    #[must_use]
    pub fn filling(&self) -> Filling {
        self.shared.filling()
    }

    /// How much may wait.
    #[must_use]
    pub fn capacity(&self) -> Filling {
        Filling { messages: self.bounds.messages, bytes: self.bounds.bytes }
    }
}

impl Drop for Inbox {
    fn drop(&mut self) {
        let mut waiting = self.shared.waiting();
        waiting.abandoned = true;
        waiting.messages.clear();
    }
}
