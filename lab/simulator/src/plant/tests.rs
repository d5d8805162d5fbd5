use super::*;
use crate::random::{Purpose, stream};

const SILENT: Noise = Noise { strain_relative: 0.0, strain_floor: 0.0, deflection_relative: 0.0, ratio: 0.0 };

fn plant(seed: u64, calibration_error: f64, noise: Noise) -> Plant {
    let streams = Streams {
        calibration: stream(seed, "r", "a", 0, Purpose::Calibration),
        contact: stream(seed, "r", "a", 0, Purpose::Contact),
        noise: stream(seed, "r", "a", 0, Purpose::Noise),
        test: stream(seed, "r", "a", 0, Purpose::Test),
    };
    Plant::new(Model::nguyen_2021(Formulation::Consistent), 70.0, 0.1, Truth::Within(calibration_error), noise, streams)
        .unwrap()
}

#[test]
fn without_errors_it_follows_the_consistent_mechanics() {
    let mut plant = plant(1, 0.0, SILENT);
    let model = Model::nguyen_2021(Formulation::Consistent);
    for _ in 0..100 {
        let reading = plant.touch(0.1).unwrap();
        let morphology = model.morphology(Megapascal::known(0.1));
        let ratio = ContactRatio::known(reading.ratio);
        let per_mm = model.sensitivity_per_mm(ratio, Millimetre::known(70.0), &morphology).unwrap();
        assert!((reading.strain / (per_mm * reading.deflection_mm) - 1.0).abs() < 1e-3, "only rounding is left");
    }
}

#[test]
fn the_noise_is_as_large_as_the_scenario_says() {
    let (mut noisy, mut silent) = (plant(1, 0.0, Noise::default()), plant(1, 0.0, SILENT));
    let (mut strain, mut deflection, mut ratio, count) = (0.0, 0.0, 0.0, 4000);
    for _ in 0..count {
        let (with, without) = (noisy.touch(0.1).unwrap(), silent.touch(0.1).unwrap());
        strain += (with.strain / without.strain - 1.0).powi(2);
        deflection += (with.deflection_mm / without.deflection_mm - 1.0).powi(2);
        ratio += (with.ratio - without.ratio).powi(2);
    }
    let rms = |sum: f64| (sum / f64::from(count)).sqrt();
    assert!((rms(strain) - 0.02).abs() < 0.001, "{}", rms(strain));
    assert!((rms(deflection) - 0.01).abs() < 0.0005, "{}", rms(deflection));
    assert!((rms(ratio) - 0.01).abs() < 0.0005, "{}", rms(ratio));
}

#[test]
fn a_trim_raises_the_sensitivity_at_equal_ratio_and_is_recorded() {
    let mut plant = plant(1, 0.03, SILENT);
    plant.touch(0.1).unwrap();
    plant.trim(5, 65.0);
    plant.trim(6, 68.0);
    assert_eq!(plant.length_mm(), 65.0, "a cut cannot lengthen it");
    assert_eq!(plant.changes()[0], LengthChange { t_us: 5, contact: 1, length_mm: 65.0, gradual: false });
    // d ln s / d ln La is -2.43 at the tip: 5 of 70 mm give 18 to 20 %.
    let gain = plant.sensitivity_per_mm(1.0, 0.1).unwrap() / plant.whole_sensitivity_per_mm(1.0).unwrap();
    assert!((1.17..1.22).contains(&gain), "{gain}");
}

#[test]
fn erosion_takes_something_off_with_each_contact_until_its_end() {
    let mut plant = plant(1, 0.0, SILENT);
    plant.erode(0, 0.5, 68.8);
    let lengths: Vec<f64> = (0..4)
        .map(|_| {
            plant.touch(0.1).unwrap();
            plant.length_mm()
        })
        .collect();
    assert_eq!(lengths, [69.5, 69.0, 68.8, 68.8]);
    assert!(plant.changes()[0].gradual);
}

#[test]
fn a_broken_gauge_reads_full_scale_a_shorted_one_nothing_a_saturated_one_its_limit() {
    let mut plant = plant(1, 0.0, SILENT);
    plant.set_gauge(GaugeCondition::Open);
    assert_eq!((plant.touch(0.1).unwrap().strain, plant.gauge()), (FULL_SCALE_STRAIN, Gauge::Open));
    plant.set_gauge(GaugeCondition::Short);
    assert_eq!((plant.touch(0.1).unwrap().strain, plant.gauge()), (0.0, Gauge::Short));
    plant.set_gauge(GaugeCondition::Saturated { limit_strain: 0.001 });
    let largest = (0..50).map(|_| plant.touch(0.1).unwrap().strain).fold(0.0, f64::max);
    assert_eq!((largest, plant.gauge()), (0.001, Gauge::Saturated));
}

#[test]
fn temperature_changes_the_sensitivity_and_no_length() {
    let mut plant = plant(1, 0.0, SILENT);
    let before = plant.sensitivity_per_mm(0.8, 0.1).unwrap();
    plant.set_temperature(1.05, 31.0);
    assert!((plant.sensitivity_per_mm(0.8, 0.1).unwrap() / before - 1.05).abs() < 1e-12);
    assert_eq!((plant.touch(0.1).unwrap().temperature_c, plant.length_mm()), (31.0, 70.0));
}

#[test]
fn each_whisker_is_off_its_calibration_within_the_stated_error() {
    let built_in = Calibration::nguyen_2021();
    for seed in 0..50 {
        let off = *plant(seed, 0.03, SILENT).model().calibration();
        let factors = [
            off.c / built_in.c,
            off.a / built_in.a,
            off.b_per_mpa / built_in.b_per_mpa,
            off.elongation_gain_mm / built_in.elongation_gain_mm,
        ];
        assert!(factors.iter().all(|factor| (factor - 1.0).abs() <= 0.03 + 1e-12));
        assert!(factors.windows(2).all(|pair| pair[0] != pair[1]), "each has its own");
    }
}

#[test]
fn a_baseline_wanders_with_each_contact_to_its_end_and_back() {
    let mut plant = plant(1, 0.0, SILENT);
    let off = |plant: &mut Plant| {
        let true_strain_of = |reading: &Reading| reading.deflection_mm * plant_sensitivity(reading.ratio);
        let reading = plant.touch(0.1).unwrap();
        reading.strain - true_strain_of(&reading)
    };
    assert!(off(&mut plant).abs() < 1e-5);
    plant.drift(-1e-4, -4e-4);
    let offs: Vec<f64> = (0..8).map(|_| off(&mut plant)).collect();
    assert!((offs[2] + 2e-4).abs() < 1e-5 && (offs[7] + 4e-4).abs() < 1e-5, "{offs:?}");
    assert_eq!(plant.baseline_strain(), -4e-4);
    plant.drift(3e-4, 0.0);
    assert!((0..4).map(|_| off(&mut plant)).all(|off| off < 1e-5), "back from below");
    assert_eq!(plant.baseline_strain(), 0.0);
}

fn plant_sensitivity(ratio: f64) -> f64 {
    plant(1, 0.0, SILENT).sensitivity_per_mm(ratio, 0.1).unwrap()
}

#[test]
fn deflections_told_wrongly_leave_the_strain_alone() {
    let (mut wrong, mut right) = (plant(1, 0.0, SILENT), plant(1, 0.0, SILENT));
    wrong.set_deflection_factor(1.1);
    let (wrong, right) = (wrong.touch(0.1).unwrap(), right.touch(0.1).unwrap());
    assert!((wrong.deflection_mm / right.deflection_mm - 1.1).abs() < 1e-3);
    assert_eq!((wrong.strain, wrong.ratio), (right.strain, right.ratio));
}

#[test]
fn a_whisker_that_is_taken_up_goes_on_as_if_nothing_had_been() {
    let mut one = plant(1, 0.03, Noise::default());
    one.trim(5, 65.0);
    one.erode(6, 0.01, 60.0);
    one.drift(2e-7, 4e-4);
    one.set_gauge(GaugeCondition::Saturated { limit_strain: 0.02 });
    one.set_temperature(1.03, 31.0);
    one.set_deflection_factor(1.05);
    for _ in 0..50 {
        one.touch(0.1).unwrap();
    }
    let text = serde_json::to_string(&one.state()).unwrap();
    // The rubber comes from the state, too: this seed would give another one.
    let mut other = plant(2, 0.03, Noise::default());
    other.contact_stream = stream(1, "r", "a", 0, Purpose::Contact);
    other.noise_stream = stream(1, "r", "a", 0, Purpose::Noise);
    other.take_up(&serde_json::from_str(&text).unwrap()).unwrap();
    assert_eq!(other.state(), one.state());
    for _ in 0..50 {
        assert_eq!(other.touch(0.1).unwrap(), one.touch(0.1).unwrap());
    }
    assert_eq!(other.state(), one.state());
}

#[test]
fn a_state_that_cannot_be_is_refused() {
    let mut plant = plant(1, 0.03, Noise::default());
    let good = serde_json::to_value(plant.state()).unwrap();
    for (name, value) in
        [("length_mm", 70.1), ("length_mm", 0.0), ("deflection_factor", 0.0), ("sensitivity_factor", -1.0)]
    {
        let mut bad = good.clone();
        bad[name] = value.into();
        let refused = plant.take_up(&serde_json::from_value(bad).unwrap()).unwrap_err();
        assert!(refused.contains(name), "{refused}");
    }
}
