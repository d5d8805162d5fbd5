//! One large array in the state of the core, built from contacts that follow the model. It requires one decision over
//! the whole array.

use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::robot::effect::{Condition, Effect};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, ContactPlace, Factsheet, GaugeState, Link, RegulatorState, Task, TouchTests,
    WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

const ARRAY: &str = "large";
const BOOT: &str = "b";
/// Number of whiskers in a row.
const COLUMNS: usize = 40;
/// Number of contacts in which a whisker's baseline is learned, and then again in which its cut is detected.
const CONTACTS: usize = 60;

/// An array of whiskers of 66 and 70 mm in rows of 40. The eight whiskers around each one are its neighbours.
#[derive(Debug, Clone)]
pub struct LargeArray {
    /// State of the core: some whiskers are trimmed, and all regulators are faulty, so no compensator is available.
    pub robot: Robot,
    /// Parameters of the core.
    pub params: Params,
    lengths_mm: Vec<f64>,
    now: Micros,
}

impl LargeArray {
    /// Cuts every `whiskers / broken`th whisker to 54 mm, which is too short to compensate itself.
    ///
    /// # Panics
    /// A cut is not detected.
    #[must_use]
    pub fn new(whiskers: usize, broken: usize) -> Self {
        let mut params = Params::nguyen_2021(Formulation::Published);
        params.detection.cold_start_contacts = CONTACTS as u32;
        let lengths_mm =
            (0..whiskers).map(|index| if (index + index / COLUMNS).is_multiple_of(2) { 70.0 } else { 66.0 });
        let lengths_mm: Vec<f64> = lengths_mm.collect();
        let robot = Robot::new(1, Numbers::default());
        let mut array = Self { robot, params, lengths_mm, now: Micros(1_000_000_000_000) };
        array.step(&Event::Connection { boot_id: BOOT, link: Link::Online });
        let factsheet = array.factsheet();
        array.step(&Event::Factsheet { boot_id: BOOT, factsheet: &factsheet });
        for whisker in 0..whiskers {
            array.touch(whisker, array.lengths_mm[whisker]);
        }
        array.tell(RegulatorState::Fault);
        for whisker in (0..whiskers).step_by(whiskers / broken) {
            array.touch(whisker, 54.0);
        }
        let is_trimmed =
            |index: &usize| array.robot.whisker(*index).is_some_and(|one| one.condition == Condition::Trimmed);
        assert_eq!((0..whiskers).filter(is_trimmed).count(), broken, "every cut must be detected");
        assert!(array.robot.compensations().is_empty(), "no compensation may begin");
        array
    }

    /// Reports working regulators, so that everything is decided in one step. Returns the effects of that step.
    pub fn decide(&mut self) -> Vec<Effect> {
        self.tell(RegulatorState::Ok)
    }

    fn tell(&mut self, regulator: RegulatorState) -> Vec<Effect> {
        let pressure = Megapascal::known(0.1);
        let status = |whisker| WhiskerStatus {
            array: ARRAY,
            whisker,
            pressure,
            setpoint: pressure,
            regulator,
            gauge: GaugeState::Ok,
        };
        let whiskers: Vec<_> = (0..self.lengths_mm.len() as u16).map(status).collect();
        let robot_time = self.now;
        self.step(&Event::Status { boot_id: BOOT, robot_time, whiskers: &whiskers })
    }

    fn step(&mut self, event: &Event<'_>) -> Vec<Effect> {
        let mut effects = Vec::new();
        self.now = self.now.after(Micros(1_000));
        self.robot.step(&self.params, self.now, event, &mut effects);
        effects
    }

    fn factsheet(&self) -> Factsheet {
        let sheet = |(index, &length_mm): (usize, &f64)| WhiskerSheet {
            number: index as u16,
            x_mm: 25.0 * (index % COLUMNS) as f64,
            y_mm: 25.0 * (index / COLUMNS) as f64,
            model: "nguyen-2021".to_owned(),
            length: Millimetre::known(length_mm),
            pressure: Megapascal::known(0.1),
            pressure_max: Megapascal::known(0.2),
            length_tolerance_mm: 0.5,
            strain_max: None,
            neighbours: around(index, self.lengths_mm.len()),
        };
        let whiskers = self.lengths_mm.iter().enumerate().map(sheet).collect();
        Factsheet {
            arrays: vec![ArraySheet { name: ARRAY.to_owned(), kind: ArrayKind::Type1, task: Task::Ratio, whiskers }],
            touch_tests: TouchTests::default(),
            applies_gain: false,
            air_control: Default::default(),
        }
    }

    /// Sends contacts of a whisker of that length at every contact ratio and deflection.
    fn touch(&mut self, whisker: usize, length_mm: f64) {
        let model = Model::nguyen_2021(Formulation::Published);
        let pressure = Megapascal::known(0.1);
        let morphology = model.morphology(pressure);
        let contact = |k: usize| {
            let spread = |step: f64| (k as f64 * step).fract();
            let (ratio, deflection_mm) =
                (ContactRatio::known(0.5 + 0.5 * spread(0.618_034)), 1.0 + 3.0 * spread(0.754_878));
            let per_mm =
                model.sensitivity_per_mm(ratio, Millimetre::known(length_mm), &morphology).expect("no chamber");
            let error = 0.02 * (2.0 * spread(0.414_214) - 1.0);
            Contact {
                array: ARRAY,
                whisker: whisker as u16,
                robot_time: self.now,
                place: ContactPlace::Ratio { ratio, sd: None },
                deflection: Millimetre::known(deflection_mm),
                strain: Strain::known(per_mm * deflection_mm * (1.0 + error)),
                pressure,
                is_test: false,
                angle_is_stated: false,
                saturated: false,
                temperature_c: None,
            }
        };
        let contacts: Vec<_> = (0..CONTACTS).map(contact).collect();
        let seq = self.robot.sequence(BOOT).map_or(0, |sequence| sequence.next());
        self.step(&Event::Contacts { boot_id: BOOT, seq, contacts: &contacts, missed: &[] });
    }
}

/// Numbers of the up to eight whiskers around this one.
fn around(index: usize, count: usize) -> Vec<u16> {
    let (row, column) = ((index / COLUMNS) as i64, (index % COLUMNS) as i64);
    let places = (-1..=1).flat_map(|down| (-1..=1).map(move |right| (row + down, column + right)));
    places
        .filter(|&(r, c)| (r, c) != (row, column) && r >= 0 && (0..COLUMNS as i64).contains(&c))
        .map(|(r, c)| r * COLUMNS as i64 + c)
        .filter(|&place| place < count as i64)
        .map(|place| place as u16)
        .collect()
}
