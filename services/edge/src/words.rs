//! The core's closed enums in the words of the contract, the database, REST and the metrics.
//!
//! The OpenAPI schema (`http/words.rs`), the label values of metrics (`metrics/labels.rs`) and the console list some of these words
//! again.

use vibrissa_core::estimation::LengthEstimate;
use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{Case, Ineligible, LongerForShorter, Mode, Refused};
use vibrissa_core::robot::ActionProblem;
use vibrissa_core::robot::effect::{
    AlarmKind, CommandState, Condition, ContactUse, EndReason, Fault, Origin, Reason, RefinementOutcome,
};
use vibrissa_core::robot::event::{ArrayKind, GaugeState, Link, Rejection};
use vibrissa_protocol::{SetpointError, SetpointReason};

use crate::actions::ActionKind;

/// A closed enum with one word per variant, in upper snake case.
pub trait Word {
    /// The word.
    fn word(self) -> &'static str;
}

/// The one of `all` that a word stands for.
pub fn named<T: Word + Copy>(all: impl IntoIterator<Item = T>, word: &str) -> Option<T> {
    all.into_iter().find(|one| one.word() == word)
}

/// Spells out `Variant => "WORD"` for each enum.
macro_rules! words {
    ($($enum:ident { $($pattern:pat => $word:expr),+ $(,)? })+) => {
        $(impl Word for $enum {
            fn word(self) -> &'static str {
                match self { $($pattern => $word),+ }
            }
        })+
    };
}

words! {
    Condition {
        Condition::Learning => "LEARNING",
        Condition::Healthy => "HEALTHY",
        Condition::Suspected => "SUSPECTED",
        Condition::Trimmed => "TRIMMED",
        Condition::Eroding => "ERODING",
        Condition::SensitivityLoss => "SENSITIVITY_LOSS",
    }
    Fault {
        Fault::Stale => "STALE",
        Fault::Gauge(GaugeState::Open) => "GAUGE_OPEN",
        Fault::Gauge(GaugeState::Short) => "GAUGE_SHORT",
        Fault::Gauge(GaugeState::Saturated) => "GAUGE_SATURATED",
        Fault::Gauge(GaugeState::Ok) => "GAUGE",
        Fault::Leak => "LEAK",
        Fault::Regulator => "REGULATOR",
        Fault::SupplyLow => "SUPPLY_LOW",
    }
    ContactUse {
        ContactUse::Learning => "LEARNING",
        ContactUse::Used => "USED",
        ContactUse::Unsettled => "UNSETTLED",
        ContactUse::TooWeak => "TOO_WEAK",
        ContactUse::OnChamber => "ON_CHAMBER",
        ContactUse::GaugeFault => "GAUGE_FAULT",
        ContactUse::Implausible => "IMPLAUSIBLE",
    }
    Case {
        Case::SelfCompensation => "SELF_COMPENSATION",
        Case::ShorterForLonger => "SHORTER_FOR_LONGER",
        Case::LongerForShorter => "LONGER_FOR_SHORTER",
    }
    Ineligible {
        Ineligible::Learning => "LEARNING",
        Ineligible::Suspected => "SUSPECTED",
        Ineligible::Trimmed => "TRIMMED",
        Ineligible::Eroding => "ERODING",
        Ineligible::SensitivityLoss => "SENSITIVITY_LOSS",
        Ineligible::Stale => "STALE",
        Ineligible::GaugeFault => "GAUGE_FAULT",
        Ineligible::Leaking => "LEAKING",
        Ineligible::SetpointFailed => "SETPOINT_FAILED",
        Ineligible::Held => "HELD",
    }
    Refused {
        Refused::Ineligible(ineligible) => ineligible.word(),
        Refused::CaseNotAllowed => "CASE_NOT_ALLOWED",
        Refused::NeedsBelowRange => "NEEDS_BELOW_RANGE",
        Refused::NeedsAboveRange => "NEEDS_ABOVE_RANGE",
        Refused::ErrorAboveLimit => "ERROR_ABOVE_LIMIT",
        Refused::CutIntoChamber => "CUT_INTO_CHAMBER",
        Refused::CostsMore => "COSTS_MORE",
        Refused::Operator => "OPERATOR_REFUSED",
    }
    EndReason {
        EndReason::LayoutChanged => "LAYOUT_CHANGED",
        EndReason::TargetTrimmedAgain => "TARGET_TRIMMED_AGAIN",
        EndReason::CompensatorBroken => "COMPENSATOR_BROKEN",
        EndReason::Reassigned => "REASSIGNED",
        EndReason::SetpointFailed => "SETPOINT_FAILED",
        EndReason::Replaced => "REPLACED",
        EndReason::Refused => "REFUSED",
        EndReason::Operator => "OPERATOR",
    }
    CommandState {
        CommandState::Pending => "PENDING",
        CommandState::Received => "RECEIVED",
        CommandState::Applying => "APPLYING",
        CommandState::Applied => "APPLIED",
        CommandState::Rejected => "REJECTED",
        CommandState::Failed => "FAILED",
        CommandState::Superseded => "SUPERSEDED",
        CommandState::Expired => "EXPIRED",
        CommandState::Abandoned => "ABANDONED",
    }
    Origin {
        Origin::Measured => "MEASURED",
        Origin::Model => "MODEL",
    }
    RefinementOutcome {
        RefinementOutcome::Refined => "REFINED",
        RefinementOutcome::HeldDither => "HELD_DITHER",
        RefinementOutcome::HeldMargin => "HELD_MARGIN",
        RefinementOutcome::HeldUncertain => "HELD_UNCERTAIN",
        RefinementOutcome::HeldSteps => "HELD_STEPS",
        RefinementOutcome::HeldUnpredictable => "HELD_UNPREDICTABLE",
    }
    AlarmKind {
        AlarmKind::Uncompensated => "UNCOMPENSATED",
        AlarmKind::SetpointFailed => "SETPOINT_FAILED",
        AlarmKind::SensitivityLoss => "SENSITIVITY_LOSS",
        AlarmKind::Eroding => "ERODING",
        AlarmKind::ArrayShift => "ARRAY_SHIFT",
        AlarmKind::BaselineDrift => "BASELINE_DRIFT",
        AlarmKind::Fault(fault) => fault.word(),
        AlarmKind::Proposed => "PROPOSED",
    }
    Mode {
        Mode::Automatic => "AUTOMATIC",
        Mode::Advise => "ADVISE",
    }
    Objective {
        Objective::Tip => "TIP",
        Objective::Mean => "MEAN",
    }
    LongerForShorter {
        LongerForShorter::Never => "NEVER",
        LongerForShorter::LastResort => "LAST_RESORT",
        LongerForShorter::Allowed => "ALLOWED",
    }
    ActionKind {
        ActionKind::Approve => "APPROVE",
        ActionKind::Refuse => "REFUSE",
        ActionKind::Setpoint => "SETPOINT",
        ActionKind::Hold => "HOLD",
        ActionKind::Release => "RELEASE",
        ActionKind::Replaced => "REPLACED",
        ActionKind::Rebaseline => "REBASELINE",
        ActionKind::Policy => "POLICY",
    }
    ActionProblem {
        ActionProblem::UnknownWhisker => "UNKNOWN_WHISKER",
        ActionProblem::NotProposed => "NOT_PROPOSED",
        ActionProblem::PressureOutOfRange { .. } => "PRESSURE_OUT_OF_RANGE",
        ActionProblem::RobotOffline => "ROBOT_OFFLINE",
        ActionProblem::Held => "HELD",
        ActionProblem::RobotHeld => "ROBOT_HELD",
    }
    ArrayKind {
        ArrayKind::Type1 => "TYPE_1",
        ArrayKind::Type2 => "TYPE_2",
    }
    Link {
        Link::Online => "ONLINE",
        Link::Offline => "OFFLINE",
        Link::Broken => "CONNECTION_BROKEN",
    }
}

impl Word for Reason {
    fn word(self) -> &'static str {
        setpoint_reason(self).as_str()
    }
}

impl Word for Rejection {
    fn word(self) -> &'static str {
        setpoint_error(self).as_str()
    }
}

/// The contract's word for why a setpoint is sent.
#[must_use]
pub fn setpoint_reason(reason: Reason) -> SetpointReason {
    match reason {
        Reason::Compensation(Case::SelfCompensation) => SetpointReason::SelfCompensation,
        Reason::Compensation(Case::ShorterForLonger) => SetpointReason::ShorterForLonger,
        Reason::Compensation(Case::LongerForShorter) => SetpointReason::LongerForShorter,
        Reason::Release => SetpointReason::Release,
        Reason::Refinement => SetpointReason::Refinement,
        Reason::Operator => SetpointReason::Operator,
    }
}

fn setpoint_error(rejection: Rejection) -> SetpointError {
    match rejection {
        Rejection::Stale => SetpointError::Stale,
        Rejection::Expired => SetpointError::Expired,
        Rejection::OutOfRange => SetpointError::OutOfRange,
        Rejection::UnknownWhisker => SetpointError::UnknownWhisker,
        Rejection::WrongBoot => SetpointError::WrongBoot,
        Rejection::NotReady => SetpointError::NotReady,
    }
}

/// 1.96: half a 95 % interval in standard deviations.
pub const Z95: f64 = 1.959_963_985;

/// A 95 % interval of a length, mm.
#[must_use]
pub fn length_interval_mm(estimate: &LengthEstimate) -> (f64, f64) {
    let half = Z95 * estimate.sd_mm;
    ((estimate.length.mm() - half).max(0.0), estimate.length.mm() + half)
}
