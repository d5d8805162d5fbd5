//! Words of compensations, of the policy and of roll-outs.

use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{Case, Ineligible, LongerForShorter, Mode, Refused};
use vibrissa_core::robot::effect::{EndReason, Origin, RefinementOutcome};
use vibrissa_core::rollout::Stage;

use super::{Severity, Word, Words};

words! {
    Case {
        SelfCompensation => "SELF_COMPENSATION" "compensates for itself",
        ShorterForLonger => "SHORTER_FOR_LONGER" "shorter for longer",
        LongerForShorter => "LONGER_FOR_SHORTER" "longer for shorter",
    }
    Ineligible {
        Learning => "LEARNING" "it is still being learned",
        Suspected => "SUSPECTED" "it may be cut itself",
        Trimmed => "TRIMMED" "it is trimmed itself",
        Eroding => "ERODING" "it is eroding",
        SensitivityLoss => "SENSITIVITY_LOSS" "it has lost sensitivity",
        Stale => "STALE" "it is silent",
        GaugeFault => "GAUGE_FAULT" "its gauge is faulty",
        Leaking => "LEAKING" "its chamber leaks",
        SetpointFailed => "SETPOINT_FAILED" "its last setpoint failed",
        Held => "HELD" "an operator holds it",
    }
    Refused {
        CaseNotAllowed => "CASE_NOT_ALLOWED" "the policy does not allow this case",
        NeedsBelowRange => "NEEDS_BELOW_RANGE" "it would need less than 0 MPa",
        NeedsAboveRange => "NEEDS_ABOVE_RANGE" "it would need more than its maximum pressure",
        ErrorAboveLimit => "ERROR_ABOVE_LIMIT" "the predicted error is above the policy's limit",
        CutIntoChamber => "CUT_INTO_CHAMBER" "it is cut into its chamber",
        GainOutOfRange => "GAIN_OUT_OF_RANGE" "the factor on its readings would be outside 0.05 to 20",
        CostsMore => "COSTS_MORE" "another candidate costs less",
        Operator => "OPERATOR_REFUSED" "an operator refused it";
        Ineligible(Ineligible)
    }
    EndReason {
        LayoutChanged => "LAYOUT_CHANGED" "the robot's layout changed",
        TargetTrimmedAgain => "TARGET_TRIMMED_AGAIN" "the whisker was trimmed again",
        CompensatorBroken => "COMPENSATOR_BROKEN" "the compensator broke",
        Reassigned => "REASSIGNED" "another compensator took over",
        SetpointFailed => "SETPOINT_FAILED" "the setpoint failed",
        Replaced => "REPLACED" "the whisker was replaced",
        Refused => "REFUSED" "an operator refused it",
        Operator => "OPERATOR" "an operator set the pressure",
    }
    Origin {
        Measured => "MEASURED",
        Model => "MODEL",
    }
    RefinementOutcome {
        Refined => "REFINED" "the pressure was refined",
        HeldDither => "HELD_DITHER" "kept: the step is too small for the regulator",
        HeldMargin => "HELD_MARGIN" "kept: too little to gain",
        HeldUncertain => "HELD_UNCERTAIN" "kept: not certain enough yet",
        HeldSteps => "HELD_STEPS" "kept: maximum number of refinements reached",
        HeldUnpredictable => "HELD_UNPREDICTABLE" "kept: the effect cannot be predicted",
    }
    Mode {
        Automatic => "AUTOMATIC" "automatic: compensations start at once",
        Advise => "ADVISE" "advise: an operator approves each compensation",
    }
    Objective {
        Tip => "TIP" "equal sensitivity at the tip (Eq. 34)",
        Mean => "MEAN" "least mean error over contact ratios",
        Shape => "SHAPE" "air for the shape, a gain for the level; the tip for robots without gains",
    }
    LongerForShorter {
        Never => "NEVER" "never",
        LastResort => "LAST_RESORT" "as a last resort",
        Allowed => "ALLOWED" "whenever it costs least",
    }
    Stage {
        Few => "FEW" "5 % of the robots",
        Quarter => "QUARTER" "25 % of the robots",
        All => "ALL" "all robots",
    }
}
