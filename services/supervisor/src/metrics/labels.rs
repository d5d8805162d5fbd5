//! The labels' values: the words of the core's closed enums, as in the contract, the database and REST.

use vibrissa_core::policy::{Case, Mode};
use vibrissa_core::robot::effect::{
    AlarmKind, CommandState, Condition, ContactUse, EndReason, Fault, Reason, RefinementOutcome,
};
use vibrissa_core::robot::event::{GaugeState, Link, Rejection};
use vibrissa_edge::actions::ActionKind;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::RobotTopic;

use super::kinds::{Labels, Word};
use crate::store::RejectionCause;
use vibrissa_edge::actions::CALIBRATION;

/// The case of a decision that found nobody.
pub const NO_CASE: Word = "NONE";
/// Outcomes of a decision, before those that end it.
pub const STARTED: Word = "STARTED";
/// It waits for an operator.
pub const PROPOSED: Word = "PROPOSED";
/// An operator has approved it.
pub const APPROVED: Word = "APPROVED";
/// Nobody can serve.
pub const UNSERVED: Word = "UNSERVED";
/// A lease was taken.
pub const TAKEN: Word = "TAKEN";
/// A lease was lost or given back.
pub const LOST: Word = "LOST";
/// What waits to be handled.
pub const INBOX: Word = "inbox";
/// What waits to be published.
pub const OUTBOX: Word = "outbox";

/// Every case of the paper.
pub const CASES: [Case; 3] = [Case::SelfCompensation, Case::ShorterForLonger, Case::LongerForShorter];

const FAULTS: [Fault; 8] = [
    Fault::Stale,
    Fault::Gauge(GaugeState::Open),
    Fault::Gauge(GaugeState::Short),
    Fault::Gauge(GaugeState::Saturated),
    Fault::Gauge(GaugeState::Ok),
    Fault::Leak,
    Fault::Regulator,
    Fault::SupplyLow,
];
const ENDS: [EndReason; 8] = [
    EndReason::LayoutChanged,
    EndReason::TargetTrimmedAgain,
    EndReason::CompensatorBroken,
    EndReason::Reassigned,
    EndReason::SetpointFailed,
    EndReason::Replaced,
    EndReason::Refused,
    EndReason::Operator,
];

const fn by_one(name: &'static str, values: fn() -> Vec<[Word; 1]>) -> Labels<1> {
    Labels { names: [name], values }
}

macro_rules! words {
    ($($one:expr),+ $(,)?) => { || vec![$([$one.word()]),+] };
}

pub(super) const TOPIC: Labels<1> = by_one("topic", || {
    RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot()).map(|kind| [kind.as_str()]).collect()
});
/// What [`vibrissa_protocol::Refusal`], [`vibrissa_edge::EdgeError`] and the engine say.
pub(super) const REASON: Labels<1> = by_one("reason", || {
    [
        "bad_name",
        "bad_time",
        "conflicting_duplicate",
        "duplicate",
        "inbox_full",
        "malformed",
        "not_allowed",
        "not_json",
        "old_boot",
        "out_of_range",
        "over_share",
        "state_backward",
        "suspect",
        "too_large",
        "too_many",
        "too_many_boots",
        "too_many_gaps",
        "too_many_layouts",
        "too_many_new_robots",
        "too_many_robots",
        "unknown_boot",
        "unknown_command",
        "unknown_model",
        "unknown_robot",
        "unknown_topic",
        "wrong_neighbour",
    ]
    .map(|reason| [reason])
    .to_vec()
});
pub(super) const USED: Labels<1> = by_one(
    "used",
    words!(
        ContactUse::Learning,
        ContactUse::Used,
        ContactUse::Unsettled,
        ContactUse::TooWeak,
        ContactUse::OnChamber,
        ContactUse::GaugeFault,
        ContactUse::Implausible
    ),
);
pub(super) const CONNECTION: Labels<1> = by_one("connection", words!(Link::Online, Link::Offline, Link::Broken));
pub(super) const HEALTH: Labels<1> = by_one("health", || {
    let conditions = [
        Condition::Learning,
        Condition::Healthy,
        Condition::Suspected,
        Condition::Trimmed,
        Condition::Eroding,
        Condition::SensitivityLoss,
    ];
    conditions.map(|one| [one.word()]).into_iter().chain(FAULTS.map(|one| [one.word()])).collect()
});
pub(super) const CASE: Labels<1> = by_one("case", || CASES.map(|case| [case.word()]).to_vec());
pub(super) const CASE_AND_OUTCOME: Labels<2> = Labels {
    names: ["case", "outcome"],
    values: || {
        let outcomes = || [STARTED, PROPOSED, APPROVED].into_iter().chain(ENDS.map(EndReason::word));
        let served = CASES.into_iter().flat_map(|case| outcomes().map(move |outcome| [case.word(), outcome]));
        served.chain([[NO_CASE, UNSERVED]]).collect()
    },
};
pub(super) const REFINEMENT: Labels<1> = by_one(
    "outcome",
    words!(
        RefinementOutcome::Refined,
        RefinementOutcome::HeldDither,
        RefinementOutcome::HeldMargin,
        RefinementOutcome::HeldUncertain,
        RefinementOutcome::HeldSteps,
        RefinementOutcome::HeldUnpredictable
    ),
);
pub(super) const STATE: Labels<1> = by_one(
    "state",
    words!(
        CommandState::Pending,
        CommandState::Received,
        CommandState::Applying,
        CommandState::Applied,
        CommandState::Rejected,
        CommandState::Failed,
        CommandState::Superseded,
        CommandState::Expired,
        CommandState::Abandoned
    ),
);
pub(super) const REJECTION_CAUSE: Labels<1> =
    by_one("cause", || RejectionCause::ALL.map(|cause| [cause.word()]).to_vec());
pub(super) const REJECTION: Labels<1> = by_one(
    "error",
    words!(
        Rejection::Stale,
        Rejection::Expired,
        Rejection::OutOfRange,
        Rejection::UnknownWhisker,
        Rejection::WrongBoot,
        Rejection::NotReady
    ),
);
pub(super) const SETPOINT_REASON: Labels<1> = by_one("reason", || {
    let others = [Reason::Release, Reason::Refinement, Reason::Operator];
    CASES.map(Reason::Compensation).into_iter().chain(others).map(|reason| [reason.word()]).collect()
});
pub(super) const ALARM: Labels<1> = by_one("kind", || {
    let others = [
        AlarmKind::Uncompensated,
        AlarmKind::SetpointFailed,
        AlarmKind::SensitivityLoss,
        AlarmKind::Eroding,
        AlarmKind::ArrayShift,
        AlarmKind::BaselineDrift,
        AlarmKind::Proposed,
    ];
    others.into_iter().chain(FAULTS.map(AlarmKind::Fault)).map(|kind| [kind.word()]).collect()
});
pub(super) const ACTION: Labels<2> = Labels {
    names: ["kind", "state"],
    values: || {
        let kinds = ActionKind::ALL.map(ActionKind::word).into_iter().chain([CALIBRATION]);
        kinds.flat_map(|kind| ["DONE", "REFUSED", "EXPIRED"].map(|state| [kind, state])).collect()
    },
};
pub(super) const MODE: Labels<1> = by_one("mode", words!(Mode::Automatic, Mode::Advise));
pub(super) const CHANGE: Labels<1> = by_one("change", || vec![[TAKEN], [LOST]]);
pub(super) const QUEUE: Labels<1> = by_one("queue", || vec![[INBOX], [OUTBOX]]);
