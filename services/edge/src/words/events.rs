//! Words of the events of the log, and of the levels of alarms.

use super::{Severity, Word, Words};
use crate::events::{Audience, EventKind};
use crate::guidance::Level;

words! {
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
}
