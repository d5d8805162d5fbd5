//! Compares the elastica with closed forms, tabulated solutions, quadrature and energies, and then with the core.

use vibrissa_core::mechanics::{Calibration, Formulation, Geometry, Model};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};

use super::whisker::Stretched;
use super::*;

fn assert_close(what: &str, ours: f64, theirs: f64, relative: f64) {
    assert!((ours / theirs - 1.0).abs() <= relative, "{what}: {ours} instead of {theirs}");
}

fn cylinder(length_mm: f64, has_gauge: bool) -> Section {
    Section { length_mm, outer_mm: [8.0; 2], inner_mm: [5.0; 2], modulus_mpa: 1.1, has_gauge }
}

/// The paper's whisker without pressure, of one modulus.
fn unpressurized() -> Stretched {
    Stretched::with(&Geometry::nguyen_2021(), (1.0, 1.0), 0.0, 0.0)
}

/// Bent by an object at a distance from the base, over which the rod slides.
fn at_object(rod: &Rod, object_mm: f64, deflection_mm: f64, friction: f64) -> (f64, Bent) {
    let mut along_mm = object_mm;
    loop {
        let bent = rod.bend(along_mm, deflection_mm, Push::Sliding(friction)).unwrap();
        let left_mm = object_mm - bent.reach_mm;
        if left_mm.abs() < 1e-9 {
            return (along_mm, bent);
        }
        along_mm += left_mm;
    }
}

fn simpson(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (n, step) = (2000, (to - from) / 2000.0);
    let inner: f64 = (1..n).map(|k| f(from + step * f64::from(k)) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (f(from) + f(to) + inner) * step / 3.0
}

/// Closed form of a uniform cantilever with a force at its end: `3 r (a - x) / a^3` per mm of deflection.
#[test]
fn property_a_small_deflection_of_a_uniform_rod_has_the_closed_form() {
    let rod = Rod { sections: vec![cylinder(10.0, false), cylinder(4.0, true), cylinder(66.0, false)] };
    for along_mm in [20.0, 43.0, 80.0_f64] {
        let expected = 3.0 * 4.0 * (along_mm - 12.0) / along_mm.powi(3);
        for push in [Push::Across, Push::Sliding(0.0), Push::Sliding(0.3)] {
            let deflection_mm = 1e-5;
            let strain = rod.bend(along_mm, deflection_mm, push).unwrap().strain;
            // Friction changes the strain in the first power of the deflection.
            assert_close("strain per mm", strain / deflection_mm, expected, 2e-7);
        }
    }
}

/// A small deflection of the paper's whisker, by numerical quadrature of `(A - x) / (E I)` over its three cones.
#[test]
fn brute_force_a_small_deflection_of_the_tapered_whisker() {
    let (solid, hollow) = (|d: f64| d.powi(4), |outer: f64, inner: f64| outer.powi(4) - inner.powi(4));
    // Table 1: the outer and the inner surface of the chamber taper by 0.1 mm per mm.
    let fourth = |x: f64| match x {
        x if x < 2.0 => solid(18.0 - 0.1 * x),
        x if x < 15.0 => hollow(18.0 - 0.1 * x, 12.0 - 0.1 * x),
        x => solid(16.5 - 0.1 * (x - 15.0)),
    };
    let whisker = unpressurized();
    for contact_mm in [18.0, 31.5, 50.0, 70.0] {
        let arm = |x: f64| contact_mm - x;
        let pieces = [(0.0, 2.0 - 1e-9), (2.0, 15.0 - 1e-9), (15.0, contact_mm)];
        let compliance: f64 = pieces.iter().map(|&(from, to)| simpson(from, to, |x| arm(x).powi(2) / fourth(x))).sum();
        let read = simpson(6.0, 8.0, |x| 0.5 * (18.0 - 0.1 * x) * arm(x) / fourth(x)) / 2.0;
        let strain = whisker.rod.bend(contact_mm, 1e-5, Push::Sliding(0.0)).unwrap().strain;
        assert_close(&format!("at {contact_mm} mm"), strain / 1e-5, read / compliance, 1e-6);
    }
}

/// Bisshopp and Drucker, 1945, with more digits by Mattiasson, 1981: for P L^2 / (E I) the deflection of the end across and
/// along the axis, as shares of the length, and its angle.
#[test]
fn golden_large_deflections_of_a_uniform_rod() {
    let rod = Rod { sections: vec![cylinder(50.0, false)] };
    let (stiffness, _) = rod.sections[0].at(0.0);
    for (load, across, along, angle) in [
        (1.0, 0.301_720_77, 0.056_433_24, 0.461_35),
        (2.0, 0.493_457_48, 0.160_641_71, 0.781_75),
        (5.0, 0.713_791_52, 0.387_627_76, 1.215_37),
        (10.0, 0.810_609_04, 0.554_996_02, 1.430_29),
    ] {
        let aim = rod.aim(50.0, 50.0 * across, Push::Across).unwrap();
        let ([_, reach_mm, ..], _) = rod.shoot(50.0, aim, Push::Across);
        let [_, across_n] = force(aim, Push::Across);
        assert_close("load", across_n * 50.0_f64.powi(2) / stiffness, load, 1e-6);
        assert_close("reach", reach_mm / 50.0, 1.0 - along, 5e-6);
        assert_close("angle", aim[1], angle, 1e-5);
    }
}

/// An object at one distance that moves across does the work that the rod stores, and the friction takes its part.
#[test]
fn property_the_work_of_the_object_is_the_energy_of_the_rod() {
    let rod = unpressurized().rod;
    for (object_mm, friction) in [(24.0, 0.0), (31.5, 0.0), (31.5, 0.3), (31.5, -0.3), (60.0, 0.3)] {
        let push = Push::Sliding(friction);
        let at = |deflection_mm: f64| {
            let (along_mm, _) = at_object(&rod, object_mm, deflection_mm, friction);
            let aim = rod.aim(along_mm, deflection_mm, push).unwrap();
            let ([.., energy_nmm], _) = rod.shoot(along_mm, aim, push);
            let normal_n = aim[0] * friction.atan().cos();
            (along_mm, force(aim, push)[1], friction * normal_n, energy_nmm)
        };
        let (before, here, after) = (at(4.99), at(5.0), at(5.01));
        let worked_nmm = 0.02 * here.1;
        let rubbed_nmm = (after.0 - before.0) * here.2;
        assert!(rubbed_nmm * friction >= 0.0, "friction takes energy from an object that moves on");
        assert_close(&format!("{object_mm} mm, {friction}"), after.3 - before.3 + rubbed_nmm, worked_nmm, 1e-5);
    }
}

/// The table costs less than the equations, and reads the same.
#[test]
fn property_the_table_interpolates_the_equations() {
    let (geometry, calibration) = (Geometry::nguyen_2021(), Calibration::nguyen_2021());
    for (pressure_mpa, friction) in [(0.1, 0.0), (0.2, 0.3)] {
        let bending = Bending::new(geometry, calibration, Nature { friction, by_volume: 1.0 });
        let whisker = Stretched::new(&geometry, &calibration, 1.0, pressure_mpa);
        for (ratio, length_mm) in [(0.33, 54.0), (0.45, 50.0), (0.45, 70.0), (0.7, 66.0), (0.95, 75.0)] {
            let object_mm = ratio * (length_mm + whisker.elongation_mm);
            for deflection_mm in [0.2, 1.0, 3.3, 6.0] {
                let place = Place { ratio, length_mm, pressure_mpa };
                let read = bending.per_mm(place, deflection_mm, false).unwrap();
                let (_, bent) = at_object(&whisker.rod, object_mm, deflection_mm, friction);
                assert_close("table", read, bent.strain / deflection_mm, 1e-5);
            }
        }
        let place = Place { ratio: 0.5, length_mm: 66.0, pressure_mpa };
        let one = |k: i32| bending.per_mm(place, 0.2 + 5.8 * (f64::from(k) + 0.5) / 200.0, k % 2 == 0).unwrap().ln();
        let mean = (0..200).map(one).sum::<f64>() / 200.0;
        assert!((bending.mean_log_per_mm(place, (0.2, 6.0)).unwrap() - mean).abs() < 1e-4, "{mean}");
        let on_chamber = Place { ratio: 0.2, length_mm: 70.0, pressure_mpa };
        assert_eq!(bending.per_mm(on_chamber, 1.0, false), None);
        // The object at the tip: the whisker does not slide off.
        let tip = Place { ratio: 1.0, length_mm: 70.0, pressure_mpa };
        let at_tip = whisker.rod.bend(70.0 + whisker.elongation_mm, 6.0, Push::Sliding(friction)).unwrap();
        assert_close("tip", bending.per_mm(tip, 6.0, false).unwrap(), at_tip.strain / 6.0, 1e-5);
    }
}

/// How far the strain per mm is from the core's without pressure, in per cent: by the thin wall of the core's chamber at once,
/// and by the way that an object slides outwards with the square of the deflection.
#[test]
fn the_core_reads_up_to_4_per_cent_more_than_the_elastica_without_pressure() {
    let rod = unpressurized().rod;
    let model = Model::nguyen_2021(Formulation::Published);
    for (ratio, friction, expected) in [
        (0.45, 0.0, [-1.21, -1.30, -1.99, -4.26]),
        (0.7, 0.0, [-1.95, -1.99, -2.35, -3.55]),
        (0.95, 0.0, [-2.55, -2.58, -2.82, -3.62]),
        (0.45, 0.3, [-1.21, -1.27, -1.91, -4.09]),
        (0.85, 0.3, [-2.33, -2.29, -2.41, -3.10]),
        (0.95, -0.3, [-2.55, -2.67, -3.07, -4.12]),
    ] {
        let core = model.normal_mode(Millimetre::known(70.0 * ratio)).strain_per_mm;
        for (deflection_mm, expected) in [0.001, 1.0, 3.0, 6.0].into_iter().zip(expected) {
            let (_, bent) = at_object(&rod, 70.0 * ratio, deflection_mm, friction);
            let off = 100.0 * (bent.strain / deflection_mm / core - 1.0);
            assert!((off - expected).abs() < 0.01, "{ratio}, {friction}, {deflection_mm} mm: {off} %");
        }
    }
}

/// The same under pressure for a small deflection, in both formulations, with the wall's thickness of the paper and with that
/// of a wall that keeps its volume.
#[test]
fn the_core_and_the_elastica_differ_by_up_to_8_per_cent_under_pressure() {
    for (formulation, by_volume, pressure_mpa, expected) in [
        (Formulation::Consistent, 0.0, 0.05, [-1.49, -2.21, -2.75]),
        (Formulation::Consistent, 0.0, 0.1, [-1.12, -1.67, -2.18]),
        (Formulation::Consistent, 0.0, 0.2, [-0.79, -0.82, -1.05]),
        (Formulation::Published, 0.0, 0.1, [1.97, 3.41, 4.56]),
        (Formulation::Consistent, 1.0, 0.05, [-1.84, -2.94, -3.75]),
        (Formulation::Consistent, 1.0, 0.1, [-1.59, -3.18, -4.52]),
        (Formulation::Consistent, 1.0, 0.2, [0.21, -2.64, -5.75]),
        (Formulation::Published, 1.0, 0.1, [1.49, 1.83, 2.06]),
        (Formulation::Published, 1.0, 0.2, [5.05, 6.30, 7.41]),
    ] {
        let model = Model::nguyen_2021(formulation);
        let morphology = model.morphology(Megapascal::known(pressure_mpa));
        let nature = Nature { friction: 0.0, by_volume };
        let bending = Bending::new(Geometry::nguyen_2021(), Calibration::nguyen_2021(), nature);
        let off = [0.45, 0.7, 0.95].map(|ratio| {
            let (at, length_mm) = (ContactRatio::known(ratio), 70.0);
            let core = model.sensitivity_per_mm(at, Millimetre::known(length_mm), &morphology).unwrap();
            let read = bending.per_mm(Place { ratio, length_mm, pressure_mpa }, 0.001, false).unwrap();
            100.0 * (read / core - 1.0)
        });
        let is_close = off.iter().zip(expected).all(|(off, expected): (&f64, f64)| (off - expected).abs() < 0.01);
        assert!(is_close, "{formulation:?}, {by_volume}, {pressure_mpa} MPa: {off:?} %");
    }
}
