//! The words of the core's closed enums in the contract, the database, REST and the metrics, with their labels and
//! severities for people.
//!
//! They are declared here only. The query parameters of REST with their OpenAPI schema (`http/words.rs`), the label
//! values of metrics (`metrics/labels.rs`) and the console (`http/console/declared.rs`) derive from this declaration.
//! `tests/integration/deploy/words.rs` names the hand-written places that need a new word: alert rules, dashboards and
//! the glossary.

use vibrissa_core::estimation::LengthEstimate;
use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{Case, Ineligible, LongerForShorter, Mode, Refused};
use vibrissa_core::robot::ActionProblem;
use vibrissa_core::robot::effect::{
    AlarmKind, CommandState, Condition, ContactUse, EndReason, Fault, Origin, Reason, RefinementOutcome, TestKind,
    TestReason, TestState,
};
use vibrissa_core::robot::event::{ArrayKind, GaugeState, Link, Rejection};
use vibrissa_core::rollout::Stage;
use vibrissa_protocol::{SetpointError, SetpointReason, TouchTestKind, TouchTestReason, WhiskerCondition};

use crate::actions::{ActionKind, RecordedKind};
use crate::events::{Audience, EventKind};
use crate::guidance::Level;
use crate::presence::Presence;

/// How urgent a word is for people.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// As it should be.
    Good,
    /// A passing state that needs nobody.
    Info,
    /// Somebody should look at it.
    Warn,
    /// Something is broken, or was refused.
    Bad,
    /// Over, or absent.
    Off,
}

impl Severity {
    /// Name of the severity in the console.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Info => "info",
            Self::Warn => "warn",
            Self::Bad => "bad",
            Self::Off => "off",
        }
    }
}

/// A closed enum with one word for each variant, in upper snake case.
pub trait Word {
    /// The word of this value.
    fn word(self) -> &'static str;
}

/// An enum whose values can be listed.
pub trait Words: Word + Sized + 'static {
    /// Name of the enum.
    const NAME: &'static str;

    /// Every value of the enum, once.
    fn all() -> Vec<Self>;

    /// A few plain words for people; `None` for enums that people see only by their words.
    fn label(self) -> Option<&'static str>;

    /// How urgent the value is for people; `None` for enums whose values are all equally urgent.
    fn severity(self) -> Option<Severity>;
}

/// The value of a word.
pub fn named<T: Words + Copy>(word: &str) -> Option<T> {
    T::all().into_iter().find(|one| one.word() == word)
}

macro_rules! if_any {
    () => {
        None
    };
    ($value:expr) => {
        Some($value)
    };
}

/// Declares each variant's word, and for people its label and severity: `Variant => "WORD" "label" (Severity)`; after
/// a semicolon, the variant that uses the words of another enum.
macro_rules! words {
    ($($enum:ident {
        $($variant:ident $(($inner:path))? => $word:literal $($label:literal)? $(($severity:ident))?),+ $(,)?
        $(; $other:ident($others:ident))?
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
            const NAME: &'static str = stringify!($enum);

            fn all() -> Vec<Self> {
                let own = [$($enum::$variant $(($inner))?),+];
                own.into_iter()$(.chain($others::all().into_iter().map($enum::$other)))?.collect()
            }

            fn label(self) -> Option<&'static str> {
                match self {
                    $($enum::$variant $(($inner))? => if_any!($($label)?),)+
                    $($enum::$other(other) => other.label(),)?
                }
            }

            fn severity(self) -> Option<Severity> {
                match self {
                    $($enum::$variant $(($inner))? => if_any!($(Severity::$severity)?),)+
                    $($enum::$other(other) => other.severity(),)?
                }
            }
        })+
    };
}

words! {
    Condition {
        Learning => "LEARNING" "learning" (Info),
        Healthy => "HEALTHY" "healthy" (Good),
        Suspected => "SUSPECTED" "suspected" (Warn),
        Trimmed => "TRIMMED" "trimmed" (Bad),
        Eroding => "ERODING" "eroding" (Warn),
        SensitivityLoss => "SENSITIVITY_LOSS" "less sensitive" (Warn),
    }
    Fault {
        Stale => "STALE" "stale: no contacts" (Warn),
        Gauge(GaugeState::Open) => "GAUGE_OPEN" "gauge open" (Bad),
        Gauge(GaugeState::Short) => "GAUGE_SHORT" "gauge shorted" (Bad),
        Gauge(GaugeState::Saturated) => "GAUGE_SATURATED" "gauge saturated" (Bad),
        Gauge(GaugeState::Ok) => "GAUGE" "gauge faulty" (Bad),
        Leak => "LEAK" "leaking" (Bad),
        Regulator => "REGULATOR" "regulator faulty" (Bad),
        SupplyLow => "SUPPLY_LOW" "air supply low" (Bad),
    }
    ContactUse {
        Learning => "LEARNING",
        Used => "USED",
        Unsettled => "UNSETTLED",
        TooWeak => "TOO_WEAK",
        OnChamber => "ON_CHAMBER",
        NoPlace => "NO_PLACE",
        BeyondTip => "BEYOND_TIP",
        GaugeFault => "GAUGE_FAULT",
        Implausible => "IMPLAUSIBLE",
    }
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
    CommandState {
        Pending => "PENDING" "not answered yet" (Info),
        Received => "RECEIVED" "received" (Info),
        Applying => "APPLYING" "being applied" (Info),
        Applied => "APPLIED" "applied" (Good),
        Rejected => "REJECTED" "rejected by the robot" (Bad),
        Failed => "FAILED" "failed" (Bad),
        Superseded => "SUPERSEDED" "superseded" (Off),
        Expired => "EXPIRED" "expired" (Warn),
        Abandoned => "ABANDONED" "abandoned" (Off),
    }
    Origin {
        Measured => "MEASURED",
        Model => "MODEL",
    }
    RefinementOutcome {
        Refined => "REFINED" "the pressure was refined",
        HeldDither => "HELD_DITHER" "kept: the step would be within the regulator's dither",
        HeldMargin => "HELD_MARGIN" "kept: too little to gain",
        HeldUncertain => "HELD_UNCERTAIN" "kept: not certain enough yet",
        HeldSteps => "HELD_STEPS" "kept: maximum number of refinements reached",
        HeldUnpredictable => "HELD_UNPREDICTABLE" "kept: the effect cannot be predicted",
    }
    AlarmKind {
        Uncompensated => "UNCOMPENSATED" "trimmed, no compensator available",
        SetpointFailed => "SETPOINT_FAILED" "setpoints have failed",
        SensitivityLoss => "SENSITIVITY_LOSS" "sensitivity loss not explained by a cut",
        Eroding => "ERODING" "eroding",
        ArrayShift => "ARRAY_SHIFT" "shift shared by the whole array",
        BaselineDrift => "BASELINE_DRIFT" "baseline drift of the gauge",
        Proposed => "PROPOSED" "a compensation waits for approval",
        ReachLost => "REACH_LOST" "no contacts near the tip any more",
        Vented => "VENTED" "vented by the robot itself, and not filled again",
        RobotSilent => "ROBOT_SILENT" "the robot is silent or not connected",
        ReceiptsUnheard => "RECEIPTS_UNHEARD" "the robot does not hear its receipts",
        DuplicateRobot => "DUPLICATE_ROBOT" "two robots use this name";
        Fault(Fault)
    }
    Level {
        Warning => "WARNING" "warning: plan for it" (Info),
        Urgent => "URGENT" "urgent: look within the working day" (Warn),
        Critical => "CRITICAL" "critical: act now" (Bad),
    }
    Audience {
        Kafka => "KAFKA" "Kafka alone",
        Programs => "PROGRAMS" "also live pages",
        People => "PEOPLE" "also webhooks",
    }
    EventKind {
        AlarmRaised => "ALARM_RAISED" "alarm raised",
        AlarmCleared => "ALARM_CLEARED" "alarm cleared",
        AlarmHandled => "ALARM_HANDLED" "alarm acknowledged, shelved or unshelved",
        Trim => "TRIM" "trim detected",
        ConditionChanged => "CONDITION_CHANGED" "condition changed",
        FaultChanged => "FAULT_CHANGED" "fault changed",
        WhiskerGone => "WHISKER_GONE" "whisker not on the robot any more",
        Decision => "DECISION" "decision about a trimmed whisker",
        CompensationBegun => "COMPENSATION_BEGUN" "compensation begun",
        CompensationEnded => "COMPENSATION_ENDED" "compensation ended",
        ProposalEnded => "PROPOSAL_ENDED" "proposed compensation refused or withdrawn",
        Setpoint => "SETPOINT" "setpoint decided",
        SetpointState => "SETPOINT_STATE" "new state of a setpoint",
        SetpointFailed => "SETPOINT_FAILED" "setpoint rejected, failed or expired",
        Error => "ERROR" "compensation error measured",
        Refinement => "REFINEMENT" "pressure and gain of a compensation evaluated",
        TouchTest => "TOUCH_TEST" "touch test requested, or its new state",
        Action => "ACTION" "action of an operator answered",
        Policy => "POLICY" "policy in force",
        Calibration => "CALIBRATION" "calibration in force",
        Rollout => "ROLLOUT" "new state of a roll-out",
        Quarantined => "QUARANTINED" "message put into quarantine",
        Contacts => "CONTACTS" "contacts of one message",
        ContactsLeftOut => "CONTACTS_LEFT_OUT" "contacts missing",
        Test => "TEST" "test of a webhook",
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
    ActionKind {
        Approve => "APPROVE" "approve a compensation",
        Refuse => "REFUSE" "refuse a compensation",
        Setpoint => "SETPOINT" "set a pressure",
        Hold => "HOLD" "hold",
        Release => "RELEASE" "release",
        Replaced => "REPLACED" "whisker replaced",
        Rebaseline => "REBASELINE" "relearn baseline",
        TouchTest => "TOUCH_TEST" "touch test",
        RefuseTouchTest => "REFUSE_TOUCH_TEST" "refuse touch test",
        Retry => "RETRY" "try a failed setpoint again",
        Policy => "POLICY" "change the policy",
    }
    RecordedKind {
        Calibration => "CALIBRATION" "activate a calibration",
        CalibrationUpload => "CALIBRATION_UPLOAD" "upload a calibration",
        AllowedRobots => "ALLOWED_ROBOTS" "change the allowed robots",
        Decommission => "DECOMMISSION" "decommission a robot",
        LabelSet => "LABEL_SET" "set a label",
        LabelRemove => "LABEL_REMOVE" "remove a label",
        NoteAdd => "NOTE_ADD" "add a note",
        NoteRemove => "NOTE_REMOVE" "remove a note",
        AlarmAcknowledge => "ALARM_ACKNOWLEDGE" "acknowledge an alarm",
        AlarmShelve => "ALARM_SHELVE" "shelve an alarm",
        AlarmUnshelve => "ALARM_UNSHELVE" "unshelve an alarm",
        AlarmsAcknowledge => "ALARMS_ACKNOWLEDGE" "acknowledge many alarms",
        AlarmsShelve => "ALARMS_SHELVE" "shelve many alarms",
        AlarmsUnshelve => "ALARMS_UNSHELVE" "unshelve many alarms",
        RobotsHold => "ROBOTS_HOLD" "hold many robots",
        RobotsRelease => "ROBOTS_RELEASE" "release many robots",
        WhiskersHold => "WHISKERS_HOLD" "hold many whiskers",
        WhiskersRelease => "WHISKERS_RELEASE" "release many whiskers",
        WhiskersRebaseline => "WHISKERS_REBASELINE" "relearn many baselines",
        Policies => "POLICIES" "change the policies of many fleets",
        Calibrations => "CALIBRATIONS" "activate a calibration in many fleets",
        BulkStop => "BULK_STOP" "stop an action on many",
        RolloutStart => "ROLLOUT_START" "begin a roll-out",
        RolloutPause => "ROLLOUT_PAUSE" "pause a roll-out",
        RolloutResume => "ROLLOUT_RESUME" "resume a roll-out",
        RolloutAdvance => "ROLLOUT_ADVANCE" "advance a roll-out",
        RolloutBack => "ROLLOUT_ROLL_BACK" "roll a change back",
        TokenCreate => "TOKEN_CREATE" "create a token",
        TokenRevoke => "TOKEN_REVOKE" "revoke a token",
        WebhookCreate => "WEBHOOK_CREATE" "create a webhook",
        WebhookChange => "WEBHOOK_CHANGE" "change a webhook",
        WebhookRemove => "WEBHOOK_REMOVE" "remove a webhook",
        WebhookSecret => "WEBHOOK_SECRET" "renew a webhook's secret",
        WebhookTest => "WEBHOOK_TEST" "test a webhook",
        WebhookRedeliver => "WEBHOOK_REDELIVER" "deliver dead letters again",
        WebhookDiscard => "WEBHOOK_DISCARD" "discard dead letters",
        SignIn => "SIGN_IN" "sign in",
        SignOut => "SIGN_OUT" "sign out",
    }
    ArrayKind {
        Type1 => "TYPE_1" "whiskers that compensate for one another",
        Type2 => "TYPE_2" "single whiskers, each for itself",
    }
    Stage {
        Few => "FEW" "5 % of the robots",
        Quarter => "QUARTER" "25 % of the robots",
        All => "ALL" "all robots",
    }
    Link {
        Online => "ONLINE",
        Offline => "OFFLINE",
        Broken => "CONNECTION_BROKEN",
    }
    Presence {
        Online => "ONLINE" "online" (Good),
        Silent => "SILENT" "connected, but silent" (Bad),
        Offline => "OFFLINE" "offline" (Off),
        Broken => "CONNECTION_BROKEN" "connection broken" (Bad),
    }
    Reason {
        Release => "RELEASE" "back to nominal",
        Refinement => "REFINEMENT" "refined from measured contacts",
        Operator => "OPERATOR" "set by an operator";
        Compensation(Case)
    }
    TestState {
        Pending => "PENDING" "not answered yet" (Info),
        Accepted => "ACCEPTED" "accepted" (Info),
        Running => "RUNNING" "running" (Info),
        Done => "DONE" "done" (Good),
        Rejected => "REJECTED" "rejected by the robot" (Bad),
        Failed => "FAILED" "failed" (Bad),
        Expired => "EXPIRED" "no answer in time" (Warn),
        Abandoned => "ABANDONED" "abandoned: the robot restarted, or the whisker is gone" (Off),
        Proposed => "PROPOSED" "waits for an operator" (Warn),
        Withdrawn => "WITHDRAWN" "withdrawn: requested, or not needed any more" (Off),
        Refused => "REFUSED" "refused by an operator" (Off),
    }
    TestKind {
        Tip => "TIP" "sweep over the tip",
        Wall => "WALL" "touches at given distances",
    }
    TestReason {
        Suspicion => "SUSPICION" "the whisker may be cut",
        Setpoint => "SETPOINT" "measure the error of a compensation",
        Operator => "OPERATOR" "requested by an operator",
        Pause => "PAUSE" "not touched for long, or the robot restarted",
        Schedule => "SCHEDULE" "on schedule",
        Change => "CHANGE" "more sensitive: cut, or a gain that wanders",
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
            ActionProblem::WrongTimeUnit => "WRONG_TIME_UNIT",
            ActionProblem::NoTouchTests => "NO_TOUCH_TESTS",
            ActionProblem::NoProposedTest => "NO_PROPOSED_TEST",
            ActionProblem::TestUnderWay => "TEST_UNDER_WAY",
            ActionProblem::TestOfHeld => "TEST_OF_HELD",
            ActionProblem::NoFailedSetpoint => "NO_FAILED_SETPOINT",
            ActionProblem::RetryOfHeld => "RETRY_OF_HELD",
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

/// The contract's word for the kind of a touch test.
#[must_use]
pub fn touch_test_kind(kind: TestKind) -> TouchTestKind {
    match kind {
        TestKind::Tip => TouchTestKind::Tip,
        TestKind::Wall => TouchTestKind::Wall,
    }
}

/// The contract's word for the reason of a touch test.
#[must_use]
pub fn touch_test_reason(reason: TestReason) -> TouchTestReason {
    match reason {
        TestReason::Suspicion => TouchTestReason::Suspicion,
        TestReason::Setpoint => TouchTestReason::Setpoint,
        TestReason::Operator => TouchTestReason::Operator,
        TestReason::Pause => TouchTestReason::Pause,
        TestReason::Schedule => TouchTestReason::Schedule,
        TestReason::Change => TouchTestReason::Change,
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

/// The contract's word for a whisker's condition.
#[must_use]
pub fn whisker_condition(condition: Condition) -> WhiskerCondition {
    match condition {
        Condition::Learning => WhiskerCondition::Learning,
        Condition::Healthy => WhiskerCondition::Healthy,
        Condition::Suspected => WhiskerCondition::Suspected,
        Condition::Trimmed => WhiskerCondition::Trimmed,
        Condition::Eroding => WhiskerCondition::Eroding,
        Condition::SensitivityLoss => WhiskerCondition::SensitivityLoss,
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
    fn words_of_touch_tests_are_those_of_the_contract() {
        assert!(TestReason::all().into_iter().all(|one| one.word() == touch_test_reason(one).as_str()));
        assert!(TestKind::all().into_iter().all(|one| one.word() == touch_test_kind(one).as_str()));
    }

    #[test]
    fn words_of_conditions_are_those_of_the_contract() {
        let words: Vec<&str> = Condition::all().into_iter().map(Word::word).collect();
        assert_eq!(words, WhiskerCondition::ALL.iter().map(|one| one.as_str()).collect::<Vec<_>>());
        assert!(Condition::all().into_iter().all(|one| one.word() == whisker_condition(one).as_str()));
    }

    #[test]
    fn each_word_stands_for_one_value() {
        for kind in AlarmKind::all() {
            assert_eq!(named(kind.word()), Some(kind));
        }
        assert!(AlarmKind::all().len() > Fault::all().len());
        assert_eq!(named::<Condition>("LONGER"), None);
    }
}
