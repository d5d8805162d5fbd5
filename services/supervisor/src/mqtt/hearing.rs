//! Proves that a connection receives the messages of its subscriptions.
//!
//! A broker can acknowledge a subscription and lose it. Therefore the connection publishes a probe for each of its
//! topic filters every few seconds, and waits until the probe comes back. A probe carries 128 random bits, so that
//! nobody else can forge it.
//!
//! In a burst a probe may be late, because it waits in the broker's queue, or may be lost, because the queue is full. A
//! missing probe therefore means deafness at once only at low traffic. At high traffic it is sent again, and a filter
//! counts as lost if nothing arrives through it for longer than a queue can explain.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_protocol::{Name, RobotTopic};

use super::identity::random_hex;

/// Interval between two rounds of probes.
pub(super) const PERIOD: Duration = Duration::from_secs(3);
/// Time limit for a probe to come back.
pub(super) const PATIENCE: Duration = Duration::from_secs(2);
/// Interval between two judgements of an overdue probe in a burst.
const LOOK: Duration = Duration::from_millis(500);
/// How long a burst can explain that nothing arrives through a filter.
const QUEUE_MAX: Duration = Duration::from_secs(15);
/// Rate from which on it is a burst, messages per second.
const QUEUE_PER_S: f64 = 100.0;
/// A judgement that is late by more follows a standstill of this process, which could not read in the meantime.
const STANDSTILL: Duration = Duration::from_secs(1);
/// Time limit for the acknowledgement of the subscriptions while nothing comes: a third of a trial.
const UNANSWERED: Duration = Duration::from_secs(5);
/// Delay of the first probe until the subscriptions are acknowledged.
const NEVER: Duration = Duration::from_secs(365 * 86_400);

const HEAD: &[u8] = b"{\"probe\":\"";
const TAIL: &[u8] = b"\"}";
const NONCE_CHARS: usize = 32;

/// Whether a payload has the form of a probe, whoever sent it.
fn is_probe(payload: &[u8]) -> bool {
    let nonce = payload.strip_prefix(HEAD).and_then(|rest| rest.strip_suffix(TAIL));
    nonce.is_some_and(|nonce| nonce.len() == NONCE_CHARS && nonce.iter().all(u8::is_ascii_hexdigit))
}

/// Whether a message is a supervisor's probe.
pub(super) fn is_probe_on(topic: &[u8], payload: &[u8]) -> bool {
    is_probe(payload) && std::str::from_utf8(topic).is_ok_and(|topic| RobotTopic::probed_on(topic).is_some())
}

/// The probe of one topic filter.
#[derive(Debug)]
struct Probe {
    kind: RobotTopic,
    topic: String,
    payload: Vec<u8>,
    /// Time of the first probe sent after the last message that came through the filter.
    unproven_since: Instant,
    /// The probe of this round came back.
    came: bool,
    /// A robot's message that matches the filter arrived since the probe of this round was sent.
    robot_heard: bool,
}

impl Probe {
    fn is_missing(&self) -> bool {
        !self.came && !self.robot_heard
    }
}

/// Next action for the probes.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Tick {
    /// Wait until [`Hearing::due`].
    Wait,
    /// Publish the probes of [`Hearing::probes`].
    Probe,
    /// The broker does not acknowledge the subscriptions.
    Unsubscribed,
    /// Nothing arrives through these filters.
    Deaf {
        /// Topics of the filters whose probe is missing, at least one.
        topics: Vec<RobotTopic>,
        /// The broker has sent nothing at all since the probes were published.
        is_silent: bool,
    },
}

/// State of the probes of one connection.
#[derive(Debug)]
pub(super) struct Hearing {
    /// Common prefix of the probes' topics.
    prefix: String,
    probes: Vec<Probe>,
    due: Instant,
    /// The broker has acknowledged the subscriptions.
    is_subscribed: bool,
    /// Time at which this round was sent; `None` before the first.
    sent: Option<Instant>,
    /// Time at which the last probe of this round came back.
    came: Option<Instant>,
    /// The broker has rejected a probe of this round.
    is_refused: bool,
    /// Number of messages since the last judgement, and the time of that judgement.
    messages: u64,
    judged: Instant,
    /// The broker has sent something since the probes were published.
    is_alive: bool,
}

impl Hearing {
    /// Starts without a probe; the first is due at [`Self::subscribed`].
    pub(super) fn new(fleet: &Name, kinds: impl Iterator<Item = RobotTopic>, now: Instant) -> Self {
        let probe = |kind: RobotTopic| Probe {
            kind,
            topic: kind.probe_topic(fleet),
            payload: Vec::new(),
            unproven_since: now,
            came: false,
            robot_heard: false,
        };
        let probes: Vec<Probe> = kinds.map(probe).collect();
        let prefix = format!("whisker/v1/{fleet}/{}/", Name::RESERVED);
        Self {
            prefix,
            probes,
            due: now + NEVER,
            is_subscribed: false,
            sent: None,
            came: None,
            is_refused: false,
            messages: 0,
            judged: now,
            is_alive: false,
        }
    }

    /// The subscriptions are on their way.
    pub(super) fn asked(&mut self, now: Instant) {
        if !self.is_subscribed {
            self.due = now + UNANSWERED;
        }
    }

    /// The broker has acknowledged the subscriptions: the first probes are due.
    pub(super) fn subscribed(&mut self, now: Instant) {
        self.is_subscribed = true;
        if self.sent.is_none() {
            self.due = now;
        }
    }

    /// Time at which [`Self::tick`] must be called next.
    pub(super) fn due(&self) -> Instant {
        self.due
    }

    /// Whether a message or probe has come through each filter in this round.
    pub(super) fn is_proven(&self) -> bool {
        self.sent.is_some() && !self.is_refused && !self.probes.iter().any(Probe::is_missing)
    }

    /// Time from the publication of this round's probes until the last of them came back.
    pub(super) fn round_trip(&self) -> Option<Duration> {
        Some(self.came?.saturating_duration_since(self.sent?))
    }

    /// Topics and payloads of the probes to publish.
    pub(super) fn probes(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.probes.iter().map(|probe| (probe.topic.as_str(), probe.payload.as_slice()))
    }

    /// Records that the broker has rejected a probe. This says nothing about the right to read topics.
    pub(super) fn refused(&mut self) {
        self.is_refused = true;
        if let Some(sent) = self.sent {
            self.due = sent + PERIOD;
        }
    }

    /// Records that the broker has acknowledged a probe, which shows that it is alive.
    pub(super) fn acknowledged(&mut self) {
        self.is_alive = true;
    }

    /// Records a message. Returns true for probes of any supervisor, which do not go to the inbox.
    pub(super) fn take(&mut self, topic: &[u8], payload: &[u8]) -> bool {
        self.messages += 1;
        let Some(kind) = topic.strip_prefix(self.prefix.as_bytes()) else {
            self.note(topic);
            return false;
        };
        let Some(probe) = self.probes.iter_mut().find(|probe| probe.kind.as_str().as_bytes() == kind) else {
            return false;
        };
        if !is_probe(payload) {
            return false;
        }
        if !probe.came && probe.payload == payload {
            probe.came = true;
            self.came = Some(Instant::now());
            self.finish();
        }
        true
    }

    /// A robot's message proves its filter like a probe does. Once the round is complete, messages need no inspection.
    fn note(&mut self, topic: &[u8]) {
        self.is_alive = true;
        if !self.probes.iter().any(Probe::is_missing) {
            return;
        }
        let Some(kind) = topic.rsplit(|&byte| byte == b'/').next() else { return };
        if let Some(probe) = self.probes.iter_mut().find(|probe| probe.kind.as_str().as_bytes() == kind) {
            probe.robot_heard = true;
            self.finish();
        }
    }

    /// Schedules the next round, if this one is complete.
    fn finish(&mut self) {
        if let Some(sent) = self.sent
            && self.is_proven()
        {
            self.due = sent + PERIOD;
        }
    }

    /// Judges the current round, or begins the next.
    pub(super) fn tick(&mut self, now: Instant) -> Tick {
        let Some(late) = now.checked_duration_since(self.due) else { return Tick::Wait };
        if !self.is_subscribed {
            // Messages may come before the answer. After a standstill of the process it waits in the socket.
            if late <= STANDSTILL && std::mem::take(&mut self.messages) == 0 {
                return Tick::Unsubscribed;
            }
            self.due = now + UNANSWERED;
            return Tick::Wait;
        }
        let messages = std::mem::take(&mut self.messages);
        let elapsed = now.saturating_duration_since(std::mem::replace(&mut self.judged, now));
        let missing: Vec<RobotTopic> =
            self.probes.iter().filter(|probe| probe.is_missing()).map(|probe| probe.kind).collect();
        if self.sent.is_none() || missing.is_empty() || self.is_refused {
            self.begin(now);
            return Tick::Probe;
        }
        if late > STANDSTILL {
            self.due = now + PATIENCE;
            return Tick::Wait;
        }
        let is_burst = messages as f64 >= QUEUE_PER_S * elapsed.as_secs_f64();
        let unproven = self.probes.iter().filter(|probe| probe.is_missing()).map(|probe| probe.unproven_since).min();
        let is_explained = unproven.is_some_and(|since| now.saturating_duration_since(since) < QUEUE_MAX);
        if is_burst && is_explained {
            // Other probes of this round came through the queue, so the missing one was probably dropped.
            let is_overtaken = self.came.is_some_and(|came| now.saturating_duration_since(came) >= PATIENCE);
            if is_overtaken {
                self.begin(now);
                return Tick::Probe;
            }
            self.due = now + LOOK;
            return Tick::Wait;
        }
        Tick::Deaf { topics: missing, is_silent: self.came.is_none() && !self.is_alive }
    }

    fn begin(&mut self, now: Instant) {
        for probe in &mut self.probes {
            if self.sent.is_none() || !probe.is_missing() || self.is_refused {
                probe.unproven_since = now;
            }
            probe.payload = [HEAD, random_hex().as_bytes(), TAIL].concat();
            (probe.came, probe.robot_heard) = (false, false);
        }
        (self.sent, self.came, self.is_refused, self.is_alive) = (Some(now), None, false, false);
        self.due = now + PATIENCE;
    }
}

#[cfg(test)]
mod tests;
