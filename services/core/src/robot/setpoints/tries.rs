//! Tries of a whisker's present setpoint, and the pauses between them.
//!
//! A try that the robot refuses, fails or leaves unanswered while it is heard counts towards the limit. A try that expires
//! while the robot or the supervisor is deaf says nothing about the robot: it is repeated after growing pauses, and counts only
//! after many of them. At the limit the whisker is failing: the alarm stands, and others may serve in its place. Single tries
//! follow after pauses from half a minute to an hour, until the robot takes one.
//!
//! A robot in a task says so and is no failing one. Its setpoint is tried again after growing pauses, for as long as it says
//! so. The pauses are those of unheard tries, of which so many are left over that silence after a task is no alarm either.
//!
//! A robot that takes a setpoint and then reports another one has not kept it: that is a failed try, too, and after a silence
//! one that says nothing about the robot. Failed tries are forgotten after an hour in which the robot has kept its setpoint,
//! with another pressure, a new boot, or an operator's action. So at most 20 setpoints with the same
//! pressure and gain go to a whisker within an hour.

use crate::optional_parts::OptionalParts;
use crate::robot::params::CommandParams;
use crate::units::Micros;

/// Tries in a row during which nobody was heard, until the whisker counts as failing: a robot that is heard between them, and
/// never during one, does not receive setpoints.
const UNHEARD_MAX: u8 = 7;
/// Tries that a task can count as unheard ones: after them each pause is the longest.
const IN_TASK_MAX: u8 = 4;
/// Longest pause between two tries while the robot is in a task: some sixteen in the first hour.
pub(super) const TASK_PAUSE_MAX: Micros = Micros(300_000_000);
/// Marks a stored byte as that of a failing whisker.
const FAILING: u8 = 0x80;
/// Tries that count, in the lower bits of a stored byte; the unheard ones follow.
const COUNTED_BITS: u8 = 4;
const COUNTED_MAX: u8 = (1 << COUNTED_BITS) - 1;

/// Failed tries of the present pressure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) enum Tries {
    /// The limit is not reached.
    Few {
        /// Failures that count.
        counted: u8,
        /// Expiries during which nobody was heard.
        unheard: u8,
    },
    /// The limit is reached, and no try after it has succeeded.
    Failing {
        /// Failed rounds, at least one: the limit, and each single try after it.
        rounds: u8,
    },
}

impl OptionalParts<3> for Tries {
    const NAMES: [&'static str; 3] = ["counted", "unheard", "failing"];

    fn has(&self) -> [bool; 3] {
        match *self {
            Self::Few { counted, unheard } => [counted > 0, unheard > 0, false],
            Self::Failing { rounds: _ } => [false, false, true],
        }
    }
}

impl Tries {
    /// No try has failed.
    pub(in crate::robot) const NONE: Self = Self::Few { counted: 0, unheard: 0 };

    pub(in crate::robot) fn is_failing(self) -> bool {
        matches!(self, Self::Failing { .. })
    }

    /// The tries after one more failure; `counts` is false if nobody was heard meanwhile.
    pub(super) fn failed(self, params: &CommandParams, counts: bool) -> Self {
        let (counted, unheard) = match self {
            Self::Failing { rounds } => return Self::Failing { rounds: rounds.saturating_add(1).min(FAILING - 1) },
            Self::Few { counted, unheard } if counts => (counted + 1, unheard),
            Self::Few { counted, unheard } => (counted, unheard + 1),
        };
        if counted >= params.attempts.min(COUNTED_MAX) || unheard >= UNHEARD_MAX {
            return Self::Failing { rounds: 1 };
        }
        Self::Few { counted, unheard }
    }

    /// The tries after one that a robot in a task has declined, and the pause before the next one. No try has failed.
    pub(super) fn in_task(self, params: &CommandParams) -> (Self, Micros) {
        match self {
            Self::Few { counted, unheard } if unheard < IN_TASK_MAX => {
                let tries = Self::Few { counted, unheard: unheard + 1 };
                (tries, tries.pause(params))
            }
            Self::Few { .. } | Self::Failing { .. } => (self, self.pause(params).max(TASK_PAUSE_MAX)),
        }
    }

    /// Pause before the next try.
    pub(super) fn pause(self, params: &CommandParams) -> Micros {
        let (first, doublings) = match self {
            Self::Few { unheard, .. } => (params.resend_after, unheard),
            Self::Failing { rounds } => (params.retry_after, rounds.saturating_sub(1)),
        };
        Micros(first.0.saturating_mul(1 << doublings.min(20)).min(params.retry_after_max.0.max(first.0)))
    }

    /// The stored byte.
    pub(in crate::robot) fn to_byte(self) -> u8 {
        match self {
            Self::Few { counted, unheard } => counted.min(COUNTED_MAX) | unheard.min(UNHEARD_MAX) << COUNTED_BITS,
            Self::Failing { rounds } => FAILING | rounds,
        }
    }

    /// The tries of a stored byte. Versions that counted sent setpoints stored their number.
    pub(in crate::robot) fn from_byte(byte: u8) -> Self {
        if byte & FAILING != 0 {
            return Self::Failing { rounds: (byte & !FAILING).max(1) };
        }
        Self::Few { counted: byte & COUNTED_MAX, unheard: byte >> COUNTED_BITS }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_grow_and_the_bytes_hold_every_state() {
        let params = CommandParams::default();
        let mut tries = Tries::NONE;
        let mut seen = Vec::new();
        for _ in 0..12 {
            tries = tries.failed(&params, true);
            assert_eq!(Tries::from_byte(tries.to_byte()), tries);
            seen.push((tries.is_failing(), tries.pause(&params).as_s()));
        }
        let pauses = [2.0, 2.0, 30.0, 60.0, 120.0, 240.0, 480.0, 960.0, 1920.0, 3600.0, 3600.0, 3600.0];
        let failing = std::iter::repeat_n(false, 2).chain(std::iter::repeat_n(true, 10));
        assert_eq!(seen, failing.zip(pauses).collect::<Vec<_>>());
    }

    #[test]
    fn unheard_tries_fail_late_and_grow_too() {
        let params = CommandParams::default();
        let mut tries = Tries::NONE.failed(&params, true);
        for unheard in 1..UNHEARD_MAX {
            tries = tries.failed(&params, false);
            assert_eq!(tries, Tries::Few { counted: 1, unheard });
            assert_eq!(
                (Tries::from_byte(tries.to_byte()), tries.pause(&params)),
                (tries, Micros(2_000_000 << unheard))
            );
        }
        assert!(tries.failed(&params, false).is_failing());
    }

    #[test]
    fn a_task_never_fails_and_leaves_tries_for_silence() {
        let params = CommandParams::default();
        let mut tries = Tries::NONE.failed(&params, true);
        let pauses = [(); 7].map(|()| {
            let (next, pause) = tries.in_task(&params);
            tries = next;
            pause.as_s()
        });
        assert_eq!(pauses, [4.0, 8.0, 16.0, 32.0, 300.0, 300.0, 300.0]);
        assert_eq!(tries, Tries::Few { counted: 1, unheard: IN_TASK_MAX });
        assert!(!tries.failed(&params, false).failed(&params, false).is_failing());
        let failing = Tries::Failing { rounds: 5 };
        assert_eq!(failing.in_task(&params), (failing, Micros(480_000_000)));
    }
}
