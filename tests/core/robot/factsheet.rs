//! A factsheet follows a birth without a request; one without news changes nothing.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::{ArrayKind, ArraySheet, Factsheet, Link, Task, TouchTests, WhiskerSheet};
use vibrissa_core::robot::{Event, Numbers, Outcome, Params, Robot};
use vibrissa_core::units::{Megapascal, Micros, Millimetre};

const BOOT: &str = "b1";

fn factsheet() -> Factsheet {
    let whisker = WhiskerSheet {
        number: 0,
        x_mm: 0.0,
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length: Millimetre::known(70.0),
        pressure: Megapascal::known(0.0),
        pressure_max: Megapascal::known(0.2),
        length_tolerance_mm: 0.5,
        strain_max: None,
        neighbours: Vec::new(),
    };
    Factsheet {
        arrays: vec![ArraySheet {
            name: "a".to_owned(),
            kind: ArrayKind::Type1,
            task: Task::Ratio,
            whiskers: vec![whisker],
        }],
        touch_tests: TouchTests::default(),
        applies_gain: false,
        air_control: Default::default(),
    }
}

struct World {
    params: Params,
    robot: Robot,
}

impl World {
    fn new() -> Self {
        Self { params: Params::nguyen_2021(Formulation::default()), robot: Robot::new(1, Numbers::default()) }
    }

    /// Sends it an event at a time in seconds; returns whether it requests the factsheet.
    fn asks(&mut self, at_s: f64, event: &Event<'_>) -> bool {
        let mut effects = Vec::new();
        self.robot.step(&self.params, Micros((at_s * 1e6) as u64), event, &mut effects);
        effects.contains(&Effect::AskForFactsheet)
    }
}

#[test]
fn a_factsheet_is_asked_for_when_it_does_not_follow_its_birth() {
    let mut world = World::new();
    let contacts = Event::Contacts { boot_id: BOOT, seq: 0, contacts: &[], missed: &[] };
    assert!(!world.asks(10.0, &Event::Connection { boot_id: BOOT, link: Link::Online }), "it is on its way");
    assert!(!world.asks(10.1, &contacts));
    assert!(!world.asks(11.9, &Event::Tick));
    assert!(world.asks(12.1, &Event::Tick), "it has not come");
    assert!(!world.asks(30.0, &Event::Tick), "once: a robot that says nothing needs none");
    assert!(world.asks(30.1, &contacts), "contacts wait for it");
    assert!(!world.asks(31.0, &contacts));
    assert!(world.asks(32.2, &contacts));
    assert!(!world.asks(33.0, &Event::Factsheet { boot_id: BOOT, factsheet: &factsheet() }));
    assert!(!world.asks(33.1, &contacts));
}

#[test]
fn a_birth_with_its_factsheet_asks_for_nothing() {
    let mut world = World::new();
    world.asks(10.0, &Event::Connection { boot_id: BOOT, link: Link::Online });
    world.asks(10.0, &Event::Factsheet { boot_id: BOOT, factsheet: &factsheet() });
    for at_s in [10.25, 12.1, 14.3] {
        assert!(!world.asks(at_s, &Event::Tick));
    }
}

#[test]
fn a_factsheet_that_says_nothing_new_leaves_nothing_to_be_stored() {
    let mut world = World::new();
    world.asks(10.0, &Event::Connection { boot_id: BOOT, link: Link::Online });
    let event = Event::Factsheet { boot_id: BOOT, factsheet: &factsheet() };
    assert_eq!(world.robot.step(&world.params, Micros(10_000_000), &event, &mut Vec::new()), Outcome::Taken);
    world.robot.take_changed();
    world.robot.take_changed_whiskers(|_| {});
    assert_eq!(world.robot.step(&world.params, Micros(11_000_000), &event, &mut Vec::new()), Outcome::Duplicate);
    assert!(!world.robot.has_changed());
    // Another boot's numbers begin anew, and that is stored.
    world.asks(12.0, &Event::Connection { boot_id: "b2", link: Link::Online });
    let anew = Event::Factsheet { boot_id: "b2", factsheet: &factsheet() };
    assert_eq!(world.robot.step(&world.params, Micros(12_000_000), &anew, &mut Vec::new()), Outcome::Taken);
    assert!(world.robot.has_changed());
}

/// A factsheet whose length is within this, mm.
fn within(tolerance_mm: f64) -> Factsheet {
    let mut factsheet = factsheet();
    factsheet.arrays[0].whiskers[0].length_tolerance_mm = tolerance_mm;
    factsheet
}

#[test]
fn a_length_is_as_certain_as_its_factsheet_says_and_another_tolerance_changes_nothing_else() {
    for tolerance_mm in [0.2, 0.5, 2.0, 20.0] {
        let mut world = World::new();
        world.asks(10.0, &Event::Connection { boot_id: BOOT, link: Link::Online });
        world.asks(10.0, &Event::Factsheet { boot_id: BOOT, factsheet: &within(tolerance_mm) });
        let sd_mm = |robot: &Robot| robot.whisker(0).unwrap().length.sd_mm;
        assert!((1.96 * sd_mm(&world.robot) - tolerance_mm).abs() < 0.01 * tolerance_mm, "{tolerance_mm}");
        let relative = world.robot.whisker(0).unwrap().relative_length;
        assert!((relative.sd_mm - 0.1).abs() < 1e-6, "{relative:?}: no part of a loss");
        let mut effects = Vec::new();
        let other = Event::Factsheet { boot_id: BOOT, factsheet: &within(1.0) };
        let outcome = world.robot.step(&world.params, Micros(11_000_000), &other, &mut effects);
        assert_eq!(outcome, Outcome::Taken);
        assert!((1.96 * sd_mm(&world.robot) - 1.0).abs() < 0.01, "{tolerance_mm}");
        let is_anew = |effect: &Effect| matches!(effect, Effect::Condition { .. } | Effect::Gone { .. });
        assert!(!effects.iter().any(is_anew), "{effects:?}");
    }
}

/// With no tolerance the length counts as exact, except for what the program never takes for exact.
#[test]
fn a_tolerance_of_zero_leaves_the_least_uncertainty() {
    let mut world = World::new();
    world.asks(10.0, &Event::Connection { boot_id: BOOT, link: Link::Online });
    world.asks(10.0, &Event::Factsheet { boot_id: BOOT, factsheet: &within(0.0) });
    let length = world.robot.whisker(0).unwrap().length;
    assert!((length.sd_mm - 0.1).abs() < 1e-6, "{length:?}");
}
