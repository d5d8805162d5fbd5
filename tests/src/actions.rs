//! Builds operator actions and waits for their answers.

use std::time::Duration;

use serde_json::{Value, json};
use vibrissa_core::policy::PolicyParams;
use vibrissa_edge::words::Word as _;
use vibrissa_protocol::Name;
use vibrissa_simulator::clock::now_us;
use vibrissa_store::Store;
use vibrissa_store::actions::{Action, Asked, NewAction};
use vibrissa_supervisor::action_notifier::ActionNotifier;

use crate::wait::PATIENCE;

/// The body of a request that sets this policy.
#[must_use]
pub fn policy_body(policy: &PolicyParams) -> Value {
    let mut body = json!({
        "mode": policy.mode.word(),
        "objective": policy.objective.word(),
        "longer_for_shorter": policy.longer_for_shorter.word(),
    });
    for number in PolicyParams::NUMBERS {
        body[number.name] = json!((number.of)(policy));
    }
    body
}

/// A new action for fleet `f` without a robot, array or whisker.
#[must_use]
pub fn asks(kind: &str, parameters: &str) -> NewAction {
    NewAction {
        fleet: Some("f".to_owned()),
        robot: None,
        array: None,
        whisker: None,
        compensation_id: None,
        alarm_id: None,
        kind: kind.to_owned(),
        parameters: parameters.to_owned(),
        reason: Some("a test".to_owned()),
        actor: "ann".to_owned(),
        role: "OPERATOR".to_owned(),
        request_id: "q1".to_owned(),
        idempotency_key: None,
        asked_us: now_us() as i64,
        expires_us: now_us() as i64 + PATIENCE.as_micros() as i64,
    }
}

/// The same for robot `r`; with a whisker number, for that whisker of array `left`.
#[must_use]
pub fn asks_of(kind: &str, parameters: &str, whisker: Option<i64>) -> NewAction {
    let array = whisker.map(|_| crate::robot::ARRAY.to_owned());
    NewAction { robot: Some("r".to_owned()), array, whisker, ..asks(kind, parameters) }
}

/// Stores the action, wakes the fleet's owner and returns the answered action.
///
/// # Panics
/// The action was stored before, or it is not answered in time.
pub async fn answered(store: &Store, action_notifier: &ActionNotifier, action: &NewAction) -> Action {
    let Asked::New(action_id) = store.ask(action).await.expect("a database") else {
        panic!("{action:?} was stored before")
    };
    if let Some(fleet) = &action.fleet {
        action_notifier.notify(&Name::new(fleet).expect("a name"));
    }
    let answer = action_notifier.answer(store, action_id, PATIENCE + Duration::from_secs(2)).await;
    let answer = answer.expect("a database").expect("asked just now");
    assert!(!answer.is_pending(), "the action is still pending: {answer:?}");
    answer
}
