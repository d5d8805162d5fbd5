//! The receiving end of the inbox, and shedding of messages.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use tokio::time::Instant;
use tracing::warn;
use vibrissa_core::units::Micros;
use vibrissa_edge::full_name::FullName;
use vibrissa_protocol::RobotTopic;

use super::fair::{Bounds, ShedReason};
use super::{BOUNDS, Inbox, Incoming, Shared};
use crate::births::BirthCause;
use crate::metrics::FleetMetrics;
use vibrissa_edge::clock::wall_clock;

/// Reason under which messages other than contacts are counted as refused when the inbox is full.
const INBOX_FULL: &str = "inbox_full";
/// Reason under which they are counted as refused when their robot has more than its share.
const OVER_SHARE: &str = "over_share";
/// Messages received together share an allocation of at most this many bytes, unless one alone is larger. So a message
/// keeps at most this much of other messages alive.
const SHARED_BYTES: usize = 64 * 1024;
/// Shortest interval between two warnings about shed messages.
const WARNING_INTERVAL: Duration = Duration::from_secs(10);

/// The receiving end of an inbox.
#[derive(Debug)]
pub(crate) struct Intake {
    shared: Arc<Shared>,
    bounds: Bounds,
    metrics: FleetMetrics,
    /// Messages received since the last hand-over, with the indices of their queues.
    together: Vec<(Bytes, Bytes, usize)>,
    /// Receipt time of the first of them. The times of messages read together differ by one microsecond each, so that
    /// they give their order.
    received: Micros,
    /// A message has been shed since the inbox last had space.
    shedding: bool,
    /// Time of the last warning.
    warned: Option<Instant>,
    /// A retained message was shed.
    missed: bool,
}

/// Both ends of a new inbox.
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
        warned: None,
        missed: false,
    };
    (intake, Inbox { shared, bounds })
}

impl Intake {
    /// Sets whether the receiver hears the robots. Returns whether it did before.
    pub(crate) fn set_hears(&self, hears: bool) -> bool {
        self.shared.link.set(hears)
    }

    /// Receives a message, or sheds and counts it. Shed messages come again: robots send contacts again, setpoints are
    /// sent again until they are answered, and births and factsheets are requested again, see [`Self::take_wanted`]. The
    /// message is in the inbox after the next [`Self::hand_over`], which must follow before the task waits.
    pub(crate) fn take(&mut self, topic: Bytes, payload: Bytes) {
        // The engine reads its clock before it locks: its ticks must not be later than a message that is stamped earlier.
        let mut waiting = self.shared.waiting();
        if self.together.is_empty() {
            self.received = after(self.received, wall_clock());
        }
        let place = waiting.messages.reserve(&topic, &payload, &self.bounds);
        if place.is_ok() {
            waiting.received.get_or_insert(self.received);
        }
        drop(waiting);
        match place {
            Ok(at) => self.together.push((topic, payload, at)),
            Err(why) => self.shed(&topic, why),
        }
    }

    /// Puts the received messages into the inbox, and returns their number.
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
            // A message that waits long must not share an allocation with one that does not: it would keep all of it
            // alive.
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
        waiting.received = None;
        drop(waiting);
        if !is_abandoned {
            self.metrics.promises.received(together.len() as u64);
        }
        self.shared.arrived.notify_one();
        if is_abandoned {
            together.iter().for_each(|(topic, _, _)| self.shed(topic, ShedReason::Full));
        }
        let count = together.len();
        // Keep the allocation.
        self.together = together;
        self.together.clear();
        count
    }

    fn shed(&mut self, topic: &[u8], why: ShedReason) {
        let is_contacts = topic.ends_with(b"/contacts");
        match (why, is_contacts) {
            (ShedReason::Full, true) => self.metrics.messages_shed.inc(),
            (ShedReason::OverShare, true) => {
                self.metrics.messages_shed.inc();
                self.metrics.messages_shed_over_share.inc();
            }
            (ShedReason::Full, false) => {
                self.metrics.messages_refused.count([INBOX_FULL]);
                let retained = RobotTopic::ALL.into_iter().filter(|kind| kind.is_retained());
                self.missed |= retained.map(RobotTopic::as_str).any(|kind| topic.ends_with(kind.as_bytes()));
            }
            (ShedReason::OverShare, false) => self.metrics.messages_refused.count([OVER_SHARE]),
        }
        if why == ShedReason::Full {
            self.shared.waiting().messages.note_full();
            self.shedding = true;
        }
        if self.warned.is_none_or(|warned| warned.elapsed() >= WARNING_INTERVAL) {
            self.warned = Some(Instant::now());
            let topic = String::from_utf8_lossy(topic);
            let mut levels = topic.split('/').skip(2);
            let robot = FullName::robot(levels.next().unwrap_or_default(), levels.next().unwrap_or_default());
            match why {
                ShedReason::Full => {
                    warn!(%robot, %topic, "inbox full, shedding messages (counted)")
                }
                ShedReason::OverShare => {
                    warn!(%robot, %topic, "robot sends more than its share, shedding its messages (counted)");
                }
            }
        }
    }

    /// The cause, once, for which births and factsheets must be requested again: that of [`Inbox::want_births`], or the
    /// inbox has space again after one was shed.
    pub(crate) fn take_wanted(&mut self) -> Option<BirthCause> {
        let wanted = self.shared.waiting().wants_births.take();
        if wanted.is_some() || !self.shedding {
            return wanted;
        }
        let filling = self.shared.filling();
        if filling.messages >= self.bounds.messages / 2 || filling.bytes >= self.bounds.bytes / 2 {
            return None;
        }
        self.shedding = false;
        std::mem::take(&mut self.missed).then_some(BirthCause::Shed)
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

/// Receipt time of the next messages: not before the last time given, unless the clock was set back.
fn after(given: Micros, now: Micros) -> Micros {
    let is_close = given > now && given.0 - now.0 <= BOUNDS.messages as u64;
    if is_close { given } else { now }
}

/// Copies of messages, `bytes` long together, in one allocation. As received they are slices of a larger buffer, which
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
mod tests;
