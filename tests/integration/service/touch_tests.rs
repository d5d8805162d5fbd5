//! Rows of touch tests, from an operator's action to the robot's answers.

use vibrissa_core::policy::Mode;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{ArrayType, Contact, RobotTopic, TouchTestKind, TouchTestOutcome, encode};
use vibrissa_tests::actions::{answered, asks_of};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::running::{Running, quick};

const ROWS: &str = "SELECT state || ' ' || touches || ' ' || missed || ' ' || (ended_us IS NOT NULL) || ' ' || \
     (length_mm IS NOT NULL) FROM touch_tests ORDER BY touch_test_id";
const EVENTS: &str = "SELECT count(*) FROM events WHERE kind = 'TOUCH_TEST'";

/// A robot whose factsheet names a touch test.
async fn tester(port: u16) -> HandRobot {
    let mut robot = HandRobot::connect(port, "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch_tests = vec![TouchTestKind::Wall];
    robot.birth().await;
    robot.settle().await;
    robot
}

async fn ask_for_test(running: &Running) {
    let action = asks_of("TOUCH_TEST", "{}", Some(0));
    let answer = answered(&running.service.store, &running.service.action_notifier, &action).await;
    assert_eq!((answer.state.as_str(), &answer.problem), ("DONE", &None), "{answer:?}");
}

/// Waits for the row of the first test; another test may follow it.
async fn until_row(running: &Running, row: &str) {
    until_true(row, async || running.database.texts(ROWS).await.first().is_some_and(|first| first == row)).await;
}

#[tokio::test]
async fn touches_count_once_and_a_test_goes_on_under_the_next_supervisor() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = tester(broker.port()).await;
    ask_for_test(&running).await;
    let test = robot.touch_test().await;
    assert_eq!(running.database.texts("SELECT test_id FROM touch_tests").await, [test.test_id.as_str()]);
    assert_eq!(running.database.texts("SELECT test_id FROM actions").await, [test.test_id.as_str()]);
    robot.answer_test(&test, TouchTestOutcome::Running, None).await;
    let sent = robot.touch_on_request(&test, (3, 60.0), (1, 69.5)).await;
    // The same message again, as after a lost receipt.
    robot.say(RobotTopic::Contacts, encode(&sent)).await;
    robot.receipted().await;
    until_row(&running, "RUNNING 3 1 0 0").await;

    let running = running.again(quick(), Some(broker.port())).await;
    robot.touch_on_request(&test, (2, 60.0), (4, 69.5)).await;
    robot.receipted().await;
    until_row(&running, "RUNNING 5 5 0 0").await;
    robot.answer_test(&test, TouchTestOutcome::Done, None).await;
    until_row(&running, "DONE 5 5 1 1").await;
    assert!(running.metric("vibrissa_touch_tests_total{fleet=\"f\",state=\"DONE\"}").await >= 1.0);
    running.service.stop().await;
}

#[tokio::test]
async fn an_operator_refuses_a_proposed_test() {
    let mut params = quick();
    params.policy.mode = Mode::Advise;
    params.touch_tests.every = Micros::from_s(1.0);
    let running = Running::with(params, None).await;
    let mut robot = tester(running.port()).await;
    let refuse = asks_of("REFUSE_TOUCH_TEST", "{}", Some(0));
    let answer = answered(&running.service.store, &running.service.action_notifier, &refuse).await;
    assert_eq!(answer.state, "REFUSED");
    assert!(answer.problem.as_deref().is_some_and(|why| why.starts_with("NO_PROPOSED_TEST")), "{answer:?}");
    // A whisker whose contacts state distances is due by the schedule.
    let contact = robot.contact(0);
    robot.send(vec![Contact { ratio: None, distance_mm: Some(60.0), ..contact }]).await;
    until_row(&running, "PROPOSED 0 0 0 0").await;
    let answer = answered(&running.service.store, &running.service.action_notifier, &refuse).await;
    assert_eq!((answer.state.as_str(), &answer.problem), ("DONE", &None), "{answer:?}");
    until_row(&running, "REFUSED 0 0 1 0").await;
    running.service.stop().await;
}

#[tokio::test]
async fn touches_of_tests_that_nobody_requested_leave_no_row() {
    let running = Running::start().await;
    let mut robot = tester(running.port()).await;
    let mut contacts = Vec::new();
    for number in 0..100 {
        let contact = robot.contact(0);
        contacts.push(Contact { test_id: Some(format!("made-up-{number}")), ..contact });
    }
    robot.send(contacts).await;
    robot.receipted().await;
    assert_eq!(running.database.number(EVENTS).await, 0);
    assert_eq!(running.database.texts(ROWS).await, [""; 0]);
    running.service.stop().await;
}

#[tokio::test]
async fn a_test_of_a_boot_that_is_over_is_abandoned_and_requested_again() {
    let running = Running::start().await;
    let mut robot = tester(running.port()).await;
    ask_for_test(&running).await;
    let first = robot.touch_test().await;
    robot.answer_test(&first, TouchTestOutcome::Accepted, None).await;
    until_row(&running, "ACCEPTED 0 0 0 0").await;
    robot.restart();
    robot.birth().await;
    robot.settle().await;
    let second = robot.touch_test().await;
    assert_ne!(first.test_id, second.test_id);
    assert_eq!(second.robot_boot_id, robot.boot_id);
    let states = "SELECT state FROM touch_tests ORDER BY touch_test_id";
    until_true("both tests", async || running.database.texts(states).await == ["ABANDONED", "PENDING"]).await;
    running.service.stop().await;
}
