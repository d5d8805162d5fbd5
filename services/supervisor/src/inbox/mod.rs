//! The queue of received messages: bounded in messages and bytes, whatever robots send, and shared fairly among them
//! ([`fair`]).
//!
//! Messages that came together are handed over together: one lock, one wake-up and one allocation for all of them.

mod fair;

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bytes::Bytes;
use tokio::sync::Notify;
use tracing::warn;
use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;

use crate::clock::wall_clock;
pub use fair::{Filling, Shed};

use fair::{Bounds, Fair, LeftOut};

use crate::metrics::FleetMetrics;

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

/// The label under which messages other than contacts are counted as refused when there is no room for them.
const INBOX_FULL: &str = "inbox_full";
/// The same if the robot holds more than its share.
const OVER_SHARE: &str = "over_share";
/// Messages that came together share an allocation of this many bytes, unless one alone is larger: no message keeps
/// more than this of others alive.
const SHARED_BYTES: usize = 64 * 1024;
/// How often the log says that messages are left out.
const TELL_EVERY: Duration = Duration::from_secs(10);

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

/// The end that fills an inbox.
#[derive(Debug)]
pub(crate) struct Intake {
    shared: Arc<Shared>,
    bounds: Bounds,
    metrics: FleetMetrics,
    /// Taken in since the last hand-over, as they were received, with the places of their queues.
    together: Vec<(Bytes, Bytes, usize)>,
    /// When the first of them came; each message of a look counts as received a microsecond after the one before, so that their times
    /// tell their order.
    received: Micros,
    /// Something has been left out since there was room last.
    shedding: bool,
    /// When the log said so last.
    told: Option<Instant>,
    /// Something was left out that the broker retains.
    missed: bool,
}

/// An inbox and the end that fills it.
pub(crate) fn inbox(metrics: FleetMetrics) -> (Intake, Inbox) {
    bounded(BOUNDS, metrics)
}

fn bounded(bounds: Bounds, metrics: FleetMetrics) -> (Intake, Inbox) {
    let shared = Arc::new(Shared::default());
    let intake = Intake {
        shared: shared.clone(),
        bounds,
        metrics,
        together: Vec::new(),
        received: Micros::default(),
        shedding: false,
        told: None,
        missed: false,
    };
    (intake, Inbox { shared, bounds })
}

impl Intake {
    /// Takes a message in, or counts it as left out. Robots send contacts again; setpoints are sent again
    /// until they are answered; what is retained is asked for again, see [`Self::take_missed`].
    /// It is in the inbox with the next [`Self::hand_over`], which must follow before anything is waited for.
    pub(crate) fn take(&mut self, topic: Bytes, payload: Bytes) {
        if self.together.is_empty() {
            self.received = after(self.received, wall_clock());
        }
        let place = self.shared.waiting().messages.reserve(&topic, &payload, &self.bounds);
        match place {
            Ok(at) => self.together.push((topic, payload, at)),
            Err(why) => self.leave_out(&topic, why),
        }
    }

    /// Puts what was taken in into the inbox: so many messages.
    pub(crate) fn hand_over(&mut self) -> usize {
        if self.together.is_empty() {
            return 0;
        }
        let mut together = std::mem::take(&mut self.together);
        let mut waiting = self.shared.waiting();
        let is_abandoned = waiting.abandoned;
        if is_abandoned {
            waiting.messages.clear();
        } else {
            // What will wait for long shares no allocation with what will not: it would keep all of it alive.
            if together.iter().any(|(_, _, at)| waiting.messages.is_long(*at)) {
                together.sort_by_key(|(_, _, at)| waiting.messages.is_long(*at));
            }
            let long = together.partition_point(|(_, _, at)| !waiting.messages.is_long(*at));
            for mut rest in [&together[..long], &together[long..]] {
                while !rest.is_empty() {
                    let (count, bytes) = sharing(rest);
                    let (first, others) = rest.split_at(count);
                    for (message, (_, _, at)) in copied(first, bytes, self.received).zip(first) {
                        waiting.messages.push(*at, message);
                    }
                    self.received.0 += count as u64;
                    rest = others;
                }
            }
        }
        drop(waiting);
        self.shared.arrived.notify_one();
        if is_abandoned {
            together.iter().for_each(|(topic, _, _)| self.leave_out(topic, LeftOut::Full));
        }
        let count = together.len();
        // Its places are used again.
        self.together = together;
        self.together.clear();
        count
    }

    fn leave_out(&mut self, topic: &[u8], why: LeftOut) {
        let is_contacts = topic.ends_with(b"/contacts");
        match (why, is_contacts) {
            (LeftOut::Full, true) => self.metrics.messages_shed.inc(),
            (LeftOut::OverShare, true) => {
                self.metrics.messages_shed.inc();
                self.metrics.messages_shed_over_share.inc();
            }
            (LeftOut::Full, false) => {
                self.metrics.messages_refused.count([INBOX_FULL]);
                let retained = RobotTopic::ALL.into_iter().filter(|kind| kind.is_retained());
                self.missed |= retained.map(RobotTopic::as_str).any(|kind| topic.ends_with(kind.as_bytes()));
            }
            (LeftOut::OverShare, false) => self.metrics.messages_refused.count([OVER_SHARE]),
        }
        if why == LeftOut::Full {
            self.shared.waiting().messages.note_full();
            self.shedding = true;
        }
        if self.told.is_none_or(|told| told.elapsed() >= TELL_EVERY) {
            self.told = Some(Instant::now());
            let topic = String::from_utf8_lossy(topic);
            match why {
                LeftOut::Full => {
                    warn!(%topic, "more messages come in than are handled: some are left out, and counted")
                }
                LeftOut::OverShare => {
                    warn!(%topic, "a robot sends more than its share: some of its messages are left out, and counted");
                }
            }
        }
    }

    /// True once if the retained messages must be requested again: on demand, or when there is room again after one was
    /// left out.
    pub(crate) fn take_missed(&mut self) -> bool {
        if std::mem::take(&mut self.shared.waiting().wants_retained) {
            return true;
        }
        if !self.shedding {
            return false;
        }
        let filling = self.shared.filling();
        if filling.messages >= self.bounds.messages / 2 || filling.bytes >= self.bounds.bytes / 2 {
            return false;
        }
        self.shedding = false;
        std::mem::take(&mut self.missed)
    }
}

impl Drop for Intake {
    fn drop(&mut self) {
        self.hand_over();
        self.shared.waiting().ended = true;
        self.shared.arrived.notify_one();
    }
}

/// How many of the first messages share an allocation, and its bytes.
fn sharing(messages: &[(Bytes, Bytes, usize)]) -> (usize, usize) {
    let (mut count, mut bytes) = (0, 0);
    for (topic, payload, _) in messages {
        let more = topic.len() + payload.len();
        if count > 0 && bytes + more > SHARED_BYTES {
            break;
        }
        (count, bytes) = (count + 1, bytes + more);
    }
    (count, bytes)
}

/// The time of a look: not before the times that the look before has given, unless the clock was set back.
fn after(given: Micros, now: Micros) -> Micros {
    let is_close = given > now && given.0 - now.0 <= BOUNDS.messages as u64;
    if is_close { given } else { now }
}

/// Copies of messages, `bytes` long together, in one allocation: as received they are pieces of a larger buffer, which
/// one small message would keep alive.
fn copied(messages: &[(Bytes, Bytes, usize)], bytes: usize, received: Micros) -> impl Iterator<Item = Incoming> {
    let mut all = Vec::with_capacity(bytes);
    for (topic, payload, _) in messages {
        all.extend_from_slice(topic);
        all.extend_from_slice(payload);
    }
    let mut all = Bytes::from(all);
    messages.iter().zip(received.0..).map(move |((topic, payload, _), received)| {
        let topic = all.split_to(topic.len());
        Incoming { topic, payload: all.split_to(payload.len()), received: Micros(received) }
    })
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
        for number in 0..count {
            intake.take(topic(kind), payload.clone());
            // As they come: by sevens here.
            if number % 7 == 6 || number == count - 1 {
                intake.hand_over();
            }
            most = most.max(intake.shared.filling().bytes);
        }
        most
    }

    /// Takes in messages of many robots until one more does not fit.
    fn fill(intake: &mut Intake, kind: &str) {
        for robot in 0..=SMALL.messages {
            intake.take(Bytes::from(format!("whisker/v1/f/r{robot}/{kind}")), Bytes::from_static(b"x"));
        }
        intake.hand_over();
        assert_eq!(intake.shared.filling().messages, SMALL.messages);
    }

    async fn drain(inbox: &mut Inbox) {
        while !inbox.is_empty() {
            inbox.recv().await.unwrap();
        }
    }

    fn counted() -> FleetMetrics {
        Metrics::new(false).unwrap().of_fleet(&Name::new("f").unwrap())
    }

    fn left_out(metrics: &FleetMetrics) -> (u64, u64) {
        let refused = [INBOX_FULL, OVER_SHARE].map(|reason| metrics.messages_refused.of([reason]).get());
        (metrics.messages_shed.get(), refused.iter().sum())
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
            assert_eq!(inbox.filling(), Filling { messages: 0, bytes: 0 });
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
        fill(&mut intake, "factsheet");
        assert!(!intake.take_missed(), "there is no room yet");
        drain(&mut inbox).await;
        assert!(intake.take_missed());
        assert!(!intake.take_missed(), "once");
        fill(&mut intake, "status");
        drain(&mut inbox).await;
        assert!(!intake.take_missed(), "the broker keeps no status");
    }

    #[tokio::test]
    async fn a_message_does_not_keep_the_buffer_alive_that_it_came_in() {
        let (mut intake, mut inbox) = bounded(SMALL, counted());
        let buffer = Bytes::from(vec![b'x'; 1_000_000]);
        intake.take(topic("status"), buffer.slice(..10));
        intake.hand_over();
        assert!(buffer.is_unique(), "only we hold it");
        assert_eq!(inbox.recv().await.unwrap().payload.len(), 10);
    }

    #[tokio::test]
    async fn what_came_together_is_given_in_order_and_as_it_came() {
        let (mut intake, mut inbox) = bounded(BOUNDS, counted());
        let payload = |number: usize| Bytes::from(vec![number as u8; number % 50 * 20]);
        for number in 0..200 {
            intake.take(topic(&number.to_string()), payload(number));
        }
        assert!(inbox.is_empty(), "not yet");
        intake.hand_over();
        let (mut all, mut counts) = (Vec::new(), Vec::new());
        drop(intake);
        loop {
            match inbox.recv_many(&mut all, 90).await {
                0 => break,
                count => counts.push(count),
            }
        }
        assert_eq!(counts, [90, 90, 20]);
        for (number, incoming) in all.iter().enumerate() {
            assert_eq!((&incoming.topic, &incoming.payload), (&topic(&number.to_string()), &payload(number)));
        }
    }

    #[tokio::test]
    async fn regress_a_message_that_waits_for_long_keeps_no_other_alive() {
        let (mut intake, mut inbox) = bounded(BOUNDS, counted());
        let payload = Bytes::from(vec![b'x'; 1_000]);
        // One robot has sent more than it may in a round; each look brings one message more of it, and many of others.
        for _ in 0..300 {
            intake.take(topic("contacts"), payload.clone());
        }
        intake.hand_over();
        while !inbox.is_throttling() {
            inbox.recv_many(&mut Vec::new(), 1_000).await;
        }
        for look in 0..300 {
            intake.take(topic("contacts"), payload.clone());
            for other in 0..20 {
                intake.take(Bytes::from(format!("whisker/v1/f/other-{look}-{other}/contacts")), payload.clone());
            }
            intake.hand_over();
            inbox.recv_many(&mut Vec::new(), 1_000).await;
        }
        inbox.begin_round(1);
        let mut left = Vec::new();
        inbox.recv_many(&mut left, 1_000).await;
        assert!(left.len() > 180, "{}", left.len());
        // The first of them came together.
        for message in left.drain(..).skip(150) {
            drop(message.topic);
            let alone = message.payload.try_into_mut().unwrap_or_else(|_| panic!("it shares an allocation"));
            assert!(alone.capacity() < 2_000, "an allocation of {} bytes", alone.capacity());
        }
    }

    #[test]
    fn messages_that_share_an_allocation_are_few_or_small() {
        let message = |bytes: usize| (Bytes::new(), Bytes::from(vec![0; bytes]), 0);
        assert_eq!(sharing(&[message(10), message(20), message(SHARED_BYTES)]), (2, 30));
        assert_eq!(sharing(&[message(10 * SHARED_BYTES), message(1)]), (1, 10 * SHARED_BYTES));
        assert_eq!(sharing(&[message(SHARED_BYTES - 1), message(1), message(1)]), (2, SHARED_BYTES));
    }

    #[tokio::test]
    async fn whoever_waits_is_woken_by_a_message_and_by_the_end() {
        let (mut intake, mut inbox) = bounded(SMALL, counted());
        let waiting = tokio::spawn(async move {
            let first = inbox.recv().await.map(|incoming| incoming.payload.len());
            (first, inbox.recv().await.is_none())
        });
        tokio::task::yield_now().await;
        intake.take(topic("status"), Bytes::from_static(b"x"));
        intake.hand_over();
        tokio::task::yield_now().await;
        drop(intake);
        assert_eq!(waiting.await.unwrap(), (Some(1), true));
    }

    #[tokio::test]
    async fn a_wait_that_is_given_up_loses_nothing() {
        let (mut intake, mut inbox) = bounded(SMALL, counted());
        for _ in 0..3 {
            let mut given_up = Box::pin(inbox.recv());
            assert!(futures_util::poll!(&mut given_up).is_pending());
            intake.take(topic("status"), Bytes::from_static(b"x"));
            intake.hand_over();
            drop(given_up);
            assert!(inbox.recv().await.is_some());
        }
    }

    #[test]
    fn what_comes_when_nobody_takes_it_any_more_is_counted() {
        let metrics = counted();
        let (mut intake, inbox) = bounded(SMALL, metrics.clone());
        drop(inbox);
        flood(&mut intake, "contacts", 10, 1_000);
        assert_eq!(left_out(&metrics), (1_000, 0));
        assert_eq!(intake.shared.filling(), Filling { messages: 0, bytes: 0 });
    }
}
