//! The engine's input: received messages as [`Incoming`], and the [`LinkState`] of the transport that receives them.
//!
//! The queue is bounded in messages and bytes, and shared fairly among robots (`fair`). The receiver fills it through
//! an `Intake`; the engine takes messages out.
//!
//! Messages received together are handed over together: one lock, one wake-up and one allocation for all of them.

mod fair;
mod intake;

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use tokio::sync::Notify;
use vibrissa_core::units::Micros;

pub use fair::{Filling, Shed};
pub(crate) use intake::{Intake, inbox};

use crate::births::BirthCause;
use crate::link_state::LinkState;
use fair::{Bounds, FairQueues};

/// A message as a transport has received it.
#[derive(Debug)]
pub struct Incoming {
    /// The topic of the contract.
    pub topic: Bytes,
    /// Payload: JSON, if the robot conforms to the contract.
    pub payload: Bytes,
    /// Receipt time by the supervisor's clock, µs since 1970.
    pub received: Micros,
}

/// Enough for a burst of 100,000 messages per second during a commit of half a second, without shedding.
const BOUNDS: Bounds =
    Bounds { messages: 100_000, messages_reserved: 10_000, bytes: 64 * 1024 * 1024, bytes_reserved: 8 * 1024 * 1024 };

/// Robots whose messages wait because they send too much: their levels of the topic, and the receipt times of their oldest
/// messages.
pub(crate) type Delayed = HashMap<Vec<u8>, Micros>;

/// State shared by both ends.
#[derive(Debug, Default)]
struct Shared {
    waiting: Mutex<Waiting>,
    /// Notified when messages arrive, or when no more can.
    arrived: Notify,
    /// Whether the receiver hears the robots.
    link: LinkState,
}

#[derive(Debug, Default)]
struct Waiting {
    messages: FairQueues,
    /// Receipt time of the first message that is received but not handed over yet.
    received: Option<Micros>,
    /// Births and factsheets are to be requested again, for this cause.
    wants_births: Option<BirthCause>,
    /// The receiving end has gone: no more messages can arrive.
    ended: bool,
    /// The engine's end has gone: nobody takes messages any more.
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
    /// Gives up to `most` messages, and returns their number. `None` if there are none now, but may be later.
    fn give(&mut self, most: usize, to: &mut impl FnMut(Incoming)) -> Option<usize> {
        let count = self.messages.give(most, to);
        (count > 0 || self.ended && self.messages.is_empty()).then_some(count)
    }
}

/// The engine's end of the inbox, bounded in messages and bytes.
#[derive(Debug)]
pub struct Inbox {
    shared: Arc<Shared>,
    bounds: Bounds,
}

impl Inbox {
    /// Waits for the next message; `None` when no more can arrive. Cancel safe.
    pub async fn recv(&mut self) -> Option<Incoming> {
        let mut next = None;
        self.take(1, |message| next = Some(message)).await;
        next
    }

    /// Waits for at least one message, and gives up to `most` (at least 1) of those that wait: robots in turns, the
    /// messages of each in order. Returns 0 when no more can arrive. Cancel safe.
    pub async fn recv_many(&mut self, into: &mut Vec<Incoming>, most: usize) -> usize {
        self.take(most.max(1), |message| into.push(message)).await
    }

    async fn take(&mut self, most: usize, mut to: impl FnMut(Incoming)) -> usize {
        loop {
            // Created before the check, so that no notification between the check and the wait is missed.
            let arrived = self.shared.arrived.notified();
            if let Some(count) = self.shared.waiting().give(most, &mut to) {
                return count;
            }
            arrived.await;
        }
    }

    /// State of the receiver's connection.
    #[must_use]
    pub fn link(&self) -> &LinkState {
        &self.shared.link
    }

    /// Whether no messages wait.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.shared.waiting().messages.is_empty()
    }

    /// Begins a round with the number of the transaction: each robot has its share of it again.
    pub fn begin_round(&self, number: u64) {
        self.shared.waiting().messages.begin_round(number);
    }

    /// Whether messages wait for another round.
    #[must_use]
    pub fn is_throttling(&self) -> bool {
        self.shared.waiting().messages.is_throttling()
    }

    /// Receipt time of the oldest message that waits or is not handed over yet, without those that wait because their own
    /// robot sends too much.
    #[must_use]
    pub fn oldest(&self) -> Option<Micros> {
        let waiting = self.shared.waiting();
        waiting.messages.oldest().into_iter().chain(waiting.received).min()
    }

    /// Robots whose messages wait because they send too much.
    #[must_use]
    pub(crate) fn delayed(&self) -> Delayed {
        let waiting = self.shared.waiting();
        if !waiting.messages.is_throttling() {
            return Delayed::new();
        }
        waiting.messages.delayed().map(|(robot, oldest)| (robot.to_vec(), oldest)).collect()
    }

    /// The robots whose messages were shed since the last call because they sent more than their share, and the number
    /// of messages shed because the inbox was full.
    pub fn take_shed(&self) -> (Vec<Shed>, u64) {
        self.shared.waiting().messages.take_shed()
    }

    /// Requests births and factsheets again, from the broker and from the robots.
    pub fn want_births(&self, cause: BirthCause) {
        self.shared.waiting().wants_births.get_or_insert(cause);
    }

    /// Amount of waiting messages.
    #[must_use]
    pub fn filling(&self) -> Filling {
        self.shared.filling()
    }

    /// Largest amount of messages that may wait.
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
