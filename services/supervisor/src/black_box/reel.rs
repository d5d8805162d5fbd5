//! The tape of one robot within its limits: what stays on it, and from which time on it has everything.

use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;

use super::tape::{Kind, Tape, TapeCopy};

/// Part of a robot's memory after which its state is put on the tape again: a busy robot's tape is shorter than a span.
const STATE_EVERY: usize = 8;
/// Shortest interval between two states of a busy robot.
const STATE_PAUSE: Micros = Micros(5_000_000);
/// A state larger than this part of the robot's memory is left out.
const STATE_PART: usize = 4;

/// Limits of a tape, which change with the number of robots.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Most bytes on the tape while a box is being recorded; two thirds of it otherwise, for up to two spans before an event.
    pub(super) share: usize,
    /// Time that the tape must cover.
    pub(super) span: Micros,
}

impl Limits {
    /// Most bytes while no box is being recorded.
    fn before(self) -> usize {
        self.share / 3 * 2
    }
}

/// A tape, and what has been removed from it.
#[derive(Debug)]
pub(super) struct Reel {
    tape: Tape,
    /// Time from which on the tape has all messages.
    from: Micros,
    /// The newest connection message and factsheet before the tape's first entry.
    base: [Option<Vec<u8>>; 2],
    /// Time of the last state, and bytes of the messages since then.
    state_at: Micros,
    since_state: usize,
}

/// Index in `base`.
fn base_of(kind: Kind) -> Option<usize> {
    match kind {
        Kind::Message(RobotTopic::Connection) => Some(0),
        Kind::Message(RobotTopic::Factsheet) => Some(1),
        Kind::Message(_) | Kind::State => None,
    }
}

impl Reel {
    /// An empty tape of a robot that is heard from `from` on. Its first state is due a span after `state_at`.
    pub(super) fn new(from: Micros, state_at: Micros) -> Self {
        Self { tape: Tape::default(), from, base: [None, None], state_at, since_state: 0 }
    }

    /// Time from which on the tape has all messages.
    pub(super) fn from(&self) -> Micros {
        self.from
    }

    /// The newest connection message and factsheet before the tape's first entry.
    pub(super) fn base(&self) -> &[Option<Vec<u8>>; 2] {
        &self.base
    }

    /// A copy of the tape.
    pub(super) fn copy(&self) -> TapeCopy {
        self.tape.copy()
    }

    /// Appends an entry, and removes the oldest ones beyond the limits.
    pub(super) fn push(&mut self, at: Micros, kind: Kind, payload: &[u8], limits: Limits) {
        let added = Tape::bytes_of(payload.len());
        let most = limits.before();
        if added > most {
            return self.skip(at, kind, payload, limits);
        }
        self.forget_old(at, limits);
        self.keep_within(most - added);
        self.append(at, kind, payload);
    }

    /// Appends an entry while a box is being recorded; returns false if there is no space. The messages before and at the
    /// event are worth more than later ones.
    pub(super) fn push_after_event(&mut self, at: Micros, kind: Kind, payload: &[u8], limits: Limits) -> bool {
        let fits = self.tape.bytes() + Tape::bytes_of(payload.len()) <= limits.share;
        if fits {
            self.append(at, kind, payload);
        }
        fits
    }

    fn append(&mut self, at: Micros, kind: Kind, payload: &[u8]) {
        if self.tape.first().is_none() {
            self.from = self.from.max(at);
        }
        self.tape.push(at, kind, payload);
        self.since_state += Tape::bytes_of(payload.len());
    }

    /// Leaves out an entry that is larger than the memory for it.
    fn skip(&mut self, at: Micros, kind: Kind, payload: &[u8], limits: Limits) {
        if kind == Kind::State {
            return;
        }
        self.keep_within(0);
        self.from = Micros(at.0 + 1);
        if let Some(index) = base_of(kind).filter(|_| payload.len() <= limits.share) {
            self.base[index] = Some(payload.to_vec());
        }
    }

    /// Removes what came before the newest state that is at least a span old.
    pub(super) fn forget_old(&mut self, now: Micros, limits: Limits) {
        let horizon = Micros(now.0.saturating_sub(limits.span.0));
        let start = self.tape.states().iter().copied().rfind(|at| *at <= horizon);
        while let Some((at, kind)) = self.tape.first() {
            let stays = match (kind, start) {
                (Kind::State, start) => start.is_none_or(|start| at >= start),
                (Kind::Message(_), None) => at >= horizon,
                // Everything before the state is part of it.
                (Kind::Message(_), Some(_)) => false,
            };
            if stays {
                break;
            }
            self.pop();
        }
    }

    /// Removes the oldest entries beyond so many bytes, and then those before the next state.
    fn keep_within(&mut self, bytes: usize) {
        if self.tape.bytes() <= bytes {
            return;
        }
        while self.tape.bytes() > bytes {
            self.pop();
        }
        while !self.tape.states().is_empty() && self.tape.first().is_some_and(|(_, kind)| kind != Kind::State) {
            self.pop();
        }
        self.tape.shrink(2 * bytes);
    }

    fn pop(&mut self) {
        let gone_at = self.tape.first().map(|(at, _)| at);
        let popped = self.tape.pop(|kind| base_of(kind).is_some());
        if let Some((kind, payload)) = popped
            && let Some(index) = base_of(kind)
        {
            self.base[index] = Some(payload);
        }
        let next = self.tape.first().map(|(at, _)| at).or(gone_at.map(|at| Micros(at.0 + 1)));
        self.from = next.unwrap_or(self.from);
    }

    /// Whether the robot's state is due. Without messages the state has hardly changed.
    pub(super) fn is_state_due(&self, now: Micros, limits: Limits) -> bool {
        let passed = now.since(self.state_at);
        self.since_state > 0
            && (passed >= limits.span || passed >= STATE_PAUSE && self.since_state >= limits.share / STATE_EVERY)
    }

    /// Notes that the state was due, and returns whether one of so many bytes has its place on the tape.
    pub(super) fn takes_state(&mut self, now: Micros, bytes: usize, limits: Limits) -> bool {
        (self.state_at, self.since_state) = (now, 0);
        bytes <= limits.share / STATE_PART
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { share: 64 * 1024, span: Micros(60_000_000) };
    const CONTACTS: Kind = Kind::Message(RobotTopic::Contacts);

    fn seconds(seconds: u64) -> Micros {
        Micros(seconds * 1_000_000)
    }

    /// Kinds of the entries, with their times in seconds.
    fn entries(reel: &Reel) -> Vec<(Kind, u64)> {
        reel.copy().entries().map(|one| (one.kind, one.at.0 / 1_000_000)).collect()
    }

    #[test]
    fn the_tape_of_a_calm_robot_begins_with_the_newest_state_that_is_a_span_old() {
        let mut reel = Reel::new(seconds(0), seconds(0));
        reel.push(seconds(0), Kind::Message(RobotTopic::Connection), b"birth", LIMITS);
        reel.push(seconds(0), Kind::Message(RobotTopic::Factsheet), b"sheet", LIMITS);
        for at in 1..=400 {
            reel.push(seconds(at), CONTACTS, &[b' '; 50], LIMITS);
            if reel.is_state_due(seconds(at), LIMITS) && reel.takes_state(seconds(at), 500, LIMITS) {
                reel.push(seconds(at), Kind::State, &[0; 500], LIMITS);
            }
        }
        let (kind, first) = entries(&reel)[0];
        assert_eq!((kind, first, reel.from()), (Kind::State, 300, seconds(300)), "states at 60, 120, ... 360");
        let base = reel.base().clone().map(|one| String::from_utf8(one.unwrap()).unwrap());
        assert_eq!(base, ["birth", "sheet"], "older than the tape, and kept");
    }

    #[test]
    fn a_flood_of_one_robot_stays_within_its_share_and_its_tape_begins_later() {
        let mut reel = Reel::new(seconds(0), seconds(0));
        for at in 0..100_000_u64 {
            let at = Micros(1_000 * at);
            reel.push(at, CONTACTS, &[b' '; 900], LIMITS);
            if reel.is_state_due(at, LIMITS) && reel.takes_state(at, 3000, LIMITS) {
                reel.push(at, Kind::State, &[0; 3000], LIMITS);
            }
            assert!(reel.tape.bytes() <= LIMITS.before());
        }
        assert!(reel.from() > seconds(99), "{:?}", reel.from());
        // The event, and what comes after it until the share is used up.
        let mut left_out = 0;
        for at in 100_000..100_200_u64 {
            left_out += u64::from(!reel.push_after_event(Micros(1_000 * at), CONTACTS, &[b' '; 900], LIMITS));
        }
        assert!(reel.tape.bytes() <= LIMITS.share && left_out > 50, "{left_out}");
    }

    #[test]
    fn a_message_larger_than_the_memory_is_left_out_and_the_tape_begins_after_it() {
        let mut reel = Reel::new(seconds(0), seconds(0));
        reel.push(seconds(1), CONTACTS, b"{}", LIMITS);
        reel.push(seconds(2), CONTACTS, &vec![b' '; 44 * 1024], LIMITS);
        reel.push(seconds(3), CONTACTS, b"{}", LIMITS);
        assert_eq!(entries(&reel), [(CONTACTS, 3)]);
        assert!(reel.from() > seconds(2));
    }
}
