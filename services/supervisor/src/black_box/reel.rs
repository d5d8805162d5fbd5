//! The tape of one robot within its limits. It loses old entries, and has all messages from a known time on.

use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;

use super::tape::{EntryKind, Tape, TapeCopy};

/// A state follows the last one after this part of a robot's memory: a busy robot's tape is shorter than a span.
const STATE_EVERY: usize = 8;
/// Shortest interval between two states of a busy robot, unless the messages since the last one take a
/// `STATE_AT_LEAST`-th of its memory.
const STATE_PAUSE: Micros = Micros(5_000_000);
/// A state follows the last one after this part of a robot's memory, however short the interval is. The memory before
/// an event (2/3) is larger than this part (1/3) and the largest state (1/4) together. So a tape that has lost its
/// beginning still has a state.
const STATE_AT_LEAST: usize = 3;
/// A state larger than this part of the robot's memory is left out.
const STATE_PART: usize = 4;

/// Limits of a tape, which change with the number of robots.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    /// Memory of the robot: most bytes on the tape while a box is being recorded. Before an event two thirds of it are
    /// used, for one to two spans.
    pub(super) share: usize,
    /// Time that the tape must cover.
    pub(super) span: Micros,
}

impl Limits {
    /// Most bytes while no box is being recorded.
    fn before(self) -> usize {
        self.share / 3 * 2
    }

    /// Most bytes of a state.
    pub(super) fn state_max(self) -> usize {
        self.share / STATE_PART
    }
}

/// Ring buffer of a robot's messages; a replay needs its base and begins at a state.
#[derive(Debug)]
pub(super) struct Reel {
    tape: Tape,
    /// Time from which on the tape has all messages.
    from: Micros,
    /// The newest connection message and factsheet before the tape's first entry.
    base: [Option<Vec<u8>>; 2],
    /// Time at which a state was last due.
    state_at: Micros,
    /// Bytes of the messages that were put on the tape since then.
    since_state: usize,
    /// The last state was small enough for the tape.
    states_fit: bool,
    /// Entries were removed, and the tape has no state since then: it cannot be replayed.
    lacks_state: bool,
    /// The first message ever heard is no longer on the tape.
    has_lost: bool,
}

/// Index in `base`.
fn base_of(kind: EntryKind) -> Option<usize> {
    match kind {
        EntryKind::Message(RobotTopic::Connection) => Some(0),
        EntryKind::Message(RobotTopic::Factsheet) => Some(1),
        EntryKind::Message(_) | EntryKind::State => None,
    }
}

impl Reel {
    /// An empty tape of a robot that is heard from `from` on. Its first state is due a span after `state_at`.
    pub(super) fn new(from: Micros, state_at: Micros) -> Self {
        Self {
            tape: Tape::default(),
            from,
            base: [None, None],
            state_at,
            since_state: 0,
            states_fit: true,
            lacks_state: false,
            has_lost: false,
        }
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
    pub(super) fn push(&mut self, at: Micros, kind: EntryKind, payload: &[u8], limits: Limits) {
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
    pub(super) fn push_after_event(&mut self, at: Micros, kind: EntryKind, payload: &[u8], limits: Limits) -> bool {
        let fits = self.tape.bytes() + Tape::bytes_of(payload.len()) <= limits.share;
        if fits {
            self.append(at, kind, payload);
        }
        fits
    }

    fn append(&mut self, at: Micros, kind: EntryKind, payload: &[u8]) {
        if self.tape.first().is_none() {
            self.from = self.from.max(at);
        }
        self.tape.push(at, kind, payload);
        if kind == EntryKind::State {
            self.lacks_state = false;
        } else {
            self.since_state += Tape::bytes_of(payload.len());
        }
    }

    /// Leaves out an entry that is larger than the memory for it. After a message the tape begins anew.
    fn skip(&mut self, at: Micros, kind: EntryKind, payload: &[u8], limits: Limits) {
        if kind == EntryKind::State {
            return;
        }
        self.keep_within(0);
        self.from = Micros(at.0 + 1);
        (self.has_lost, self.lacks_state) = (true, true);
        if let Some(index) = base_of(kind).filter(|_| payload.len() <= limits.share) {
            self.base[index] = Some(payload.to_vec());
        }
    }

    /// Removes what came before the newest state that is at least a span old. Before the first such state, everything stays
    /// that the limits of memory allow: a replay begins with a state, or with the first message ever heard.
    pub(super) fn forget_old(&mut self, now: Micros, limits: Limits) {
        let horizon = Micros(now.0.saturating_sub(limits.span.0));
        let start = self.tape.states().iter().copied().rfind(|at| *at <= horizon);
        while let Some((at, kind)) = self.tape.first() {
            let stays = match (kind, start) {
                (EntryKind::State, start) => start.is_none_or(|start| at >= start),
                (EntryKind::Message(_), None) => self.states_fit || at >= horizon,
                // Everything before the state is part of it.
                (EntryKind::Message(_), Some(_)) => false,
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
        self.lacks_state = self.tape.states().is_empty();
        self.begin_with_state();
        self.tape.shrink(2 * bytes);
    }

    /// Removes the messages before the first state, if there is one.
    fn begin_with_state(&mut self) {
        while !self.tape.states().is_empty() && self.tape.first().is_some_and(|(_, kind)| kind != EntryKind::State) {
            self.pop();
        }
    }

    /// Prepares the tape for a box: removes messages without a state before them if there is a later state.
    pub(super) fn begin_box(&mut self) {
        if self.has_lost {
            self.begin_with_state();
        }
    }

    fn pop(&mut self) {
        let gone_at = self.tape.first().map(|(at, _)| at);
        self.has_lost = true;
        let popped = self.tape.pop(|kind| base_of(kind).is_some());
        if let Some((kind, payload)) = popped
            && let Some(index) = base_of(kind)
        {
            self.base[index] = Some(payload);
        }
        let next = self.tape.first().map(|(at, _)| at).or(gone_at.map(|at| Micros(at.0 + 1)));
        self.from = next.unwrap_or(self.from);
    }

    /// Whether the robot's state is due. If no message was put on the tape, the state has hardly changed. A state that was
    /// too large is encoded again only after a span, because that costs as much as many messages.
    pub(super) fn is_state_due(&self, now: Micros, limits: Limits) -> bool {
        let passed = now.since(self.state_at);
        let has_many = |part: usize| self.since_state >= limits.share / part;
        self.since_state > 0
            && (passed >= limits.span
                || self.states_fit
                    && (passed >= STATE_PAUSE && has_many(STATE_EVERY) || has_many(STATE_AT_LEAST) || self.lacks_state))
    }

    /// Notes that the state was due, and returns whether one of so many bytes has its place on the tape.
    pub(super) fn takes_state(&mut self, now: Micros, bytes: usize, limits: Limits) -> bool {
        (self.state_at, self.since_state) = (now, 0);
        self.states_fit = bytes <= limits.state_max();
        self.states_fit
    }
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;

    const LIMITS: Limits = Limits { share: 64 * 1024, span: Micros(60_000_000) };
    const CONTACTS: EntryKind = EntryKind::Message(RobotTopic::Contacts);

    fn seconds(seconds: u64) -> Micros {
        Micros(seconds * 1_000_000)
    }

    /// Kinds of the entries, with their times in seconds.
    fn entries(reel: &Reel) -> Vec<(EntryKind, u64)> {
        reel.copy().entries().map(|one| (one.kind, one.at.0 / 1_000_000)).collect()
    }

    #[test]
    fn the_tape_of_a_calm_robot_begins_with_the_newest_state_that_is_a_span_old() {
        let mut reel = Reel::new(seconds(0), seconds(0));
        reel.push(seconds(0), EntryKind::Message(RobotTopic::Connection), b"birth", LIMITS);
        reel.push(seconds(0), EntryKind::Message(RobotTopic::Factsheet), b"sheet", LIMITS);
        for at in 1..=400 {
            reel.push(seconds(at), CONTACTS, &[b' '; 50], LIMITS);
            if reel.is_state_due(seconds(at), LIMITS) && reel.takes_state(seconds(at), 500, LIMITS) {
                reel.push(seconds(at), EntryKind::State, &[0; 500], LIMITS);
            }
        }
        let (kind, first) = entries(&reel)[0];
        assert_eq!((kind, first, reel.from()), (EntryKind::State, 300, seconds(300)), "states at 60, 120, ... 360");
        let base = reel.base().clone().map(|one| String::from_utf8(one.unwrap()).unwrap());
        assert_eq!(base, ["birth", "sheet"], "older than the tape, and kept");
    }

    #[test]
    fn regress_a_state_that_is_too_large_is_tried_once_per_span() {
        let mut reel = Reel::new(seconds(0), seconds(0));
        let mut tried = Vec::new();
        for at in 1..=180 {
            reel.push(seconds(at), CONTACTS, &[b' '; 30_000], LIMITS);
            if reel.is_state_due(seconds(at), LIMITS) {
                tried.push(at);
                assert!(!reel.takes_state(seconds(at), LIMITS.share, LIMITS));
            }
        }
        assert_eq!(tried, [1, 61, 121]);
    }

    /// The state itself counted as a reason for the next one, so that a large one filled the tape.
    #[test]
    fn regress_a_state_alone_makes_no_other_state_due() {
        let mut reel = Reel::new(seconds(0), seconds(0));
        reel.push(seconds(1), CONTACTS, &[b' '; 50], LIMITS);
        assert!(reel.is_state_due(seconds(61), LIMITS) && reel.takes_state(seconds(61), 16_000, LIMITS));
        reel.push(seconds(61), EntryKind::State, &[0; 16_000], LIMITS);
        for at in 62..300 {
            assert!(!reel.is_state_due(seconds(at), LIMITS), "{at} s");
        }
        reel.push(seconds(300), CONTACTS, &[b' '; 50], LIMITS);
        assert!(reel.is_state_due(seconds(300), LIMITS));
    }

    #[test]
    fn a_flood_of_one_robot_stays_within_its_share_and_its_tape_begins_later() {
        let mut reel = Reel::new(seconds(0), seconds(0));
        for at in 0..100_000_u64 {
            let at = Micros(1_000 * at);
            reel.push(at, CONTACTS, &[b' '; 900], LIMITS);
            if reel.is_state_due(at, LIMITS) && reel.takes_state(at, 3000, LIMITS) {
                reel.push(at, EntryKind::State, &[0; 3000], LIMITS);
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

    /// Puts a message on the tape as the recorder does, after the robot's state if that is due.
    fn record(reel: &mut Reel, now: Micros, bytes: usize, limits: Limits) {
        if reel.is_state_due(now, limits) && reel.takes_state(now, 12_000, limits) {
            reel.push(now, EntryKind::State, &[0; 12_000], limits);
        }
        reel.push(now, CONTACTS, &vec![b' '; bytes], limits);
    }

    proptest! {
        #[test]
        fn property_a_box_begins_with_a_state_or_with_the_first_message_at_any_pace_and_share(
            // Messages that waited come at one moment. Robots come and go, which changes the share.
            messages in vec((prop_oneof![Just(0), Just(1_000), Just(300_000)], 0..4_000_usize), 1..1_000),
            shares in vec((0..1_000_usize, 64 * 1024..1024 * 1024_usize), 0..5),
        ) {
            let mut reel = Reel::new(seconds(1), seconds(0));
            let (mut now, mut limits) = (seconds(1), Limits { share: 256 * 1024, span: seconds(10) });
            for (number, (pause, bytes)) in messages.into_iter().enumerate() {
                now = now.after(Micros(pause));
                for (_, share) in shares.iter().filter(|(at, _)| *at == number) {
                    limits.share = *share;
                }
                record(&mut reel, now, bytes, limits);
                prop_assert!(reel.tape.bytes() <= limits.before());
            }
            // A smaller share may just have removed all states. The next one comes with the next message.
            record(&mut reel, now, 100, limits);
            reel.begin_box();
            let first = entries(&reel)[0].0;
            prop_assert!(first == EntryKind::State || !reel.has_lost, "{:?}", first);
        }
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
