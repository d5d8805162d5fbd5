//! The words of the contract for the core's closed enums.

use vibrissa_core::policy::Case;
use vibrissa_core::robot::effect::{Condition, Reason, TestKind, TestReason};
use vibrissa_core::robot::event::Rejection;
use vibrissa_protocol::{SetpointError, SetpointReason, TouchTestKind, TouchTestReason, WhiskerCondition};

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
        Rejection::InTask => SetpointError::InTask,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::words::{Word, Words};

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
}
