//! Estimates of the whiskers' present lengths: told to the robot, retained for those that come later, and ordered.

use std::time::Duration;

use rumqttc::QoS;
use vibrissa_protocol::{ArrayType, Estimate, Message, RobotTopic, SetpointOutcome, WhiskerCondition, WhiskerEstimate};
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::{Heard, Observer};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::running::{LEARNED, Running, quick};

const TOPIC: &str = "whisker/v1/f/r/estimate";
/// Longest time within which an estimate follows a change: the interval of estimates, a round of ticks and a commit.
const SOON: Duration = Duration::from_secs(3);

fn estimate(heard: &Heard) -> Option<Estimate> {
    match &heard.message {
        Message::Estimate(estimate) => Some(estimate.clone()),
        _ => None,
    }
}

/// The robot's next estimate whose first whisker fulfils a condition, and its order.
async fn until_estimate(
    robot: &mut HandRobot,
    what: &str,
    fits: impl Fn(&WhiskerEstimate) -> bool,
) -> (Estimate, (u64, u64)) {
    let fitting = |heard: &Heard| estimate(heard).filter(|estimate| fits(&estimate.whiskers[0]));
    let estimate = robot.hear(what, fitting).await;
    let order = (estimate.epoch, estimate.version);
    (estimate, order)
}

/// What a client that subscribes now gets from the broker.
async fn retained(port: u16) -> Estimate {
    let mut late = Observer::subscribed(port, "late", &[TOPIC]).await;
    let first = |heard: Heard| Some((estimate(&heard)?, heard.retained, heard.qos, heard.expiry_s));
    let (estimate, is_retained, qos, expiry_s) = late.expect("a retained estimate", first).await;
    assert_eq!((is_retained, qos, expiry_s), (true, QoS::AtLeastOnce, None));
    estimate
}

fn contains(one: &WhiskerEstimate, length_mm: f64) -> bool {
    (one.length_low_mm..=one.length_high_mm).contains(&length_mm)
}

#[tokio::test]
async fn a_cut_and_its_compensation_change_the_estimate_that_the_broker_retains() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0, 65.0])).await;
    let (first, born) = until_estimate(&mut robot, "the first estimate", |_| true).await;
    let lengths: Vec<(u16, f64)> = first.whiskers.iter().map(|one| (one.whisker, one.length_mm)).collect();
    assert_eq!(lengths, [(0, 70.0), (1, 65.0)]);
    assert!(first.whiskers.iter().all(|one| one.condition == WhiskerCondition::Learning && one.gain.is_empty()));

    for whisker in 0..2 {
        robot.touch(whisker, LEARNED + 40).await;
    }
    let healthy = |one: &WhiskerEstimate| one.condition == WhiskerCondition::Healthy;
    let (_, learned) = until_estimate(&mut robot, "a healthy whisker", healthy).await;
    robot.cut(0, 62.0);
    robot.touch(0, 80).await;
    let (setpoint, _) = robot.setpoint().await;
    let (cut, shorter) =
        until_estimate(&mut robot, "a trimmed whisker", |one| one.condition == WhiskerCondition::Trimmed).await;
    assert!(contains(&cut.whiskers[0], 62.0) && (cut.whiskers[0].length_mm - 62.0).abs() < 1.0, "{cut:?}");
    assert_eq!((cut.whiskers[0].pressure_mpa, cut.whiskers[0].gain.len()), (0.1, 0), "nothing is applied yet");
    assert!((cut.whiskers[1].length_mm - 65.0).abs() < 0.5, "{cut:?}");

    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    let (compensated, newest) =
        until_estimate(&mut robot, "the compensation", |one| (one.pressure_mpa - setpoint.pressure_mpa).abs() < 1e-5)
            .await;
    let estimated_gain = &compensated.whiskers[0].gain;
    assert_eq!(estimated_gain.len(), setpoint.gain.len());
    let same = |((ratio, factor), (asked_ratio, asked)): (&(f64, f64), &(f64, f64))| {
        ratio == asked_ratio && (factor - asked).abs() < 1e-4
    };
    assert!(!estimated_gain.is_empty() && estimated_gain.iter().zip(&setpoint.gain).all(same), "{estimated_gain:?}");
    assert!(born < learned && learned < shorter && shorter < newest, "{born:?} {learned:?} {shorter:?} {newest:?}");
    assert_eq!(retained(broker.port()).await, compensated);
    running.service.stop().await;
}

/// The broker forgets retained messages; a restart of the supervisor begins a new epoch.
#[tokio::test]
async fn each_birth_and_each_supervisor_brings_an_estimate_that_is_newer_and_as_good() {
    let mut broker = Mosquitto::start();
    let mut running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 40).await;
    robot.cut(0, 62.0);
    robot.touch(0, 80).await;
    let trimmed = |one: &WhiskerEstimate| one.condition == WhiskerCondition::Trimmed && contains(one, 62.0);
    let (_, before) = until_estimate(&mut robot, "a trimmed whisker", trimmed).await;

    // The same boot is born again: nothing has changed.
    robot.birth().await;
    let (_, born) = until_estimate(&mut robot, "the estimate after a birth", trimmed).await;
    assert!(born > before && born.0 == before.0, "{born:?} {before:?}");

    broker.kill();
    broker.restart();
    // Without any message of the robot.
    let again = retained_after(&broker).await;
    assert!(trimmed(&again.whiskers[0]) && (again.epoch, again.version) > born, "{again:?}");

    running = running.again(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::connect(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let next = |heard: &Heard| estimate(heard).filter(|estimate| estimate.epoch > before.0);
    let next = robot.hear("the next supervisor's estimate", next).await;
    assert!(trimmed(&next.whiskers[0]), "{next:?}");
    running.service.stop().await;
}

/// The estimate that arrives at a broker without one.
async fn retained_after(broker: &Mosquitto) -> Estimate {
    let mut observer = Observer::subscribed(broker.port(), "observer", &[TOPIC]).await;
    observer.expect("an estimate after the broker's restart", |heard| estimate(&heard)).await
}

/// A length that changes with each contact must not flood the robot, and a whisker that stays must not be told again.
#[tokio::test]
async fn estimates_have_a_limited_rate_and_stop_when_nothing_changes() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut observer = Observer::subscribed(broker.port(), "observer", &[TOPIC]).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let begun = std::time::Instant::now();
    for part in 0..24 {
        robot.cut(0, 70.0 - 0.25 * f64::from(part));
        robot.touch(0, 20).await;
        robot.receipted().await;
    }
    let seconds = begun.elapsed().as_secs_f64();
    let mut count = 0;
    while let Some(heard) = observer.next(SOON).await {
        assert!(estimate(&heard).is_some());
        count += 1;
    }
    assert!(count >= 3 && f64::from(count) <= seconds + SOON.as_secs_f64() + 2.0, "{count} in {seconds} s");
    for _ in 0..5 {
        robot.status().await;
        assert!(observer.next(Duration::from_millis(700)).await.is_none(), "nothing has changed");
    }
    running.service.stop().await;
}

/// The simulated robot that feels cuts at its tip learns its present length from the supervisor.
#[tokio::test]
async fn a_simulated_robot_learns_its_present_length() {
    const SCENARIO: &str = r#"
fleet = "f"
seed = 3
[behaviour]
contacts_per_second = 100.0
contacts_per_message = 20
message_after_s = 0.2
places = "TIP"
[[robots]]
robot = "r"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
[[robots.events]]
at_contact = 300
array = "left"
whisker = 1
change = { kind = "TRIM", length_mm = 63.0 }
"#;
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let scenario = Scenario::from_toml_str(SCENARIO).unwrap();
    let fleet = Fleet::start(&scenario, &Broker::new("127.0.0.1", broker.port())).unwrap();
    let robot = &fleet.robots()[0];
    let lengths_mm = || robot.with(|robot| [0, 1].map(|at: usize| robot.whiskers()[at].estimated_length_mm()));
    until_true("lengths of both whiskers", async || lengths_mm().iter().all(Option::is_some)).await;
    until_true("the length after the cut", async || {
        matches!(lengths_mm(), [Some(whole), Some(cut)] if (whole - 70.0).abs() < 1.0 && (cut - 63.0).abs() < 1.0)
    })
    .await;
    fleet.stop().await;
    running.service.stop().await;
}

/// A robot that divides by the estimated length sends distances until it knows one.
#[tokio::test]
async fn a_simulated_robot_sends_distances_before_the_first_estimate_and_ratios_after_it() {
    const SCENARIO: &str = r#"
fleet = "f"
seed = 3
[behaviour]
contacts_per_second = 20.0
message_after_s = 0.2
places = "ESTIMATED_RATIO"
[[robots]]
robot = "r"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }] }]
"#;
    let broker = Mosquitto::start();
    let contacts = format!("whisker/v1/f/r/{}", RobotTopic::Contacts);
    let mut observer = Observer::subscribed(broker.port(), "observer", &[&contacts]).await;
    let scenario = Scenario::from_toml_str(SCENARIO).unwrap();
    let fleet = Fleet::start(&scenario, &Broker::new("127.0.0.1", broker.port())).unwrap();
    let has_ratio = |heard: Heard| match heard.message {
        Message::Contacts(message) => Some(message.contacts.iter().any(|contact| contact.ratio.is_some())),
        _ => None,
    };
    for _ in 0..3 {
        assert!(!observer.expect("contacts", has_ratio).await, "a ratio without any estimate");
    }
    let running = Running::with(quick(), Some(broker.port())).await;
    observer.expect("a ratio", |heard| has_ratio(heard).filter(|&has_ratio| has_ratio)).await;
    fleet.stop().await;
    running.service.stop().await;
}
