//! What is not trimming has its own name, and is called no trim.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{AlarmKind, Condition, Effect, Fault};
use vibrissa_core::robot::event::GaugeState;
use vibrissa_core::robot::{Event as CoreEvent, Params};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event};

const AT_CONTACT: u64 = 400;

/// What becomes of one of two whiskers to which this happens, and of the other.
fn world_with(change: Change, seconds: f64) -> World {
    let mut scenario = super::scenario(31, ArrayType::Type2, &[70.0, 70.0]);
    scenario.robots[0].events.push(Event::at_contact(AT_CONTACT, super::name("left"), 0, change));
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(seconds);
    world
}

fn assert_fault(world: &World, expected: Fault) {
    let faults = world.picked(|effect| match effect {
        Effect::Fault { whisker, to, .. } => Some((*whisker, *to)),
        _ => None,
    });
    assert!(faults.contains(&(0, Some(expected))), "{expected:?} expected: {faults:?}");
    assert!(faults.iter().all(|(whisker, _)| *whisker == 0), "the other whisker has none: {faults:?}");
    let alarm = AlarmKind::Fault(expected);
    let alarms = world.picked(|effect| matches!(effect, Effect::Alarm { kind, .. } if *kind == alarm).then_some(()));
    assert!(!alarms.is_empty(), "people are told");
    let trims = world.picked(|effect| matches!(effect, Effect::Trim(_)).then_some(()));
    assert!(trims.is_empty(), "no trim: {:#?}", world.effects);
    for index in 0..2 {
        let condition = world.core.whisker(index).unwrap().condition;
        assert!(matches!(condition, Condition::Healthy | Condition::Suspected), "{condition:?}");
    }
}

#[test]
fn an_open_gauge_is_a_gauge_fault() {
    assert_fault(&world_with(Change::GaugeOpen, 20.0), Fault::Gauge(GaugeState::Open));
}

#[test]
fn a_shorted_gauge_is_a_gauge_fault() {
    assert_fault(&world_with(Change::GaugeShort, 20.0), Fault::Gauge(GaugeState::Short));
}

#[test]
fn a_saturated_gauge_is_a_gauge_fault() {
    let change = Change::GaugeSaturated { limit_strain: 0.01 };
    assert_fault(&world_with(change, 20.0), Fault::Gauge(GaugeState::Saturated));
}

#[test]
fn a_chamber_that_cannot_be_held_is_a_leak() {
    assert_fault(&world_with(Change::Leak { rate_mpa_per_s: 0.2 }, 30.0), Fault::Leak);
}

#[test]
fn a_whisker_of_which_nothing_is_heard_is_stale_and_back_when_it_is() {
    let scenario = super::scenario(32, ArrayType::Type2, &[70.0]);
    let mut world = World::new(&scenario, Params::nguyen_2021(Formulation::Published));
    world.run_until_s(10.0);
    world.silent_for_s(20.0);
    let stale = |world: &World| world.core.whisker(0).unwrap().fault;
    assert_eq!(stale(&world), Some(Fault::Stale));
    world.run_until_s(31.0);
    assert_eq!(stale(&world), None);
    world.step(&CoreEvent::Tick);
    assert_eq!(world.core.whisker(0).unwrap().condition, Condition::Healthy);
}
