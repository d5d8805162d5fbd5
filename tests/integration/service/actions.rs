//! Operator actions, from their rows in the database to the robot.

use vibrissa_protocol::{ArrayType, SetpointOutcome, SetpointReason};
use vibrissa_store::actions::{Action, Asked, NewAction};
use vibrissa_tests::actions::{answered, asks, asks_of};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::running::{LEARNED, Running, quick};

async fn ask(running: &Running, action: &NewAction) -> Action {
    answered(&running.service.store, &running.service.action_notifier, action).await
}

async fn done(running: &Running, action: &NewAction) {
    let answer = ask(running, action).await;
    assert_eq!((answer.state.as_str(), &answer.problem), ("DONE", &None), "{answer:?}");
    assert!(answer.done_us.is_some_and(|done_us| done_us >= answer.asked_us), "{answer:?}");
}

async fn refused(running: &Running, action: &NewAction) -> String {
    let answer = ask(running, action).await;
    assert_eq!(answer.state, "REFUSED", "{answer:?}");
    answer.problem.unwrap()
}

fn policy(expected_version: i64, mode: &str) -> NewAction {
    asks("POLICY", &format!(r#"{{"expected_version": {expected_version}, "mode": "{mode}"}}"#))
}

/// A robot with two whiskers whose baselines are learned.
async fn learned(running: &Running, name: &str) -> HandRobot {
    let mut robot = HandRobot::born(running.port(), name, array(ArrayType::Type1, &[70.0, 65.0])).await;
    for whisker in [0, 1] {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.receipted().await;
    robot
}

#[tokio::test]
async fn where_operators_approve_a_cut_is_served_once_somebody_has_approved() {
    let running = Running::start().await;
    let mut robot = learned(&running, "r").await;
    done(&running, &policy(0, "ADVISE")).await;
    let late = refused(&running, &policy(0, "AUTOMATIC")).await;
    assert!(late.starts_with("VERSION: version 1 is in force"), "{late}");
    robot.cut(0, 54.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    let database = &running.database;
    let standing = "SELECT kind FROM alarms WHERE cleared_us IS NULL";
    assert_eq!(database.texts(standing).await, ["PROPOSED"]);
    assert_eq!(database.texts("SELECT approval FROM compensations").await, ["PROPOSED"]);
    assert_eq!(database.number("SELECT count(*) FROM setpoints").await, 0);
    let id = database.number("SELECT compensation_id FROM compensations").await;
    let of = |kind, id| NewAction { compensation_id: Some(id), ..asks_of(kind, "{}", None) };
    let other = refused(&running, &of("APPROVE", id + 1)).await;
    assert!(other.starts_with("NOT_PROPOSED: "), "{other}");
    let elsewhere = refused(&running, &of("APPROVE", id + (1 << 32))).await;
    assert!(elsewhere.starts_with("NOT_PROPOSED: "), "{elsewhere}");
    assert!(robot.setpoints_left().is_empty());
    done(&running, &of("APPROVE", id)).await;
    let (setpoint, _) = robot.setpoint().await;
    assert_eq!((setpoint.whisker, setpoint.reason), (1, SetpointReason::ShorterForLonger));
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    assert_eq!(database.texts(standing).await, [""; 0]);
    assert_eq!(database.texts("SELECT approval FROM compensations").await, ["APPROVED"]);
    let in_force = running.service.store.policy("f").await.unwrap().unwrap();
    assert_eq!((in_force.version, in_force.mode.as_str(), in_force.changed_by.as_str()), (1, "ADVISE", "ann"));

    // The next owner of the fleet applies the same policy.
    let running = running.again(quick(), None).await;
    let still = refused(&running, &policy(0, "AUTOMATIC")).await;
    assert!(still.starts_with("VERSION: version 1 is in force"), "{still}");
    let mut robot = learned(&running, "another").await;
    robot.cut(0, 54.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    let waiting = "SELECT count(*) FROM compensations WHERE approval = 'PROPOSED' AND ended_us IS NULL";
    until_true("a proposal", async || running.database.number(waiting).await == 1).await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_manual_pressure_is_held_until_it_is_released() {
    let running = Running::start().await;
    let mut robot = learned(&running, "r").await;
    done(&running, &asks_of("SETPOINT", r#"{"pressure_mpa": 0.05}"#, Some(1))).await;
    let (setpoint, _) = robot.setpoint().await;
    assert_eq!((setpoint.whisker, setpoint.pressure_mpa, setpoint.reason), (1, 0.05, SetpointReason::Operator));
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    let database = &running.database;
    let held = "SELECT 'r ' || held FROM robots UNION ALL SELECT whisker || ' ' || held FROM whiskers";
    assert_eq!(database.texts(held).await, ["r 0", "0 0", "1 1"]);
    done(&running, &asks_of("HOLD", "{}", None)).await;
    assert_eq!(database.texts(held).await, ["r 1", "0 0", "1 1"]);
    let one = refused(&running, &asks_of("RELEASE", "{}", Some(1))).await;
    assert!(one.starts_with("ROBOT_HELD: "), "{one}");
    done(&running, &asks_of("RELEASE", "{}", None)).await;
    done(&running, &asks_of("RELEASE", "{}", Some(1))).await;
    let (release, _) = robot.setpoint().await;
    assert_eq!((release.whisker, release.pressure_mpa, release.reason), (1, 0.1, SetpointReason::Release));
    assert_eq!(database.texts(held).await, ["r 0", "0 0", "1 0"]);
    running.service.stop().await;
}

#[tokio::test]
async fn what_cannot_be_done_is_refused_with_a_word_and_a_text() {
    let running = Running::start().await;
    let mut robot = learned(&running, "r").await;
    let stranger = NewAction { robot: Some("stranger".to_owned()), ..asks_of("HOLD", "{}", None) };
    let cases = [
        (asks_of("HOLD", "{}", Some(7)), "UNKNOWN_WHISKER"),
        (asks_of("HOLD", "{}", Some(70_000)), "UNKNOWN_WHISKER"),
        (stranger, "UNKNOWN_ROBOT"),
        (asks_of("SETPOINT", r#"{"pressure_mpa": 0.3}"#, Some(1)), "PRESSURE_OUT_OF_RANGE"),
        (asks_of("SETPOINT", r#"{"pressure": 0.1}"#, Some(1)), "MALFORMED"),
        (asks_of("DANCE", "{}", Some(1)), "UNKNOWN_KIND"),
    ];
    for (action, word) in cases {
        let answer = ask(&running, &action).await;
        let (refusal, text) = answer.refusal().unwrap();
        assert_eq!((answer.state.as_str(), refusal), ("REFUSED", word), "{answer:?}");
        assert!(text.len() > 10, "{text}");
    }
    robot.connection(vibrissa_protocol::ConnectionState::Offline).await;
    let offline = "SELECT connection FROM robots";
    until_true("offline", async || running.database.texts(offline).await == ["OFFLINE"]).await;
    let late = refused(&running, &asks_of("SETPOINT", r#"{"pressure_mpa": 0.1}"#, Some(1))).await;
    assert!(late.starts_with("ROBOT_OFFLINE: "), "{late}");
    assert_eq!(running.database.number("SELECT count(*) FROM setpoints").await, 0);
    assert_eq!(running.metric(r#"vibrissa_actions_total{fleet="f",kind="SETPOINT",state="REFUSED"}"#).await, 3.0);
    running.service.stop().await;
}

#[tokio::test]
async fn what_is_too_late_is_not_done_and_what_is_asked_twice_is_done_once() {
    let running = Running::start().await;
    let _robot = learned(&running, "r").await;
    let hold = asks_of("HOLD", "{}", None);
    let answer = ask(&running, &NewAction { expires_us: hold.asked_us - 1, ..hold.clone() }).await;
    assert_eq!((answer.state.as_str(), answer.problem), ("EXPIRED", None));
    assert_eq!(running.database.number("SELECT held FROM robots").await, 0);

    let keyed = NewAction { idempotency_key: Some("k".to_owned()), ..hold.clone() };
    let first = ask(&running, &keyed).await;
    let store = &running.service.store;
    let again = NewAction { request_id: "q2".to_owned(), asked_us: hold.asked_us + 5, ..keyed.clone() };
    assert_eq!(store.ask(&again).await.unwrap(), Asked::Again(first.clone()));
    let other = NewAction { kind: "RELEASE".to_owned(), ..keyed.clone() };
    assert_eq!(store.ask(&other).await.unwrap(), Asked::Different(first));
    assert!(matches!(store.ask(&NewAction { actor: "ben".to_owned(), ..keyed }).await.unwrap(), Asked::New(_)));
    running.service.stop().await;
}

/// At any time the database has either both the answer and its effects or neither.
#[tokio::test]
async fn property_an_answer_and_its_effects_are_there_at_the_same_time() {
    let running = Running::start().await;
    let _robot = learned(&running, "r").await;
    let holds = "SELECT count(*) FROM actions WHERE state = 'DONE' AND kind = 'HOLD'";
    let both = "SELECT max(abs((SELECT held FROM robots) - (SELECT kind = 'HOLD' FROM actions WHERE state = 'DONE' \
                ORDER BY action_id DESC LIMIT 1))) FROM robots";
    for at in 0..20 {
        let action = asks_of(if at % 2 == 0 { "HOLD" } else { "RELEASE" }, "{}", None);
        let Asked::New(_) = running.service.store.ask(&action).await.unwrap() else { panic!("new") };
        running.service.action_notifier.notify(&vibrissa_protocol::Name::new("f").unwrap());
        for _ in 0..20 {
            if running.database.number("SELECT count(*) FROM actions WHERE state = 'DONE'").await > 0 {
                assert_eq!(running.database.number(both).await, 0, "after {at} actions");
            }
        }
    }
    until_true("all answered", async || {
        running.database.number("SELECT count(*) FROM actions WHERE state = 'PENDING'").await == 0
    })
    .await;
    assert_eq!(running.database.number(holds).await, 10);
    running.service.stop().await;
}
