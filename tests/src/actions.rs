//! Actions as operators ask for them.

use std::time::Duration;

use vibrissa_protocol::Name;
use vibrissa_simulator::fleet::now_us;
use vibrissa_store::Store;
use vibrissa_store::actions::{Action, Asked, NewAction};
use vibrissa_supervisor::mailroom::Mailroom;

use crate::wait::PATIENCE;

/// An action of the fleet `f`, about nothing in particular yet.
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

/// The same about robot `r`, and a whisker of its array `left` if there is one.
#[must_use]
pub fn asks_of(kind: &str, parameters: &str, whisker: Option<i64>) -> NewAction {
    let array = whisker.map(|_| crate::robot::ARRAY.to_owned());
    NewAction { robot: Some("r".to_owned()), array, whisker, ..asks(kind, parameters) }
}

/// Asks, and gives what became of it.
///
/// # Panics
/// It was asked before, or nobody answers.
pub async fn answered(store: &Store, mailroom: &Mailroom, action: &NewAction) -> Action {
    let Asked::New(action_id) = store.ask(action).await.expect("a database") else { panic!("{action:?} is not new") };
    if let Some(fleet) = &action.fleet {
        mailroom.ring(&Name::new(fleet).expect("a name"));
    }
    let answer = mailroom.answer(store, action_id, PATIENCE + Duration::from_secs(2)).await;
    let answer = answer.expect("a database").expect("asked just now");
    assert!(!answer.is_pending(), "nobody has answered {answer:?}");
    answer
}
