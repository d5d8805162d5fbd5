//! Facts for the maintenance of whiskers: published on request of the setting, for other tools.

use std::time::Duration;

use serde_json::Value;
use vibrissa_protocol::{
    ArrayType, ConnectionState, Maintenance, Message, TouchTestKind, TouchTestOutcome, WhiskerCondition,
    WhiskerMaintenance,
};
use vibrissa_tests::actions::{answered, asks_of};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::{Heard, Observer};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::send;

use crate::running::{LEARNED, Running, quick};

const TOPIC: &str = "whisker/v1/f/r/maintenance";
const EVERY: Duration = Duration::from_secs(1);

/// The facts of a message, which fits its schema.
fn facts(heard: &Heard) -> Option<Maintenance> {
    let Message::Maintenance(facts) = &heard.message else { return None };
    let schema = include_str!("../../../docs/schemas/maintenance.json");
    let validator = jsonschema::validator_for(&serde_json::from_str::<Value>(schema).unwrap()).unwrap();
    validator.validate(&serde_json::from_slice(&heard.payload).unwrap()).unwrap();
    Some(facts.clone())
}

/// The next facts about the first whisker that fulfil a condition.
async fn until_facts(tool: &mut Observer, what: &str, fits: impl Fn(&WhiskerMaintenance) -> bool) -> Maintenance {
    tool.expect(what, |heard| facts(&heard).filter(|facts| fits(&facts.whiskers[0]))).await
}

fn is_between(one: &WhiskerMaintenance, wear_mm: f64) -> bool {
    one.wear_low_mm.zip(one.wear_high_mm).is_some_and(|(low, high)| (low..=high).contains(&wear_mm))
}

async fn tested(running: &Running, robot: &mut HandRobot) {
    let action = asks_of("TOUCH_TEST", "{}", Some(0));
    let answer = answered(&running.service.store, &running.service.action_notifier, &action).await;
    assert_eq!((answer.state.as_str(), &answer.problem), ("DONE", &None), "{answer:?}");
    let test = robot.touch_test().await;
    robot.answer_test(&test, TouchTestOutcome::Running, None).await;
    robot.touch_on_request(&test, (usize::from(test.contacts), 60.0), (0, 60.0)).await;
    robot.receipted().await;
    robot.answer_test(&test, TouchTestOutcome::Done, None).await;
}

#[tokio::test]
async fn wear_and_the_last_test_are_told_to_tools_until_the_robot_leaves() {
    let broker = Mosquitto::start();
    let running = Running::maintained(EVERY, broker.port()).await;
    let mut tool = Observer::subscribed(broker.port(), "tool", &["whisker/v1/f/+/maintenance"]).await;
    let mut robot = HandRobot::connect(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch_tests = vec![TouchTestKind::Wall];
    robot.birth().await;
    let new = until_facts(&mut tool, "the first facts", |_| true).await;
    let unknown = WhiskerMaintenance {
        array: new.whiskers[0].array.clone(),
        whisker: 0,
        condition: WhiskerCondition::Learning,
        factory_length_mm: 70.0,
        wear_mm: None,
        wear_low_mm: None,
        wear_high_mm: None,
        last_calibration: None,
        contacts_left: None,
        contacts_left_low: None,
        contacts_left_high: None,
    };
    assert_eq!(new.whiskers, [unknown], "nothing has shown the length yet");

    robot.settle().await;
    tested(&running, &mut robot).await;
    let after_test = until_facts(&mut tool, "the test", |one| one.last_calibration.is_some()).await;
    let tested_at = after_test.whiskers[0].last_calibration;
    robot.touch(0, LEARNED + 40).await;
    let healthy = |one: &WhiskerMaintenance| one.condition == WhiskerCondition::Healthy;
    let whole = until_facts(&mut tool, "a whole whisker", healthy).await;
    assert!(is_between(&whole.whiskers[0], 0.0) && whole.whiskers[0].contacts_left.is_none(), "{whole:?}");
    robot.cut(0, 62.0);
    robot.touch(0, 80).await;
    let is_cut = |one: &WhiskerMaintenance| one.condition == WhiskerCondition::Trimmed && is_between(one, 8.0);
    let cut = until_facts(&mut tool, "the cut", is_cut).await;
    assert_eq!(cut.whiskers[0].last_calibration, tested_at);
    assert!(new.seq < after_test.seq && after_test.seq < whole.seq && whole.seq < cut.seq);

    // The next supervisor has the same facts, and its message is retained.
    let running = running.maintained_again(EVERY, broker.port()).await;
    let mut late = Observer::subscribed(broker.port(), "late", &[TOPIC]).await;
    let next = late.expect("the next epoch's", |heard| facts(&heard).filter(|facts| facts.epoch > cut.epoch)).await;
    assert!(is_cut(&next.whiskers[0]), "{next:?}");
    assert_eq!(next.whiskers[0].last_calibration, tested_at);
    let mut later = Observer::subscribed(broker.port(), "later", &[TOPIC]).await;
    let is_retained = later.expect("a retained message", |heard| facts(&heard).map(|_| heard.retained)).await;
    assert!(is_retained);

    robot.connection(ConnectionState::ConnectionBroken).await;
    let body = serde_json::json!({ "reason": "scrapped" });
    until_true("the robot to leave", async || {
        send(running.service.http, "DELETE", "/v1/fleets/f/robots/r", &[], Some(&body)).await.unwrap().status == 200
    })
    .await;
    until_true("nothing retained", async || {
        let mut new = Observer::subscribed(broker.port(), "new", &[TOPIC]).await;
        new.next(Duration::from_millis(500)).await.is_none()
    })
    .await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_whisker_that_erodes_has_a_number_of_contacts_left() {
    let broker = Mosquitto::start();
    let running = Running::maintained(EVERY, broker.port()).await;
    let mut tool = Observer::subscribed(broker.port(), "tool", &[TOPIC]).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 40).await;
    for part in 0..100 {
        robot.cut(0, 70.0 - 0.1 * f64::from(part));
        robot.touch(0, 10).await;
        robot.receipted().await;
    }
    let wears = |one: &WhiskerMaintenance| one.contacts_left.is_some();
    let worn = until_facts(&mut tool, "remaining contacts", wears).await;
    let one = &worn.whiskers[0];
    assert_eq!(one.condition, WhiskerCondition::Eroding);
    assert!(one.contacts_left_low <= one.contacts_left, "{one:?}");
    running.service.stop().await;
}

/// A robot and tools of today get nothing new.
#[tokio::test]
async fn without_the_setting_there_are_no_such_messages() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut tool = Observer::subscribed(broker.port(), "tool", &["whisker/v1/f/r/#"]).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 40).await;
    let mut others = 0;
    tool.expect("the estimate of a healthy whisker", |heard| {
        others += usize::from(facts(&heard).is_some());
        let Message::Estimate(estimate) = heard.message else { return None };
        (estimate.whiskers[0].condition == WhiskerCondition::Healthy).then_some(())
    })
    .await;
    assert_eq!(others, 0);
    running.service.stop().await;
}
