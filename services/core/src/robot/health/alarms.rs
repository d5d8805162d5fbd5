//! Alarms stand as long as their cause. The alarms that are due follow from the state alone, at the end of each step;
//! differences from the standing alarms become effects.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::encoding;
use crate::robot::Robot;
use crate::robot::effect::{AlarmKind, Condition, Effect, Fault, WhiskerIndex};
use crate::robot::state::whisker::Whisker;

/// All kinds except faults, of which there are several. A cause comes before its consequences.
const KINDS: [AlarmKind; 7] = [
    AlarmKind::SensitivityLoss,
    AlarmKind::Eroding,
    AlarmKind::ArrayShift,
    AlarmKind::BaselineDrift,
    AlarmKind::SetpointFailed,
    AlarmKind::Uncompensated,
    AlarmKind::Proposed,
];

// A stored state has one byte for these kinds and the bit that says whether a fault follows.
const _: () = assert!(KINDS.len() < 8, "an eighth kind needs a second byte: see Standing");

/// The alarms that stand for a whisker: of its faults only the worst.
///
/// The seven kinds and the bit for a fault fill the stored byte. An eighth kind can be stored without a new format
/// version as follows: a condition is either SENSITIVITY_LOSS or ERODING, so no stored byte has both lowest bits set.
/// Let such a byte announce two bytes with all kinds, and write it only if a kind from the eighth on stands. States
/// without such an alarm keep their bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Standing {
    fault: Option<Fault>,
    /// One bit for each of [`KINDS`], the first in the lowest bit.
    kinds: u8,
}

impl Standing {
    /// The kinds of the standing alarms, each once.
    pub fn kinds(&self) -> impl Iterator<Item = AlarmKind> + '_ {
        let stands = |(at, _): &(usize, AlarmKind)| self.kinds & 1 << at != 0;
        let others = KINDS.into_iter().enumerate().filter(stands).map(|(_, kind)| kind);
        self.fault.map(AlarmKind::Fault).into_iter().chain(others)
    }

    /// The alarms that do not stand in the other.
    fn without(&self, other: &Self) -> Self {
        Self { fault: self.fault.filter(|_| self.fault != other.fault), kinds: self.kinds & !other.kinds }
    }
}

/// The bit after those of the kinds is set if a fault follows.
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
    /// Raises the alarms of a whisker that are due and do not stand, and clears those that stand and are not due.
    pub(in crate::robot) fn tell_alarms(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let due = self.alarms_due(index);
        let was = self.whiskers[index].standing;
        if due == was {
            return;
        }
        self.whiskers[index].standing = due;
        let (cleared, raised) = (was.without(&due), due.without(&was));
        effects.extend(cleared.kinds().map(|kind| Effect::AlarmCleared { whisker: index, kind }));
        effects.extend(raised.kinds().map(|kind| Effect::Alarm { whisker: index, kind }));
    }

    /// The alarms that the state of a whisker asks for.
    pub(in crate::robot) fn alarms_due(&self, index: WhiskerIndex) -> Standing {
        let is_proposed = self.head.compensations.iter().any(|one| one.proposed && one.target() == index);
        self.whiskers[index].due(is_proposed)
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
        Standing { fault: self.fault, kinds: encoding::pack_flags(is) as u8 }
    }
}
