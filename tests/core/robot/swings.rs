//! A sealed chamber whose pressure goes up and down with the temperature of the day.

use serde_json::Value;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_evaluation::World;
use vibrissa_evaluation::world::{Peer, START_US};
use vibrissa_protocol::{ArrayType, Name, RobotTopic};
use vibrissa_simulator::robot::Outgoing;
use vibrissa_simulator::scenario::{Change, Event as Planned};
use vibrissa_simulator::{Robot as SimulatedRobot, RobotConfig};

/// The pressure changes by so much, in MPa: more than the supervisor lets a chamber drift, and less than it needs to refuse
/// contacts as those of another response.
const SWING_MPA: f64 = 0.006;
/// A day of the test, in microseconds.
const DAY_US: u64 = 20_000_000;

/// A robot whose chamber is warm in the second half of each day.
struct Warmed {
    robot: SimulatedRobot,
    begins_us: u64,
}

impl Warmed {
    fn is_warm(&self, now_us: u64) -> bool {
        now_us > self.begins_us && (now_us - self.begins_us) % DAY_US >= DAY_US / 2
    }

    fn felt(&self, now_us: u64, said: Vec<Outgoing>) -> Vec<Outgoing> {
        let is_warm = self.is_warm(now_us);
        let warmed = |outgoing| match outgoing {
            Outgoing::Publish { topic: topic @ (RobotTopic::Status | RobotTopic::Contacts), payload } if is_warm => {
                let mut message: Value = serde_json::from_slice(&payload).expect("JSON");
                for list in ["whiskers", "contacts"] {
                    for one in message.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten() {
                        if let Some(mpa) = one["pressure_mpa"].as_f64() {
                            one["pressure_mpa"] = (mpa + SWING_MPA).into();
                        }
                    }
                }
                Outgoing::Publish { topic, payload: serde_json::to_vec(&message).expect("JSON") }
            }
            other => other,
        };
        said.into_iter().map(warmed).collect()
    }
}

impl Peer for Warmed {
    fn fleet(&self) -> &Name {
        self.robot.fleet()
    }

    fn name(&self) -> &Name {
        self.robot.name()
    }

    fn connected(&mut self, now_us: u64) -> Vec<Outgoing> {
        let said = self.robot.connected(now_us);
        self.felt(now_us, said)
    }

    fn next_deadline(&self) -> u64 {
        self.robot.next_deadline()
    }

    fn poll(&mut self, now_us: u64) -> Vec<Outgoing> {
        let said = self.robot.poll(now_us);
        self.felt(now_us, said)
    }

    fn receive(&mut self, topic: RobotTopic, payload: &[u8], now_us: u64) -> Vec<Outgoing> {
        let said = self.robot.receive(topic, payload, now_us);
        self.felt(now_us, said)
    }
}

#[test]
fn regress_a_pressure_that_swings_is_followed_for_ever() {
    let mut scenario = super::scenario(76, ArrayType::Type2, &[70.0]);
    scenario.robots[0].applies_gain = true;
    for (contact, change) in [(400, Change::Trim { length_mm: 65.0 }), (1500, Change::ValvesBroken)] {
        scenario.robots[0].events.push(Planned::at_contact(contact, super::name("left"), 0, change));
    }
    let config = RobotConfig::all(&scenario).next().expect("a robot");
    let robot = SimulatedRobot::new(config, scenario.seed, START_US).expect("a robot");
    let begins_us = u64::MAX;
    let mut world = World::of(Warmed { robot, begins_us }, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(60.0);
    let begins_s = world.seconds();
    world.robot.begins_us = START_US + (begins_s * 1e6) as u64;
    let (mut followed, mut before_mpa) = (0, f64::NAN);
    for half_day in 1..=90 {
        world.run_until_s(begins_s + f64::from(half_day) * DAY_US as f64 / 2e6 - 0.5);
        let [one] = world.core.compensations() else { panic!("{half_day}: {:?}", world.core.compensations()) };
        let true_mpa = world.robot.robot.whiskers()[0].regulator().pressure_mpa();
        let felt_mpa = true_mpa + if half_day % 2 == 0 { SWING_MPA } else { 0.0 };
        followed += u32::from(one.pressure().mpa() != before_mpa);
        before_mpa = one.pressure().mpa();
        assert!(
            (before_mpa - felt_mpa).abs() < 0.0045,
            "{half_day}: {before_mpa} instead of {felt_mpa} after {followed} changes"
        );
    }
    assert!(followed > 64, "{followed}");
}
