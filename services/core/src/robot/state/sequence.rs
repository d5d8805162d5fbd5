//! The numbers of a robot's messages that are accounted for: a watermark, and ranges beyond gaps.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::text::ShortText;
use crate::units::Micros;

/// Gaps that are remembered; a message that would open one more is not taken, so the robot sends it again.
const RANGES_MAX: usize = 64;
/// A robot that does not close a gap for this long, while gaps keep others out, never will: it does not send
/// again, or it has dropped those messages. Then the oldest gap is given up, so that the rest can go on.
const PATIENCE: Micros = Micros(90_000_000);
/// A robot that is heard for this long without closing the oldest gap has lost the missing messages: it has dropped
/// them, or a receipt covered them that the supervisor does not remember, because its database was restored.
const STANDSTILL: Micros = Micros(600_000_000);
/// Boots whose numbers are remembered: messages of an older boot may still arrive after a restart.
const BOOTS_MAX: usize = 4;
/// Older boots of which only a mark is remembered. Beyond them the database knows all that ever had a number.
const MARKS_MAX: usize = 64;

/// Outcome for the number of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Admission {
    /// First time: take it.
    New,
    /// Seen before: it changes nothing.
    Duplicate,
    /// Too many gaps already: not taken, not receipted.
    TooManyGaps,
    /// Not a boot that a factsheet is known of: not taken, not receipted.
    UnknownBoot,
    /// Two robots use the name, so that nobody knows whose message it is: not taken, not receipted.
    TwoRobots,
}

/// The `contacts` numbers of one boot.
#[derive(Debug, Clone, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub struct Sequence {
    boot_id: ShortText,
    next: u64,
    /// Inclusive ranges beyond `next`, ascending, not touching.
    held: Vec<(u64, u64)>,
    /// Since when gaps keep messages out.
    blocked_since: Option<Micros>,
    /// Numbers of gaps that were given up.
    given_up: u64,
    /// Since when it is heard without closing the oldest gap.
    standing_since: Option<Micros>,
}

impl Sequence {
    fn new(boot_id: &str) -> Self {
        Self {
            boot_id: boot_id.into(),
            next: 0,
            held: Vec::new(),
            blocked_since: None,
            given_up: 0,
            standing_since: None,
        }
    }

    /// Boot that the numbers belong to.
    #[must_use]
    pub fn boot_id(&self) -> &str {
        self.boot_id.as_str()
    }

    /// Every number below is accounted for.
    #[must_use]
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Inclusive ranges that are accounted for beyond a gap.
    #[must_use]
    pub fn held(&self) -> &[(u64, u64)] {
        &self.held
    }

    /// The first number that lies beyond every one that was received.
    #[must_use]
    pub fn end(&self) -> u64 {
        self.held.last().map_or(self.next, |&(_, last)| last + 1)
    }

    /// Since when a gap is waited for; `None` without one.
    #[must_use]
    pub fn gap_since(&self) -> Option<Micros> {
        self.standing_since.filter(|_| !self.held.is_empty())
    }

    /// Messages that were never received, and are not waited for any more.
    #[must_use]
    pub fn given_up(&self) -> u64 {
        self.given_up
    }

    fn admit(&mut self, seq: u64, now: Micros) -> Admission {
        let admission = self.place(seq);
        if admission != Admission::TooManyGaps {
            self.watch_standstill(now);
            return admission;
        }
        let since = *self.blocked_since.get_or_insert(now);
        if now.since(since) < PATIENCE || self.held.is_empty() {
            return admission;
        }
        self.give_up_the_oldest();
        self.place(seq)
    }

    /// Whether a number was seen before and no gap is open: then [`Self::admit`] changes nothing.
    pub(in crate::robot) fn is_plain_duplicate(&self, seq: u64) -> bool {
        self.held.is_empty() && seq < self.next
    }

    /// A gap that stays open costs a robot that looks at the watermark only everything beyond it.
    fn watch_standstill(&mut self, now: Micros) {
        if !self.held.is_empty() && now.since(*self.standing_since.get_or_insert(now)) >= STANDSTILL {
            self.give_up_the_oldest();
        }
    }

    fn give_up_the_oldest(&mut self) {
        let (first, last) = self.held.remove(0);
        self.given_up += first - self.next;
        self.advance(last + 1);
    }

    fn advance(&mut self, next: u64) {
        self.next = next;
        self.blocked_since = None;
        self.standing_since = None;
    }

    fn place(&mut self, seq: u64) -> Admission {
        if seq < self.next {
            return Admission::Duplicate;
        }
        let at = self.held.partition_point(|&(_, last)| last < seq);
        if self.held.get(at).is_some_and(|&(first, _)| first <= seq) {
            return Admission::Duplicate;
        }
        if seq == self.next {
            self.advance(seq + 1);
            if self.held.first().is_some_and(|&(first, _)| first == self.next) {
                let (_, last) = self.held.remove(0);
                self.advance(last + 1);
            }
            return Admission::New;
        }
        self.hold(at, seq)
    }

    fn hold(&mut self, at: usize, seq: u64) -> Admission {
        let joins_left = at > 0 && self.held[at - 1].1 + 1 == seq;
        let joins_right = self.held.get(at).is_some_and(|&(first, _)| seq + 1 == first);
        match (joins_left, joins_right) {
            (true, true) => {
                self.held[at - 1].1 = self.held[at].1;
                self.held.remove(at);
            }
            (true, false) => self.held[at - 1].1 = seq,
            (false, true) => self.held[at].0 = seq,
            (false, false) if self.held.len() >= RANGES_MAX => return Admission::TooManyGaps,
            (false, false) => self.held.insert(at, (seq, seq)),
        }
        Admission::New
    }
}

crate::optional_parts::optional_fields!(Sequence: boot_id, next;
    held: !held.is_empty(),
    blocked_since: blocked_since.is_some(),
    given_up: *given_up > 0,
    standing_since: standing_since.is_some(),
);

/// The numbers of a robot's newest boots, the newest last, and marks of those before them.
#[derive(Debug, Clone, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub struct Sequences {
    boots: Vec<Sequence>,
    /// The newest last.
    older: Vec<u64>,
}

crate::optional_parts::optional_fields!(Sequences: ; boots: !boots.is_empty(), older: !older.is_empty());

/// The sequences as version 4 of the state had them.
#[derive(BorshDeserialize)]
pub(in crate::robot) struct SequencesOfVersion4 {
    boots: Vec<Sequence>,
}

impl From<SequencesOfVersion4> for Sequences {
    fn from(stored: SequencesOfVersion4) -> Self {
        Self { boots: stored.boots, older: Vec::new() }
    }
}

/// A mark of a boot, in 64 bits (FNV-1a): that two boots of a robot share one is less likely than one in 10^16.
fn mark(boot_id: &str) -> u64 {
    boot_id.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
}

impl Sequences {
    /// A boot whose factsheet is known; the oldest beyond the limit is forgotten.
    pub fn begin(&mut self, boot_id: &str) {
        if self.boots.iter().all(|sequence| sequence.boot_id != *boot_id) {
            if self.boots.len() >= BOOTS_MAX {
                let oldest = self.boots.remove(0);
                if self.older.len() >= MARKS_MAX {
                    self.older.remove(0);
                }
                self.older.push(mark(oldest.boot_id()));
            }
            self.boots.push(Sequence::new(boot_id));
        }
    }

    /// Whether a boot is known, and another one came after it: it does not come back.
    #[must_use]
    pub fn is_old(&self, boot_id: &str) -> bool {
        let before_the_newest = self.boots.len().saturating_sub(1);
        self.boots.iter().take(before_the_newest).any(|sequence| sequence.boot_id == *boot_id)
            || !self.older.is_empty() && self.older.contains(&mark(boot_id))
    }

    /// Takes a number in.
    pub fn admit(&mut self, boot_id: &str, seq: u64, now: Micros) -> Admission {
        let sequence = self.boots.iter_mut().rev().find(|sequence| sequence.boot_id == *boot_id);
        sequence.map_or(Admission::UnknownBoot, |sequence| sequence.admit(seq, now))
    }

    /// Whether the oldest gap of a boot has stood since before `time`.
    pub(in crate::robot) fn have_stood_before(&self, time: Micros) -> bool {
        self.boots.iter().any(|sequence| sequence.standing_since.is_some_and(|since| since < time))
    }

    /// Nothing could be heard meanwhile: no gap was left open by the robot until now.
    pub(in crate::robot) fn wait_anew(&mut self) {
        for sequence in &mut self.boots {
            sequence.standing_since = None;
        }
    }

    /// All whose numbers are remembered.
    pub(in crate::robot) fn boots(&self) -> &[Sequence] {
        &self.boots
    }

    /// The numbers of that boot.
    #[must_use]
    pub fn of(&self, boot_id: &str) -> Option<&Sequence> {
        self.boots.iter().find(|sequence| sequence.boot_id == *boot_id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Micros = Micros(1_000_000);

    fn sequence(numbers: &[u64]) -> Sequence {
        let mut sequence = Sequence::new("b");
        for &number in numbers {
            sequence.admit(number, NOW);
        }
        sequence
    }

    #[test]
    fn a_gap_is_held_and_closed() {
        let mut gapped = sequence(&[0, 1, 3, 5, 4]);
        assert_eq!((gapped.next(), gapped.held()), (2, &[(3, 5)][..]));
        assert_eq!(gapped.admit(4, NOW), Admission::Duplicate);
        assert_eq!(gapped.admit(2, NOW), Admission::New);
        assert_eq!((gapped.next(), gapped.held()), (6, &[][..]));
        assert_eq!(gapped.admit(5, NOW), Admission::Duplicate);
    }

    #[test]
    fn one_gap_too_many_is_not_taken() {
        let odd: Vec<u64> = (0..64).map(|k| 2 * k + 1).collect();
        let mut full = sequence(&odd);
        assert_eq!(full.admit(999, NOW), Admission::TooManyGaps);
        assert_eq!(full.admit(0, NOW), Admission::New, "closing a gap is always possible");
    }

    #[test]
    fn any_order_with_repeats_ends_contiguous() {
        let mut order: Vec<u64> = (0..40).collect();
        let mut state = 12345_u64;
        for i in (1..order.len()).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            order.swap(i, (state >> 33) as usize % (i + 1));
        }
        let mut any = Sequence::new("b");
        let fresh = order.iter().chain(&order).filter(|&&seq| any.admit(seq, NOW) == Admission::New).count();
        assert_eq!((fresh, any.next(), any.held().len()), (40, 40, 0));
    }

    #[test]
    fn a_boot_without_factsheet_is_not_known() {
        let mut sequences = Sequences::default();
        assert_eq!(sequences.admit("b1", 0, NOW), Admission::UnknownBoot);
        sequences.begin("b1");
        assert_eq!(sequences.admit("b1", 0, NOW), Admission::New);
        sequences.begin("b1");
        assert_eq!(sequences.admit("b1", 0, NOW), Admission::Duplicate, "a factsheet said again forgets nothing");
    }

    #[test]
    fn a_boot_that_others_have_followed_stays_old() {
        let mut sequences = Sequences::default();
        let boots: Vec<String> = (0..60).map(|boot| format!("b{boot}")).collect();
        for (at, boot) in boots.iter().enumerate() {
            assert!(!sequences.is_old(boot), "{boot} is new");
            sequences.begin(boot);
            assert!(!sequences.is_old(boot), "{boot} is the newest");
            assert!(boots[..at].iter().all(|before| sequences.is_old(before)));
        }
        // Late messages of those just before are still numbered.
        assert_eq!(sequences.admit("b56", 0, NOW), Admission::New);
        assert_eq!(sequences.admit("b55", 0, NOW), Admission::UnknownBoot);
        let bytes = borsh::to_vec(&sequences).unwrap();
        assert_eq!(borsh::from_slice::<Sequences>(&bytes).unwrap(), sequences);
        (0..1000).for_each(|boot| sequences.begin(&format!("c{boot}")));
        assert!(borsh::to_vec(&sequences).unwrap().len() < 700);
    }

    #[test]
    fn a_gap_that_is_never_closed_is_given_up_after_a_while() {
        let odd: Vec<u64> = (0..64).map(|k| 2 * k + 1).collect();
        let mut full = sequence(&odd);
        let later = NOW.after(PATIENCE);
        assert_eq!(full.admit(999, NOW), Admission::TooManyGaps);
        assert_eq!(full.admit(999, Micros(later.0 - 1)), Admission::TooManyGaps);
        assert_eq!(full.admit(999, later), Admission::New);
        assert_eq!((full.next(), full.given_up()), (2, 1));
        assert_eq!(full.admit(1001, later), Admission::TooManyGaps, "patience begins anew");
    }

    #[test]
    fn a_gap_that_a_robot_leaves_open_while_it_is_heard_is_given_up() {
        let after = |us: u64| Micros(NOW.0 + us);
        let mut gapped = sequence(&[0, 1, 10]);
        assert_eq!(gapped.admit(11, after(STANDSTILL.0 - 1)), Admission::New);
        assert_eq!((gapped.next(), gapped.held()), (2, &[(10, 11)][..]));
        assert_eq!(gapped.admit(12, after(STANDSTILL.0)), Admission::New);
        assert_eq!((gapped.next(), gapped.held(), gapped.given_up()), (13, &[][..], 8));
        assert_eq!(gapped.admit(5, after(STANDSTILL.0)), Admission::Duplicate, "receipted: it would come for ever");
    }

    #[test]
    fn a_gap_that_is_being_closed_or_could_not_be_is_waited_for() {
        let after = |us: u64| Micros(NOW.0 + us);
        let mut closing = sequence(&[0, 10]);
        assert_eq!(closing.admit(1, after(STANDSTILL.0 - 1)), Admission::New);
        assert_eq!(closing.admit(11, after(2 * STANDSTILL.0 - 2)), Admission::New);
        assert_eq!((closing.next(), closing.given_up()), (2, 0), "it comes on");

        let mut sequences = Sequences { boots: vec![sequence(&[0, 10])], older: Vec::new() };
        sequences.wait_anew();
        assert_eq!(sequences.admit("b", 11, after(STANDSTILL.0)), Admission::New);
        assert_eq!(sequences.of("b").map(Sequence::given_up), Some(0));
    }
}
