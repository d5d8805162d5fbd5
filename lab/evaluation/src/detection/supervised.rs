//! One whisker supervised by the core: takes contacts, returns verdicts.

use vibrissa_core::robot::effect::{Condition, Effect};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, ContactPlace, Factsheet, Link, Task, TouchTests, WhiskerSheet,
};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{Megapascal, Micros, Millimetre, Strain};

use super::Plan;
use super::plant::{PRESSURE_MPA, Touch, WHOLE_MM};

const BOOT: &str = "b";
const ARRAY: &str = "a";
/// Time between two contacts, in microseconds.
const CONTACT_US: u64 = 20_000;

/// One whisker and the core's state.
pub(super) struct Supervised {
    params: Params,
    robot: Robot,
    effects: Vec<Effect>,
    contacts: u64,
}

/// The core's reaction to one contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct Said {
    /// A change is suspected.
    pub alarm: bool,
    /// A verdict: trimmed, eroding or loss of sensitivity.
    pub called: bool,
    /// Length and its standard deviation after a trim, mm.
    pub trim: Option<(f64, f64)>,
    /// The standardised innovation squared, at most 9; 0 while learning.
    pub square: f64,
}

impl Supervised {
    pub(super) fn new(plan: &Plan) -> Self {
        let mut params = Params::nguyen_2021(plan.model.formulation());
        for (_, model) in &mut params.models {
            model.clone_from(&plan.model);
        }
        params.detection.contacts_between_false_alarms = plan.contacts_between_false_alarms;
        // Only the strain's relative noise is configured, at 2 %, far below the true noise: its size must be
        // learned.
        params.noise.strain_floor = 5e-6;
        params.noise.ratio = 0.0;
        params.noise.deflection_relative = 0.0;
        let mut one = Self { params, robot: Robot::new(1, Numbers::default()), effects: Vec::new(), contacts: 0 };
        one.step(&Event::Connection { boot_id: BOOT, link: Link::Online });
        let pressure = Megapascal::known(PRESSURE_MPA);
        let sheet = WhiskerSheet {
            number: 0,
            x_mm: 0.0,
            y_mm: 0.0,
            model: "nguyen-2021".to_owned(),
            length: Millimetre::known(WHOLE_MM),
            pressure,
            pressure_max: Megapascal::EXAMINED_MAX,
            // The simulated whiskers are exactly as long.
            length_tolerance_mm: 0.0,
            strain_max: None,
            neighbours: Vec::new(),
        };
        let array =
            ArraySheet { name: ARRAY.to_owned(), kind: ArrayKind::Type2, task: Task::Ratio, whiskers: vec![sheet] };
        one.step(&Event::Factsheet {
            boot_id: BOOT,
            factsheet: &Factsheet {
                arrays: vec![array],
                touch_tests: TouchTests::default(),
                applies_gain: false,
                air_control: Default::default(),
            },
        });
        one
    }

    fn step(&mut self, event: &Event<'_>) {
        self.effects.clear();
        self.robot.step(&self.params, Micros(CONTACT_US * self.contacts), event, &mut self.effects);
    }

    pub(super) fn feel(&mut self, touch: &Touch) -> Said {
        let contact = Contact {
            array: ARRAY,
            whisker: 0,
            robot_time: Micros(CONTACT_US * self.contacts),
            place: ContactPlace::Ratio { ratio: touch.ratio, sd: None },
            deflection: Millimetre::known(touch.deflection_mm),
            strain: Strain::known(touch.strain),
            pressure: Megapascal::known(PRESSURE_MPA),
            is_test: false,
            angle_is_stated: false,
            saturated: false,
            temperature_c: None,
        };
        let seq = self.contacts;
        self.contacts += 1;
        self.step(&Event::Contacts { boot_id: BOOT, seq, contacts: &[contact], missed: &[] });
        self.heard()
    }

    fn heard(&self) -> Said {
        let mut said = Said { alarm: false, called: false, trim: None, square: 0.0 };
        let watching = self.is_watching();
        for effect in &self.effects {
            if let Effect::Condition { to, .. } = effect {
                said.alarm |= *to == Condition::Suspected;
                said.called |= matches!(to, Condition::Trimmed | Condition::Eroding | Condition::SensitivityLoss);
            }
            if let Effect::Trim(trim) = effect {
                said.trim = Some((trim.length_after.length.mm(), trim.length_after.sd_mm));
            }
            if let Effect::Contact(contact) = effect {
                said.square = contact.standardised.filter(|_| watching).map_or(0.0, |one| one.powi(2).min(9.0));
            }
        }
        said
    }

    /// Whether the cold start is over.
    pub(super) fn is_watching(&self) -> bool {
        self.condition() != Some(Condition::Learning)
    }

    /// Whether the cold start is over and no change is suspected.
    pub(super) fn is_calm(&self) -> bool {
        self.condition() == Some(Condition::Healthy)
    }

    fn condition(&self) -> Option<Condition> {
        self.robot.whisker(0).map(|view| view.condition)
    }
}
