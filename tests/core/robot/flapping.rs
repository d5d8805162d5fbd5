//! A robot whose faults or connection flap causes few effects: one alarm for each whisker, a few changes, few decisions.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{AlarmKind, Effect, Fault};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Factsheet, GaugeState, Link, RegulatorState, Task, TouchTests, WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{Megapascal, Micros, Millimetre};

const START: Micros = Micros(1_795_260_000_000_000);
const OK: (RegulatorState, GaugeState) = (RegulatorState::Ok, GaugeState::Ok);
const LEAK: (RegulatorState, GaugeState) = (RegulatorState::Leak, GaugeState::Ok);
const WHISKERS: u16 = 60;

struct Plant {
    robot: Robot,
    params: Params,
    now: Micros,
    effects: Vec<Effect>,
}

impl Plant {
    fn new() -> Self {
        let sheet = |number| WhiskerSheet {
            number,
            x_mm: 0.0,
            y_mm: 0.0,
            model: "nguyen-2021".to_owned(),
            length: Millimetre::new(70.0).unwrap(),
            pressure: Megapascal::known(0.1),
            pressure_max: Megapascal::known(0.2),
            length_tolerance_mm: 0.5,
            strain_max: None,
            neighbours: Vec::new(),
        };
        let whiskers = (0..WHISKERS).map(sheet).collect();
        let array = ArraySheet { name: "left".to_owned(), kind: ArrayKind::Type2, task: Task::Ratio, whiskers };
        let factsheet = Factsheet {
            arrays: vec![array],
            touch_tests: TouchTests::default(),
            applies_gain: false,
            air_control: Default::default(),
        };
        let params = Params::nguyen_2021(Formulation::Published);
        let mut plant = Self { robot: Robot::new(1, Numbers::default()), params, now: START, effects: Vec::new() };
        plant.connection(Link::Online);
        plant.step(&Event::Factsheet { boot_id: "b", factsheet: &factsheet });
        plant
    }

    fn step(&mut self, event: &Event<'_>) {
        self.robot.step(&self.params, self.now, event, &mut self.effects);
    }

    fn connection(&mut self, link: Link) {
        self.step(&Event::Connection { boot_id: "b", link });
    }

    /// One status of all whiskers; ticks follow for `seconds`.
    fn status(&mut self, state: (RegulatorState, GaugeState), seconds: f64) {
        self.status_of(state, 0.1, seconds);
    }

    /// One status of sound whiskers that hold `pressure_mpa`.
    fn status_at(&mut self, pressure_mpa: f64, seconds: f64) {
        self.status_of(OK, pressure_mpa, seconds);
    }

    fn status_of(&mut self, (regulator, gauge): (RegulatorState, GaugeState), pressure_mpa: f64, seconds: f64) {
        let pressure = Megapascal::known(pressure_mpa);
        let status = |whisker| WhiskerStatus { array: "left", whisker, pressure, setpoint: pressure, regulator, gauge };
        let whiskers: Vec<_> = (0..WHISKERS).map(status).collect();
        self.step(&Event::Status { boot_id: "b", robot_time: self.now, whiskers: &whiskers });
        let end = self.now.after(Micros::from_s(seconds));
        while self.now < end {
            self.now = end.min(self.now.after(Micros::from_s(0.5)));
            self.step(&Event::Tick);
        }
    }

    fn count(&self, is_counted: impl Fn(&Effect) -> bool) -> usize {
        self.effects.iter().filter(|effect| is_counted(effect)).count()
    }

    fn raised(&self, kind: AlarmKind) -> usize {
        self.count(|effect| matches!(effect, Effect::Alarm { kind: raised, .. } if *raised == kind))
    }

    fn of_faults(&self) -> usize {
        self.count(|effect| matches!(effect, Effect::Alarm { kind: AlarmKind::Fault(_), .. }))
    }

    fn changes(&self) -> usize {
        self.count(|effect| matches!(effect, Effect::Fault { .. }))
    }
}

#[test]
fn regress_a_status_that_says_leak_and_ok_in_turns_is_one_alarm_for_each_whisker() {
    let all = usize::from(WHISKERS);
    for pause_s in [0.3, 2.0, 10.0] {
        let mut plant = Plant::new();
        for _ in 0..(600.0 / pause_s) as usize / 2 {
            plant.status(LEAK, pause_s);
            plant.status(OK, pause_s);
        }
        assert_eq!(plant.raised(AlarmKind::Fault(Fault::Leak)), all, "every {pause_s} s");
        assert!(plant.changes() <= 6 * all, "every {pause_s} s: {} changes", plant.changes());
        // Nothing is new any more: the alarm stands, and the whisker is faulty.
        let known = plant.effects.len();
        plant.status(LEAK, 1.0);
        plant.status(OK, 1.0);
        assert_eq!(plant.effects.len(), known, "{:?}", &plant.effects[known..]);
        assert!((0..all).all(|index| plant.robot.whisker(index).unwrap().fault == Some(Fault::Leak)));
        // Over once the robot has reported no fault for ten minutes.
        for _ in 0..70 {
            plant.status(OK, 10.0);
        }
        let cleared = plant.count(|effect| matches!(effect, Effect::AlarmCleared { .. }));
        assert_eq!((cleared, plant.robot.whisker(0).unwrap().fault), (all, None));
    }
}

#[test]
fn regress_all_states_in_turns_are_few_alarms() {
    let gauge = |state| (RegulatorState::Ok, state);
    let regulator = |state| (state, GaugeState::Ok);
    let all = [
        regulator(RegulatorState::Leak),
        gauge(GaugeState::Open),
        OK,
        regulator(RegulatorState::SupplyLow),
        gauge(GaugeState::Short),
        regulator(RegulatorState::Fault),
    ];
    let mut plant = Plant::new();
    for _ in 0..200 {
        for state in all {
            plant.status(state, 0.5);
        }
    }
    let whiskers = usize::from(WHISKERS);
    assert!(plant.of_faults() <= 3 * whiskers, "{} alarms", plant.of_faults());
    assert!(plant.changes() <= 7 * whiskers, "{} changes", plant.changes());
}

#[test]
fn regress_a_connection_that_flaps_does_not_repeat_the_alarms_of_whiskers() {
    let mut plant = Plant::new();
    plant.status(LEAK, 5.0);
    for _ in 0..50 {
        plant.connection(Link::Broken);
        plant.status(LEAK, 1.0);
        plant.connection(Link::Online);
        plant.status(LEAK, 1.0);
    }
    assert_eq!(plant.of_faults(), usize::from(WHISKERS));
    assert!(plant.count(|effect| matches!(effect, Effect::AlarmCleared { .. })) == 0);
}

#[test]
fn a_flapping_fault_goes_on_as_it_was_after_a_restart() {
    let mut plant = Plant::new();
    for at in 0..40 {
        let state = if at % 2 == 0 { LEAK } else { OK };
        plant.status(state, 0.7);
        let (head, whiskers) = (plant.robot.to_bytes().unwrap(), 0..usize::from(WHISKERS));
        let whiskers: Vec<_> = whiskers.map(|index| plant.robot.whisker_to_bytes(index).unwrap()).collect();
        // The restored robot goes on in place of the other.
        let restored = Robot::restore(&head, &whiskers).unwrap();
        assert_eq!(restored.to_bytes().unwrap(), head, "after {at} statuses");
        let again =
            (0..usize::from(WHISKERS)).all(|index| restored.whisker_to_bytes(index).unwrap() == whiskers[index]);
        assert!(again, "after {at} statuses");
        plant.robot = restored;
    }
    let whiskers = usize::from(WHISKERS);
    assert_eq!(plant.raised(AlarmKind::Fault(Fault::Leak)), whiskers);
    assert!(plant.changes() <= 6 * whiskers, "{} changes", plant.changes());
}

#[test]
fn regress_a_setpoint_that_is_nominal_and_0_in_turns_is_one_alarm_for_each_whisker() {
    let all = usize::from(WHISKERS);
    for pause_s in [0.3, 2.0, 10.0] {
        let mut plant = Plant::new();
        // A robot that vents within a minute of its birth is filled again.
        for _ in 0..7 {
            plant.status(OK, 10.0);
        }
        for _ in 0..(600.0 / pause_s) as usize / 2 {
            plant.status_at(0.0, pause_s);
            plant.status_at(0.1, pause_s);
        }
        assert_eq!(plant.raised(AlarmKind::Vented), all, "every {pause_s} s");
        let known = plant.effects.len();
        plant.status_at(0.0, 1.0);
        plant.status_at(0.1, 1.0);
        assert_eq!(plant.effects.len(), known, "{:?}", &plant.effects[known..]);
        // Over once the robot has held the pressure for ten minutes.
        for _ in 0..70 {
            plant.status(OK, 10.0);
        }
        assert_eq!(plant.count(|effect| matches!(effect, Effect::AlarmCleared { kind: AlarmKind::Vented, .. })), all);
    }
}

#[test]
fn a_lasting_vent_is_one_alarm_that_ends_after_the_off_delay() {
    let mut plant = Plant::new();
    for _ in 0..7 {
        plant.status(OK, 10.0);
    }
    let all = usize::from(WHISKERS);
    plant.status_at(0.0, 2.0);
    assert_eq!(plant.raised(AlarmKind::Vented), all);
    plant.status_at(0.0, 9000.0);
    assert_eq!(plant.raised(AlarmKind::Vented), all);
    let cleared = |plant: &Plant| plant.count(|effect| matches!(effect, Effect::AlarmCleared { .. }));
    let known = cleared(&plant);
    plant.status_at(0.1, 10.0);
    assert_eq!(cleared(&plant), known);
    plant.status_at(0.1, 10.0);
    assert!(plant.count(|one| matches!(one, Effect::AlarmCleared { kind: AlarmKind::Vented, .. })) == all);
}
