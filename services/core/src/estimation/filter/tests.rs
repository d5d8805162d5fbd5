//! The filter on whiskers of another rubber, and with a doubt that contacts do not remove.

use super::*;
use crate::mechanics::{Calibration, Formulation, Geometry};
use crate::units::Megapascal;

const WHOLE_MM: f64 = 70.0;
const WORN_MM: f64 = 10.0;
const CONTACTS: u32 = 2000;

/// A whisker with a rubber of this modulus relative to the model's, and with the model's modulus of the chamber.
fn of_rubber(factor: f64) -> Model {
    let own = Calibration::nguyen_2021();
    let youngs_modulus_mpa = factor * own.youngs_modulus_mpa;
    let calibration = Calibration { c: own.c / factor, a: own.a / factor, youngs_modulus_mpa, ..own };
    Model::new(Geometry::nguyen_2021(), calibration, Formulation::Published).unwrap()
}

/// Contacts all over a plant that loses so much length with each of them, without noise, mm.
fn touch(filter: &mut LengthFilter, plant: &Model, (from_mm, loss_mm): (f64, f64), wander_mm: f64) {
    let (model, noise, scale) =
        (Model::nguyen_2021(Formulation::Published), SensorNoise::default(), NoiseScale::default());
    let at_nominal = |one: &Model| one.morphology(Megapascal::known(0.1));
    for contact in 0..CONTACTS {
        let ratio = ContactRatio::known(0.45 + 0.55 * (f64::from(contact) * 0.618_034).fract());
        let length = Millimetre::known(from_mm - loss_mm * f64::from(contact));
        let deflection_mm = 1.0 + 4.0 * (f64::from(contact) * 0.754_878).fract();
        let per_mm = plant.sensitivity_per_mm(ratio, length, &at_nominal(plant)).unwrap();
        let place = ExpectedRatio::exact(ratio);
        let strain = per_mm * deflection_mm;
        let contact = Observation { place, informs_length: true, deflection_mm, strain, warmer_k: 0.0 };
        let seen = filter.observe(&model, &at_nominal(&model), &noise, &scale, &contact).unwrap();
        assert!(filter.learn(&seen, Wander { length_mm: wander_mm, baseline_strain: 0.0, offset: 0.0 }));
    }
}

/// With the offset at its contact ratio the lengths of the three rubbers were wrong by -1.5, 0 and 1.2 mm.
#[test]
fn property_a_loss_of_length_is_right_for_another_rubber() {
    for factor in [0.5, 1.0, 2.0] {
        let plant = of_rubber(factor);
        let mut filter = LengthFilter::new(Millimetre::known(WHOLE_MM), &FilterParams::default());
        touch(&mut filter, &plant, (WHOLE_MM, 0.0), 2e-4);
        touch(&mut filter, &plant, (WHOLE_MM, WORN_MM / f64::from(CONTACTS)), 0.05);
        touch(&mut filter, &plant, (WHOLE_MM - WORN_MM, 0.0), 0.05);
        let off_mm = filter.length().length.mm() - (WHOLE_MM - WORN_MM);
        assert!(off_mm.abs() < 0.3, "{factor}: {off_mm}");
    }
}

#[test]
fn contacts_do_not_remove_a_doubt_and_a_measurement_does() {
    let plant = of_rubber(1.0);
    let mut filter = LengthFilter::new(Millimetre::known(WHOLE_MM), &FilterParams::default());
    filter.keep_doubt(2.0);
    touch(&mut filter, &plant, (WHOLE_MM, 0.0), 2e-4);
    assert_eq!(filter.length().sd_mm, 2.0);
    assert_eq!(filter.learned_anew(&FilterParams::default()).length().sd_mm, 2.0);
    filter.keep_doubt(0.0);
    assert!(filter.length().sd_mm < 0.2, "{:?}", filter.length());
}

#[test]
fn an_offset_belongs_to_the_distance_from_the_base() {
    let whole = Offset { level: 0.1, slope: 0.4 };
    let cut = whole.shortened(0.9);
    for ratio in [0.5, 0.8, 1.0] {
        let difference = cut.at(ContactRatio::known(ratio)) - whole.at(ContactRatio::known(0.9 * ratio));
        assert!(difference.abs() < 1e-12, "{ratio}: {difference}");
    }
}
