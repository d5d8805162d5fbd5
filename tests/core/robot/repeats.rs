//! Setpoints that a robot takes, and does not keep: how often the same one is sent again.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{CONTACT_RATIOS, Formulation};
use vibrissa_core::robot::effect::{Command, Effect};
use vibrissa_core::robot::event::{GaugeState, Link, RegulatorState, Rejection, SetpointReport, WhiskerStatus};
use vibrissa_core::robot::{Event, OperatorAction, Outcome, Params, Place, Robot, Scope};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_evaluation::World;
use vibrissa_evaluation::world::START_US;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event as Planned, Misbehaviour};

use crate::by_hand::ByHand;

const ARRAY: &str = "left";
const NOMINAL_MPA: f64 = 0.1;
/// A report this close to a setpoint is that setpoint.
const SETTLED_MPA: f64 = 0.004;

/// Behaviour of a robot towards a setpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Habit {
    /// It gives no answer.
    Deaf,
    Rejects(Rejection),
    Fails,
    Supersedes,
    /// It says that the pressure moves, and no more.
    Applies,
    /// It takes it, and reports a pressure as its setpoint that is rounded to multiples of this, MPa.
    Rounds(f64),
    /// It takes it, and goes back to the nominal pressure after some seconds.
    Returns(u32),
    /// It takes it, and vents after some seconds.
    Vents(u32),
    Keeps,
}

/// A robot with one cut whisker, whose every answer is drawn.
struct Drawn {
    core: Robot,
    params: Params,
    now: Micros,
    effects: Vec<Effect>,
    sent: Vec<(Micros, Command)>,
    /// The setpoint in force, as it reports it, and when it leaves it for which other, if it does.
    holds_mpa: f64,
    leaves: Option<(Micros, f64)>,
    boot_id: String,
    /// Pressure and gain that it took last, until it reports another setpoint or boots.
    in_force: Option<(Megapascal, Option<[f64; CONTACT_RATIOS.len()]>)>,
    /// Number of setpoints that were in force already.
    in_force_again: u32,
}

impl Drawn {
    /// A robot whose whisker was cut and is served a moment ago.
    fn served() -> Self {
        let mut scenario = super::scenario(91, ArrayType::Type2, &[70.0]);
        let cut = Change::Trim { length_mm: 65.0 };
        scenario.robots[0].events.push(Planned::at_contact(400, super::name("left"), 0, cut));
        let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
        let is_served = |world: &World| world.core.compensations().iter().any(|one| one.is_settled());
        while !is_served(&world) {
            world.run_until_s(world.seconds() + 0.5);
        }
        let holds_mpa = world.core.whisker(0).expect("there").setpoint.mpa();
        Self {
            boot_id: world.core.connection_state().0.expect("born").to_owned(),
            now: Micros(START_US + (world.seconds() * 1e6) as u64),
            params: world.params.clone(),
            core: world.core.clone(),
            effects: Vec::new(),
            sent: Vec::new(),
            holds_mpa,
            leaves: None,
            in_force: None,
            in_force_again: 0,
        }
    }

    fn step(&mut self, event: &Event<'_>) {
        let before = self.effects.len();
        self.core.step(&self.params, self.now, event, &mut self.effects);
        for effect in &self.effects[before..] {
            if let Effect::Command(command) = effect {
                self.in_force_again += u32::from(self.in_force == Some((command.pressure, command.gain)));
                self.sent.push((self.now, (**command).clone()));
            }
        }
    }

    fn status(&mut self) {
        let setpoint = Megapascal::known(self.holds_mpa);
        let (regulator, gauge) = (RegulatorState::Ok, GaugeState::Ok);
        let status = WhiskerStatus { array: ARRAY, whisker: 0, pressure: setpoint, setpoint, regulator, gauge };
        self.in_force.take_if(|(pressure, _)| (pressure.mpa() - self.holds_mpa).abs() > SETTLED_MPA);
        let (boot_id, robot_time) = (self.boot_id.clone(), self.now);
        self.step(&Event::Status { boot_id: &boot_id, robot_time, whiskers: &[status] });
    }

    fn answers(&mut self, command: &Command, habit: Habit) {
        let after = |seconds: u32| Micros(self.now.0 + u64::from(seconds) * 1_000_000);
        let mpa = command.pressure.mpa();
        let (report, holds_mpa, leaves) = match habit {
            Habit::Deaf => return,
            Habit::Rejects(why) => (SetpointReport::Rejected(why), self.holds_mpa, self.leaves),
            Habit::Fails => (SetpointReport::Failed, self.holds_mpa, self.leaves),
            Habit::Supersedes => (SetpointReport::Superseded, self.holds_mpa, self.leaves),
            Habit::Applies => (SetpointReport::Applying, mpa, None),
            Habit::Rounds(step) => (SetpointReport::Applied(command.pressure), (mpa / step).round() * step, None),
            Habit::Returns(s) => (SetpointReport::Applied(command.pressure), mpa, Some((after(s), NOMINAL_MPA))),
            Habit::Vents(s) => (SetpointReport::Applied(command.pressure), mpa, Some((after(s), 0.0))),
            Habit::Keeps => (SetpointReport::Applied(command.pressure), mpa, None),
        };
        (self.holds_mpa, self.leaves) = (holds_mpa, leaves);
        if matches!(report, SetpointReport::Applied(_)) {
            self.in_force = Some((command.pressure, command.gain));
        }
        let (boot_id, robot_time) = (self.boot_id.clone(), self.now);
        self.step(&Event::Setpoint { boot_id: &boot_id, command: command.key, report, robot_time });
    }

    /// One second: the answers to setpoints that were sent meanwhile, a status if it is heard, and a tick.
    fn second(&mut self, is_heard: bool, mut habit: impl FnMut() -> Habit) {
        let from = self.sent.len();
        self.now = self.now.after(Micros::from_s(1.0));
        if let Some((_, to_mpa)) = self.leaves.take_if(|(at, _)| *at <= self.now) {
            self.holds_mpa = to_mpa;
        }
        if is_heard {
            self.status();
        }
        self.step(&Event::Tick);
        let sent = self.sent[from..].to_vec();
        for (_, command) in sent {
            self.answers(&command, habit());
        }
    }

    fn boots(&mut self, boot_id: &str) {
        self.boot_id = boot_id.to_owned();
        (self.in_force, self.holds_mpa, self.leaves) = (None, NOMINAL_MPA, None);
        self.step(&Event::Connection { boot_id, link: Link::Online });
    }
}

fn habits() -> Vec<Habit> {
    let mut all = vec![Habit::Deaf, Habit::Fails, Habit::Supersedes, Habit::Applies, Habit::Keeps];
    all.extend(
        [
            Rejection::NotReady,
            Rejection::InTask,
            Rejection::Expired,
            Rejection::WrongBoot,
            Rejection::Stale,
            Rejection::OutOfRange,
        ]
        .map(Habit::Rejects),
    );
    all.extend([0.0005, 0.002, 0.005, 0.02].map(Habit::Rounds));
    all.extend([0, 3, 15, 45, 200, 1000].map(Habit::Returns));
    all.extend([0, 3, 15, 45, 200, 1000].map(Habit::Vents));
    all
}

/// Setpoints with the same pressure, gain and boot within an hour, at most, as docs/operators.md states.
const SAME_IN_AN_HOUR_MAX: usize = 20;
const HOUR: Micros = Micros(3_600_000_000);

/// The most setpoints with the same pressure, gain and boot that were sent within any hour.
fn most_of_the_same(sent: &[(Micros, Command)]) -> usize {
    let is_same = |one: &Command, other: &Command| {
        one.pressure == other.pressure && one.gain == other.gain && one.robot_boot_id == other.robot_boot_id
    };
    let within = |(at, one): &(Micros, Command)| {
        let later = sent.iter().filter(|(then, _)| *then >= *at && then.since(*at) < HOUR);
        later.filter(|(_, other)| is_same(one, other)).count()
    };
    sent.iter().map(within).max().unwrap_or(0)
}

/// A robot that took each setpoint and reported another one was sent 1,800 in an hour.
#[test]
fn regress_a_setpoint_that_is_not_kept_is_sent_again_after_growing_pauses() {
    for habit in habits() {
        for heard in [1, 10, 14, 20, 40, 90] {
            let mut one = Drawn::served();
            one.holds_mpa = NOMINAL_MPA;
            for second in 0..3 * 3600 {
                one.second(second % heard == 0, || habit);
            }
            let most = most_of_the_same(&one.sent);
            assert!(most <= SAME_IN_AN_HOUR_MAX, "{habit:?}, heard every {heard} s: {most} of the same in an hour");
            let in_the_last_hour = one.sent.iter().filter(|(at, _)| one.now.since(*at) < HOUR).count();
            // A robot in a task gets a setpoint every five minutes, so that it has one soon after the end.
            let most = if matches!(habit, Habit::Rejects(Rejection::InTask)) { 12 } else { 4 };
            assert!(in_the_last_hour <= most, "{habit:?}, heard every {heard} s: {in_the_last_hour} in the last hour");
        }
    }
}

#[test]
fn property_nothing_that_is_in_force_is_sent_and_what_is_lost_only_a_limited_number_of_times() {
    let mut sent = 0;
    for seed in 0..60 {
        let mut draw = ChaCha8Rng::seed_from_u64(seed);
        let (all, mut one) = (habits(), Drawn::served());
        let (mut few, mut heard, mut boots) = (Vec::new(), 1, 1);
        for second in 0..6 * 3600 {
            // Every ten minutes another mood: a few habits, and how often the robot is heard.
            if second % 600 == 0 {
                few = (0..draw.random_range(1..4)).map(|_| all[draw.random_range(0..all.len())]).collect();
                heard = [1, 5, 10, 14, 20, 40, 90, 700][draw.random_range(0..8)];
                if draw.random_bool(0.1) {
                    boots += 1;
                    one.boots(&format!("boot-{boots}"));
                }
            }
            let is_heard = second % heard == 0;
            one.second(is_heard, || few[draw.random_range(0..few.len())]);
        }
        sent += one.sent.len();
        let most = most_of_the_same(&one.sent);
        assert!(most <= SAME_IN_AN_HOUR_MAX, "seed {seed}: {most} of the same in an hour");
        assert_eq!(one.in_force_again, 0, "seed {seed}");
    }
    assert!(sent > 600, "{sent} setpoints");
}

/// The same with contacts, which refine setpoints meanwhile.
#[test]
fn regress_a_robot_that_reports_a_wrong_setpoint_is_not_sent_the_same_for_ever() {
    for fault in [Misbehaviour::StatusStaysNominal, Misbehaviour::HoldsLess, Misbehaviour::ReturnsWithoutSupervisor] {
        let mut scenario = super::scenario(91, ArrayType::Type2, &[70.0]);
        scenario.behaviour.misbehaviour = Some(fault);
        let cut = Change::Trim { length_mm: 65.0 };
        scenario.robots[0].events.push(Planned::at_contact(400, super::name("left"), 0, cut));
        let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
        world.run_until_s(1200.0);
        let command = |(at, effect): &(Micros, Effect)| match effect {
            Effect::Command(command) => Some((*at, (**command).clone())),
            _ => None,
        };
        let sent: Vec<_> = world.effects.iter().filter_map(command).collect();
        assert!(sent.len() <= SAME_IN_AN_HOUR_MAX, "{fault}: {} setpoints in 20 minutes", sent.len());
    }
}

/// The contract allows nominal pressures above 0.2 MPa, and no setpoint goes beyond. Such a whisker got a new setpoint every 2 s
/// after a release, because the pressure that it applied was never the nominal one.
#[test]
fn regress_a_nominal_pressure_above_the_limit_is_ordered_once() {
    let mut one = ByHand::born(70.0);
    one.pressures_mpa = [0.25, 0.3];
    assert_eq!(one.boots("b2", 70.0), [Outcome::Taken; 2]);
    let (mut held_mpa, mut ordered_mpa, place) = (0.25, Vec::new(), Place { array: ARRAY, whisker: 0 });
    for tick in 0..1200 {
        one.passes_s(0.5);
        if tick % 10 == 0 {
            assert_eq!(one.status_at(held_mpa, 0), Outcome::Taken);
        }
        let outcome = match tick {
            40 => one.step(&Event::Operator(&OperatorAction::Setpoint { whisker: place, pressure_mpa: 0.1 })),
            80 => one.step(&Event::Operator(&OperatorAction::Release(Scope::Whisker(place)))),
            _ => one.step(&Event::Tick),
        };
        assert_eq!(outcome, Outcome::Taken);
        for effect in std::mem::take(&mut one.effects) {
            let Effect::Command(command) = effect else { continue };
            ordered_mpa.push(command.pressure.mpa());
            held_mpa = command.pressure.mpa();
            let (boot_id, report) = (command.robot_boot_id.as_str(), SetpointReport::Applied(command.pressure));
            one.step(&Event::Setpoint { boot_id, command: command.key, report, robot_time: one.now });
        }
    }
    assert_eq!(ordered_mpa, [0.2, 0.1, 0.2], "at the factsheet, by hand, and at the release");
}

/// After an interruption the operator may have turned away.
#[test]
fn regress_a_manual_setpoint_is_not_repeated_to_a_robot_that_was_away() {
    let mut one = ByHand::born(70.0);
    for _ in 0..3 {
        one.passes_s(1.0);
        one.status(0);
    }
    let ordered = one.asked_for(0.05).expect("a setpoint");
    let repeated = |one: &ByHand| one.robot.commands_to_repeat().map(|command| command.key).collect::<Vec<_>>();
    assert_eq!(repeated(&one), [ordered.key], "this supervisor may have been away");
    for link in [Link::Broken, Link::Online] {
        one.step(&Event::Connection { boot_id: "b1", link });
    }
    assert!(repeated(&one).is_empty());
    assert_eq!(one.robot.commands_under_way().count(), 1, "its answer counts all the same");
}
