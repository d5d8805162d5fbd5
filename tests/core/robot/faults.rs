//! Faults that are no trims have their own names, and are not called trims.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{AlarmKind, Condition, Effect, Fault};
use vibrissa_core::robot::event::GaugeState;
use vibrissa_core::robot::{Event as CoreEvent, Params};
use vibrissa_evaluation::World;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::scenario::{Change, Event};

const AT_CONTACT: u64 = 400;

/// Result for the one of two whiskers that has the fault, and for the other.
fn world_with(change: Change, seconds: f64) -> World {
    world_after(&[(AT_CONTACT, change)], seconds, true)
}

/// The same after several changes; `notices`: the robot says so itself.
fn world_after(changes: &[(u64, Change)], seconds: f64, notices: bool) -> World {
    let mut scenario = super::scenario(31, ArrayType::Type2, &[70.0, 70.0]);
    scenario.behaviour.notices_faults = notices;
    let at = |&(contact, change): &(u64, Change)| Event::at_contact(contact, super::name("left"), 0, change);
    scenario.robots[0].events.extend(changes.iter().map(at));
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
fn a_gauge_fault_that_only_the_contacts_show_has_its_name_and_ends_with_the_fault() {
    for (change, expected) in [
        (Change::GaugeOpen, GaugeState::Open),
        (Change::GaugeShort, GaugeState::Short),
        (Change::GaugeSaturated { limit_strain: 0.003 }, GaugeState::Saturated),
        // Which one contact in twelve reaches.
        (Change::GaugeSaturated { limit_strain: 0.015 }, GaugeState::Saturated),
    ] {
        let world = world_after(&[(AT_CONTACT, change)], 20.0, false);
        assert_fault(&world, Fault::Gauge(expected));
        assert_eq!(world.core.whisker(0).unwrap().fault, Some(Fault::Gauge(expected)));
        let mended = world_after(&[(AT_CONTACT, change), (AT_CONTACT + 300, Change::GaugeOk)], 20.0, false);
        assert_fault(&mended, Fault::Gauge(expected));
        assert_eq!(mended.core.whisker(0).unwrap().fault, None, "{change:?} is over");
    }
}

#[test]
fn a_cut_after_a_gauge_was_mended_is_still_a_trim() {
    let changes = [
        (AT_CONTACT, Change::GaugeSaturated { limit_strain: 0.005 }),
        (AT_CONTACT + 200, Change::GaugeOk),
        (AT_CONTACT + 400, Change::Trim { length_mm: 60.0 }),
    ];
    let world = world_after(&changes, 24.0, false);
    let trims = world.picked(|effect| if let Effect::Trim(trim) = effect { Some(trim.whisker) } else { None });
    assert_eq!(trims, [0]);
}

#[test]
fn a_leak_that_the_robot_does_not_notice_is_a_leak_and_over_when_it_is() {
    let changes = [
        (AT_CONTACT, Change::Leak { rate_mpa_per_s: 0.002 }),
        (AT_CONTACT + 2500, Change::Leak { rate_mpa_per_s: 0.0 }),
    ];
    let world = world_after(&changes, 60.0, false);
    assert_fault(&world, Fault::Leak);
    assert_eq!(world.core.whisker(0).unwrap().fault, Some(Fault::Leak));
    let mended = world_after(&changes, 60.0 + 900.0, false);
    assert_eq!(mended.core.whisker(0).unwrap().fault, None);
    let rate = mended.core.whisker(0).unwrap().leak_per_s.expect("stated");
    assert!(rate.low < 1e-4 && rate.mean < 1e-4, "{rate:?}");
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
