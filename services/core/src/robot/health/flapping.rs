//! A fault that comes and goes: its changes are folded, and its alarm has an on-delay and an off-delay, as in ISA-18.2.
//! The alarm VENTED has the same delays and latch, because a status can raise and clear it, too.
//!
//! A fault counts for the policy as soon as it comes. Changes that follow each other quickly are counted: from
//! [`FlappingParams::latch_changes`] on the fault is latched, and the whisker has the worst that was seen, until nothing has
//! changed for [`FlappingParams::steady_after`]. So a fault that flaps gives a few changes and one alarm, however often it
//! comes and goes. Slow changes, each after a steady time, are counted, too, and latch the fault until nothing has changed for
//! [`FlappingParams::forgotten_after`]. Silence is no such fault: it ends with the next message.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::optional_parts::OptionalParts;
use crate::robot::effect::Fault;
use crate::robot::params::FlappingParams;
use crate::units::Micros;

/// Numbers of a fault's changes. A stored byte has both, in four bits each. In a byte of a version that counted only quick
/// ones, a number above 15 latches the fault for longer, once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Changes {
    /// Changes that have followed each other quickly.
    quick: u8,
    /// Changes after a steady time, none of them long after the one before.
    slow: u8,
}

impl Changes {
    const MAX: u8 = 15;

    /// Counts a change. The first one after a steady time is a slow one.
    fn count(&mut self) {
        if self.quick == 0 {
            self.slow = self.slow.saturating_add(1).min(Self::MAX);
        }
        self.quick = self.quick.saturating_add(1).min(Self::MAX);
    }
}

impl BorshSerialize for Changes {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        (self.quick | self.slow << 4).serialize(writer)
    }
}

impl BorshDeserialize for Changes {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let byte = u8::deserialize_reader(reader)?;
        Ok(Self { quick: byte & Self::MAX, slow: byte >> 4 })
    }
}

/// A state that a status can raise and clear.
pub(in crate::robot) trait Flips: Copy + PartialEq {
    /// The cause comes before the symptom, as in the order in which faults are found; more than 0.
    fn rank(self) -> u8;
}

impl Flips for Fault {
    fn rank(self) -> u8 {
        match self {
            Self::SupplyLow => 1,
            Self::Regulator => 2,
            Self::Leak => 3,
            Self::Gauge(_) => 4,
            Self::Stale => 5,
        }
    }
}

/// The robot has vented the whisker without a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Vent;

impl Flips for Vent {
    fn rank(self) -> u8 {
        1
    }
}

/// The newest changes of a whisker's fault, or of its vents, until they are forgotten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub(in crate::robot) struct Flapping<T> {
    /// By the newest evidence.
    present: Option<T>,
    /// Time of its last change by the supervisor's clock; 0 if it has not changed since it was steady.
    changed: Micros,
    changes: Changes,
    /// The whisker's fault: the present one, or the worst one while it is latched.
    pub(super) reported: Option<T>,
    /// The fault whose alarm stands.
    pub(super) alarm: Option<T>,
}

impl<T> OptionalParts<5> for Flapping<T> {
    const NAMES: [&'static str; 5] = ["present", "quick changes", "slow changes", "told", "alarm"];

    fn has(&self) -> [bool; 5] {
        let Self { present, changed: _, changes: Changes { quick, slow }, reported, alarm } = self;
        [present.is_some(), *quick > 0, *slow > 0, reported.is_some(), alarm.is_some()]
    }
}

impl<T: Flips> Flapping<T> {
    /// A fault, or none, that has not changed for long.
    pub(in crate::robot) fn steady(fault: Option<T>) -> Self {
        Self { present: fault, changed: Micros(0), changes: Changes::default(), reported: fault, alarm: fault }
    }

    /// Takes the newest evidence in.
    pub(super) fn observe(&mut self, params: &FlappingParams, now: Micros, present: Option<T>) {
        let unchanged_for = now.since(self.changed);
        if unchanged_for >= params.steady_after {
            self.changes.quick = 0;
        }
        if unchanged_for >= params.forgotten_after {
            self.changes.slow = 0;
        }
        if present != self.present {
            (self.present, self.changed) = (present, now);
            self.changes.count();
        }
        let unchanged_for = now.since(self.changed);
        let is_latched = self.changes.quick.max(self.changes.slow) >= params.latch_changes;
        self.reported = if is_latched { worst(self.reported, present) } else { present };
        self.alarm = match (self.alarm, self.reported) {
            (None, Some(_)) if self.changes.quick <= 1 && unchanged_for < params.alarm_on_delay => None,
            (Some(alarm), reported)
                if worst(Some(alarm), reported) == Some(alarm) && unchanged_for < params.alarm_off_delay =>
            {
                Some(alarm)
            }
            (_, reported) => reported,
        };
    }

    /// Whether nothing follows from it any more.
    pub(super) fn is_over(&self, params: &FlappingParams, now: Micros) -> bool {
        now.since(self.changed) >= params.forgotten_after && self.reported == self.present && self.alarm == self.present
    }

    /// When time alone changes something.
    pub(super) fn times(&self, params: &FlappingParams) -> [Micros; 4] {
        [params.alarm_on_delay, params.alarm_off_delay, params.steady_after, params.forgotten_after]
            .map(|delay| self.changed.after(delay))
    }
}

fn worst<T: Flips>(one: Option<T>, other: Option<T>) -> Option<T> {
    let rank = |fault: Option<T>| fault.map_or(0, T::rank);
    if rank(other) > rank(one) { other } else { one }
}

#[cfg(test)]
mod tests;
