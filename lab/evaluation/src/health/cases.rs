//! Simulated scenarios of each class.

use rand::seq::IndexedRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};
use vibrissa_protocol::{ArrayType, Name, OnSupervisorLoss};
use vibrissa_simulator::plant::{DEFLECTION_MM, RATIO_MIN};
use vibrissa_simulator::scenario::{
    ArrayScenario, Behaviour, Change, Event, Noise, RobotScenario, Scenario, WhiskerScenario,
};

use super::Class;

/// Contacts of each whisker per second.
pub(super) const CONTACTS_PER_SECOND: f64 = 10.0;
const ARRAY: &str = "array";
/// Configured floor of the strain noise; a baseline drift is a multiple of it.
const STRAIN_FLOOR: f64 = 5e-6;
/// Number of steps of a slow change of temperature.
const RAMP_STEPS: u32 = 25;
/// Temperature that the thermometer shows, degrees Celsius: that of the start.
const COOL_C: f64 = 24.0;

/// One simulated case.
pub(super) struct Case {
    pub(super) class: Class,
    pub(super) scenario: Scenario,
    /// Index of the affected whisker; `None` if the whole array or no whisker is affected.
    pub(super) whisker: Option<usize>,
    pub(super) onset_s: f64,
    pub(super) end_s: f64,
}

/// The `number`-th case of a class.
pub(super) fn case(seed: u64, class: Class, number: u32) -> Case {
    let mut stream = ChaCha8Rng::seed_from_u64(seed);
    stream.set_stream((class as u64) << 32 | u64::from(number));
    let rng = &mut stream;
    let count: u16 = rng.random_range(3..=12);
    let whisker = rng.random_range(0..count);
    let onset_contacts = rng.random_range(300..=500);
    let onset_s = f64::from(onset_contacts) / CONTACTS_PER_SECOND;
    let whiskers: Vec<WhiskerScenario> = (0..count).map(|number| built_in(number, count, whisker, rng)).collect();
    let own = &whiskers[usize::from(whisker)];
    let (events, contacts_after) = events(class, own, onset_s, rng);
    let noise_factor = rng.random_range(1.0..=2.0);
    let (array_type, calibration_error) = (kind(rng), rng.random_range(0.03..=0.10));
    let scenario = Scenario {
        calibration: None,
        seed: rng.random(),
        fleet: name("evaluation"),
        behaviour: Behaviour {
            contacts_per_second: CONTACTS_PER_SECOND,
            contacts_per_message: 20,
            notices_faults: false,
            // The supervisor is never lost, although it may send nothing for a long time.
            supervisor_lost_after_s: 86_400.0,
            ..Behaviour::default()
        },
        noise: scaled(noise_factor),
        calibration_error,
        robots: vec![RobotScenario {
            robot: name("robot"),
            model: "evaluation".to_owned(),
            on_supervisor_loss: OnSupervisorLoss::Hold,
            applies_gain: false,
            arrays: vec![ArrayScenario { array: name(ARRAY), array_type, whiskers }],
            events,
        }],
    };
    let of_one = !matches!(class, Class::Healthy | Class::ArrayShift);
    let end_s = onset_s + f64::from(contacts_after) / CONTACTS_PER_SECOND;
    Case { class, scenario, whisker: of_one.then_some(usize::from(whisker)), onset_s, end_s }
}

fn kind(rng: &mut ChaCha8Rng) -> ArrayType {
    if rng.random() { ArrayType::Type1 } else { ArrayType::Type2 }
}

/// The affected whisker is long enough to lose 30 mm and still reach beyond its chamber.
fn built_in(number: u16, count: u16, affected: u16, rng: &mut ChaCha8Rng) -> WhiskerScenario {
    let lengths_mm: &[f64] = if number == affected { &[70.0, 75.0] } else { &[65.0, 70.0, 75.0] };
    WhiskerScenario {
        whisker: number,
        x_mm: 25.0 * f64::from(number),
        length_mm: *lengths_mm.choose(rng).expect("lengths"),
        pressure_mpa: 0.1,
        neighbours: [number.checked_sub(1), Some(number + 1).filter(|&next| next < count)]
            .into_iter()
            .flatten()
            .collect(),
        ..WhiskerScenario::default()
    }
}

fn scaled(factor: f64) -> Noise {
    let Noise { strain_relative, strain_floor, deflection_relative, ratio } = Noise::default();
    Noise {
        strain_relative: factor * strain_relative,
        strain_floor: factor * strain_floor,
        deflection_relative: factor * deflection_relative,
        ratio: factor * ratio,
    }
}

/// The events, and the number of contacts that the core may use.
fn events(class: Class, own: &WhiskerScenario, onset_s: f64, rng: &mut ChaCha8Rng) -> (Vec<Event>, u32) {
    let to_one = |change| vec![Event::whisker_at_s(onset_s, name(ARRAY), own.whisker, change)];
    match class {
        Class::Healthy => (Vec::new(), 2000),
        Class::Trim => (to_one(Change::Trim { length_mm: own.length_mm - rng.random_range(1.0..=30.0) }), 1200),
        Class::Erosion => {
            let rate_mm_per_contact = log_uniform(0.001, 0.008, rng);
            (to_one(Change::Erode { rate_mm_per_contact, until_length_mm: 50.0 }), 3500)
        }
        Class::ArrayShift => (array_shift(onset_s, rng), 1500),
        Class::BaselineDrift => {
            let until_strain = either_sign(STRAIN_FLOOR * rng.random_range(40.0..=160.0), rng);
            let strain_per_contact = until_strain / rng.random_range(500.0..=2000.0);
            (to_one(Change::BaselineDrift { strain_per_contact, until_strain }), 3000)
        }
        Class::Leak => (to_one(Change::Leak { rate_mpa_per_s: log_uniform(0.0005, 0.01, rng) }), 2500),
        Class::GaugeOpen => (to_one(Change::GaugeOpen), 300),
        Class::GaugeShort => (to_one(Change::GaugeShort), 300),
        Class::GaugeSaturated => {
            let limit_strain = strain_reached_by(rng.random_range(0.05..=0.7), own, rng);
            (to_one(Change::GaugeSaturated { limit_strain }), 1000)
        }
        Class::Silent => (to_one(Change::Silent { for_s: 1e6 }), 400),
    }
}

/// A step or a ramp of the temperature, or wrongly reported deflections.
fn array_shift(onset_s: f64, rng: &mut ChaCha8Rng) -> Vec<Event> {
    let factor = 1.0 + either_sign(rng.random_range(0.03..=0.09), rng);
    let at = |seconds, change| Event { array: Some(name(ARRAY)), ..Event::robot_at_s(seconds, change) };
    // The thermometer does not show it: a change of temperature that the robot measures is no shift.
    let warm = |sensitivity_factor| Change::Temperature { sensitivity_factor, temperature_c: COOL_C };
    match rng.random_range(0..3) {
        0 => vec![at(onset_s, warm(factor))],
        1 => vec![at(onset_s, Change::DeflectionScale { factor })],
        _ => {
            let ramp_s = rng.random_range(20.0..=60.0);
            let step = |step: u32| f64::from(step) / f64::from(RAMP_STEPS);
            (1..=RAMP_STEPS).map(|k| at(onset_s + step(k) * ramp_s, warm(1.0 + step(k) * (factor - 1.0)))).collect()
        }
    }
}

/// The strain that this share of a whole whisker's contacts reaches.
fn strain_reached_by(part: f64, own: &WhiskerScenario, rng: &mut ChaCha8Rng) -> f64 {
    const SAMPLES: usize = 400;
    let model = Model::nguyen_2021(Formulation::Consistent);
    let morphology = model.morphology(Megapascal::known(own.pressure_mpa));
    let mut strains: Vec<f64> = (0..SAMPLES)
        .map(|_| {
            let ratio = ContactRatio::known(rng.random_range(RATIO_MIN..=1.0));
            let deflection_mm: f64 = rng.random_range(DEFLECTION_MM.0..=DEFLECTION_MM.1);
            let per_mm = model.sensitivity_per_mm(ratio, Millimetre::known(own.length_mm), &morphology);
            per_mm.expect("beyond the chamber") * deflection_mm
        })
        .collect();
    strains.sort_by(f64::total_cmp);
    strains[((1.0 - part) * SAMPLES as f64) as usize]
}

fn log_uniform(low: f64, high: f64, rng: &mut ChaCha8Rng) -> f64 {
    low * (high / low).powf(rng.random())
}

fn either_sign(size: f64, rng: &mut ChaCha8Rng) -> f64 {
    if rng.random() { size } else { -size }
}

fn name(text: &str) -> Name {
    Name::new(text).expect("a name")
}
