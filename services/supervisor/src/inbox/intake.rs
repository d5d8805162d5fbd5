//! The end of the inbox that is filled, and messages for which there is no room.

use std::sync::Arc;
use std::time::{Duration, Instant};

use bytes::Bytes;
use tracing::warn;
use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;

use super::fair::{Bounds, LeftOut};
use super::{BOUNDS, Inbox, Incoming, Shared};
use crate::metrics::FleetMetrics;
use vibrissa_edge::clock::wall_clock;

/// The label under which messages other than contacts are counted as refused when there is no room for them.
const INBOX_FULL: &str = "inbox_full";
/// The same if the robot holds more than its share.
const OVER_SHARE: &str = "over_share";
/// Messages that came together share an allocation of this many bytes, unless one alone is larger: no message keeps
/// more than this of others alive.
const SHARED_BYTES: usize = 64 * 1024;
/// How often the log says that messages are left out.
const TELL_EVERY: Duration = Duration::from_secs(10);

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
mod tests;
