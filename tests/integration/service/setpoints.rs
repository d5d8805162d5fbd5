//! Setpoints are sent until they are answered, one at a time and within limits, and abandoned with an alarm.

use std::time::Duration;

use rumqttc::QoS;
use vibrissa_core::robot::Params;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{ArrayFacts, ArrayType, RobotTopic, Setpoint, SetpointError, SetpointOutcome, SetpointReason};
use vibrissa_tests::observer::Observer;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::send;

use crate::running::{LEARNED, Running, quick};

const TIME_TO_LIVE_S: f64 = 5.0;
const SLEW_MPA_PER_S: f64 = 0.02;

fn params() -> Params {
    let mut params = quick();
    params.command.time_to_live = Micros::from_s(TIME_TO_LIVE_S);
    params
}

async fn start(array: ArrayFacts) -> (Running, HandRobot) {
    let running = Running::with(params(), None).await;
    let mut robot = HandRobot::born(running.port(), "r", array).await;
    for whisker in 0..robot.array.whiskers.len() as u16 {
        robot.touch(whisker, LEARNED + 20).await;
    }
    (running, robot)
}

/// A robot with a cut whisker, and the setpoint that follows.
async fn cut() -> (Running, HandRobot, Setpoint) {
    let (running, mut robot) = start(array(ArrayType::Type2, &[70.0])).await;
    robot.cut(0, 66.0);
    robot.touch(0, 80).await;
    let (setpoint, _) = robot.setpoint().await;
    (running, robot, setpoint)
}

/// Waits for some ticks of the supervisor: each round needs an answer from it.
async fn some_rounds(robot: &mut HandRobot) {
    for _ in 0..10 {
        robot.status().await;
        robot.touch(0, 1).await;
        robot.receipted().await;
    }
}

async fn states(running: &Running) -> Vec<String> {
    running.database.texts("SELECT state FROM setpoints ORDER BY epoch, version").await
}

async fn until_states(running: &Running, expected: &[&str]) {
    until_true(&format!("setpoints {expected:?}"), async || states(running).await == expected).await;
}

#[tokio::test]
async fn an_unanswered_setpoint_is_sent_again_under_its_name_with_the_next_number() {
    let (running, mut robot) = start(array(ArrayType::Type2, &[70.0])).await;
    robot.cut(0, 66.0);
    robot.touch(0, 80).await;
    let (first, _) = robot.setpoint().await;
    for again in 1..4 {
        let (setpoint, heard) = robot.setpoint().await;
        assert_eq!(setpoint, Setpoint { seq: first.seq + again, ..first.clone() });
        assert_eq!((heard.qos, heard.retained), (QoS::AtLeastOnce, false));
        let expiry_s = heard.expiry_s.expect("a message expiry");
        assert!((1..=15).contains(&expiry_s), "{expiry_s} s");
    }
    let mut late = Observer::subscribed(running.port(), "late", &["whisker/v1/f/r/#"]).await;
    // A retained message would arrive before the setpoint that is sent again.
    let retained = late.expect("a setpoint", |heard| {
        heard.payload.windows(10).any(|part| part == b"command_id").then_some(heard.retained)
    });
    assert!(!retained.await);
    robot.answer(&first, SetpointOutcome::Received, None).await;
    until_states(&running, &["RECEIVED"]).await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_setpoint_expires_by_the_robots_clock_also_if_that_was_never_set_and_a_new_one_follows() {
    let (running, mut robot) = start(array(ArrayType::Type2, &[70.0])).await;
    // A robot whose clock was never set and shows the year 2020.
    robot.restart();
    robot.clock_us = 1_600_000_000_000_000;
    robot.birth().await;
    robot.settle().await;
    let begun = std::time::Instant::now();
    robot.cut(0, 66.0);
    robot.touch(0, 80).await;
    // Its time passes: otherwise it is no time in microseconds.
    for _ in 0..3 {
        tokio::time::sleep(Duration::from_millis(200)).await;
        robot.clock_us = 1_600_000_001_000_000 + begun.elapsed().as_micros() as u64;
        robot.status().await;
    }
    let (first, _) = robot.setpoint().await;
    let left_s = (first.expires_us as f64 - robot.clock_us as f64) / 1e6;
    let slewing_s = (0.1 - first.pressure_mpa) / SLEW_MPA_PER_S;
    assert!((-2.0..2.0).contains(&(TIME_TO_LIVE_S + slewing_s - left_s)), "{left_s} s left");

    let expired = std::time::Instant::now();
    until_true("the expiry", async || {
        tokio::time::sleep(Duration::from_millis(150)).await;
        robot.clock_us = first.expires_us + 1 + expired.elapsed().as_micros() as u64;
        robot.status().await;
        states(&running).await.first().is_some_and(|state| state == "EXPIRED")
    })
    .await;
    let second = until("another setpoint", async || {
        Some(robot.setpoint().await.0).filter(|setpoint| setpoint.command_id != first.command_id)
    })
    .await;
    assert!(second.version > first.version && second.expires_us > robot.clock_us);
    robot.answer(&second, SetpointOutcome::Applied, None).await;
    until_states(&running, &["EXPIRED", "APPLIED"]).await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_setpoint_that_a_robot_is_not_ready_for_is_tried_three_times_and_then_given_up_with_an_alarm() {
    let (running, mut robot, mut setpoint) = cut().await;
    for _ in 0..2 {
        robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::NotReady)).await;
        let (next, _) = robot.setpoint().await;
        assert!(next.version > setpoint.version && next.command_id != setpoint.command_id);
        assert_eq!((next.pressure_mpa, next.epoch), (setpoint.pressure_mpa, setpoint.epoch));
        setpoint = next;
    }
    robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::NotReady)).await;
    until_true("the alarm", async || {
        running.metric("vibrissa_alarms_raised_total{fleet=\"f\",kind=\"SETPOINT_FAILED\"}").await == 1.0
    })
    .await;
    some_rounds(&mut robot).await;
    assert_eq!(robot.setpoints_left(), [&setpoint; 0]);
    assert_eq!(states(&running).await, ["REJECTED"; 3]);
    let alarms = running.database.texts("SELECT kind FROM alarms ORDER BY alarm_id").await;
    assert_eq!(alarms, ["SETPOINT_FAILED", "UNCOMPENSATED"], "no other whisker can compensate");
    let ended = running.database.texts("SELECT end_reason FROM compensations WHERE compensator_whisker_id IS NOT NULL");
    assert_eq!(ended.await, ["SETPOINT_FAILED"]);
    running.service.stop().await;
}

/// A robot in a task declines setpoints for as long as it works.
#[tokio::test]
async fn a_setpoint_waits_for_the_end_of_the_robots_task_without_an_alarm() {
    let running = Running::with(quick(), None).await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 20).await;
    robot.cut(0, 66.0);
    robot.touch(0, 80).await;
    let (mut setpoint, _) = robot.setpoint().await;
    // More often than a robot may be not ready.
    for _ in 0..4 {
        robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::InTask)).await;
        let waits = async || {
            let row = running.list("compensations").await.remove(0);
            row["setpoint_error"] == "IN_TASK" && row["ended_at"].is_null()
        };
        until_true("what it waits for", waits).await;
        let next = loop {
            let (next, _) = robot.setpoint().await;
            if next.command_id != setpoint.command_id {
                break next;
            }
        };
        assert_eq!((next.pressure_mpa, next.epoch), (setpoint.pressure_mpa, setpoint.epoch));
        setpoint = next;
    }
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    until_states(&running, &["REJECTED", "REJECTED", "REJECTED", "REJECTED", "APPLIED"]).await;
    let alarms = running.database.texts("SELECT kind FROM alarms ORDER BY alarm_id").await;
    assert!(!alarms.contains(&"SETPOINT_FAILED".to_owned()), "{alarms:?}");
    assert_eq!(running.metric("vibrissa_setpoints_total{fleet=\"f\",state=\"REJECTED\"}").await, 0.0);
    let declined = running.metric("vibrissa_setpoints_rejected_total{error=\"IN_TASK\",fleet=\"f\"}").await;
    assert_eq!(declined, 4.0);
    running.service.stop().await;
}

#[tokio::test]
async fn a_setpoint_that_is_stale_for_the_robot_is_not_insisted_on() {
    let (running, mut robot, setpoint) = cut().await;
    robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::Stale)).await;
    until_true("the alarm", async || {
        running.metric("vibrissa_alarms_raised_total{fleet=\"f\",kind=\"SETPOINT_FAILED\"}").await == 1.0
    })
    .await;
    some_rounds(&mut robot).await;
    assert_eq!(robot.setpoints_left(), [&setpoint; 0]);
    assert_eq!(states(&running).await, ["REJECTED"]);
    running.service.stop().await;
}

#[tokio::test]
async fn there_is_one_setpoint_at_a_time_for_a_whisker() {
    let (running, mut robot, setpoint) = cut().await;
    robot.answer(&setpoint, SetpointOutcome::Received, None).await;
    until_states(&running, &["RECEIVED"]).await;
    // A second cut while the first setpoint is pending.
    robot.cut(0, 63.0);
    robot.touch(0, 100).await;
    let (second, _) = robot.setpoint().await;
    assert!(second.version > setpoint.version && second.pressure_mpa < setpoint.pressure_mpa);
    until_states(&running, &["SUPERSEDED", "PENDING"]).await;
    // The end of the first setpoint no longer matters.
    robot.answer(&setpoint, SetpointOutcome::Superseded, None).await;
    robot.answer(&second, SetpointOutcome::Applied, None).await;
    until_states(&running, &["SUPERSEDED", "APPLIED"]).await;
    running.service.stop().await;
}

/// Pressures of the setpoints for an array in which the chamber of a neighbour is limited to this pressure.
async fn pressures_at_most(pressure_max_mpa: f64) -> Vec<f64> {
    let mut array = array(ArrayType::Type1, &[66.0, 70.0]);
    array.whiskers[1].pressure_max_mpa = pressure_max_mpa;
    let (running, mut robot) = start(array).await;
    // Too short to compensate itself; only its longer neighbour can compensate it, with more pressure.
    robot.cut(0, 50.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    until_true("a decision", async || running.database.number("SELECT count(*) FROM compensations").await == 1).await;
    let served = running.database.number("SELECT count(compensator_whisker_id) FROM compensations").await;
    let mut pressures = Vec::new();
    if served == 1 {
        let (setpoint, _) = robot.setpoint().await;
        assert_eq!(setpoint.reason, SetpointReason::LongerForShorter);
        pressures.push(setpoint.pressure_mpa);
    }
    some_rounds(&mut robot).await;
    pressures.extend(robot.setpoints_left().iter().map(|setpoint| setpoint.pressure_mpa));
    running.service.stop().await;
    pressures
}

#[tokio::test]
async fn no_pressure_is_above_the_factsheets_highest() {
    let free = pressures_at_most(0.2).await;
    assert!(free.iter().all(|&mpa| mpa > 0.11 && mpa <= 0.2) && !free.is_empty(), "{free:?}");
    let limited = pressures_at_most(0.105).await;
    assert!(limited.iter().all(|&mpa| mpa <= 0.105), "{limited:?}");
}

#[tokio::test]
async fn a_robot_that_restarts_is_sent_the_setpoint_of_a_compensation_in_force_again() {
    let (running, mut robot, setpoint) = cut().await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.status().await;
    robot.touch(0, 1).await;
    until_states(&running, &["APPLIED"]).await;
    robot.restart();
    robot.birth().await;
    robot.settle().await;
    let (again, _) = robot.setpoint().await;
    assert_eq!(again.robot_boot_id, robot.boot_id);
    assert!(again.version > setpoint.version && again.command_id != setpoint.command_id);
    assert_eq!((again.pressure_mpa, again.reason), (setpoint.pressure_mpa, setpoint.reason));
    robot.answer(&again, SetpointOutcome::Applied, None).await;
    until_states(&running, &["APPLIED", "APPLIED"]).await;
    assert_eq!(running.database.number("SELECT count(*) FROM compensations").await, 1, "expected one decision");
    running.service.stop().await;
}

#[tokio::test]
async fn a_setpoint_under_way_to_a_boot_that_is_no_more_is_abandoned_and_made_anew() {
    let (running, mut robot, setpoint) = cut().await;
    robot.restart();
    robot.birth().await;
    robot.settle().await;
    let again = until("a setpoint for the new boot", async || {
        Some(robot.setpoint().await.0).filter(|setpoint| setpoint.robot_boot_id == robot.boot_id)
    })
    .await;
    assert!(again.version > setpoint.version);
    until_states(&running, &["ABANDONED", "PENDING"]).await;
    // The robot has restarted and cannot apply a setpoint for its earlier boot.
    robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::WrongBoot)).await;
    robot.answer(&again, SetpointOutcome::Applied, None).await;
    until_states(&running, &["ABANDONED", "APPLIED"]).await;
    running.service.stop().await;
}

#[tokio::test]
async fn junk_about_a_setpoint_leaves_it_under_way() {
    let (running, mut robot, setpoint) = cut().await;
    robot.say(RobotTopic::SetpointState, "{}").await;
    let mut unknown = setpoint.clone();
    unknown.command_id = "somebody-elses".to_owned();
    robot.answer(&unknown, SetpointOutcome::Failed, Some(SetpointError::Leak)).await;
    robot.touch(0, 1).await;
    robot.receipted().await;
    assert_eq!(states(&running).await, ["PENDING"]);
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    until_states(&running, &["APPLIED"]).await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_failed_setpoint_is_tried_again_on_request() {
    let (running, mut robot, setpoint) = cut().await;
    let path = "/v1/fleets/f/robots/r/arrays/left/whiskers/0/retry";
    let retried = async || send(running.service.http, "POST", path, &[], None).await.unwrap();
    let early = retried().await;
    assert!(early.status == 409 && early.body.contains("failed"), "{early:?}");
    robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::Stale)).await;
    let standing = "SELECT kind FROM alarms WHERE kind = 'SETPOINT_FAILED' AND cleared_us IS NULL";
    until_true("the alarm", async || running.database.texts(standing).await.len() == 1).await;
    let done = retried().await;
    assert!(done.status == 200 && done.json()["state"] == "DONE", "{done:?}");
    // It decides anew with the next contacts.
    robot.touch(0, 20).await;
    let (again, _) = robot.setpoint().await;
    assert!((again.epoch, again.version) > (setpoint.epoch, setpoint.version), "{again:?}");
    robot.answer(&again, SetpointOutcome::Applied, None).await;
    until_true("no alarm", async || running.database.texts(standing).await.is_empty()).await;
    assert_eq!(retried().await.status, 409, "it has not failed any more");
    running.service.stop().await;
}
