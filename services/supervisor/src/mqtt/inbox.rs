//! What was received and is not handled yet: bounded in messages and bytes, whatever robots send.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use bytes::Bytes;
use tokio::sync::mpsc;
use tracing::warn;
use vibrissa_protocol::RobotTopic;

use crate::engine::{Incoming, wall_clock};
use crate::metrics::FleetMetrics;

/// The label under which messages other than contacts are counted as refused when there is no room for them.
const INBOX_FULL: &str = "inbox_full";
/// What a message takes beside its topic and payload, generously.
const MESSAGE_BYTES: usize = 256;

/// How much may wait. Over the bounds nothing is taken; contacts leave the reserves to everything else.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    messages: usize,
    messages_reserved: usize,
    bytes: usize,
    bytes_reserved: usize,
}

const BOUNDS: Bounds =
    Bounds { messages: 20_000, messages_reserved: 2_000, bytes: 64 * 1024 * 1024, bytes_reserved: 8 * 1024 * 1024 };

/// What was received and is not handled yet, bounded in messages and bytes.
#[derive(Debug)]
pub struct Inbox {
    messages: mpsc::Receiver<Incoming>,
    bytes: Arc<AtomicUsize>,
    bytes_max: usize,
}

/// How full an inbox is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Filling {
    /// Messages.
    pub messages: usize,
    /// Bytes.
    pub bytes: usize,
}

impl Inbox {
    /// The next message; none when no more can come.
    pub async fn recv(&mut self) -> Option<Incoming> {
        let incoming = self.messages.recv().await?;
        self.bytes.fetch_sub(weight(&incoming.topic, &incoming.payload), Ordering::Relaxed);
        Some(incoming)
    }

    /// Takes the next messages, at most so many; waits for one. 0 when no more can come.
    pub async fn recv_many(&mut self, taken: &mut Vec<Incoming>, most: usize) -> usize {
        let before = taken.len();
        let count = self.messages.recv_many(taken, most).await;
        let bytes = taken[before..].iter().map(|one| weight(&one.topic, &one.payload)).sum();
        self.bytes.fetch_sub(bytes, Ordering::Relaxed);
        count
    }

    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.messages.is_empty()
    }

    /// How much waits.
    #[must_use]
    pub fn filling(&self) -> Filling {
        Filling { messages: self.messages.len(), bytes: self.bytes.load(Ordering::Relaxed) }
    }

    /// How much may wait.
    #[must_use]
    pub fn capacity(&self) -> Filling {
        Filling { messages: self.messages.max_capacity(), bytes: self.bytes_max }
    }
}

/// The end that fills an inbox.
#[derive(Debug)]
pub(super) struct Intake {
    sender: mpsc::Sender<Incoming>,
    bytes: Arc<AtomicUsize>,
    bounds: Bounds,
    metrics: FleetMetrics,
    /// Something has been left out since there was room last; said once.
    shedding: bool,
    /// Something was left out that the broker retains.
    missed: bool,
}

/// An inbox and the end that fills it.
pub(super) fn inbox(metrics: FleetMetrics) -> (Intake, Inbox) {
    bounded(BOUNDS, metrics)
}

fn bounded(bounds: Bounds, metrics: FleetMetrics) -> (Intake, Inbox) {
    let (sender, messages) = mpsc::channel(bounds.messages);
    let bytes = Arc::new(AtomicUsize::new(0));
    let intake = Intake { sender, bytes: bytes.clone(), bounds, metrics, shedding: false, missed: false };
    (intake, Inbox { messages, bytes, bytes_max: bounds.bytes })
}

fn weight(topic: &[u8], payload: &[u8]) -> usize {
    topic.len() + payload.len() + MESSAGE_BYTES
}

impl Intake {
    /// Takes a message in, or counts it as left out. Robots send contacts again; setpoints are sent again
    /// until they are answered; what is retained is asked for again, see [`Self::take_missed`].
    pub(super) fn take(&mut self, topic: &Bytes, payload: &Bytes) {
        let is_contacts = topic.ends_with(b"/contacts");
        let weight = weight(topic, payload);
        if !self.has_room(weight, is_contacts) {
            self.leave_out(topic, is_contacts);
            return;
        }
        self.bytes.fetch_add(weight, Ordering::Relaxed);
        // Copied: as received they are pieces of a larger buffer, which one small message would keep alive.
        let copied = |bytes: &Bytes| Bytes::copy_from_slice(bytes);
        let incoming = Incoming { topic: copied(topic), payload: copied(payload), received: wall_clock() };
        if self.sender.try_send(incoming).is_err() {
            self.bytes.fetch_sub(weight, Ordering::Relaxed);
            self.leave_out(topic, is_contacts);
        }
    }

    fn has_room(&self, weight: usize, is_contacts: bool) -> bool {
        let (messages, bytes) =
            if is_contacts { (self.bounds.messages_reserved, self.bounds.bytes_reserved) } else { (0, 0) };
        self.sender.capacity() > messages && self.bytes.load(Ordering::Relaxed) + weight + bytes <= self.bounds.bytes
    }

    fn leave_out(&mut self, topic: &[u8], is_contacts: bool) {
        if is_contacts {
            self.metrics.messages_shed.inc();
        } else {
            self.metrics.messages_refused.count([INBOX_FULL]);
            let retained = RobotTopic::ALL.into_iter().filter(|kind| kind.is_retained());
            self.missed |= retained.map(RobotTopic::as_str).any(|kind| topic.ends_with(kind.as_bytes()));
        }
        if !std::mem::replace(&mut self.shedding, true) {
            warn!(contacts = is_contacts, "more messages come in than are handled: some are left out, and counted");
        }
    }

    /// True once when there is room again after something retained was left out: it must be asked for.
    pub(super) fn take_missed(&mut self) -> bool {
        let is_half_empty = self.sender.capacity() > self.bounds.messages / 2
            && self.bytes.load(Ordering::Relaxed) < self.bounds.bytes / 2;
        if !is_half_empty {
            return false;
        }
        self.shedding = false;
        std::mem::take(&mut self.missed)
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::Name;

    use super::*;
    use crate::metrics::Metrics;

    const SMALL: Bounds = Bounds { messages: 100, messages_reserved: 10, bytes: 100_000, bytes_reserved: 20_000 };

    fn topic(kind: &str) -> Bytes {
        Bytes::from(format!("whisker/v1/f/r/{kind}"))
    }

    /// Takes in `count` messages; gives the most bytes that ever waited.
    fn flood(intake: &mut Intake, kind: &str, payload_bytes: usize, count: usize) -> usize {
        let payload = Bytes::from(vec![b'x'; payload_bytes]);
        let mut most = 0;
        for _ in 0..count {
            intake.take(&topic(kind), &payload);
            most = most.max(intake.bytes.load(Ordering::Relaxed));
        }
        most
    }

    fn counted() -> FleetMetrics {
        Metrics::new(false).unwrap().of_fleet(&Name::new("f").unwrap())
    }

    fn left_out(metrics: &FleetMetrics) -> (u64, u64) {
        (metrics.messages_shed.get(), metrics.messages_refused.of([INBOX_FULL]).get())
    }

    #[tokio::test]
    async fn floods_of_any_kind_stay_within_both_bounds_and_are_counted() {
        for (kind, payload_bytes) in [("status", 10), ("connection", 5_000), ("contacts", 10), ("contacts", 5_000)] {
            let metrics = counted();
            let (mut intake, mut inbox) = bounded(SMALL, metrics.clone());
            let most = flood(&mut intake, kind, payload_bytes, 5_000);
            assert!(most <= SMALL.bytes, "{kind} of {payload_bytes}: {most} bytes");
            drop(intake);
            let mut taken = 0;
            while inbox.recv().await.is_some() {
                taken += 1;
            }
            assert!((1..=SMALL.messages as u64).contains(&taken), "{kind}: {taken}");
            let (shed, refused) = left_out(&metrics);
            assert_eq!(shed + refused + taken, 5_000, "{kind}: none disappears uncounted");
            assert_eq!(shed == 0, kind != "contacts");
            assert_eq!(inbox.bytes.load(Ordering::Relaxed), 0);
        }
    }

    #[tokio::test]
    async fn contacts_leave_room_for_everything_else() {
        for payload_bytes in [10, 5_000] {
            let metrics = counted();
            let (mut intake, _inbox) = bounded(SMALL, metrics.clone());
            flood(&mut intake, "contacts", payload_bytes, 1_000);
            flood(&mut intake, "setpoint_state", 200, SMALL.messages_reserved);
            assert_eq!(left_out(&metrics).1, 0);
        }
    }

    #[tokio::test]
    async fn what_is_retained_is_asked_for_again_once_there_is_room() {
        let (mut intake, mut inbox) = bounded(SMALL, counted());
        flood(&mut intake, "factsheet", 10, SMALL.messages + 1);
        assert!(!intake.take_missed(), "there is no room yet");
        for _ in 0..SMALL.messages {
            inbox.recv().await.unwrap();
        }
        assert!(intake.take_missed());
        assert!(!intake.take_missed(), "once");
        flood(&mut intake, "status", 10, SMALL.messages + 1);
        for _ in 0..SMALL.messages {
            inbox.recv().await.unwrap();
        }
        assert!(!intake.take_missed(), "the broker keeps no status");
    }

    #[tokio::test]
    async fn a_message_does_not_keep_the_buffer_alive_that_it_came_in() {
        let (mut intake, mut inbox) = bounded(SMALL, counted());
        let buffer = Bytes::from(vec![b'x'; 1_000_000]);
        intake.take(&topic("status"), &buffer.slice(..10));
        assert!(buffer.is_unique(), "only we hold it");
        assert_eq!(inbox.recv().await.unwrap().payload.len(), 10);
    }
}
