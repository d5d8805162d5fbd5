//! Tests of `check-robot`: the simulator passes, and a robot that breaks one rule fails exactly that rule.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks what it waits for"
)]

mod embedded;
mod faults;
mod helper;
mod manners;
mod program;

use std::time::Duration;

use vibrissa_lab::check::{CheckOptions, Help, Timings};
use vibrissa_protocol::{
    BootId, Name, RobotTopic, Setpoint, SetpointReason, SupervisorPresence, SupervisorState, Timestamp, Topic, encode,
};
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_simulator::{Broker, Fleet, RobotHandle, Scenario};
use vibrissa_supervisor::mqtt::{BrokerAddress, Connection, prepare};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::observer::Observer;
use vibrissa_tests::wait;

const FLEET: &str = "f";
/// Epoch of the last supervisor.
const EPOCH: u64 = 6;
/// Contacts of each whisker per second.
const CONTACTS_PER_S: f64 = 4.0;

/// Timings for simulated robots, which answer at once.
fn timings() -> Timings {
    let ms = Duration::from_millis;
    Timings {
        retained: ms(400),
        supervisor: ms(400),
        answer: ms(1500),
        grace: ms(400),
        status: (ms(1000), ms(3000)),
        clock: ms(2000),
        apply: ms(10_000),
        slew: ms(2000),
        contacts: ms(5000),
        resend: ms(8000),
        backoff: ms(20_000),
        help: ms(10_000),
        fill: ms(20_000),
        silence: ms(13_000),
    }
}

fn options(robot: &str) -> CheckOptions {
    options_in(FLEET, robot)
}

fn options_in(fleet: &str, robot: &str) -> CheckOptions {
    CheckOptions {
        fleet: Name::new(fleet).unwrap(),
        robot: Name::robot(robot).unwrap(),
        whisker: None,
        epoch: None,
        help: Help::Restart,
        relay: None,
        timings: timings(),
    }
}

fn connection(broker: &Mosquitto, name: &str) -> Connection {
    connection_in(FLEET, broker, name)
}

fn connection_in(fleet: &str, broker: &Mosquitto, name: &str) -> Connection {
    let address = BrokerAddress::new("127.0.0.1", broker.port());
    let prepared = prepare(&address).unwrap();
    let fleet = Name::new(fleet).unwrap();
    Connection::new(address, prepared, fleet, BootId::new(&format!("check-{name}")).unwrap())
}

/// Starts a robot of that name with continuous contacts, and waits until it is connected.
async fn robot(broker: &Mosquitto, name: &str, fault: Option<Misbehaviour>) -> (Fleet, RobotHandle) {
    robot_of(&Broker::new("127.0.0.1", broker.port()), FLEET, name, fault).await
}

/// The same with a broker that may require credentials.
async fn robot_of(broker: &Broker, fleet: &str, name: &str, fault: Option<Misbehaviour>) -> (Fleet, RobotHandle) {
    let scenario = scenario_of(fleet, name, fault);
    let fleet = Fleet::start(&scenario, broker).unwrap();
    let robot = fleet.robots()[0].clone();
    wait::until_true("a connected robot", async || robot.with(|robot| robot.is_connected())).await;
    (fleet, robot)
}

/// The scenario of a robot with continuous contacts.
fn scenario_of(fleet: &str, name: &str, fault: Option<Misbehaviour>) -> Scenario {
    let text = format!(
        r#"
        fleet = "{fleet}"
        seed = 1
        [behaviour]
        contacts_per_second = {CONTACTS_PER_S:?}
        contacts_per_message = 2
        message_after_s = 0.3
        kept_messages = 200
        supervisor_lost_after_s = 10.0
        touch_tests = ["WALL"]
        [[robots]]
        robot = "{name}"
        applies_gain = true
        [[robots.arrays]]
        array = "left"
        type = "TYPE_1"
        whiskers = [{{ whisker = 0, neighbours = [1], strain_max = 0.2 }}, {{ whisker = 1, strain_max = 0.2 }}]
        "#
    );
    let mut scenario = Scenario::from_toml_str(&text).unwrap();
    scenario.behaviour.misbehaviour = fault;
    scenario
}

/// Publishes the retained state of a supervisor.
async fn supervisor(broker: &Mosquitto, state: SupervisorPresence) {
    supervisor_of(FLEET, broker, state).await;
}

async fn supervisor_of(fleet: &str, broker: &Mosquitto, state: SupervisorPresence) {
    let observer = Observer::subscribed(broker.port(), &format!("{fleet}-supervisor-{state}"), &[]).await;
    let topic = Topic::SupervisorState { fleet: Name::new(fleet).unwrap() };
    let message = SupervisorState { boot_id: BootId::new("s1").unwrap(), seq: 0, state, epoch: EPOCH };
    observer.publish(&topic.to_string(), encode(&message), true).await;
}

/// Topic of a robot.
fn topic(robot: &str, kind: RobotTopic) -> String {
    kind.of(&Name::new(FLEET).unwrap(), &Name::robot(robot).unwrap()).to_string()
}

/// A supervisor's setpoint for the first whisker.
fn setpoint(robot: &RobotHandle, epoch: u64, version: u64) -> Setpoint {
    let (boot_id, now_us) = (robot.with(|robot| robot.boot_id().clone()), now_us());
    Setpoint {
        boot_id: BootId::new("s2").unwrap(),
        seq: 0,
        command_id: format!("{epoch}.{version}"),
        epoch,
        version,
        robot_boot_id: boot_id,
        array: Name::new("left").unwrap(),
        whisker: 0,
        pressure_mpa: 0.09,
        slew_mpa_per_s: 0.02,
        issued: Timestamp(now_us),
        expires_us: now_us + 30_000_000,
        reason: SetpointReason::Operator,
        gain: vec![],
        reading_gain: None,
    }
}
