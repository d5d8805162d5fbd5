//! Alarms stand from the moment their cause is there until it is over. What is due follows from the state alone, at the
//! end of each step; what differs from what stands is told.

use borsh::{BorshDeserialize, BorshSerialize};

use super::Robot;
use super::effect::{AlarmKind, Condition, Effect, WhiskerIndex};
use super::whisker::Whisker;

/// Alarms that can stand for one whisker at the same time: of its faults only the worst.
const SLOTS: usize = 7;

/// The alarms that stand for a whisker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub struct Standing([Option<AlarmKind>; SLOTS]);

impl Standing {
    /// Their kinds, each once.
    pub fn kinds(&self) -> impl Iterator<Item = AlarmKind> + '_ {
        self.0.iter().copied().flatten()
    }
}

impl Robot {
    /// Raises what is due and does not stand, and clears what stands and is not due: of the whiskers that the step has
    /// touched.
    pub(super) fn tell_alarms(&mut self, effects: &mut Vec<Effect>) {
        // Few wait for approval, and none where nobody has to approve: then this is empty.
        let waiting: Vec<WhiskerIndex> =
            self.compensations.iter().filter(|one| one.proposed).map(|one| one.target()).collect();
        self.touched.sort_unstable();
        for index in self.touched.drain(..).map(|index| index as usize) {
            let whisker = &mut self.whiskers[index];
            whisker.touched = false;
            let due = whisker.due(waiting.contains(&index));
            if due == whisker.standing {
                continue;
            }
            let was = std::mem::replace(&mut whisker.standing, due);
            whisker.changed = true;
            let differs = |slot: &usize| was.0[*slot] != due.0[*slot];
            let slots: Vec<usize> = (0..SLOTS).filter(differs).collect();
            let cleared = slots.iter().filter_map(|&slot| was.0[slot]);
            effects.extend(cleared.map(|kind| Effect::AlarmCleared { whisker: index, kind }));
            let raised = slots.iter().filter_map(|&slot| due.0[slot]);
            effects.extend(raised.map(|kind| Effect::Alarm { whisker: index, kind }));
        }
        let waits = |index: &WhiskerIndex| waiting.contains(index);
        let told = |(index, one): (WhiskerIndex, &Whisker)| one.due(waits(&index)) == one.standing;
        debug_assert!(self.whiskers.iter().enumerate().all(told), "a whisker was changed that was not touched");
    }

    /// What people are told of a whisker is to be looked at, at the end of this step.
    pub(super) fn touch(&mut self, index: WhiskerIndex) {
        let touched = &mut self.whiskers[index].touched;
        if !std::mem::replace(touched, true) {
            self.touched.push(index as u32);
        }
    }

    /// The same of all whiskers.
    pub(super) fn touch_all(&mut self) {
        (0..self.whiskers.len()).for_each(|index| self.touch(index));
    }
}

impl Whisker {
    /// The alarms that its state asks for.
    fn due(&self, proposed: bool) -> Standing {
        let by_condition = match self.condition {
            Condition::SensitivityLoss => Some(AlarmKind::SensitivityLoss),
            Condition::Eroding => Some(AlarmKind::Eroding),
            Condition::Learning | Condition::Healthy | Condition::Suspected | Condition::Trimmed => None,
        };
        Standing([
            self.fault.map(AlarmKind::Fault),
            by_condition,
            self.shift_told.then_some(AlarmKind::ArrayShift),
            self.drift_told.then_some(AlarmKind::BaselineDrift),
            // The cause before what follows from it.
            self.given_up.then_some(AlarmKind::SetpointFailed),
            self.unserved.then_some(AlarmKind::Uncompensated),
            proposed.then_some(AlarmKind::Proposed),
        ])
    }
}
