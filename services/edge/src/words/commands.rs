//! Words of setpoints and touch tests.

use vibrissa_core::policy::Case;
use vibrissa_core::robot::effect::{CommandState, Reason, TestKind, TestReason, TestState};
use vibrissa_core::robot::event::Rejection;

use super::{Severity, Word, Words};

words! {
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
    Reason {
        Release => "RELEASE" "back to nominal",
        Refinement => "REFINEMENT" "refined from measured contacts",
        Operator => "OPERATOR" "set by an operator";
        Compensation(Case)
    }
    Rejection {
        Stale => "STALE",
        Expired => "EXPIRED",
        OutOfRange => "OUT_OF_RANGE",
        UnknownWhisker => "UNKNOWN_WHISKER",
        WrongBoot => "WRONG_BOOT",
        NotReady => "NOT_READY",
        InTask => "IN_TASK",
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
}
