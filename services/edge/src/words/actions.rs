//! Words of the actions of people, and of what an action is refused for.

use vibrissa_core::robot::ActionProblem;

use super::{Severity, Word, Words};
use crate::actions::{ActionKind, RecordedKind};

words! {
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
        MaintenanceSet => "MAINTENANCE_SET" "set a maintenance",
        MaintenanceEnd => "MAINTENANCE_END" "end a maintenance",
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
