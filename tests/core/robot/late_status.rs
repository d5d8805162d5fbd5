//! Statuses that arrive after later messages of their robot: a cluster of brokers, and a log beside a broker, keep the order
//! of messages only within a topic.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{Command, CommandState, Effect};
use vibrissa_core::robot::event::{GaugeState, RegulatorState, SetpointReport, WhiskerStatus};
use vibrissa_core::robot::{Event, OperatorAction, Params, Place};
use vibrissa_core::units::{Megapascal, Micros};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{self, Change};

use crate::taken_up::{NOMINAL_MPA, Taken, commands};

fn status(mpa: f64) -> WhiskerStatus<'static> {
    let pressure = Megapascal::known(mpa);
    let (regulator, gauge) = (RegulatorState::Ok, GaugeState::Ok);
    WhiskerStatus { array: "left", whisker: 0, pressure, setpoint: pressure, regulator, gauge }
}

/// A robot has applied the setpoint of its compensation. Returns the world, the setpoint, and when it was applied.
fn compensated() -> (World, Command, Micros) {
    let mut one = super::scenario(7, ArrayType::Type2, &[70.0]);
    let cut = scenario::Event::at_contact(1000, super::name("left"), 0, Change::Trim { length_mm: 66.0 });
    one.robots[0].events.push(cut);
    let mut world = World::new(&one, Params::nguyen_2021(Formulation::Published));
    for tenth_s in 200.. {
        world.run_until_s(f64::from(tenth_s) / 10.0);
        let applied = world.effects.iter().find_map(|(at, effect)| {
            matches!(effect, Effect::CommandState { state: CommandState::Applied, .. }).then_some(*at)
        });
        if let Some(at) = applied {
            let sent = world.picked(|effect| match effect {
                Effect::Command(command) => Some((**command).clone()),
                _ => None,
            });
            assert_eq!(sent.len(), 1, "{sent:?}");
            return (world, sent[0].clone(), at);
        }
        assert!(tenth_s < 1200, "no setpoint was applied");
    }
    unreachable!()
}

fn commands_of(world: &World) -> usize {
    world.picked(|effect| matches!(effect, Effect::Command(_)).then_some(())).len()
}

#[test]
fn regress_a_status_from_before_a_setpoint_does_not_make_the_setpoint_go_out_again() {
    let (mut world, sent, applied_at) = compensated();
    let boot_id = sent.robot_boot_id.as_str();
    let late = status(NOMINAL_MPA);
    let whiskers = std::slice::from_ref(&late);
    world.step(&Event::Status { boot_id, robot_time: sent.issued, whiskers });
    world.step(&Event::Tick);
    assert_eq!(world.core.whisker(0).unwrap().setpoint, sent.pressure);
    assert_eq!(commands_of(&world), 1, "the robot holds the pressure already");
    // A later status counts: the robot has left the pressure.
    world.step(&Event::Status { boot_id, robot_time: applied_at.after(Micros::from_s(0.5)), whiskers });
    world.step(&Event::Tick);
    assert_eq!(commands_of(&world), 2, "the compensation is still in force");
}

#[test]
fn a_status_from_before_a_setpoint_is_known_after_a_takeover() {
    let (mut world, sent, _) = compensated();
    let bytes = [world.core.whisker_to_bytes(0).unwrap()];
    let head = world.core.to_bytes().unwrap();
    world.core = vibrissa_core::robot::Robot::restore(&head, &bytes).unwrap();
    let late = status(NOMINAL_MPA);
    let (boot_id, whiskers) = (sent.robot_boot_id.as_str(), std::slice::from_ref(&late));
    world.step(&Event::Status { boot_id, robot_time: sent.issued, whiskers });
    assert_eq!(world.core.whisker(0).unwrap().setpoint, sent.pressure);
}

/// A robot whose statuses all come eight seconds late, as from a log after an outage. Its clock seems to be behind.
fn with_late_statuses() -> Taken {
    let mut robot = Taken::first_met();
    for _ in 0..30 {
        late(&mut robot, NOMINAL_MPA);
    }
    robot
}

fn late(robot: &mut Taken, mpa: f64) {
    let (entry, robot_time) = (status(mpa), Micros(robot.now.0 - 8_000_000));
    robot.step(&Event::Status { boot_id: "b1", robot_time, whiskers: std::slice::from_ref(&entry) });
}

#[test]
fn regress_statuses_that_come_late_from_a_log_do_not_undo_a_setpoint() {
    let mut robot = with_late_statuses();
    let whisker = Place { array: "left", whisker: 0 };
    let sent = commands(robot.step(&Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.06 })));
    robot.reports(&sent[0], SetpointReport::Applied(Megapascal::known(0.06)));
    for second in 0..6 {
        late(&mut robot, NOMINAL_MPA);
        assert_eq!(robot.setpoint_mpa(), 0.06, "after {second} s");
    }
    // These were sent after the report: the robot has left the pressure.
    for _ in 0..4 {
        late(&mut robot, NOMINAL_MPA);
    }
    assert_eq!(robot.setpoint_mpa(), NOMINAL_MPA);
}

#[test]
fn golden_the_report_of_a_whisker_of_version_10_has_no_time_of_receipt() {
    let mut robot = Taken::first_met();
    for _ in 0..10 {
        robot.holds(NOMINAL_MPA);
    }
    let whisker = Place { array: "left", whisker: 0 };
    let sent = commands(robot.step(&Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.06 })));
    robot.reports(&sent[0], SetpointReport::Applied(Megapascal::known(0.06)));
    let [head, now] = robot.stored();
    // The time of receipt, 8 bytes, comes last; the version, 19, is in the first byte. The fourth number, of one byte,
    // names the parts that came with version 16: none.
    let mut older = now[..now.len() - 8].to_vec();
    older[0] -= 9;
    let ends = |from: usize| from + now[from..].iter().take_while(|byte| **byte >= 0x80).count() + 1;
    assert_eq!(older.remove(ends(ends(ends(0)))), 0);
    let restored = vibrissa_core::robot::Robot::restore(&head, &[older]).unwrap();
    assert_eq!(restored.whisker(0).unwrap().setpoint, sent[0].pressure);
    let read = restored.whisker_to_bytes(0).unwrap();
    assert_eq!((&read[..now.len() - 8], &read[now.len() - 8..]), (&now[..now.len() - 8], &[0; 8][..]));
}

#[test]
fn statuses_of_a_clock_that_was_set_back_are_believed_soon() {
    let mut robot = Taken::first_met();
    for _ in 0..10 {
        robot.holds(NOMINAL_MPA);
    }
    let whisker = Place { array: "left", whisker: 0 };
    let sent = commands(robot.step(&Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.06 })));
    robot.reports(&sent[0], SetpointReport::Applied(Megapascal::known(0.06)));
    assert_eq!(robot.setpoint_mpa(), 0.06);
    let mut seconds = 0;
    while robot.setpoint_mpa() != NOMINAL_MPA {
        let back = Micros(robot.now.0 - 300_000_000);
        let entry = status(NOMINAL_MPA);
        robot.step(&Event::Status { boot_id: "b1", robot_time: back, whiskers: std::slice::from_ref(&entry) });
        seconds += 1;
        assert!(seconds <= 70, "not believed after {seconds} s");
    }
}
