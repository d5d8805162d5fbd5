//! Alarms stand from the moment their cause is there until it is over. What is due follows from the state alone, at the
//! end of each step; what differs from what stands is told.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::counts;
use crate::robot::Robot;
use crate::robot::effect::{AlarmKind, Condition, Effect, Fault, WhiskerIndex};
use crate::robot::state::whisker::Whisker;

/// All kinds but for a fault, which is one of several; the cause before what follows from it.
const KINDS: [AlarmKind; 7] = [
    AlarmKind::SensitivityLoss,
    AlarmKind::Eroding,
    AlarmKind::ArrayShift,
    AlarmKind::BaselineDrift,
    AlarmKind::SetpointFailed,
    AlarmKind::Uncompensated,
    AlarmKind::Proposed,
];

/// The alarms that stand for a whisker: of its faults only the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Standing {
    fault: Option<Fault>,
    /// Which of [`KINDS`], the first in the lowest bit.
    kinds: u8,
}

impl Standing {
    /// Their kinds, each once.
    pub fn kinds(&self) -> impl Iterator<Item = AlarmKind> + '_ {
        let stands = |(at, _): &(usize, AlarmKind)| self.kinds & 1 << at != 0;
        let others = KINDS.into_iter().enumerate().filter(stands).map(|(_, kind)| kind);
        self.fault.map(AlarmKind::Fault).into_iter().chain(others)
    }

    /// Those that do not stand in the other.
    fn without(&self, other: &Self) -> Self {
        Self { fault: self.fault.filter(|_| self.fault != other.fault), kinds: self.kinds & !other.kinds }
    }
}

/// A fault is there where the bit after those of the kinds is set.
impl BorshSerialize for Standing {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        (self.kinds | u8::from(self.fault.is_some()) << KINDS.len()).serialize(writer)?;
        self.fault.iter().try_for_each(|fault| fault.serialize(writer))
    }
}

impl BorshDeserialize for Standing {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (bits, fault) = (u8::deserialize_reader(reader)?, 1 << KINDS.len());
        let has_fault = (bits & fault != 0).then(|| Fault::deserialize_reader(reader));
        Ok(Self { fault: has_fault.transpose()?, kinds: bits & !fault })
    }
}

impl Robot {
    /// Raises what is due and does not stand, and clears what stands and is not due: of the whiskers that the step has
    /// touched.
    pub(in crate::robot) fn tell_alarms(&mut self, effects: &mut Vec<Effect>) {
        // Few wait for approval, and none where nobody has to approve: then this is empty.
        let waiting: Vec<WhiskerIndex> =
            self.compensations.iter().filter(|one| one.proposed).map(|one| one.target()).collect();
        // A long list is not kept: what is about all whiskers is seldom.
        let mut touched = std::mem::take(&mut self.touched);
        touched.sort_unstable();
        for index in touched.into_iter().map(|index| index as usize) {
            let whisker = &mut self.whiskers[index];
            whisker.touched = false;
            let due = whisker.due(waiting.contains(&index));
            if due == whisker.standing {
                continue;
            }
            let was = std::mem::replace(&mut whisker.standing, due);
            whisker.changed = true;
            let (cleared, raised) = (was.without(&due), due.without(&was));
            effects.extend(cleared.kinds().map(|kind| Effect::AlarmCleared { whisker: index, kind }));
            effects.extend(raised.kinds().map(|kind| Effect::Alarm { whisker: index, kind }));
        }
        let waits = |index: &WhiskerIndex| waiting.contains(index);
        let told = |(index, one): (WhiskerIndex, &Whisker)| one.due(waits(&index)) == one.standing;
        debug_assert!(self.whiskers.iter().enumerate().all(told), "a whisker was changed that was not touched");
    }

    /// What people are told of a whisker is to be looked at, at the end of this step.
    pub(in crate::robot) fn touch(&mut self, index: WhiskerIndex) {
        let touched = &mut self.whiskers[index].touched;
        if !std::mem::replace(touched, true) {
            self.touched.push(index as u32);
        }
    }

    /// The same of all whiskers.
    pub(in crate::robot) fn touch_all(&mut self) {
        (0..self.whiskers.len()).for_each(|index| self.touch(index));
    }
}

impl Whisker {
    /// The alarms that its state asks for.
    fn due(&self, proposed: bool) -> Standing {
        let is = [
            self.condition == Condition::SensitivityLoss,
            self.condition == Condition::Eroding,
            self.shift_told,
            self.drift_told,
            self.given_up,
            self.unserved,
            proposed,
        ];
        Standing { fault: self.fault, kinds: counts::bits(is) as u8 }
    }
}
