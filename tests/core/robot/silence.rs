//! One alarm per silent robot: whiskers have an alarm for silence only while their robot is heard.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{AlarmKind, Effect, Fault};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Factsheet, GaugeState, Link, RegulatorState, Task, TouchTests, WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{Megapascal, Micros, Millimetre};

const START: Micros = Micros(1_795_260_000_000_000);
const STALE: AlarmKind = AlarmKind::Fault(Fault::Stale);

/// A robot with some whiskers, and the time.
struct Plant {
    robot: Robot,
    params: Params,
    now: Micros,
    whiskers: u16,
}

impl Plant {
    fn new(whiskers: u16) -> Self {
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
        let whisker_sheets = (0..whiskers).map(sheet).collect();
        let array =
            ArraySheet { name: "left".to_owned(), kind: ArrayKind::Type2, task: Task::Ratio, whiskers: whisker_sheets };
        let factsheet = Factsheet {
            arrays: vec![array],
            touch_tests: TouchTests::default(),
            applies_gain: false,
            air_control: Default::default(),
        };
        let params = Params::nguyen_2021(Formulation::Published);
        let mut plant = Self { robot: Robot::new(1, Numbers::default()), params, now: START, whiskers };
        plant.step(&Event::Connection { boot_id: "b", link: Link::Online });
        plant.step(&Event::Factsheet { boot_id: "b", factsheet: &factsheet });
        plant
    }

    /// The alarms that an event raises (true) and clears, each with its whisker.
    fn step(&mut self, event: &Event<'_>) -> Vec<(bool, Option<usize>, AlarmKind)> {
        let mut effects = Vec::new();
        self.robot.step(&self.params, self.now, event, &mut effects);
        #[expect(clippy::wildcard_enum_match_arm, reason = "only alarms matter")]
        let changes = effects.iter().filter_map(|effect| match effect {
            Effect::Alarm { whisker, kind } => Some((true, Some(*whisker), *kind)),
            Effect::AlarmCleared { whisker, kind } => Some((false, Some(*whisker), *kind)),
            Effect::RobotAlarm { kind } => Some((true, None, *kind)),
            Effect::RobotAlarmCleared { kind } => Some((false, None, *kind)),
            _ => None,
        });
        changes.collect()
    }

    /// For some seconds the robot reports these whiskers each second.
    fn reports(&mut self, seconds: u64, heard: &[u16]) -> Vec<(bool, Option<usize>, AlarmKind)> {
        let mut changes = Vec::new();
        for _ in 0..seconds {
            self.now = Micros(self.now.0 + 1_000_000);
            let pressure = Megapascal::known(0.1);
            let (regulator, gauge) = (RegulatorState::Ok, GaugeState::Ok);
            let status =
                |&whisker| WhiskerStatus { array: "left", whisker, pressure, setpoint: pressure, regulator, gauge };
            let whiskers: Vec<_> = heard.iter().map(status).collect();
            if !heard.is_empty() {
                changes.extend(self.step(&Event::Status { boot_id: "b", robot_time: self.now, whiskers: &whiskers }));
            }
            changes.extend(self.step(&Event::Tick));
        }
        changes
    }

    fn all(&self) -> Vec<u16> {
        (0..self.whiskers).collect()
    }
}

#[test]
fn a_silent_robot_has_one_alarm_whatever_the_order_in_which_its_whiskers_fell_silent() {
    let mut plant = Plant::new(24);
    assert_eq!(plant.reports(30, &plant.all()), []);
    // Its last contacts name a few whiskers only.
    assert_eq!(plant.reports(5, &[3, 4]), []);
    assert_eq!(plant.reports(60, &[]), [(true, None, AlarmKind::RobotSilent)]);
    assert!((0..24).all(|index| plant.robot.whisker(index).unwrap().fault == Some(Fault::Stale)));
    assert_eq!(plant.robot.standing().collect::<Vec<_>>(), [AlarmKind::RobotSilent]);
    // Its first message afterwards names one whisker only, and the next ones all.
    assert_eq!(plant.reports(1, &[7]), [(false, None, AlarmKind::RobotSilent)]);
    assert_eq!(plant.reports(30, &plant.all()), []);
}

#[test]
fn a_robot_that_is_not_connected_has_one_alarm_until_it_is_heard() {
    for link in [Link::Offline, Link::Broken] {
        let mut plant = Plant::new(3);
        plant.reports(5, &plant.all());
        assert_eq!(plant.step(&Event::Connection { boot_id: "b", link }), [(true, None, AlarmKind::RobotSilent)]);
        assert_eq!(plant.reports(60, &[]), []);
        plant.step(&Event::Connection { boot_id: "b", link: Link::Online });
        let cleared = [(false, None, AlarmKind::RobotSilent)];
        assert_eq!(plant.reports(5, &plant.all()), cleared);
    }
}

#[test]
fn a_whisker_that_is_silent_alone_has_its_own_alarm_until_its_robot_is_silent_too() {
    let mut plant = Plant::new(3);
    plant.reports(5, &plant.all());
    assert_eq!(plant.reports(60, &[0, 2]), [(true, Some(1), STALE)]);
    let silent = plant.reports(60, &[]);
    assert_eq!(silent, [(true, None, AlarmKind::RobotSilent), (false, Some(1), STALE)]);
    // The robot is back without the whisker.
    let back = plant.reports(60, &[0, 2]);
    assert_eq!(back, [(false, None, AlarmKind::RobotSilent), (true, Some(1), STALE)]);
    assert_eq!(plant.reports(5, &plant.all()), [(false, Some(1), STALE)]);
}

#[test]
fn alarms_that_an_older_version_raised_for_each_whisker_of_a_silent_robot_become_one() {
    let silent_alone = |silent: u16| {
        let mut plant = Plant::new(2);
        plant.reports(5, &plant.all());
        assert_eq!(plant.reports(60, &[1 - silent]), [(true, Some(silent.into()), STALE)]);
        plant
    };
    let mut plant = silent_alone(0);
    // Version 7 ended before the alarm for silence, the end of the last silence, the watch for a second robot, gains, air, places
    // and readings that do not fit.
    let mut head = plant.robot.to_bytes().unwrap();
    head.truncate(head.len() - 30);
    head[0] = 7;
    let whiskers = [0, 1].map(|index| silent_alone(index as u16).robot.whisker_to_bytes(index).unwrap());
    plant.robot = Robot::restore(&head, &whiskers).unwrap();
    let mut changes = plant.step(&Event::Tick);
    changes.sort_by_key(|(_, whisker, _)| *whisker);
    assert_eq!(
        changes,
        [(true, None, AlarmKind::RobotSilent), (false, Some(0), STALE), (false, Some(1), STALE)],
        "at the first step"
    );
    let cleared = [(false, None, AlarmKind::RobotSilent)];
    assert_eq!(plant.reports(30, &plant.all()), cleared);
}
