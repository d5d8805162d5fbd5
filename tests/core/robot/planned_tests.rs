//! Touch tests after a pause of contacts, after a restart of the robot and on a schedule, and proposed ones.

use std::collections::{BTreeMap, BTreeSet};

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{CommandKey, Condition, Effect, ProposedTest, TestReason, TestState, TouchTest};
use vibrissa_core::robot::event::{Distance, MissedTouch, TestReport};
use vibrissa_core::robot::{ActionProblem, Event, OperatorAction, Outcome, Params, Place, Scope};
use vibrissa_core::units::{Micros, Millimetre};
use vibrissa_evaluation::World;
use vibrissa_protocol::{ArrayType, Task, TouchTestKind};
use vibrissa_simulator::places::Places;
use vibrissa_simulator::scenario::{Change, Event as Planned};

const WHISKERS: usize = 4;

/// The robot's distances are known to be right, so that no test measures their error.
fn params() -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.touch_tests.zero_sd_mm = 0.0;
    params
}

/// Whole whiskers of 70 mm.
fn world(places: Places, params: Params, events: Vec<Planned>) -> World {
    let mut scenario = crate::scenario(7, ArrayType::Type2, &[70.0; WHISKERS]);
    scenario.behaviour.places = places;
    scenario.behaviour.touch_tests = vec![TouchTestKind::Wall];
    scenario.behaviour.task = Some(Task::Distance);
    scenario.noise.ratio = 0.1 / 70.0;
    scenario.behaviour.contacts_per_message = 1;
    scenario.robots[0].events = events;
    World::new(&scenario, params)
}

fn cut(whisker: u16, at_s: f64) -> Planned {
    Planned::whisker_at_s(at_s, crate::name("left"), whisker, Change::Trim { length_mm: 62.0 })
}

fn silent(whisker: u16, at_s: f64, for_s: f64) -> Planned {
    Planned::whisker_at_s(at_s, crate::name("left"), whisker, Change::Silent { for_s })
}

fn tests(world: &World) -> Vec<TouchTest> {
    world.picked(|effect| if let Effect::Test(test) = effect { Some((**test).clone()) } else { None })
}

fn proposals(world: &World) -> Vec<ProposedTest> {
    world.picked(|effect| if let Effect::TestProposed(test) = effect { Some(*test) } else { None })
}

fn trimmed(world: &World) -> Vec<usize> {
    world.picked(|effect| if let Effect::Trim(trim) = effect { Some(trim.whisker) } else { None })
}

/// Last state of each test that was requested or proposed.
fn last_states(world: &World) -> BTreeMap<CommandKey, TestState> {
    let keys = world.picked(|effect| match effect {
        Effect::Test(test) => Some((test.key, TestState::Pending)),
        Effect::TestProposed(test) => Some((test.key, TestState::Proposed)),
        _ => None,
    });
    let mut states: BTreeMap<CommandKey, TestState> = keys.into_iter().collect();
    for (_, effect) in &world.effects {
        if let Effect::TestState { test, state, .. } = effect {
            assert!(states.insert(*test, *state).is_some(), "a state of a test that was not requested");
        }
    }
    states
}

fn place(whisker: u16) -> Place<'static> {
    Place { array: "left", whisker }
}

#[test]
fn a_whisker_that_was_cut_in_a_pause_is_tested_with_its_next_contact() {
    let mut params = params();
    params.touch_tests.after_pause = Micros::from_s(10.0);
    let mut world = world(Places::Distance, params, vec![silent(1, 20.0, 12.0), silent(2, 20.0, 6.0), cut(1, 25.0)]);
    world.run_until_s(31.9);
    assert_eq!(tests(&world), [], "no pause is over");
    world.run_until_s(34.0);
    let found = tests(&world);
    assert!(!found.is_empty() && found.iter().all(|test| (test.whisker, test.reason) == (1, TestReason::Pause)));
    assert_eq!(trimmed(&world), [1]);
}

#[test]
fn after_a_restart_each_whisker_is_tested_one_after_another() {
    let mut params = params();
    params.touch_tests.after_pause = Micros::from_s(3600.0);
    let restart = vec![Planned::robot_at_s(20.0, Change::Restart)];
    let mut world = world(Places::Distance, params, restart.clone());
    world.run_until_s(19.9);
    assert_eq!(tests(&world), []);
    world.run_until_s(60.0);
    let found = tests(&world);
    let whiskers: BTreeSet<usize> = found.iter().map(|test| test.whisker).collect();
    assert_eq!((found.len(), whiskers.len()), (WHISKERS, WHISKERS), "one test refutes a cut of a sound whisker");
    assert!(found.iter().all(|test| test.reason == TestReason::Pause));
    let mut under_way = BTreeSet::new();
    for (_, effect) in &world.effects {
        match effect {
            Effect::Test(test) => {
                under_way.insert(test.key);
                assert_eq!(under_way.len(), 1, "two tests at once");
            }
            Effect::TestState { test, state: TestState::Done, .. } => {
                under_way.remove(test);
            }
            _ => {}
        }
    }
    assert_eq!(trimmed(&world), [0_usize; 0]);

    // By default, no restart leads to a test.
    let mut other = self::world(Places::Distance, self::params(), restart);
    other.run_until_s(60.0);
    assert_eq!(tests(&other), []);
}

#[test]
fn whiskers_whose_contacts_state_no_place_are_tested_each_hour_by_default_and_their_cuts_are_found() {
    let world_of = |places: Places, params: Params| {
        let mut scenario = crate::scenario(7, ArrayType::Type2, &[70.0; WHISKERS]);
        scenario.behaviour.places = places;
        scenario.behaviour.touch_tests = vec![TouchTestKind::Wall];
        scenario.behaviour.contacts_per_second = 0.5;
        scenario.behaviour.contacts_per_message = 1;
        scenario.robots[0].events = vec![cut(2, 5000.0)];
        let mut world = World::new(&scenario, params);
        world.run_until_s(4000.0);
        let before = tests(&world);
        world.run_until_s(8000.0);
        (before, world)
    };
    let (before, world) = world_of(Places::Unknown, params());
    assert!(before.iter().all(|test| test.reason == TestReason::Schedule), "{before:?}");
    let whiskers: BTreeSet<usize> = before.iter().map(|test| test.whisker).collect();
    assert_eq!(whiskers.len(), WHISKERS, "{before:?}");
    assert_eq!(trimmed(&world), [2]);
    // A robot that states its places is not moved, nor is one whose operator wants no tests.
    assert_eq!(world_of(Places::Ratio, params()).0, []);
    let mut never = params();
    never.touch_tests.every_without_place = Micros(0);
    assert_eq!(world_of(Places::Unknown, never).0, []);
}

#[test]
fn each_whisker_is_tested_once_per_interval_and_the_limit_per_hour_holds() {
    for (per_hour, whole_intervals) in [(30, true), (5, false)] {
        let mut params = params();
        (params.touch_tests.every, params.touch_tests.per_hour) = (Micros::from_s(40.0), per_hour);
        let mut world = world(Places::Distance, params, Vec::new());
        world.run_until_s(110.0);
        let found = tests(&world);
        assert!(found.iter().all(|test| test.reason == TestReason::Schedule));
        let expected = if whole_intervals { 2 * WHISKERS } else { 5 };
        assert_eq!(found.len(), expected, "{per_hour} per hour: {found:#?}");
        for whisker in (0..WHISKERS).filter(|_| whole_intervals) {
            let times: Vec<Micros> =
                found.iter().filter(|test| test.whisker == whisker).map(|test| test.issued).collect();
            assert_eq!(times.len(), 2);
            assert!(times[1].since(times[0]) >= Micros::from_s(40.0));
        }
    }
}

#[test]
fn robots_that_know_the_present_length_and_held_whiskers_are_not_tested() {
    let mut params = params();
    params.touch_tests.every = Micros::from_s(20.0);
    let mut world = world(Places::Ratio, params.clone(), Vec::new());
    world.run_until_s(60.0);
    assert_eq!(tests(&world), []);

    let mut held = self::world(Places::Distance, params, Vec::new());
    held.run_until_s(5.0);
    assert_eq!(held.step(&Event::Operator(&OperatorAction::Hold(Scope::Whisker(place(2))))), Outcome::Taken);
    held.run_until_s(60.0);
    let whiskers: BTreeSet<usize> = tests(&held).iter().map(|test| test.whisker).collect();
    assert_eq!(whiskers, BTreeSet::from([0, 1, 3]));
}

#[test]
fn a_test_of_the_schedule_that_fails_is_not_repeated_before_the_next_interval() {
    let mut params = params();
    params.touch_tests.every = Micros::from_s(30.0);
    let mut world = world(Places::Distance, params, Vec::new());
    let mut now_s = 29.0;
    while world.core.tests_under_way().count() == 0 {
        now_s += 0.02;
        world.run_until_s(now_s);
        assert!(now_s < 40.0, "no test is requested");
    }
    let (test, whisker) = world.core.tests_under_way().next().unwrap();
    let boot_id = world.core.connection_state().0.unwrap().to_owned();
    let robot_time = Micros(world.robot.start_us() + (now_s * 1e6) as u64);
    let report = TestReport::Failed;
    assert_eq!(world.step(&Event::TouchTest { boot_id: &boot_id, test, report, robot_time }), Outcome::Taken);
    assert_eq!(last_states(&world)[&test], TestState::Failed);
    let of_it = |world: &World| tests(world).iter().filter(|test| test.whisker == whisker).count();
    world.run_until_s(now_s + 29.0);
    assert_eq!(of_it(&world), 1);
    world.run_until_s(now_s + 35.0);
    assert_eq!(of_it(&world), 2);
}

#[test]
fn in_mode_advise_a_test_is_proposed_once_and_an_operator_starts_it() {
    let mut params = params();
    params.policy.mode = Mode::Advise;
    let mut world = world(Places::Distance, params, vec![cut(1, 30.0)]);
    world.run_until_s(40.0);
    assert_eq!(tests(&world), [], "nobody has asked for a test");
    let proposed = proposals(&world);
    assert_eq!(proposed.iter().map(|one| (one.whisker, one.reason)).collect::<Vec<_>>(), [(1, TestReason::Suspicion)]);
    assert_eq!(world.core.whisker(1).unwrap().touch_test, Some((proposed[0].kind, TestState::Proposed)));
    assert_eq!(world.core.tests_under_way().count(), 0, "a robot cannot answer a proposal");

    assert_eq!(world.step(&Event::Operator(&OperatorAction::TouchTest(place(1)))), Outcome::Taken);
    let started = tests(&world);
    assert_eq!(started.iter().map(|one| (one.whisker, one.reason)).collect::<Vec<_>>(), [(1, TestReason::Suspicion)]);
    assert!(started[0].key > proposed[0].key, "robots refuse an older version");
    assert_eq!(last_states(&world)[&proposed[0].key], TestState::Withdrawn);
    world.run_until_s(50.0);
    assert_eq!(last_states(&world)[&started[0].key], TestState::Done);
    assert_eq!(trimmed(&world), [1], "the tests of a row follow each other");
    assert_eq!(proposals(&world).len(), 1);
}

#[test]
fn a_refused_test_is_not_proposed_again_without_new_evidence() {
    let mut params = params();
    params.policy.mode = Mode::Advise;
    let mut world = world(Places::Distance, params.clone(), vec![cut(1, 30.0)]);
    let refuse = |world: &mut World, whisker| {
        let place = place(whisker);
        world.step(&Event::Operator(&OperatorAction::RefuseTouchTest(place)))
    };
    assert_eq!(refuse(&mut world, 1), Outcome::Refused(ActionProblem::NoProposedTest));
    world.run_until_s(40.0);
    let key = proposals(&world)[0].key;
    assert_eq!(refuse(&mut world, 1), Outcome::Taken);
    assert_eq!(last_states(&world)[&key], TestState::Refused);
    assert_eq!(world.core.whisker(1).unwrap().touch_test, None);
    assert_eq!(refuse(&mut world, 1), Outcome::Refused(ActionProblem::NoProposedTest));
    // The silence goes on, and so does the suspicion. Another mode is no evidence.
    world.run_until_s(50.0);
    world.params.policy.mode = Mode::Automatic;
    world.step(&Event::PolicyChanged);
    world.run_until_s(60.0);
    assert_eq!((proposals(&world).len(), tests(&world).len()), (1, 0));
    assert_eq!(world.core.whisker(1).unwrap().condition, Condition::Suspected);
    // An operator may think otherwise, ...
    assert_eq!(world.step(&Event::Operator(&OperatorAction::TouchTest(place(1)))), Outcome::Taken);
    assert_eq!(tests(&world).len(), 1);
    world.run_until_s(80.0);
    assert_eq!(trimmed(&world), [1]);

    // ... and a touch that does not come is evidence.
    let mut world = self::world(Places::Distance, params, vec![cut(1, 30.0)]);
    world.run_until_s(40.0);
    assert_eq!(refuse(&mut world, 1), Outcome::Taken);
    let boot_id = world.core.connection_state().0.unwrap().to_owned();
    let robot_time = Micros(world.robot.start_us() + 40_000_000);
    let at = Distance { at: Millimetre::known(66.0), sd_mm: 0.5 };
    let array = crate::name("left");
    let missed = [MissedTouch { array: array.as_str(), whisker: 1, robot_time, at }];
    world.step(&Event::Contacts { boot_id: &boot_id, seq: 1_000_000, contacts: &[], missed: &missed });
    assert_eq!(proposals(&world).len(), 2);
}

#[test]
fn a_proposal_is_withdrawn_when_the_mode_changes_or_its_reason_is_gone() {
    let mut params = params();
    params.policy.mode = Mode::Advise;
    let mut world = world(Places::Distance, params, vec![cut(1, 30.0)]);
    world.run_until_s(40.0);
    let key = proposals(&world)[0].key;
    world.params.policy.mode = Mode::Automatic;
    world.step(&Event::PolicyChanged);
    world.run_until_s(45.0);
    assert_eq!(last_states(&world)[&key], TestState::Withdrawn);
    assert!(!tests(&world).is_empty());

    // A new whisker in its place gives no reason for a test.
    let mut params = self::params();
    params.policy.mode = Mode::Advise;
    let mut world = self::world(Places::Distance, params, vec![cut(1, 30.0)]);
    world.run_until_s(40.0);
    let key = proposals(&world)[0].key;
    world.step(&Event::Operator(&OperatorAction::Replaced(place(1))));
    assert_eq!(last_states(&world)[&key], TestState::Withdrawn);
    assert_eq!(tests(&world), []);
}

/// A cut is called from the first touches that do not come, while the robot goes on with the rest of the test.
#[test]
fn a_test_is_followed_to_its_end_after_its_measurement_has_ended() {
    let mut world = world(Places::Distance, params(), vec![cut(0, 30.0), cut(1, 31.0), cut(2, 32.0)]);
    world.run_until_s(60.0);
    assert_eq!(trimmed(&world).len(), 3);
    let called_first = world.effects.iter().any(|(_, effect)| {
        let Effect::Trim(trim) = effect else { return false };
        let called = world.effects.iter().position(|(_, one)| one == effect);
        let done = world.effects.iter().rposition(|(_, one)| {
            matches!(one, Effect::TestState { whisker: Some(of), state: TestState::Done, .. } if *of == trim.whisker)
        });
        called < done
    });
    assert!(called_first, "no cut was called before the end of its test");
    let states = last_states(&world);
    assert!(!states.is_empty() && states.values().all(|state| *state == TestState::Done), "{states:?}");
    assert_eq!(world.core.tests_under_way().count(), 0);
}
