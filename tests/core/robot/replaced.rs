//! A new whisker in the place of an old one, and new layouts.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{AlarmKind, Command, Condition, Effect, EndReason, Fault, Reason};
use vibrissa_core::robot::event::{ArraySheet, Factsheet, GaugeState, RegulatorState, Task, TouchTests, WhiskerStatus};
use vibrissa_core::robot::{Event, OperatorAction, Params, Place};
use vibrissa_core::units::Millimetre;
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event as Planned};

/// Whisker 0 is cut and served by 1; 3 is cut and serves itself; 4 is whole.
fn served() -> World {
    let mut scenario = super::scenario(51, ArrayType::Type1, &[70.0, 65.0, 70.0, 70.0, 66.0]);
    for (whisker, length_mm) in [(0, 54.0), (3, 65.0)] {
        scenario.robots[0].events.push(Planned::at_contact(
            300,
            super::name("left"),
            whisker,
            Change::Trim { length_mm },
        ));
    }
    // No refinement: nothing is to be under way but what a replacement brings.
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.refinement.first_look_contacts = u32::MAX;
    let mut world = World::new(&scenario, params);
    world.run_until_s(14.0);
    assert_eq!(pairs(&world), [(0, 1), (3, 3)]);
    assert!(world.core.commands_under_way().next().is_none(), "settled");
    world.effects.clear();
    world
}

/// (target, compensator) of everything in force, by target.
fn pairs(world: &World) -> Vec<(usize, usize)> {
    let mut pairs: Vec<_> = world.core.compensations().iter().map(|one| (one.target(), one.compensator())).collect();
    pairs.sort_unstable();
    pairs
}

fn ended(world: &World) -> Vec<EndReason> {
    world.picked(|effect| if let Effect::Ended { reason, .. } = effect { Some(*reason) } else { None })
}

fn commands(world: &World) -> Vec<Command> {
    world.picked(|effect| if let Effect::Command(command) = effect { Some((**command).clone()) } else { None })
}

fn condition(world: &World, index: usize) -> Condition {
    world.core.whisker(index).expect("there").condition
}

fn factsheet_with(world: &World, change: impl FnOnce(&mut ArraySheet)) -> Factsheet {
    let whiskers = (0..world.core.whisker_count()).map(|index| world.core.whisker(index).unwrap().sheet.into());
    let kind = world.core.whisker(0).unwrap().kind;
    let mut array = ArraySheet { name: "left".to_owned(), kind, task: Task::Ratio, whiskers: whiskers.collect() };
    change(&mut array);
    Factsheet {
        arrays: vec![array],
        touch_tests: TouchTests::default(),
        applies_gain: false,
        air_control: Default::default(),
    }
}

fn tell(world: &mut World, factsheet: &Factsheet) {
    let boot_id = world.core.connection_state().0.expect("born").to_owned();
    world.step(&Event::Factsheet { boot_id: &boot_id, factsheet });
}

fn replace(world: &mut World, array: &str, whisker: u16) {
    world.step(&Event::Operator(&OperatorAction::Replaced(Place { array, whisker })));
}

#[test]
fn a_replaced_whisker_is_learned_anew_and_its_compensator_returns_to_nominal() {
    let mut world = served();
    let other = world.core.compensations().iter().find(|one| one.target() == 3).unwrap().id();
    replace(&mut world, "left", 0);
    assert_eq!(ended(&world), [EndReason::Replaced]);
    let release = &commands(&world)[..];
    let nominal = world.core.whisker(1).unwrap().sheet.pressure;
    assert_eq!(release.len(), 1, "{release:?}");
    assert_eq!((release[0].whisker, release[0].reason, release[0].pressure), (1, Reason::Release, nominal));
    assert_eq!(condition(&world, 0), Condition::Learning);
    assert_eq!(world.core.whisker(0).unwrap().contacts, 0);
    world.run_until_s(18.0);
    assert_eq!(world.core.whisker(1).unwrap().setpoint, nominal, "the robot holds it");
    assert_eq!(pairs(&world), [(3, 3)]);
    assert_eq!(world.core.compensations()[0].id(), other, "the other goes on");
    assert_eq!(commands(&world).len(), 1, "nobody else is told anything");
}

#[test]
fn whom_a_replaced_compensator_served_is_decided_anew_and_served_again_once_the_new_one_is_learned() {
    let mut world = served();
    replace(&mut world, "left", 1);
    assert_eq!(ended(&world), [EndReason::Replaced]);
    assert_eq!(pairs(&world), [(3, 3)], "nobody else can serve 0");
    assert_eq!(condition(&world, 0), Condition::Trimmed);
    let released = commands(&world);
    assert_eq!(released.iter().map(|one| (one.whisker, one.reason)).collect::<Vec<_>>(), [(1, Reason::Release)]);
    // 150 contacts of the cold start, 50 of them a second, begin once the pressure is there.
    world.run_until_s(25.0);
    assert_eq!(condition(&world, 1), Condition::Healthy);
    assert_eq!(pairs(&world), [(0, 1), (3, 3)]);
}

#[test]
fn a_whisker_that_serves_itself_is_released_when_it_is_replaced() {
    let mut world = served();
    replace(&mut world, "left", 3);
    assert_eq!(ended(&world), [EndReason::Replaced]);
    let released = commands(&world);
    assert_eq!(released.iter().map(|one| (one.whisker, one.reason)).collect::<Vec<_>>(), [(3, Reason::Release)]);
    world.run_until_s(18.0);
    let view = world.core.whisker(3).unwrap();
    assert_eq!(view.setpoint, view.sheet.pressure);
    assert_eq!(pairs(&world), [(0, 1)]);
}

#[test]
fn an_unknown_whisker_that_is_replaced_changes_nothing() {
    let mut world = served();
    let before = world.core.clone();
    replace(&mut world, "left", 99);
    replace(&mut world, "right", 0);
    assert_eq!(world.effects, []);
    assert_eq!(world.core, before);
}

#[test]
fn a_factsheet_with_another_whisker_ends_what_concerns_it_and_nothing_else() {
    let mut world = served();
    let ids = world.core.compensations().iter().map(|one| (one.target(), one.id())).collect::<Vec<_>>();
    let contacts_of = |world: &World, index| world.core.whisker(index).unwrap().contacts;
    let known = contacts_of(&world, 3);
    // Whisker 0 is a new one of 68 mm, and another one comes first: every index moves on by one.
    let factsheet = factsheet_with(&world, |array| {
        array.whiskers[0].length = Millimetre::known(68.0);
        let mut first = array.whiskers[0].clone();
        first.number = 9;
        first.neighbours = Vec::new();
        array.whiskers.insert(0, first);
    });
    tell(&mut world, &factsheet);
    assert_eq!(ended(&world), [EndReason::Replaced]);
    assert_eq!(pairs(&world), [(4, 4)], "whisker 3 by its new index");
    assert!(ids.contains(&(3, world.core.compensations()[0].id())), "under its old number");
    assert_eq!(contacts_of(&world, 4), known, "what is known of it stays");
    assert_eq!((condition(&world, 1), contacts_of(&world, 1)), (Condition::Learning, 0));
    let conditions = world.picked(|effect| match effect {
        Effect::Condition { whisker, from, to } => Some((*whisker, *from, *to)),
        _ => None,
    });
    assert_eq!(conditions, [(1, Condition::Trimmed, Condition::Learning)]);
    let released = commands(&world);
    assert_eq!(released.iter().map(|one| (one.whisker, one.reason)).collect::<Vec<_>>(), [(2, Reason::Release)]);
    assert!(
        world.picked(|effect| matches!(effect, Effect::Decided(_)).then_some(())).is_empty(),
        "nothing new to decide"
    );
}

#[test]
fn setpoints_under_way_go_with_their_whiskers_and_those_of_whiskers_that_are_gone_are_abandoned() {
    let mut scenario = super::scenario(52, ArrayType::Type2, &[70.0, 70.0]);
    for whisker in [0, 1] {
        let change = Change::Trim { length_mm: 65.0 };
        scenario.robots[0].events.push(Planned::at_contact(300, super::name("left"), whisker, change));
    }
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    let mut seconds = 6.0;
    while world.core.commands_under_way().count() < 2 {
        seconds += 0.1;
        assert!(seconds < 20.0, "two setpoints under way at a time");
        world.run_until_s(seconds);
    }
    let kept = world.core.commands_under_way().find(|command| command.whisker == 1).unwrap().key;
    let lost = world.core.commands_under_way().find(|command| command.whisker == 0).unwrap().key;
    world.effects.clear();
    let factsheet = factsheet_with(&world, |array| {
        array.whiskers.remove(0);
        array.whiskers[0].neighbours.clear();
    });
    tell(&mut world, &factsheet);
    let under_way: Vec<_> = world.core.commands_under_way().map(|command| (command.key, command.whisker)).collect();
    assert_eq!(under_way, [(kept, 0)], "by its new index");
    assert_eq!(ended(&world), [EndReason::LayoutChanged]);
    let abandoned = world.picked(|effect| match effect {
        Effect::CommandState { command, state, .. } => Some((*command, *state)),
        _ => None,
    });
    assert_eq!(abandoned, [(lost, vibrissa_core::robot::effect::CommandState::Abandoned)]);
    world.run_until_s(seconds + 4.0);
    assert_eq!(pairs(&world), [(0, 0)]);
    assert!(world.core.whisker(0).unwrap().setpoint < world.core.whisker(0).unwrap().sheet.pressure, "applied");
}

#[test]
fn two_that_are_no_neighbours_any_more_do_not_serve_each_other() {
    let mut world = served();
    let factsheet = factsheet_with(&world, |array| {
        array.whiskers[0].neighbours.clear();
        array.whiskers[1].neighbours = vec![2];
    });
    tell(&mut world, &factsheet);
    assert_eq!(ended(&world), [EndReason::LayoutChanged]);
    assert_eq!(pairs(&world), [(3, 3)]);
    assert_eq!(condition(&world, 0), Condition::Trimmed, "the whisker is the same");
    let decided = world.picked(|effect| match effect {
        Effect::Decided(decision) => Some((decision.target, decision.chosen)),
        _ => None,
    });
    assert_eq!(decided, [(0, None)]);
}

#[test]
fn alarms_of_a_whisker_that_is_gone_are_cleared_by_its_name() {
    let mut world = served();
    let boot_id = world.core.connection_state().0.expect("born").to_owned();
    let view = world.core.whisker(4).unwrap();
    let (regulator, gauge) = (RegulatorState::Ok, GaugeState::Open);
    let status =
        WhiskerStatus { array: "left", whisker: 4, pressure: view.setpoint, setpoint: view.setpoint, regulator, gauge };
    let robot_time = view.heard.unwrap();
    world.step(&Event::Status { boot_id: &boot_id, robot_time, whiskers: &[status] });
    // Longer than the alarm's on-delay.
    world.silent_for_s(2.0);
    world.effects.clear();
    let factsheet = factsheet_with(&world, |array| {
        array.whiskers.pop();
        array.whiskers[3].neighbours = vec![2];
    });
    tell(&mut world, &factsheet);
    let gone = world.picked(|effect| match effect {
        Effect::Gone { array, number, alarms } => Some((array.clone(), *number, alarms.clone())),
        _ => None,
    });
    assert_eq!(gone, [("left".to_owned(), 4, vec![AlarmKind::Fault(Fault::Gauge(GaugeState::Open))])]);
    assert_eq!(world.picked(|effect| matches!(effect, Effect::AlarmCleared { .. }).then_some(())), []);
}
