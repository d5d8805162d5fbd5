//! Brokers that forget retained messages, or refuse to retain any: the supervisor asks robots for their births.

use vibrissa_protocol::{ArrayType, Message, RobotTopic, SupervisorPresence, SupervisorRequest};
use vibrissa_simulator::{Broker, Fleet, Robot, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::Observer;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::running::{LEARNED, Running, quick};

/// Robot `one` is cut after it has learned.
const SCENARIO: &str = r#"
fleet = "f"
seed = 11
[behaviour]
contacts_per_second = 40.0
contacts_per_message = 10
message_after_s = 0.2
[[robots]]
robot = "one"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
events = [{ at_contact = 400, array = "left", whisker = 0, change = { kind = "TRIM", length_mm = 65.0 } }]
[[robots]]
robot = "two"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
"#;
const ROBOTS: [&str; 2] = ["one", "two"];
const STATE: &str = "whisker/v1/f/supervisor/state";
const REQUESTS: &str = "whisker/v1/f/supervisor/request";

fn start_fleet(broker: &Mosquitto) -> Fleet {
    Fleet::start(&Scenario::from_toml_str(SCENARIO).unwrap(), &Broker::new("127.0.0.1", broker.port())).unwrap()
}

/// Makes the broker forget every retained message. Returns once it has acknowledged that.
async fn forget(broker: &Mosquitto, observer: &str) {
    let observer = Observer::subscribed(broker.port(), observer, &[]).await;
    for robot in ROBOTS {
        for kind in [RobotTopic::Connection, RobotTopic::Factsheet, RobotTopic::Estimate] {
            observer.publish(&format!("whisker/v1/f/{robot}/{kind}"), Vec::new(), true).await;
        }
    }
    observer.publish(STATE, Vec::new(), true).await;
}

/// Waits until the factsheets of all robots have reached the broker.
async fn announced(observer: &mut Observer) {
    for _ in ROBOTS {
        observer.expect("a factsheet", |heard| matches!(heard.message, Message::Factsheet(_)).then_some(())).await;
    }
}

async fn next_request(observer: &mut Observer) -> SupervisorRequest {
    let request = |heard: vibrissa_tests::observer::Heard| match heard.message {
        Message::SupervisorRequest(request) => Some((request, heard.retained)),
        _ => None,
    };
    let (request, retained) = observer.expect("a request for births", request).await;
    assert!(!retained);
    request
}

async fn requested(running: &Running, cause: &str) -> f64 {
    running.metric(&format!("vibrissa_birth_requests_total{{cause=\"{cause}\",fleet=\"f\"}}")).await
}

/// Waits until the supervisor knows both robots in their present boots.
async fn all_are_known(running: &Running, fleet: &Fleet) {
    until_true("every robot known in its present boot", async || {
        let listed = running.list("robots").await;
        fleet.robots().iter().all(|robot| {
            let boot_id = robot.with(|robot| robot.boot_id().to_string());
            listed.iter().any(|one| one["robot"] == robot.name().as_str() && one["boot_id"] == boot_id)
        })
    })
    .await;
}

/// Stops the contacts, and checks that each one was recorded once.
async fn nothing_is_lost(running: &Running, fleet: &Fleet) {
    fleet.rest();
    until_true("every message receipted", async || fleet.is_receipted()).await;
    let made = fleet.contacts_made() as i64;
    assert_eq!(running.database.counted().await, (made, made));
}

async fn a_setpoint_is_applied(running: &Running) {
    until_true("a setpoint applied", async || {
        running.list("setpoints").await.iter().any(|one| one["robot"] == "one" && one["state"] == "APPLIED")
    })
    .await;
}

#[tokio::test]
async fn a_supervisor_knows_its_robots_although_the_broker_has_forgotten_them() {
    let broker = Mosquitto::start();
    let mut observer = Observer::subscribed(broker.port(), "o", &["whisker/v1/f/+/factsheet"]).await;
    let fleet = start_fleet(&broker);
    announced(&mut observer).await;
    // The observer does not accept the empty messages that delete retained ones.
    drop(observer);
    forget(&broker, "forget-1").await;
    let running = Running::with(quick(), Some(broker.port())).await;
    all_are_known(&running, &fleet).await;
    assert_eq!(requested(&running, "CONNECTED").await, 1.0);

    // The next owner finds the robots in new boots that it has not heard of.
    let folder = running.stop().await;
    for robot in fleet.robots() {
        let before = robot.with(|robot| robot.boot_id().clone());
        robot.with(Robot::restart_soon);
        until_true("a new boot", async || robot.with(|robot| *robot.boot_id() != before && robot.is_connected())).await;
    }
    forget(&broker, "forget-2").await;
    let running = Running::on(folder, quick(), Some(broker.port())).await;
    all_are_known(&running, &fleet).await;
    a_setpoint_is_applied(&running).await;
    fleet.stop().await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_broker_that_is_killed_between_two_owners_costs_nothing_but_seconds() {
    let mut broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let fleet = start_fleet(&broker);
    all_are_known(&running, &fleet).await;
    let folder = running.stop().await;
    broker.kill();
    broker.restart();
    let running = Running::on(folder, quick(), Some(broker.port())).await;
    forget(&broker, "forget").await;
    all_are_known(&running, &fleet).await;
    a_setpoint_is_applied(&running).await;
    nothing_is_lost(&running, &fleet).await;
    fleet.stop().await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_broker_that_retains_nothing_is_enough_for_contacts_setpoints_estimates_and_a_takeover() {
    let broker = Mosquitto::builder().line("retain_available false").start();
    let fleet = start_fleet(&broker);
    until_true("connected robots", async || fleet.robots().iter().all(|one| one.with(|robot| robot.is_connected())))
        .await;
    let running = Running::with(quick(), Some(broker.port())).await;
    all_are_known(&running, &fleet).await;
    let mut observer = Observer::subscribed(broker.port(), "o", &[STATE, "whisker/v1/f/+/estimate"]).await;
    let states = async |observer: &mut Observer| {
        let state = |heard: vibrissa_tests::observer::Heard| match heard.message {
            Message::SupervisorState(state) => Some((state.state, state.epoch, heard.retained)),
            _ => None,
        };
        observer.expect("the supervisor's state", state).await
    };
    let (presence, first, retained) = states(&mut observer).await;
    assert_eq!((presence, retained), (SupervisorPresence::Online, false), "repeated for those who came later");

    let folder = running.stop().await;
    let running = Running::on(folder, quick(), Some(broker.port())).await;
    all_are_known(&running, &fleet).await;
    // Both robots receive their lengths after the takeover, although nothing is retained.
    let mut payloads = std::collections::BTreeSet::new();
    while payloads.len() < ROBOTS.len() {
        let estimate = |heard: vibrissa_tests::observer::Heard| match heard.message {
            Message::Estimate(estimate) if estimate.epoch > first => Some((estimate.whiskers.len(), heard.payload)),
            _ => None,
        };
        let (whiskers, payload) = observer.expect("an estimate of the new owner", estimate).await;
        assert_eq!(whiskers, 2);
        payloads.insert(payload);
    }
    a_setpoint_is_applied(&running).await;
    nothing_is_lost(&running, &fleet).await;
    // Two robots and two owners: each learns from its first connection that the broker retains no last will.
    assert_eq!(broker.logged("retain not supported"), 4);
    fleet.stop().await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_silent_robot_of_the_database_is_asked_once_more_and_no_further() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED).await;
    robot.receipted().await;
    for kind in [RobotTopic::Connection, RobotTopic::Factsheet] {
        robot.mqtt.publish(&robot.topic(kind), Vec::new(), true).await;
    }
    let folder = running.stop().await;
    let mut observer = Observer::subscribed(broker.port(), "o", &[REQUESTS]).await;
    let running = Running::on(folder, quick(), Some(broker.port())).await;
    let (first, second) = (next_request(&mut observer).await, next_request(&mut observer).await);
    assert_eq!((first.seq, second.seq, &first.boot_id, first.epoch), (0, 1, &second.boot_id, second.epoch));
    until_true("it is counted", async || requested(&running, "UNHEARD").await == 1.0).await;
    // It still works in its old boot, and nothing is missed any more.
    robot.touch(0, 5).await;
    robot.receipted().await;

    // Another boot, whose birth is lost: its contacts make the supervisor ask again.
    robot.restart();
    let contact = robot.contact(0);
    let early = robot.send(vec![contact]).await;
    next_request(&mut observer).await;
    until_true("it is counted", async || requested(&running, "UNANNOUNCED").await == 1.0).await;
    robot.birth().await;
    robot.say(RobotTopic::Contacts, vibrissa_protocol::encode(&early)).await;
    robot.receipted().await;
    assert_eq!(requested(&running, "UNHEARD").await, 1.0);
    assert_eq!(requested(&running, "CONNECTED").await, 1.0);
    running.service.stop().await;
}

#[tokio::test]
async fn robots_that_do_not_know_the_request_are_known_from_a_broker_that_retains() {
    let broker = Mosquitto::start();
    let mut robot = HandRobot::connect(broker.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.birth().await;
    let running = Running::with(quick(), Some(broker.port())).await;
    robot.settle().await;
    robot.touch(0, 20).await;
    robot.receipted().await;
    assert_eq!(running.database.counted().await, (20, 20));
    running.service.stop().await;
}
