//! Closed lists of the kinds of events and effects.

use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::{Link, Rejection, SetpointReport, TestReport};
use vibrissa_core::robot::{Event, OperatorAction, Scope};

/// Lists patterns that cover a type, each with a name: a pattern that is missing does not compile.
macro_rules! closed_list {
    ($all:ident, $name_of:ident($type:ty): $($pattern:pat => $name:literal,)*) => {
        pub(super) const $all: &[&str] = &[$($name),*];

        pub(super) fn $name_of(one: &$type) -> &'static str {
            match one {
                $($pattern => $name,)*
            }
        }
    };
}

closed_list! {
    KINDS, kind_of(Event<'_>):
    Event::Connection { link: Link::Online, .. } => "online",
    Event::Connection { link: Link::Offline, .. } => "offline",
    Event::Connection { link: Link::Broken, .. } => "broken",
    Event::Factsheet { .. } => "factsheet",
    Event::Contacts { .. } => "contacts",
    Event::Status { .. } => "status",
    Event::Setpoint { report: SetpointReport::Received, .. } => "received",
    Event::Setpoint { report: SetpointReport::Applying, .. } => "applying",
    Event::Setpoint { report: SetpointReport::Applied(_), .. } => "applied",
    Event::Setpoint { report: SetpointReport::Failed, .. } => "failed",
    Event::Setpoint { report: SetpointReport::Superseded, .. } => "superseded",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::Stale), .. } => "rejected: stale",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::Expired), .. } => "rejected: expired",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::OutOfRange), .. } => "rejected: out of range",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::UnknownWhisker), .. } => "rejected: unknown whisker",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::WrongBoot), .. } => "rejected: wrong boot",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::NotReady), .. } => "rejected: not ready",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::InTask), .. } => "rejected: in a task",
    Event::TouchTest { report: TestReport::Accepted, .. } => "test accepted",
    Event::TouchTest { report: TestReport::Running, .. } => "test running",
    Event::TouchTest { report: TestReport::Done, .. } => "test done",
    Event::TouchTest { report: TestReport::Failed, .. } => "test failed",
    Event::TouchTest { report: TestReport::Rejected(_), .. } => "test rejected",
    Event::Operator(OperatorAction::TouchTest(_)) => "touch test by hand",
    Event::Operator(OperatorAction::RefuseTouchTest(_)) => "touch test refused",
    Event::Operator(OperatorAction::Retry(_)) => "setpoint tried again",
    Event::Operator(OperatorAction::Approve { .. }) => "approve",
    Event::Operator(OperatorAction::Refuse { .. }) => "refuse",
    Event::Operator(OperatorAction::Setpoint { .. }) => "setpoint by hand",
    Event::Operator(OperatorAction::Hold(Scope::Robot)) => "hold robot",
    Event::Operator(OperatorAction::Hold(Scope::Whisker(_))) => "hold whisker",
    Event::Operator(OperatorAction::Release(Scope::Robot)) => "release robot",
    Event::Operator(OperatorAction::Release(Scope::Whisker(_))) => "release whisker",
    Event::Operator(OperatorAction::Replaced(_)) => "replaced",
    Event::Operator(OperatorAction::Rebaseline(_)) => "rebaseline",
    Event::PolicyChanged => "policy changed",
    Event::Tick => "tick",
}

closed_list! {
    EFFECTS, effect_of(Effect):
    Effect::Contact(_) => "contact",
    Effect::UnknownWhisker { .. } => "unknown whisker",
    Effect::BadTime { .. } => "bad time",
    Effect::Condition { .. } => "condition",
    Effect::Fault { .. } => "fault",
    Effect::Trim(_) => "trim",
    Effect::Decided(_) => "decided",
    Effect::Ended { .. } => "ended",
    Effect::Command(_) => "command",
    Effect::Resend(_) => "resend",
    Effect::CommandState { .. } => "command state",
    Effect::Response(_) => "response",
    Effect::Error(_) => "error",
    Effect::Refined(_) => "refined",
    Effect::Approved { .. } => "approved",
    Effect::Alarm { .. } => "alarm",
    Effect::AlarmCleared { .. } => "alarm cleared",
    Effect::RobotAlarm { .. } => "robot alarm",
    Effect::RobotAlarmCleared { .. } => "robot alarm cleared",
    Effect::Gone { .. } => "gone",
    Effect::MissedTouch { .. } => "missed touch",
    Effect::Test(_) => "test",
    Effect::TestProposed(_) => "test proposed",
    Effect::TestState { .. } => "test state",
    Effect::AskForFactsheet => "ask for factsheet",
}
