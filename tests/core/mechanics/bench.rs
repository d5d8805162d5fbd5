//! Fits of bench readings with contacts, generated from known whiskers.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use vibrissa_core::mechanics::{
    BenchContact, BenchFit, BenchReading, Calibration, FitError, Formulation, Geometry, Given, Kind, Model, Place,
    Quantity, Unknown, fit_bench,
};
use vibrissa_core::units::Megapascal;

use super::{assert_close, mm, mpa, ratio};

/// A rubber that is far from the paper's.
fn truth() -> Calibration {
    Calibration { c: 0.4, a: 0.9, b_per_mpa: 13.0, youngs_modulus_mpa: 1.9, elongation_gain_mm: 8.0 }
}

fn model() -> Model {
    Model::new(Geometry::nguyen_2021(), truth(), Formulation::Published).unwrap()
}

fn given() -> Given {
    Given {
        geometry: Geometry::nguyen_2021(),
        formulation: Formulation::Published,
        youngs_modulus_mpa: None,
        fits_gauge_gain: false,
    }
}

/// A bench that reads a true whisker with relative noise of each kind, and a true gauge's gain.
struct Bench {
    noise: [f64; 4],
    gauge_gain: f64,
    stated: bool,
    rng: ChaCha8Rng,
}

impl Bench {
    fn new(noise: [f64; 4], seed: u64) -> Self {
        Self { noise, gauge_gain: 1.0, stated: false, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    fn reading(&mut self, pressure: Megapascal, quantity: Quantity, true_value: f64, noise: f64) -> BenchReading {
        let error: f64 = StandardNormal.sample(&mut self.rng);
        let sd = self.stated.then_some(noise * true_value);
        BenchReading { pressure, pressure_sd_mpa: 0.0, quantity, value: true_value * (1.0 + noise * error), sd }
    }

    /// Strains and elongations without contact, each `times`.
    fn without_contact(&mut self, times: usize) -> Vec<BenchReading> {
        let model = model();
        let mut readings = Vec::new();
        for pressure in [0.002, 0.02, 0.05, 0.1, 0.15, 0.2].map(mpa) {
            for _ in 0..times {
                let strain = self.gauge_gain * model.axial_strain(pressure).ratio();
                readings.push(self.reading(pressure, Quantity::AxialStrain, strain, self.noise[0]));
                let stretch_mm = model.elongation(pressure).mm();
                readings.push(self.reading(pressure, Quantity::Elongation, stretch_mm, self.noise[1]));
            }
        }
        readings
    }

    /// Strains, and forces on request, of contacts at places, lengths and pressures. The truth is the model's.
    fn contacts(&mut self, with_force: bool) -> Vec<BenchReading> {
        let model = model();
        let mut readings = Vec::new();
        for (length_mm, pressure) in [(70.0, mpa(0.0)), (70.0, mpa(0.1)), (70.0, mpa(0.2)), (64.0, mpa(0.1))] {
            let morphology = model.morphology(pressure);
            for (a, deflection_mm) in [(0.45, 2.0), (0.7, 2.0), (0.7, 3.0), (1.0, 3.0)] {
                let response = model.response(ratio(a), mm(length_mm), &morphology).unwrap();
                let place = Place::Ratio(ratio(a), mm(length_mm));
                let contact = BenchContact { place, place_sd: 0.0, deflection_mm, deflection_sd_mm: 0.0 };
                let strain = self.gauge_gain * response.strain_per_mm * deflection_mm;
                readings.push(self.reading(pressure, Quantity::ContactStrain(contact), strain, self.noise[2]));
                if with_force {
                    // Eq. 9: the deflection is P / (E pi) times the compliance.
                    let compliance = response.delta1_per_mm + response.delta2_per_mm + response.delta3_per_mm;
                    let force_n = deflection_mm * truth().youngs_modulus_mpa * std::f64::consts::PI / compliance;
                    readings.push(self.reading(pressure, Quantity::ContactForce(contact), force_n, self.noise[3]));
                }
            }
        }
        readings
    }
}

fn true_value(unknown: Unknown, gauge_gain: f64) -> f64 {
    match unknown {
        Unknown::C => truth().c,
        Unknown::A => truth().a,
        Unknown::B => truth().b_per_mpa,
        Unknown::Modulus => truth().youngs_modulus_mpa,
        Unknown::ElongationGain => truth().elongation_gain_mm,
        Unknown::GaugeGain => gauge_gain,
        Unknown::GaugeOffset => 0.0,
    }
}

#[test]
fn property_exact_bench_readings_give_modulus_and_gauge_gain_back() {
    for (with_force, gauge_gain) in [(false, 1.0), (true, 1.0), (true, 0.93)] {
        let mut bench = Bench::new([0.0; 4], 1);
        bench.gauge_gain = gauge_gain;
        let readings = [bench.without_contact(2), bench.contacts(with_force)].concat();
        let fit = fit_bench(&Given { fits_gauge_gain: gauge_gain != 1.0, ..given() }, &readings).unwrap();
        assert!(fit.parameter(Unknown::Modulus).is_some());
        for (unknown, parameter) in &fit.fitted {
            assert_close(&format!("{unknown:?}"), parameter.value, true_value(*unknown, gauge_gain), 1e-5);
        }
    }
}

/// 95 % intervals must contain the truth in about 95 % of 200 benches, within 3.5 standard deviations.
#[test]
fn property_bench_intervals_hold_the_truth_as_often_as_they_say() {
    let repetitions = 200;
    for (with_force, gain, stated, times) in [
        (true, false, false, 3),
        (false, false, false, 3),
        (true, true, false, 3),
        (true, false, true, 3),
        (true, false, false, 1),
        (false, false, false, 1),
    ] {
        let mut held = std::collections::BTreeMap::<String, i32>::new();
        for seed in 0..repetitions {
            let mut bench = Bench::new([0.02, 0.04, 0.03, 0.05], seed);
            (bench.gauge_gain, bench.stated) = (if gain { 1.05 } else { 1.0 }, stated);
            let readings = [bench.without_contact(times), bench.contacts(with_force)].concat();
            let fit = fit_bench(&Given { fits_gauge_gain: gain, ..given() }, &readings).unwrap();
            for (unknown, parameter) in &fit.fitted {
                let holds = (parameter.low..=parameter.high).contains(&true_value(*unknown, bench.gauge_gain));
                *held.entry(format!("{unknown:?}")).or_default() += i32::from(holds);
            }
            let k2 = fit.k2(mpa(0.07));
            let holds = (k2.low..=k2.high).contains(&model().k2(mpa(0.07)));
            *held.entry("k2".to_owned()).or_default() += i32::from(holds);
        }
        for (name, held) in held {
            let share = f64::from(held) / repetitions as f64;
            println!("force {with_force}, gain {gain}, stated {stated}, {times} runs: {name} {share}");
            assert!(
                (0.896..=1.0).contains(&share),
                "force {with_force}, gain {gain}, stated {stated}, {times} runs, {name}: {share}"
            );
        }
    }
}

/// Readings that scatter more than their stated standard deviations widen the intervals.
#[test]
fn property_stated_deviations_that_are_too_small_do_not_narrow_the_intervals() {
    let span = |stated_share: f64| {
        let mut bench = Bench::new([0.02, 0.04, 0.03, 0.05], 5);
        bench.stated = true;
        let mut readings = [bench.without_contact(3), bench.contacts(true)].concat();
        readings.iter_mut().for_each(|reading| reading.sd = reading.sd.map(|sd| stated_share * sd));
        fit_bench(&given(), &readings).unwrap().parameter(Unknown::Modulus).unwrap().span()
    };
    let (honest, boasted) = (span(1.0), span(0.1));
    assert!(boasted > 0.8 * honest, "{boasted} {honest}");
}

#[test]
fn property_the_gauges_offset_comes_from_readings_at_zero_pressure() {
    let mut bench = Bench::new([0.005; 4], 3);
    let mut readings = bench.without_contact(4);
    for at_zero in [0.0019, 0.0021, 0.0020] {
        let blank = readings[0];
        readings.push(BenchReading { pressure: mpa(0.0), value: at_zero, ..blank });
    }
    for reading in readings.iter_mut().filter(|reading| reading.kind() == Some(Kind::Axial)) {
        reading.value += 0.002;
    }
    let fit = fit_bench(&Given { youngs_modulus_mpa: Some(1.9), ..given() }, &readings).unwrap();
    let offset = fit.parameter(Unknown::GaugeOffset).unwrap();
    assert!((offset.low..=offset.high).contains(&0.002) && offset.high - offset.low < 0.001, "{offset:?}");
    assert_close("c", fit.calibration.c, truth().c, 0.03);
    assert_close("b", fit.calibration.b_per_mpa, truth().b_per_mpa, 0.05);
}

/// Four readings: an interval over a factor of 5, so a person needs a warning.
fn four() -> BenchFit {
    let row = |(pressure_mpa, value)| BenchReading {
        pressure: mpa(pressure_mpa),
        pressure_sd_mpa: 0.0,
        quantity: Quantity::AxialStrain,
        value,
        sd: None,
    };
    let readings = [(0.02, 0.0067), (0.06, 0.0278), (0.12, 0.0738), (0.2, 0.149)].map(row);
    fit_bench(&Given { youngs_modulus_mpa: Some(1.1134), ..given() }, &readings).unwrap()
}

#[test]
fn regress_four_readings_do_not_carry_a_fit_and_more_of_the_advised_ones_do() {
    let fit = four();
    let b = fit.parameter(Unknown::B).unwrap();
    assert!(b.span() > 2.0, "{b:?}");
    let advice = fit.advice(Unknown::B).unwrap();
    assert!(advice.span < b.span() / 2.0, "{advice:?}");
    assert_eq!(fit.advice(Unknown::Modulus), None);
    println!("{b:?} {advice:?} {:?} {}", fit.hardly_distinct(), fit.condition());
}

/// The advice is compared with benches to which its readings are really added.
#[test]
fn brute_force_the_advised_readings_narrow_the_interval_more_than_others() {
    let mut ratios = Vec::new();
    for seed in 0..20 {
        let mut bench = Bench::new([0.02, 0.04, 0.03, 0.05], seed);
        let readings = [bench.without_contact(1), bench.contacts(false)].concat();
        let fit = fit_bench(&given(), &readings).unwrap();
        let advice = fit.advice(Unknown::Modulus).unwrap();
        let added = |reading: BenchReading, bench: &mut Bench| {
            let true_model = model();
            let noise = match reading.kind().unwrap() {
                Kind::Zero | Kind::Axial => bench.noise[0],
                Kind::Elongation => bench.noise[1],
                Kind::ContactStrain => bench.noise[2],
                Kind::ContactForce => bench.noise[3],
            };
            let value = match reading.quantity {
                Quantity::AxialStrain => true_model.axial_strain(reading.pressure).ratio(),
                Quantity::Elongation => true_model.elongation(reading.pressure).mm(),
                Quantity::ContactStrain(_) | Quantity::ContactForce(_) => reading.value,
            };
            let more = (0..advice.repetitions).map(|_| bench.reading(reading.pressure, reading.quantity, value, noise));
            let readings: Vec<_> = readings.iter().copied().chain(more).collect();
            fit_bench(&given(), &readings).unwrap().parameter(Unknown::Modulus).unwrap().span()
        };
        let elongation = BenchReading { pressure: mpa(0.002), quantity: Quantity::Elongation, ..advice.reading };
        ratios.push(added(advice.reading, &mut bench).ln() / added(elongation, &mut bench).ln());
    }
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!(mean < 0.8, "{ratios:?}");
}

#[test]
fn property_bench_readings_that_determine_nothing_are_refused_by_name() {
    let mut bench = Bench::new([0.02, 0.04, 0.03, 0.05], 9);
    let (without, contacts) = (bench.without_contact(3), bench.contacts(true));
    let refusal = |given: &Given, readings: &[BenchReading]| fit_bench(given, readings).unwrap_err();
    assert_eq!(refusal(&given(), &without), FitError::ModulusWithoutContacts);
    let reversed: Vec<_> = contacts.iter().map(|reading| BenchReading { value: -reading.value, ..*reading }).collect();
    assert!(matches!(refusal(&given(), &reversed), FitError::ForceBelowZero { row: 2, .. }));
    let strains: Vec<_> = reversed.into_iter().filter(|one| one.kind() == Some(Kind::ContactStrain)).collect();
    assert_eq!(refusal(&given(), &strains), FitError::GaugeReversed);
    let mut near = [without.clone(), contacts.clone()].concat();
    let Quantity::ContactStrain(contact) = near[without.len()].quantity else { panic!("a contact") };
    near[without.len()].quantity =
        Quantity::ContactStrain(BenchContact { place: Place::Distance(mm(15.0)), ..contact });
    let row = without.len() + 1;
    assert!(matches!(refusal(&given(), &near), FitError::OnChamber { row: found, .. } if found == row));
    // Strains of contacts alone at one place, and an unknown gauge: the readings do not tell level and softness apart.
    let at_one = |reading: &BenchReading| match reading.quantity {
        Quantity::ContactStrain(contact) => contact.place == Place::Ratio(ratio(0.7), mm(70.0)),
        Quantity::AxialStrain | Quantity::Elongation | Quantity::ContactForce(_) => false,
    };
    let one_place: Vec<_> = contacts.into_iter().filter(at_one).collect();
    let given = Given { fits_gauge_gain: true, ..given() };
    assert!(matches!(refusal(&given, &one_place), FitError::NotDetermined { .. }));
}
