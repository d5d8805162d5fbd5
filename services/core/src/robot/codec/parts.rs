//! The parts of the stored bytes that not every robot has, by name. A test needs a stored robot with each of them; so a
//! part that is new does not compile before it is named here or beside its type, and a named one needs a fixture.

use std::collections::BTreeMap;

use super::whisker;
use crate::estimation::leak;
use crate::optional_parts::{OptionalParts, optional_fields};
use crate::policy::Case;
use crate::robot::compensation::Compensation;
use crate::robot::effect::{Command, CommandState, Condition, Fault, Reason, TestKind, TestReason, TestState};
use crate::robot::event::{AirControl, ArrayKind, GaugeState, Link, RegulatorState, Task, TouchTests};
use crate::robot::health::misfit::Cause;
use crate::robot::health::standing;
use crate::robot::state::head::Head;
use crate::robot::state::whisker::{Desired, Holds, InFlight, Whisker};
use crate::robot::{Array, Robot};
use crate::units::Micros;

/// Implements [`OptionalParts`] for an enum. All variants must be listed; those after the semicolon are never stored.
macro_rules! stored_variants {
    ($type:ty: $($variant:ident $(($content:tt))?),+ $(; $($never:ident),+)?) => {
        impl OptionalParts<{ [$(stringify!($variant)),+].len() }> for $type {
            const NAMES: [&'static str; [$(stringify!($variant)),+].len()] = [$(stringify!($variant)),+];

            fn has(&self) -> [bool; [$(stringify!($variant)),+].len()] {
                match self {
                    $(Self::$variant $(($content))? => (),)+
                    $($(Self::$never => (),)+)?
                }
                [$(matches!(self, Self::$variant $(($content))?)),+]
            }
        }
    };
}

stored_variants!(Link: Online, Offline, Broken);
stored_variants!(ArrayKind: Type1, Type2);
stored_variants!(Task: Ratio, Distance);
stored_variants!(AirControl: FillAndVent, VentOnly, None);
stored_variants!(Case: SelfCompensation, ShorterForLonger, LongerForShorter);
stored_variants!(Cause: Unknown, CablesExchanged, GaugeReversed, WhiskerReplaced);
stored_variants!(Condition: Learning, Healthy, Suspected, Trimmed, Eroding, SensitivityLoss);
stored_variants!(Holds: Unheard, Stray, Known, Vented);
stored_variants!(Fault: Stale, Gauge(_), Leak, Regulator, SupplyLow);
stored_variants!(RegulatorState: Ok, Filling, Venting, SupplyLow, Leak, Fault);
stored_variants!(GaugeState: Ok, Saturated, Open, Short);
stored_variants!(Reason: Compensation(_), Release, Refinement, Operator);
stored_variants!(CommandState: Pending, Received, Applying;
    Applied, Rejected, Failed, Superseded, Expired, Abandoned);
stored_variants!(TestKind: Tip, Wall);
stored_variants!(TestReason: Suspicion, Setpoint, Operator, Pause, Schedule, Change);
stored_variants!(TestState: Pending, Accepted, Running, Proposed, Refused;
    Done, Rejected, Failed, Expired, Abandoned, Withdrawn);

// `undecided` is false at the end of a step.
optional_fields!(Head:
    epoch, link, clock, sequences, arrays, next_version, next_trim, next_compensation, undecided, listening_since,
    touch_tests, tests, duplicate, air_control;
    boot_id: boot_id.is_some(),
    compensations: !compensations.is_empty(),
    held: *held,
    is_taken_up: *is_taken_up,
    test_times: !test_times.is_empty(),
    silent: *silent,
    heard_again: *heard_again > Micros::default(),
    applies_gain: *applies_gain,
    states_distance: *states_distance,
    misfits: !misfits.is_empty(),
    called_changes: !called_changes.is_empty(),
);
optional_fields!(TouchTests: ; tip: *tip, wall: *wall);
optional_fields!(Compensation:
    id, target, compensator, case, predicted_error, length, pressure_before, pressure, after, length_sd_mm, refining;
    before: before.is_some(),
    settled: *settled,
    proposed: *proposed,
);
optional_fields!(Desired: pressure, reason; compensation: compensation.is_some(), gain: gain.is_some());
optional_fields!(Command: key, whisker, robot_boot_id, pressure, slew_mpa_per_s, issued, expires, reason;
    compensation: compensation.is_some(),
    gain: gain.is_some(),
);

/// Names of parts, each with whether one of the values has it.
#[derive(Default)]
struct Parts(BTreeMap<String, bool>);

impl Parts {
    fn add<'a, const N: usize, T: OptionalParts<N> + 'a>(&mut self, of: &str, values: impl IntoIterator<Item = &'a T>) {
        self.note(of, T::NAMES, values.into_iter().map(T::has));
    }

    fn note<const N: usize>(&mut self, of: &str, names: [&str; N], values: impl Iterator<Item = [bool; N]>) {
        let mut have = [false; N];
        for has in values {
            have.iter_mut().zip(has).for_each(|(any, has)| *any |= has);
        }
        self.0.extend(names.iter().zip(have).map(|(name, has)| (format!("{of}: {name}"), has)));
    }
}

impl Robot {
    /// Every optional part of stored robots, and whether this one has it: for tests of the stored formats.
    #[doc(hidden)]
    #[must_use]
    pub fn stored_parts(&self) -> BTreeMap<String, bool> {
        let mut parts = Parts::default();
        let head = &*self.head;
        parts.add("robot", [head]);
        parts.add("link", [&head.link]);
        parts.add("clock", [&head.clock]);
        parts.add("sequences", [&head.sequences]);
        parts.add("sequence", head.sequences.boots());
        parts.add("array kind", head.arrays.iter().map(|Array { name: _, kind, task: _ }| kind));
        parts.add("array task", head.arrays.iter().map(|array| &array.task));
        parts.add("touch tests", [&head.touch_tests]);
        parts.add("test budget", [&head.tests]);
        parts.add("test times", &head.test_times);
        parts.add("duplicate", [&head.duplicate]);
        parts.add("misfit", &head.misfits);
        parts.add("misfit cause", head.misfits.iter().filter_map(|one| one.cause.as_ref()));
        parts.add("air control", [&head.air_control]);
        parts.add("compensation", &head.compensations);
        parts.add("compensation case", head.compensations.iter().map(|one| &one.case));
        parts.add("refining", head.compensations.iter().map(|one| &one.refining));

        let whiskers = || self.whiskers.iter();
        parts.note("whisker", whisker::FLAGS, whiskers().map(Whisker::is));
        parts.note("whisker", whisker::PARTS, whiskers().map(Whisker::has_parts));
        parts.note("whisker", whisker::LATER_PARTS, whiskers().map(Whisker::has_later_parts));
        let learned = |one: &Whisker| [one.temperatures.is_some(), one.heard.is_some()];
        parts.note("whisker", ["temperatures", "heard"], whiskers().map(learned));
        parts.add("condition", whiskers().map(|one| &one.condition));
        parts.add("fault", whiskers().filter_map(|one| one.fault.as_ref()));
        parts.add("holds", whiskers().map(|one| &one.holds));
        parts.note("standing", standing::PARTS, whiskers().map(|one| one.standing.has()));
        parts.note("air", whisker::AIR_FLAGS, whiskers().map(|one| one.air.is(&one.sheet)));
        parts.add("regulator", whiskers().map(|one| &one.air.regulator));
        parts.add("detector", whiskers().map(|one| &one.detector));
        parts.note("leak", leak::FLAGS, whiskers().map(|one| one.leak.is()));
        parts.add("gauge", whiskers().map(|one| &one.gauge));
        parts.add("reported gauge", whiskers().map(|one| &one.gauge.reported));
        parts.add("observed gauge", whiskers().map(|one| &one.gauge.observed));
        let desired = || whiskers().filter_map(|one| one.desired.as_deref());
        parts.add("desired", desired());
        parts.add("desired reason", desired().map(|one| &one.reason));
        let flights = || whiskers().filter_map(|one| one.command.as_deref());
        parts.add("command", flights().map(|InFlight { command, state: _, resend_at: _ }| command));
        parts.add("command reason", flights().map(|one| &one.command.reason));
        parts.add("command state", flights().map(|one| &one.state));
        parts.add("tries", whiskers().map(|one| &one.rare.tries));
        parts.add("reach", whiskers().filter_map(|one| one.rare.reach.as_deref()));
        parts.add("flapping", whiskers().filter_map(|one| one.rare.flapping.as_ref()));
        parts.add("vents", whiskers().filter_map(|one| one.rare.vents.as_ref()));
        let length_tests = || whiskers().filter_map(|one| one.rare.length_test.as_deref());
        parts.add("length test", length_tests());
        parts.add("wanted test", length_tests().filter_map(|one| one.wanted.as_ref()));
        let tests = || length_tests().filter_map(|one| one.in_flight.as_ref());
        parts.add("test kind", tests().map(|one| &one.kind));
        parts.add("test reason", tests().map(|one| &one.reason));
        parts.add("test state", tests().map(|one| &one.state));
        parts.0
    }
}
