//! Values of labels: the words of the core's closed enums, as in the contract, the database and the REST API.

use vibrissa_core::policy::{Case, Mode};
use vibrissa_core::robot::effect::{
    AlarmKind, CommandState, Condition, ContactUse, EndReason, Fault, Reason, RefinementOutcome, TestReason, TestState,
};
use vibrissa_core::robot::event::Rejection;
use vibrissa_edge::actions::ActionKind;
use vibrissa_edge::presence::Presence;
use vibrissa_edge::words::{Word as _, Words};
use vibrissa_protocol::RobotTopic;

use super::kinds::{Labels, Word};
use crate::births::BirthCause;
use crate::log_inbox::Skipped;
use crate::set_aside::Reader;
use vibrissa_edge::actions::RecordedKind;
use vibrissa_store::RejectionCause;

/// Case of a decision that found no compensator.
pub const NO_CASE: Word = "NONE";
/// Outcome of a decision: the compensation starts.
pub const STARTED: Word = "STARTED";
/// Outcome of a decision: the compensation waits for an operator's approval.
pub const PROPOSED: Word = "PROPOSED";
/// Outcome of a proposal: an operator approved it.
pub const APPROVED: Word = "APPROVED";
/// Outcome of a decision: no whisker can compensate.
pub const UNSERVED: Word = "UNSERVED";
/// A lease was acquired.
pub const TAKEN: Word = "TAKEN";
/// A lease was lost or released.
pub const LOST: Word = "LOST";
/// Connection that receives from robots.
pub const RECEIVING: Word = "RECEIVING";
/// Connection that publishes to robots.
pub const PUBLISHING: Word = "PUBLISHING";
/// Queue of received messages.
pub const INBOX: Word = "inbox";
/// Queue of messages to publish.
pub const OUTBOX: Word = "outbox";

const fn by_one(name: &'static str, values: fn() -> Vec<[Word; 1]>) -> Labels<1> {
    Labels { names: [name], values }
}

/// All words of a closed enum.
fn all<T: Words>() -> Vec<[Word; 1]> {
    T::all().into_iter().map(|one| [one.word()]).collect()
}

pub(super) const TOPIC: Labels<1> = by_one("topic", || {
    RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot()).map(|kind| [kind.as_str()]).collect()
});
/// Reasons of [`vibrissa_protocol::Refusal`], [`vibrissa_edge::EdgeError`] and the engine.
pub(super) const REASON: Labels<1> = by_one("reason", || {
    [
        "bad_name",
        "bad_time",
        "conflicting_duplicate",
        "duplicate",
        "duplicate_robot",
        "inbox_full",
        "malformed",
        "newer_state",
        "not_allowed",
        "not_cbor",
        "not_json",
        "old_boot",
        "out_of_range",
        "over_budget",
        "over_share",
        "state_backward",
        "suspect",
        "time_unit",
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
        "unknown_whisker",
        "wrong_neighbour",
    ]
    .map(|reason| [reason])
    .to_vec()
});
pub(super) const USED: Labels<1> = by_one("used", all::<ContactUse>);
pub(super) const CONNECTION: Labels<1> = by_one("connection", all::<Presence>);
pub(super) const HEALTH: Labels<1> =
    by_one("health", || all::<Condition>().into_iter().chain(all::<Fault>()).collect());
pub(super) const CASE: Labels<1> = by_one("case", all::<Case>);
pub(super) const CASE_AND_OUTCOME: Labels<2> = Labels {
    names: ["case", "outcome"],
    values: || {
        let outcomes =
            || [STARTED, PROPOSED, APPROVED].into_iter().chain(EndReason::all().into_iter().map(EndReason::word));
        let served = Case::all().into_iter().flat_map(|case| outcomes().map(move |outcome| [case.word(), outcome]));
        served.chain([[NO_CASE, UNSERVED]]).collect()
    },
};
pub(super) const REFINEMENT: Labels<1> = by_one("outcome", all::<RefinementOutcome>);
pub(super) const STATE: Labels<1> = by_one("state", all::<CommandState>);
pub(super) const REJECTION_CAUSE: Labels<1> =
    by_one("cause", || RejectionCause::ALL.map(|cause| [cause.word()]).to_vec());
pub(super) const BIRTH_CAUSE: Labels<1> = by_one("cause", || BirthCause::ALL.map(|cause| [cause.word()]).to_vec());
pub(super) const LOG_SKIPPED: Labels<1> = by_one("reason", || Skipped::ALL.map(|reason| [reason.word()]).to_vec());
pub(super) const READER: Labels<1> = by_one("reader", || Reader::ALL.map(|reader| [reader.word()]).to_vec());
pub(super) const TEST_STATE: Labels<1> = by_one("state", all::<TestState>);
pub(super) const TEST_REASON: Labels<1> = by_one("reason", all::<TestReason>);
pub(super) const REJECTION: Labels<1> = by_one("error", all::<Rejection>);
pub(super) const SETPOINT_REASON: Labels<1> = by_one("reason", all::<Reason>);
pub(super) const ALARM: Labels<1> = by_one("kind", all::<AlarmKind>);
pub(super) const ACTION: Labels<2> = Labels {
    names: ["kind", "state"],
    values: || {
        let kinds =
            ActionKind::ALL.map(ActionKind::word).into_iter().chain(RecordedKind::OF_ENGINE.map(RecordedKind::word));
        kinds.flat_map(|kind| ["DONE", "REFUSED", "EXPIRED"].map(|state| [kind, state])).collect()
    },
};
pub(super) const ROLLOUT_EVENT: Labels<1> = by_one("event", || {
    ["STARTED", "LOOKED", "ADVANCED", "PAUSED", "RESUMED", "ROLLED_BACK", "COMPLETED"].map(|event| [event]).to_vec()
});
pub(super) const MODE: Labels<1> = by_one("mode", all::<Mode>);
pub(super) const CHANGE: Labels<1> = by_one("change", || vec![[TAKEN], [LOST]]);
pub(super) const QUEUE: Labels<1> = by_one("queue", || vec![[INBOX], [OUTBOX]]);
