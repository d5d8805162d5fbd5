//! Alarms stand as long as their cause. The alarms that are due follow from the state alone, at the end of each step;
//! differences from the standing alarms become effects.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::encoding;
use crate::robot::effect::{AlarmKind, Condition, Effect, Fault, WhiskerIndex};
use crate::robot::health::duplicate::DuplicateWatch;
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::robot::{Compensation, Robot};
use crate::units::Micros;

/// All kinds of a whisker except faults, of which there are several. A cause comes before its consequences.
const KINDS: [AlarmKind; 9] = [
    AlarmKind::SensitivityLoss,
    AlarmKind::Eroding,
    AlarmKind::ArrayShift,
    AlarmKind::BaselineDrift,
    AlarmKind::SetpointFailed,
    AlarmKind::Uncompensated,
    AlarmKind::Proposed,
    AlarmKind::ReachLost,
    AlarmKind::Vented,
];

/// Names of the stored parts of [`Standing`].
pub(in crate::robot) const PARTS: [&str; 1 + KINDS.len()] = [
    "Fault",
    "SensitivityLoss",
    "Eroding",
    "ArrayShift",
    "BaselineDrift",
    "SetpointFailed",
    "Uncompensated",
    "Proposed",
    "ReachLost",
    "Vented",
];

const STALE: Option<Fault> = Some(Fault::Stale);

/// The first kinds, which fill a stored byte together with the bit for a fault.
const IN_ONE_BYTE: u32 = 7;
/// Two alarms that never stand together, because a condition is either SENSITIVITY_LOSS or ERODING. A stored byte with
/// both announces another one with the kinds from the eighth on.
const ANNOUNCES_ANOTHER: u8 = 0b11;

// A second byte has room for as many.
const _: () = assert!(KINDS.len() <= IN_ONE_BYTE as usize + 8, "stored alarms need a third byte: see Standing");

/// The alarms that stand for a whisker: of its faults only the worst.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Standing {
    fault: Option<Fault>,
    /// One bit for each of [`KINDS`], the first in the lowest bit.
    kinds: u16,
}

impl Standing {
    /// The kinds of the standing alarms, each once.
    pub fn kinds(&self) -> impl Iterator<Item = AlarmKind> + '_ {
        let stands = |(at, _): &(usize, AlarmKind)| self.kinds & 1 << at != 0;
        let others = KINDS.into_iter().enumerate().filter(stands).map(|(_, kind)| kind);
        self.fault.map(AlarmKind::Fault).into_iter().chain(others)
    }

    /// Whether it has a fault, and each of [`KINDS`].
    pub(in crate::robot) fn has(&self) -> [bool; 1 + KINDS.len()] {
        std::array::from_fn(|at| at.checked_sub(1).map_or(self.fault.is_some(), |kind| self.kinds & 1 << kind != 0))
    }

    /// The alarms that do not stand in the other.
    fn without(&self, other: &Self) -> Self {
        Self { fault: self.fault.filter(|_| self.fault != other.fault), kinds: self.kinds & !other.kinds }
    }
}

/// One byte with the first seven kinds and a bit for a fault that follows. If a further kind stands, a byte that announces
/// them and the bit for a fault comes first, then one with the first seven kinds and one with the further ones.
impl BorshSerialize for Standing {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        let [first, further] = [self.kinds & 0x7f, self.kinds >> IN_ONE_BYTE].map(|bits| bits as u8);
        let fault = u8::from(self.fault.is_some()) << IN_ONE_BYTE;
        if further == 0 {
            (first | fault).serialize(writer)?;
        } else {
            (ANNOUNCES_ANOTHER | fault, first, further).serialize(writer)?;
        }
        self.fault.iter().try_for_each(|fault| fault.serialize(writer))
    }
}

impl BorshDeserialize for Standing {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (bits, fault) = (u8::deserialize_reader(reader)?, 1 << IN_ONE_BYTE);
        let kinds = if bits & !fault == ANNOUNCES_ANOTHER {
            let [first, further] = <[u8; 2]>::deserialize_reader(reader)?;
            u16::from(first) | u16::from(further) << IN_ONE_BYTE
        } else {
            u16::from(bits & !fault)
        };
        let has_fault = (bits & fault != 0).then(|| Fault::deserialize_reader(reader));
        Ok(Self { fault: has_fault.transpose()?, kinds })
    }
}

impl Robot {
    /// Raises the alarms of a whisker that are due and do not stand, and clears those that stand and are not due.
    pub(in crate::robot) fn tell_alarms(&mut self, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        self.let_stand(index, self.alarms_due(index), effects);
    }

    fn let_stand(&mut self, index: WhiskerIndex, due: Standing, effects: &mut Vec<Effect>) {
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
        let is_own = |one: &Compensation| one.target() == index && one.compensator() == index && !one.settled;
        let is_tried = self.whiskers[index].rare.tries.is_failing() && self.head.compensations.iter().any(is_own);
        let whisker = &self.whiskers[index];
        let due = whisker.due(is_proposed, is_tried);
        let stands = !self.head.silent && whisker.fault == STALE && whisker.standing.fault == STALE;
        if stands { Standing { fault: STALE, ..due } } else { due }
    }

    /// Raises or clears the alarm for the robot's silence. Returns whether the silence has begun: then no whisker's own
    /// silence is an alarm any more.
    pub(in crate::robot) fn tell_silence(&mut self, now: Micros, effects: &mut Vec<Effect>) -> bool {
        let (was, is) = (self.head.silent, self.is_silent());
        if was == is || self.is_duplicated() {
            return false;
        }
        self.head.silent = is;
        let kind = AlarmKind::RobotSilent;
        if is {
            effects.push(Effect::RobotAlarm { kind });
        } else {
            self.head.heard_again = now;
            // Ticks follow the whiskers that stay silent.
            self.tick_deadline.end();
            effects.push(Effect::RobotAlarmCleared { kind });
        }
        is
    }

    /// Whether no whisker is heard.
    fn is_silent(&self) -> bool {
        // First a whisker of this step, because it is in the processor's cache.
        let is_heard = self.whiskers.first_touched().is_some_and(|index| self.whiskers[index].fault != STALE);
        !is_heard && !self.whiskers.is_empty() && self.whiskers.iter().all(|whisker| whisker.fault == STALE)
    }

    /// Raises the alarms of whiskers that are silent alone. Whiskers of a robot that falls silent are not: they become
    /// stale one after the other, and nothing comes from any of them.
    pub(in crate::robot) fn tell_lone_silence(&mut self, params: &Params, effects: &mut Vec<Effect>) {
        if self.is_duplicated()
            || self.is_silent()
            || !(0..self.whiskers.len()).any(|index| self.may_be_silent_alone(index))
        {
            return;
        }
        let newest = self.whiskers.iter().filter_map(|whisker| whisker.heard).max().unwrap_or_default();
        for index in 0..self.whiskers.len() {
            let heard = self.whiskers[index].heard.unwrap_or_default().max(self.head.heard_again);
            if self.may_be_silent_alone(index) && newest.since(heard) > params.health.stale_after {
                self.let_stand(index, Standing { fault: STALE, ..self.alarms_due(index) }, effects);
            }
        }
    }

    /// Whether a whisker is silent, and whether it is so alone is not known yet.
    pub(in crate::robot) fn may_be_silent_alone(&self, index: WhiskerIndex) -> bool {
        let whisker = &self.whiskers[index];
        !self.head.silent && whisker.fault == STALE && whisker.standing.fault != STALE
    }

    /// Takes back all alarms without effects, because nobody is responsible for the robot for now. Returns whether any
    /// stood. [`Self::review_alarms`] must follow before the next step.
    pub fn withdraw_alarms(&mut self) -> bool {
        let mut any = std::mem::take(&mut self.head.silent) || self.is_duplicated();
        self.head.duplicate = DuplicateWatch::default();
        for index in 0..self.whiskers.len() {
            if self.whiskers[index].standing != Standing::default() {
                self.whiskers[index].standing = Standing::default();
                any = true;
            }
        }
        any
    }

    /// Makes the next step raise the alarms that are due: the robot is supervised again. Silence counts from `now` on.
    pub fn review_alarms(&mut self, now: Micros) {
        self.listen_from(now);
        self.whiskers.touch_all();
    }

    /// The standing alarms about the robot as a whole.
    pub fn standing(&self) -> impl Iterator<Item = AlarmKind> + '_ {
        let silent = self.head.silent.then_some(AlarmKind::RobotSilent);
        silent.into_iter().chain(self.is_duplicated().then_some(AlarmKind::DuplicateRobot))
    }
}

impl Whisker {
    /// The alarms that its state asks for, but for its silence; `is_tried` if its own compensation has failed and is tried
    /// again.
    fn due(&self, proposed: bool, is_tried: bool) -> Standing {
        let is = [
            self.condition == Condition::SensitivityLoss,
            self.condition == Condition::Eroding,
            self.shift_told,
            self.drift_told,
            self.has_failed_setpoint(),
            self.unserved || is_tried,
            proposed,
            self.rare.reach.as_ref().is_some_and(|reach| reach.is_lost()),
            self.has_vented_alarm(),
        ];
        Standing { fault: self.fault_with_alarm(), kinds: encoding::pack_flags(is) }
    }
}
