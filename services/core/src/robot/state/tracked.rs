//! Change tracking: a robot's state can only be changed through these types, which note every mutable access.
//!
//! Four consequences of a change follow from the access:
//!
//! - The stored bytes must be written at the next checkpoint: [`Tracked::take_mark`] for the head,
//!   [`Whiskers::take_changed`] for the whiskers.
//! - The alarms of a whisker must be evaluated: it was accessed in this step, a compensation began, ended or was
//!   approved, or the robot fell silent.
//! - The policy must look at the arrays: the [`DecisionBasis`](super::whisker::DecisionBasis) of an accessed whisker or
//!   the list of compensations differs from that of the last decision.
//! - The cached deadline of ticks may be too late: it is lowered to the deadline of each accessed whisker, see
//!   [`super::deadline`].
//!
//! The last three are evaluated at the end of each step, by [`Robot::finish_step`].
//!
//! A mutable access that changes nothing marks, too: the cost is one write too many. Code that runs often therefore
//! reads first, and asks for mutable access only if it has something to change. A change without a mark needs
//! `without_mark`, which is for changes that whoever restores the stored bytes makes again.

use std::ops::{Deref, DerefMut, Index, IndexMut};

use smallvec::SmallVec;

use crate::robot::Robot;
use crate::robot::effect::{Effect, WhiskerIndex};
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::Micros;

/// A value and a mark, which every mutable access sets.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::robot) struct Tracked<T> {
    value: T,
    is_marked: bool,
}

impl<T> Tracked<T> {
    /// A value that is not stored yet.
    pub(in crate::robot) fn new(value: T) -> Self {
        Self { value, is_marked: true }
    }

    /// A value as it is stored.
    pub(in crate::robot) fn stored(value: T) -> Self {
        Self { value, is_marked: false }
    }

    /// Access for a change that need not be written.
    pub(in crate::robot) fn without_mark(&mut self) -> &mut T {
        &mut self.value
    }

    /// Marks the value as changed.
    pub(in crate::robot) fn mark(&mut self) {
        self.is_marked = true;
    }

    pub(in crate::robot) fn is_marked(&self) -> bool {
        self.is_marked
    }

    /// Whether the value was accessed mutably since the last call.
    pub(in crate::robot) fn take_mark(&mut self) -> bool {
        std::mem::take(&mut self.is_marked)
    }
}

impl<T> Deref for Tracked<T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for Tracked<T> {
    fn deref_mut(&mut self) -> &mut T {
        self.is_marked = true;
        &mut self.value
    }
}

/// The whiskers of a robot by index. Mutable access to one whisker notes its index.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::robot) struct Whiskers {
    all: Vec<Whisker>,
    /// Accessed since the end of the last step.
    touched: IndexSet,
    /// Accessed since they were last taken for a checkpoint, up to the end of the last step.
    changed: IndexSet,
    /// Whether the end of the next step evaluates all of them, also after a checkpoint meanwhile.
    is_review_due: bool,
}

impl Whiskers {
    /// Whiskers as they are stored.
    pub(in crate::robot) fn stored(all: Vec<Whisker>) -> Self {
        let none = IndexSet::with_room_for(all.len());
        Self { all, touched: none.clone(), changed: none, is_review_due: false }
    }

    /// Whiskers of a new layout, all of them changed.
    pub(in crate::robot) fn changed(all: Vec<Whisker>) -> Self {
        let mut whiskers = Self::stored(all);
        (0..whiskers.all.len()).for_each(|index| whiskers.touched.insert(index));
        whiskers
    }

    /// The whiskers themselves; none are left.
    pub(in crate::robot) fn take(&mut self) -> Vec<Whisker> {
        std::mem::take(self).all
    }

    /// Access for a change that need not be written.
    pub(in crate::robot) fn without_mark(&mut self) -> &mut [Whisker] {
        &mut self.all
    }

    /// The first whisker that was accessed since the end of the last step.
    pub(in crate::robot) fn first_touched(&self) -> Option<WhiskerIndex> {
        self.next_touched(0)
    }

    /// The first whisker from `index` on that was accessed since the end of the last step.
    fn next_touched(&self, index: WhiskerIndex) -> Option<WhiskerIndex> {
        self.touched.next(index)
    }

    /// Makes the end of the next step evaluate all whiskers.
    pub(in crate::robot) fn review(&mut self) {
        self.is_review_due = true;
    }

    fn end_step(&mut self) {
        self.changed.take_over(&mut self.touched);
    }

    pub(in crate::robot) fn has_changed(&self) -> bool {
        !self.changed.is_empty() || !self.touched.is_empty()
    }

    /// Calls `visit` for each whisker that was accessed mutably since the last call.
    pub(in crate::robot) fn take_changed(&mut self, mut visit: impl FnMut(WhiskerIndex)) {
        self.end_step();
        let mut next = self.changed.next(0);
        while let Some(index) = next {
            visit(index);
            next = self.changed.next(index + 1);
        }
        self.changed.clear();
    }
}

impl Deref for Whiskers {
    type Target = [Whisker];

    fn deref(&self) -> &[Whisker] {
        &self.all
    }
}

impl Index<WhiskerIndex> for Whiskers {
    type Output = Whisker;

    fn index(&self, index: WhiskerIndex) -> &Whisker {
        &self.all[index]
    }
}

impl IndexMut<WhiskerIndex> for Whiskers {
    fn index_mut(&mut self, index: WhiskerIndex) -> &mut Whisker {
        self.touched.insert(index);
        &mut self.all[index]
    }
}

/// Indices of whiskers, one bit each.
#[derive(Debug, Clone, PartialEq, Default)]
struct IndexSet(SmallVec<[u64; 1]>);

const BITS: usize = u64::BITS as usize;

impl IndexSet {
    fn with_room_for(whiskers: usize) -> Self {
        Self(SmallVec::from_elem(0, whiskers.div_ceil(BITS)))
    }

    fn insert(&mut self, index: usize) {
        // An index beyond the last whisker is refused by the whiskers themselves.
        if let Some(word) = self.0.get_mut(index / BITS) {
            *word |= 1 << (index % BITS);
        }
    }

    /// The lowest index of the set that is not below `from`.
    fn next(&self, from: usize) -> Option<usize> {
        let first = from / BITS;
        let word = self.0.get(first)? & u64::MAX << (from % BITS);
        if word != 0 {
            return Some(first * BITS + word.trailing_zeros() as usize);
        }
        let (at, word) = self.0.iter().enumerate().skip(first + 1).find(|(_, word)| **word != 0)?;
        Some(at * BITS + word.trailing_zeros() as usize)
    }

    fn is_empty(&self) -> bool {
        self.0.iter().all(|&word| word == 0)
    }

    fn clear(&mut self) {
        self.0.fill(0);
    }

    /// Moves the indices of another set of the same size into this one.
    fn take_over(&mut self, other: &mut Self) {
        for (word, other) in self.0.iter_mut().zip(&mut other.0) {
            *word |= std::mem::take(other);
        }
    }
}

/// A compensation as the last decision and the last evaluation of alarms saw it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) struct KnownCompensation {
    id: u32,
    target: u32,
    proposed: bool,
}

/// As many compensations of one robot are known without an allocation.
pub(in crate::robot) type KnownCompensations = SmallVec<[KnownCompensation; 2]>;

impl Robot {
    fn present_compensations(&self) -> impl Iterator<Item = KnownCompensation> + '_ {
        self.head.compensations.iter().map(|one| KnownCompensation {
            id: one.id,
            target: one.target,
            proposed: one.proposed,
        })
    }

    /// Takes the compensations as decided on and their alarms as evaluated, as they are in a stored robot.
    pub(in crate::robot) fn know_compensations(&mut self) {
        self.known_compensations = self.present_compensations().collect();
    }

    /// Evaluates everything that follows from the changes of this step.
    pub(in crate::robot) fn finish_step(&mut self, params: &Params, now: Micros, effects: &mut Vec<Effect>) {
        let mut has_other_compensations = self.note_basis();
        if self.head.undecided {
            self.decide(params, effects);
            has_other_compensations |= self.note_basis();
            // The decision took its own changes into account.
            self.head.undecided = false;
            self.reconcile_all(params, now, effects);
            has_other_compensations |= self.note_basis();
        }
        let is_review_due = std::mem::take(&mut self.whiskers.is_review_due);
        let of_all = self.tell_silence(now, effects) || has_other_compensations || is_review_due;
        let mut next = self.first_from(0, of_all);
        while let Some(index) = next {
            self.tell_alarms(index, effects);
            self.meet_deadline(params, now, index);
            next = self.first_from(index + 1, of_all);
        }
        let stands = |index: WhiskerIndex| self.alarms_due(index) == self.whiskers[index].standing;
        debug_assert!((0..self.whiskers.len()).all(stands), "an alarm of a whisker that was not accessed is due");
        self.whiskers.end_step();
    }

    /// The first whisker from `index` on, of all or of those that were accessed in this step.
    fn first_from(&self, index: WhiskerIndex, of_all: bool) -> Option<WhiskerIndex> {
        if of_all {
            Some(index).filter(|&index| index < self.whiskers.len())
        } else {
            self.whiskers.next_touched(index)
        }
    }

    /// Asks for a decision if what the last one rested on has changed. Returns whether a compensation began, ended or
    /// was approved since the last call.
    fn note_basis(&mut self) -> bool {
        let mut is_other = false;
        let mut next = self.whiskers.next_touched(0);
        while let Some(index) = next {
            // Not stored, and the whisker is marked already.
            let whisker = &mut self.whiskers.without_mark()[index];
            let basis = whisker.decision_basis();
            is_other |= std::mem::replace(&mut whisker.decided_on, basis) != basis;
            next = self.whiskers.next_touched(index + 1);
        }
        let has_other_compensations = !self.present_compensations().eq(self.known_compensations.iter().copied());
        if has_other_compensations {
            let ids = self.present_compensations().map(|one| one.id);
            is_other |= !ids.eq(self.known_compensations.iter().map(|one| one.id));
            self.know_compensations();
        }
        if is_other && !self.head.undecided {
            self.head.undecided = true;
        }
        has_other_compensations
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mutable_access_marks_and_a_read_does_not() {
        let mut tracked = Tracked::stored(vec![1]);
        assert_eq!((tracked[0], tracked.is_marked()), (1, false));
        tracked[0] = 2;
        assert!(tracked.is_marked() && tracked.take_mark() && !tracked.take_mark());
        tracked.without_mark().clear();
        assert!(!tracked.is_marked());
    }

    #[test]
    fn property_a_set_has_the_indices_that_were_put_in() {
        for whiskers in [1, 24, 64, 65, 300] {
            let mut set = IndexSet::with_room_for(whiskers);
            let indices: Vec<usize> = (0..whiskers).filter(|index| index % 7 == 3 || index % 64 == 0).collect();
            indices.iter().for_each(|&index| set.insert(index));
            set.insert(whiskers + 64);
            let next = |from: Option<usize>, set: &IndexSet| set.next(from.map_or(0, |index| index + 1));
            let found: Vec<usize> = std::iter::successors(next(None, &set), |&index| next(Some(index), &set)).collect();
            assert_eq!(found, indices);
            let mut other = IndexSet::with_room_for(whiskers);
            other.take_over(&mut set);
            assert!(set.is_empty() && !other.is_empty());
            other.clear();
            assert!(other.is_empty() && other.next(0).is_none());
        }
    }
}
