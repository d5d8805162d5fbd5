//! Metrics for Prometheus.

use std::collections::BTreeSet;
use std::sync::Arc;

use tokio::task::JoinSet;
use vibrissa_protocol::{
    ArrayType, Connection, ConnectionState, Contacts, RobotTopic, SetpointOutcome, Timestamp, encode,
};
use vibrissa_tests::observer::Observer;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};

use crate::running::{LEARNED, Running, quick};
use crate::web::{self, Metrics};

/// Number of robots with invented names.
const INVENTED: usize = 100_000;
/// One in this many of them also sends its birth.
const BORN_EVERY: usize = 100;
const SENDERS: usize = 50;
/// Number of robots that send before the test waits for the service, whose broker keeps a limited number of messages.
const ROUND: usize = 5_000;

fn names(metrics: &Metrics) -> BTreeSet<String> {
    metrics.names().map(ToOwned::to_owned).collect()
}

/// Number of contacts messages received, with any outcome.
fn came(metrics: &Metrics) -> f64 {
    let shed = metrics.get("vibrissa_messages_shed_total{fleet=\"f\"}");
    shed + metrics.get("vibrissa_messages_received_total{fleet=\"f\",topic=\"contacts\"}")
}

async fn invent(broker: Arc<Observer>, numbers: impl Iterator<Item = usize>) {
    for number in numbers {
        let boot_id = vibrissa_protocol::BootId::new("b").unwrap();
        let contacts = Contacts { boot_id: boot_id.clone(), seq: 0, contacts: Vec::new(), missed: Vec::new() };
        let topic = |kind: RobotTopic| format!("whisker/v1/f/invented-{number}/{kind}");
        if number % BORN_EVERY == 0 {
            let birth = Connection { boot_id, seq: 0, timestamp: Timestamp(0), state: ConnectionState::Online };
            broker.publish(&topic(RobotTopic::Connection), encode(&birth), false).await;
            broker.publish(&format!("whisker/v1/f/invented-{number}/made_up_{number}"), b"{}".to_vec(), false).await;
        }
        broker.publish(&topic(RobotTopic::Contacts), encode(&contacts), false).await;
    }
}

#[tokio::test]
async fn a_hundred_thousand_invented_robots_make_no_series() {
    let running = Running::start().await;
    let http = running.service.http;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0, 70.0])).await;
    robot.touch(0, 10).await;
    robot.receipted().await;
    // A route has a metric after its first request.
    web::get(http, "/v1/robots").await;
    web::get(http, "/metrics").await;
    web::get(http, "/no/such/path").await;
    let before = running.metrics().await;
    let broker = Arc::new(Observer::subscribed(running.port(), "crowd", &["whisker/v1/f/nobody/receipt"]).await);
    for first in (0..INVENTED).step_by(ROUND) {
        let mut senders = JoinSet::new();
        for sender in 0..SENDERS {
            senders.spawn(invent(broker.clone(), (first + sender..first + ROUND).step_by(SENDERS)));
        }
        senders.join_all().await;
        let expected = came(&before) + (first + ROUND) as f64;
        until_true("the round has come", async || came(&running.metrics().await) >= expected).await;
    }
    for number in 0..100 {
        web::get(http, &format!("/no/such/path/{number}")).await;
    }
    let after = running.metrics().await;
    assert!(after.get("vibrissa_messages_refused_total{fleet=\"f\",reason=\"unknown_robot\"}") > 1000.0);
    assert_eq!(names(&after), names(&before));
    running.service.stop().await;
}

const ERROR: &str = "vibrissa_compensation_error_mean_ratio{case=\"SELF_COMPENSATION\",fleet=\"f\"}";

#[tokio::test]
async fn a_compensation_is_told_from_the_contact_to_the_error_and_also_after_a_restart() {
    let running = Running::start().await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0, 70.0])).await;
    robot.touch(0, LEARNED + 40).await;
    robot.touch(1, LEARNED + 40).await;
    robot.cut(0, 65.0);
    let setpoint = until_setpoint(&mut robot).await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    let count = |metrics: &Metrics, name: &str| {
        metrics.get(&format!("vibrissa_setpoint_{name}_seconds_count{{fleet=\"f\",reason=\"SELF_COMPENSATION\"}}"))
    };
    let sum = |metrics: &Metrics, name: &str| {
        metrics.get(&format!("vibrissa_setpoint_{name}_seconds_sum{{fleet=\"f\",reason=\"SELF_COMPENSATION\"}}"))
    };
    let metrics = until("the setpoint's times", async || {
        Some(running.metrics().await).filter(|metrics| count(metrics, "application") == 1.0)
    })
    .await;
    assert_eq!(count(&metrics, "publication"), 1.0);
    assert!(sum(&metrics, "publication") > 0.0 && sum(&metrics, "publication") <= sum(&metrics, "application"));
    assert_eq!(metrics.get("vibrissa_trims_total{fleet=\"f\"}"), 1.0);
    assert_eq!(
        metrics.get("vibrissa_compensations_total{case=\"SELF_COMPENSATION\",fleet=\"f\",outcome=\"STARTED\"}"),
        1.0
    );
    robot.settle().await;
    // Fewer contacts than a refinement needs, after which the measurement of the error would restart.
    robot.touch(0, 150).await;
    robot.receipted().await;
    let error = until("the error", async || {
        let error = running.metric(ERROR).await;
        (error > 0.0).then_some(error)
    })
    .await;
    let newest = &running.list("compensations").await[0];
    assert!((newest["measured_error"].as_f64().unwrap() - error).abs() < 1e-9, "{error} {newest}");
    assert_eq!(running.metric("vibrissa_compensations_in_force{case=\"SELF_COMPENSATION\",fleet=\"f\"}").await, 1.0);
    let running = running.again(quick(), None).await;
    let again =
        until("the error once more", async || Some(running.metric(ERROR).await).filter(|&again| again > 0.0)).await;
    // It counts the contacts since the last measurement, too: half as many as those before it.
    assert!((again - error).abs() < 0.06, "{again} {error}");
    running.service.stop().await;
}

/// Sends contacts of the cut whisker until a setpoint arrives.
async fn until_setpoint(robot: &mut HandRobot) -> vibrissa_protocol::Setpoint {
    for _ in 0..30 {
        robot.touch(0, 10).await;
        robot.touch(1, 10).await;
        robot.receipted().await;
        if let Some(setpoint) = robot.setpoints_left().first() {
            return (*setpoint).clone();
        }
    }
    robot.setpoint().await.0
}
