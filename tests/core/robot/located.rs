//! The place of a touch from its strain and deflection, by the model and by the response in estimates, on whiskers that
//! are whole, cut, and compensated.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use vibrissa_core::mechanics::{Calibration, Formulation, Geometry, Model};
use vibrissa_core::robot::effect::{Condition, Effect};
use vibrissa_core::robot::event::SetpointReport;
use vibrissa_core::robot::{Event, LocateError, Touch};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre, Strain};
use vibrissa_robot::contract::Response;

use crate::by_hand::ByHand;

const WHOLE_MM: f64 = 70.0;
/// Relative noise of a strain.
const NOISE: f64 = 0.03;
const TOUCHES: usize = 200;

/// Median error of places, mm, and the share of intervals that hold the place.
type Located = (f64, f64);

/// Places that were found.
#[derive(Default)]
struct Places {
    errors_mm: Vec<f64>,
    held: usize,
}

impl Places {
    fn add(&mut self, true_mm: f64, found_mm: f64, interval_mm: (f64, f64)) {
        self.errors_mm.push((found_mm - true_mm).abs());
        self.held += usize::from((interval_mm.0..=interval_mm.1).contains(&true_mm));
    }

    fn located(mut self) -> Located {
        let count = self.errors_mm.len();
        assert!(count * 100 >= TOUCHES * 98, "{count} of {TOUCHES} have a place");
        self.errors_mm.sort_by(f64::total_cmp);
        (self.errors_mm[count / 2], self.held as f64 / count as f64)
    }
}

/// A whisker that differs from the model in all parameters, and a robot that touches it.
struct Plant {
    model: Model,
    /// Factor of the gauge.
    gain: f64,
    length_mm: f64,
    pressure_mpa: f64,
    random: ChaCha8Rng,
}

impl Plant {
    fn drawn(seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut off = |value: f64| value * random.random_range(0.9..1.1);
        let known = Calibration::nguyen_2021();
        let calibration = Calibration {
            a: off(known.a),
            b_per_mpa: off(known.b_per_mpa),
            c: off(known.c),
            youngs_modulus_mpa: off(known.youngs_modulus_mpa),
            ..known
        };
        let formulation = if seed.is_multiple_of(2) { Formulation::Published } else { Formulation::Consistent };
        let model = Model::new(Geometry::nguyen_2021(), calibration, formulation).unwrap();
        let gain = off(1.0);
        Self { model, gain, length_mm: WHOLE_MM, pressure_mpa: 0.1, random }
    }

    /// A touch: contact ratio, deflection in mm, strain.
    fn touch(&mut self) -> (f64, f64, f64) {
        let ratio = self.random.random_range(0.5..1.0);
        let deflection_mm = self.random.random_range(1.0..4.0);
        let noise: f64 = StandardNormal.sample(&mut self.random);
        let morphology = self.model.morphology(Megapascal::known(self.pressure_mpa));
        let (at, length) = (ContactRatio::new(ratio).unwrap(), Millimetre::known(self.length_mm));
        let per_mm = self.model.sensitivity_per_mm(at, length, &morphology).unwrap();
        (ratio, deflection_mm, self.gain * per_mm * deflection_mm * (NOISE * noise).exp())
    }

    fn touches(&mut self, one: &mut ByHand, contacts: usize) {
        for _ in 0..contacts {
            one.passes_s(0.25);
            let touch = self.touch();
            one.touched_at(self.pressure_mpa, &[(touch, 0)]);
        }
    }

    /// How well touches are located: by the model, and by a robot that knows the response alone.
    fn located(&mut self, one: &ByHand) -> [Located; 2] {
        let [mut by_model, mut by_response] = <[Places; 2]>::default();
        let points = one.robot.response_curve(&one.params, 0);
        assert!(points.len() == 16 && (points[15].distance_mm - self.length_mm).abs() < 1.5, "{points:?}");
        let points: Vec<_> = points.iter().map(|one| (one.distance_mm, one.strain_per_mm, one.sd_per_mm)).collect();
        let response = Response::new(self.pressure_mpa, &points).unwrap();
        for _ in 0..TOUCHES {
            let (ratio, deflection_mm, strain) = self.touch();
            let touch = Touch {
                strain: Strain::new(strain).unwrap(),
                deflection: Millimetre::known(deflection_mm),
                pressure: Some(Megapascal::known(self.pressure_mpa)),
            };
            let true_mm = ratio * self.length_mm;
            if let Ok(found) = one.robot.locate(&one.params, 0, &touch) {
                by_model.add(true_mm, found.distance_mm, found.interval_mm);
            }
            if let Ok(found) = response.place(strain, deflection_mm) {
                by_response.add(true_mm, found.distance_mm, found.interval_mm);
            }
        }
        [by_model, by_response].map(Places::located)
    }
}

/// Mean over the plants of the median errors, mm, and of the shares of intervals that hold.
fn mean(of: &[[Located; 2]], way: usize) -> Located {
    let mean = |pick: fn(&Located) -> f64| of.iter().map(|one| pick(&one[way])).sum::<f64>() / of.len() as f64;
    (mean(|one| one.0), mean(|one| one.1))
}

#[test]
fn property_the_place_of_a_touch_is_within_2_mm_and_2_5_mm_after_a_cut_compensated_or_not() {
    let (mut whole, mut cut, mut compensated) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..24 {
        let mut plant = Plant::drawn(seed);
        let mut one = ByHand::born(WHOLE_MM);
        plant.touches(&mut one, 300);
        whole.push(plant.located(&one));
        plant.length_mm = plant.random.random_range(60.0..66.0);
        let before = one.effects.len();
        plant.touches(&mut one, 120);
        assert_eq!(one.robot.whisker(0).unwrap().condition, Condition::Trimmed, "seed {seed}");
        cut.push(plant.located(&one));
        let command = one.commands_from(before).pop().expect("a setpoint");
        plant.pressure_mpa = command.pressure.mpa();
        let robot_time = one.now;
        let report = SetpointReport::Applied(command.pressure);
        one.step(&Event::Setpoint { boot_id: "b1", command: command.key, report, robot_time });
        plant.touches(&mut one, 60);
        compensated.push(plant.located(&one));
        let command = one.effects.iter().rev().find(|effect| matches!(effect, Effect::Command(_)));
        assert!(command.is_some());
    }
    for (way, name) in ["the model", "the response"].into_iter().enumerate() {
        let [whole, cut, compensated] = [&whole, &cut, &compensated].map(|of| mean(of, way));
        println!("by {name}, median error and intervals: whole {whole:?}, cut {cut:?}, compensated {compensated:?}");
        assert!(whole.0 <= 2.0 && cut.0 <= 2.5 && compensated.0 <= 2.5, "{name}: {whole:?} {cut:?} {compensated:?}");
        for (_, held) in [whole, cut, compensated] {
            assert!((0.92..=0.985).contains(&held), "{name}: {whole:?} {cut:?} {compensated:?}");
        }
    }
}

#[test]
fn a_strain_that_no_place_explains_says_why() {
    let mut plant = Plant::drawn(5);
    let mut one = ByHand::born(WHOLE_MM);
    plant.touches(&mut one, 300);
    let located = |strain: f64| {
        let (deflection, pressure) = (Millimetre::known(2.0), None);
        one.robot.locate(&one.params, 0, &Touch { strain: Strain::new(strain).unwrap(), deflection, pressure })
    };
    assert_eq!(located(-0.01), Err(LocateError::Negative));
    assert_eq!(located(0.3), Err(LocateError::OnChamber));
    assert_eq!(located(1e-3), Err(LocateError::BeyondTip));
    let touch = Touch { strain: Strain::new(0.01).unwrap(), deflection: Millimetre::known(2.0), pressure: None };
    assert_eq!(one.robot.locate(&one.params, 7, &touch), Err(LocateError::UnknownWhisker(7)));
}
