//! The words of the core's closed enums in the contract, the database, REST and the metrics.
//!
//! The OpenAPI schema (`http/words.rs`), the label values of metrics (`metrics/labels.rs`) and the console repeat
//! some of these words.

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

/// A closed enum with one word for each variant, in upper snake case.
pub trait Word {
    /// The word of this value.
    fn word(self) -> &'static str;
}

/// An enum whose values can be listed.
pub trait Words: Word + Sized {
    /// Every value of the enum, once.
    fn all() -> Vec<Self>;
}

/// The value of a word.
pub fn named<T: Words + Copy>(word: &str) -> Option<T> {
    T::all().into_iter().find(|one| one.word() == word)
}

/// Declares the word of each variant: `Variant => "WORD"`; after a semicolon, the variant that uses the words of
/// another enum.
macro_rules! words {
    ($($enum:ident {
        $($variant:ident $(($inner:path))? => $word:literal),+ $(,)? $(; $other:ident($others:ident))?
    })+) => {
        $(impl Word for $enum {
            fn word(self) -> &'static str {
                match self {
                    $($enum::$variant $(($inner))? => $word,)+
                    $($enum::$other(other) => other.word(),)?
                }
            }
        }

        impl Words for $enum {
            fn all() -> Vec<Self> {
                let own = [$($enum::$variant $(($inner))?),+];
                own.into_iter()$(.chain($others::all().into_iter().map($enum::$other)))?.collect()
            }
        })+
    };
}

words! {
    Condition {
        Learning => "LEARNING",
        Healthy => "HEALTHY",
        Suspected => "SUSPECTED",
        Trimmed => "TRIMMED",
        Eroding => "ERODING",
        SensitivityLoss => "SENSITIVITY_LOSS",
    }
    Fault {
        Stale => "STALE",
        Gauge(GaugeState::Open) => "GAUGE_OPEN",
        Gauge(GaugeState::Short) => "GAUGE_SHORT",
        Gauge(GaugeState::Saturated) => "GAUGE_SATURATED",
        Gauge(GaugeState::Ok) => "GAUGE",
        Leak => "LEAK",
        Regulator => "REGULATOR",
        SupplyLow => "SUPPLY_LOW",
    }
    ContactUse {
        Learning => "LEARNING",
        Used => "USED",
        Unsettled => "UNSETTLED",
        TooWeak => "TOO_WEAK",
        OnChamber => "ON_CHAMBER",
        GaugeFault => "GAUGE_FAULT",
        Implausible => "IMPLAUSIBLE",
    }
    Case {
        SelfCompensation => "SELF_COMPENSATION",
        ShorterForLonger => "SHORTER_FOR_LONGER",
        LongerForShorter => "LONGER_FOR_SHORTER",
    }
    Ineligible {
        Learning => "LEARNING",
        Suspected => "SUSPECTED",
        Trimmed => "TRIMMED",
        Eroding => "ERODING",
        SensitivityLoss => "SENSITIVITY_LOSS",
        Stale => "STALE",
        GaugeFault => "GAUGE_FAULT",
        Leaking => "LEAKING",
        SetpointFailed => "SETPOINT_FAILED",
        Held => "HELD",
    }
    Refused {
        CaseNotAllowed => "CASE_NOT_ALLOWED",
        NeedsBelowRange => "NEEDS_BELOW_RANGE",
        NeedsAboveRange => "NEEDS_ABOVE_RANGE",
        ErrorAboveLimit => "ERROR_ABOVE_LIMIT",
        CutIntoChamber => "CUT_INTO_CHAMBER",
        CostsMore => "COSTS_MORE",
        Operator => "OPERATOR_REFUSED";
        Ineligible(Ineligible)
    }
    EndReason {
        LayoutChanged => "LAYOUT_CHANGED",
        TargetTrimmedAgain => "TARGET_TRIMMED_AGAIN",
        CompensatorBroken => "COMPENSATOR_BROKEN",
        Reassigned => "REASSIGNED",
        SetpointFailed => "SETPOINT_FAILED",
        Replaced => "REPLACED",
        Refused => "REFUSED",
        Operator => "OPERATOR",
    }
    CommandState {
        Pending => "PENDING",
        Received => "RECEIVED",
        Applying => "APPLYING",
        Applied => "APPLIED",
        Rejected => "REJECTED",
        Failed => "FAILED",
        Superseded => "SUPERSEDED",
        Expired => "EXPIRED",
        Abandoned => "ABANDONED",
    }
    Origin {
        Measured => "MEASURED",
        Model => "MODEL",
    }
    RefinementOutcome {
        Refined => "REFINED",
        HeldDither => "HELD_DITHER",
        HeldMargin => "HELD_MARGIN",
        HeldUncertain => "HELD_UNCERTAIN",
        HeldSteps => "HELD_STEPS",
        HeldUnpredictable => "HELD_UNPREDICTABLE",
    }
    AlarmKind {
        Uncompensated => "UNCOMPENSATED",
        SetpointFailed => "SETPOINT_FAILED",
        SensitivityLoss => "SENSITIVITY_LOSS",
        Eroding => "ERODING",
        ArrayShift => "ARRAY_SHIFT",
        BaselineDrift => "BASELINE_DRIFT",
        Proposed => "PROPOSED";
        Fault(Fault)
    }
    Mode {
        Automatic => "AUTOMATIC",
        Advise => "ADVISE",
    }
    Objective {
        Tip => "TIP",
        Mean => "MEAN",
    }
    LongerForShorter {
        Never => "NEVER",
        LastResort => "LAST_RESORT",
        Allowed => "ALLOWED",
    }
    ActionKind {
        Approve => "APPROVE",
        Refuse => "REFUSE",
        Setpoint => "SETPOINT",
        Hold => "HOLD",
        Release => "RELEASE",
        Replaced => "REPLACED",
        Rebaseline => "REBASELINE",
        Policy => "POLICY",
    }
    ArrayKind {
        Type1 => "TYPE_1",
        Type2 => "TYPE_2",
    }
    Link {
        Online => "ONLINE",
        Offline => "OFFLINE",
        Broken => "CONNECTION_BROKEN",
    }
    Reason {
        Release => "RELEASE",
        Refinement => "REFINEMENT",
        Operator => "OPERATOR";
        Compensation(Case)
    }
    Rejection {
        Stale => "STALE",
        Expired => "EXPIRED",
        OutOfRange => "OUT_OF_RANGE",
        UnknownWhisker => "UNKNOWN_WHISKER",
        WrongBoot => "WRONG_BOOT",
        NotReady => "NOT_READY",
    }
}

impl Word for ActionProblem {
    fn word(self) -> &'static str {
        match self {
            ActionProblem::UnknownWhisker => "UNKNOWN_WHISKER",
            ActionProblem::NotProposed => "NOT_PROPOSED",
            ActionProblem::PressureOutOfRange { .. } => "PRESSURE_OUT_OF_RANGE",
            ActionProblem::RobotOffline => "ROBOT_OFFLINE",
            ActionProblem::Held => "HELD",
            ActionProblem::RobotHeld => "ROBOT_HELD",
        }
    }
}

/// The contract's word for the reason of a setpoint.
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

/// The contract's word for the reason of a rejection.
#[must_use]
pub fn setpoint_error(rejection: Rejection) -> SetpointError {
    match rejection {
        Rejection::Stale => SetpointError::Stale,
        Rejection::Expired => SetpointError::Expired,
        Rejection::OutOfRange => SetpointError::OutOfRange,
        Rejection::UnknownWhisker => SetpointError::UnknownWhisker,
        Rejection::WrongBoot => SetpointError::WrongBoot,
        Rejection::NotReady => SetpointError::NotReady,
    }
}

/// 1.96: half the width of a 95 % interval, in standard deviations.
pub const Z95: f64 = 1.959_963_985;

/// The 95 % interval of a length, in mm.
#[must_use]
pub fn length_interval_mm(estimate: &LengthEstimate) -> (f64, f64) {
    let half = Z95 * estimate.sd_mm;
    ((estimate.length.mm() - half).max(0.0), estimate.length.mm() + half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_setpoints_are_those_of_the_contract() {
        assert!(Reason::all().into_iter().all(|one| one.word() == setpoint_reason(one).as_str()));
        assert!(Rejection::all().into_iter().all(|one| one.word() == setpoint_error(one).as_str()));
    }

    #[test]
    fn each_word_stands_for_one_value() {
        for kind in AlarmKind::all() {
            assert_eq!(named(kind.word()), Some(kind));
        }
        assert_eq!(AlarmKind::all().len(), 15);
        assert_eq!(named::<Condition>("LONGER"), None);
    }
}
