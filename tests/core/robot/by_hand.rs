//! A robot whose every message, and when it comes, a test chooses.

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{Command, CommandState, Effect};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, ContactPlace, Factsheet, GaugeState, Link, RegulatorState, Task, TouchTests,
    WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, OperatorAction, Outcome, Params, Place, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

pub(crate) const ARRAY: &str = "left";
pub(crate) const S: u64 = 1_000_000;
pub(crate) const YEAR_US: i64 = 365 * 86_400 * 1_000_000;

/// A robot with one whisker, its supervisor's clock, and the effects so far.
pub(crate) struct ByHand {
    pub(crate) robot: Robot,
    pub(crate) params: Params,
    pub(crate) now: Micros,
    pub(crate) effects: Vec<Effect>,
    boot_id: String,
    seq: u64,
    /// Whether contacts are at the end of the gauge's range.
    pub(crate) saturated: bool,
    /// Nominal and highest pressure of its factsheet, MPa.
    pub(crate) pressures_mpa: [f64; 2],
}

impl ByHand {
    /// Born, with its factsheet; its whisker has this length.
    pub(crate) fn born(length_mm: f64) -> Self {
        let mut one = Self {
            robot: Robot::new(1, Numbers::default()),
            params: Params::nguyen_2021(Formulation::Published),
            now: Micros(1_795_248_000 * S),
            effects: Vec::new(),
            boot_id: String::new(),
            seq: 0,
            saturated: false,
            pressures_mpa: [0.1, 0.2],
        };
        assert_eq!(one.boots("b1", length_mm), [Outcome::Taken; 2]);
        one
    }

    /// A birth and a factsheet.
    pub(crate) fn boots(&mut self, boot_id: &str, length_mm: f64) -> [Outcome; 2] {
        let sheet = WhiskerSheet {
            number: 0,
            x_mm: 0.0,
            y_mm: 0.0,
            model: "nguyen-2021".to_owned(),
            length: Millimetre::known(length_mm),
            pressure: Megapascal::known(self.pressures_mpa[0]),
            pressure_max: Megapascal::known(self.pressures_mpa[1]),
            length_tolerance_mm: 0.5,
            strain_max: None,
            neighbours: Vec::new(),
        };
        let array =
            ArraySheet { name: ARRAY.to_owned(), kind: ArrayKind::Type2, task: Task::Ratio, whiskers: vec![sheet] };
        let factsheet = Factsheet {
            arrays: vec![array],
            touch_tests: TouchTests::default(),
            applies_gain: false,
            air_control: Default::default(),
        };
        let born = self.step(&Event::Connection { boot_id, link: Link::Online });
        let after_factsheet = self.step(&Event::Factsheet { boot_id, factsheet: &factsheet });
        if born == Outcome::Taken {
            (self.boot_id, self.seq) = (boot_id.to_owned(), 0);
        }
        [born, after_factsheet]
    }

    pub(crate) fn step(&mut self, event: &Event<'_>) -> Outcome {
        self.robot.step(&self.params, self.now, event, &mut self.effects)
    }

    pub(crate) fn passes_s(&mut self, seconds: f64) {
        self.now = self.now.after(Micros::from_s(seconds));
    }

    /// Lets time pass without messages from the robot, with four ticks a second.
    pub(crate) fn silent_for_s(&mut self, seconds: f64) {
        for _ in 0..(4.0 * seconds) as usize {
            self.passes_s(0.25);
            self.step(&Event::Tick);
        }
    }

    /// The robot's time by a clock that is ahead by this.
    pub(crate) fn time(&self, ahead_us: i64) -> Micros {
        Micros(self.now.0.saturating_add_signed(ahead_us))
    }

    /// A status with everything in order.
    pub(crate) fn status(&mut self, ahead_us: i64) -> Outcome {
        self.status_at(0.1, ahead_us)
    }

    /// The same at a pressure of the chamber.
    pub(crate) fn status_at(&mut self, pressure_mpa: f64, ahead_us: i64) -> Outcome {
        let pressure = Megapascal::known(pressure_mpa);
        let status = WhiskerStatus {
            array: ARRAY,
            whisker: 0,
            pressure,
            setpoint: pressure,
            regulator: RegulatorState::Ok,
            gauge: GaugeState::Ok,
        };
        let (boot_id, robot_time) = (self.boot_id.clone(), self.time(ahead_us));
        self.step(&Event::Status { boot_id: &boot_id, robot_time, whiskers: &[status] })
    }

    /// A contacts message, each contact with (contact ratio, deflection in mm, strain) and how far its time is ahead.
    pub(crate) fn touched(&mut self, contacts: &[((f64, f64, f64), i64)]) -> Outcome {
        self.touched_at(0.1, contacts)
    }

    /// The same at a pressure of the chamber.
    pub(crate) fn touched_at(&mut self, pressure_mpa: f64, contacts: &[((f64, f64, f64), i64)]) -> Outcome {
        let contact = |&((ratio, deflection_mm, strain), ahead_us): &((f64, f64, f64), i64)| Contact {
            array: ARRAY,
            whisker: 0,
            robot_time: self.time(ahead_us),
            place: ContactPlace::Ratio { ratio: ContactRatio::new(ratio).unwrap(), sd: None },
            deflection: Millimetre::new(deflection_mm).unwrap(),
            strain: Strain::new(strain).unwrap(),
            pressure: Megapascal::known(pressure_mpa),
            is_test: false,
            angle_is_stated: false,
            saturated: self.saturated,
            temperature_c: None,
        };
        let contacts: Vec<Contact<'_>> = contacts.iter().map(contact).collect();
        let (boot_id, seq) = (self.boot_id.clone(), self.seq);
        self.seq += 1;
        self.step(&Event::Contacts { boot_id: &boot_id, seq, contacts: &contacts, missed: &[] })
    }

    /// An operator asks for a pressure; the setpoint that goes out at once, if one does.
    pub(crate) fn asked_for(&mut self, pressure_mpa: f64) -> Option<Command> {
        let before = self.effects.len();
        let whisker = Place { array: ARRAY, whisker: 0 };
        self.step(&Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa }));
        self.step(&Event::Tick);
        self.commands_from(before).pop()
    }

    /// The new setpoints among the effects from a place on.
    pub(crate) fn commands_from(&self, place: usize) -> Vec<Command> {
        let command = |effect: &Effect| if let Effect::Command(one) = effect { Some((**one).clone()) } else { None };
        self.effects[place..].iter().filter_map(command).collect()
    }

    /// When a setpoint that was sent before was sent again or given up: `Some` for a state, none for once more.
    pub(crate) fn fates_from(&self, place: usize) -> Vec<Option<CommandState>> {
        let fate = |effect: &Effect| match effect {
            Effect::Resend(_) => Some(None),
            Effect::CommandState { state, .. } => Some(Some(*state)),
            _ => None,
        };
        self.effects[place..].iter().filter_map(fate).collect()
    }

    pub(crate) fn bad_times(&self) -> usize {
        self.effects.iter().filter(|effect| matches!(effect, Effect::BadTime { .. })).count()
    }
}
