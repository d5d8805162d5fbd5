//! Properties that hold for every whisker in the model's range.

use proptest::prelude::*;
use vibrissa_core::mechanics::{
    CONTACT_RATIOS, Calibration, Compensator, Formulation, Geometry, LengthError, Model, Objective, Offset, Solution,
    compensable_range, compensation_error, solve_setpoint,
};
use vibrissa_core::units::{ContactRatio, Megapascal};

use super::{compensator, mm, mpa, ratio, target};

fn formulations() -> impl Strategy<Value = Formulation> {
    prop_oneof![Just(Formulation::Published), Just(Formulation::Consistent)]
}

/// The paper's geometry with calibration parameters up to 20 % off.
fn models() -> impl Strategy<Value = Model> {
    (formulations(), prop::array::uniform5(0.8..1.2)).prop_map(|(formulation, by)| {
        let known = Calibration::nguyen_2021();
        let calibration = Calibration {
            c: known.c * by[0],
            a: known.a * by[1],
            b_per_mpa: known.b_per_mpa * by[2],
            youngs_modulus_mpa: known.youngs_modulus_mpa * by[3],
            elongation_gain_mm: known.elongation_gain_mm * by[4],
        };
        Model::new(Geometry::nguyen_2021(), calibration, formulation).unwrap()
    })
}

fn offsets() -> impl Strategy<Value = Offset> {
    (-0.1..0.1, -0.1..0.1).prop_map(|(level, slope)| Offset { level, slope })
}

proptest! {
    #[test]
    fn property_sensitivity_falls_with_contact_distance(
        model in models(), a in 0.45..0.99, length_mm in 45.0..120.0, pressure_mpa in 0.0..0.2, farther in 1.001..1.2,
    ) {
        let morphology = model.morphology(mpa(pressure_mpa));
        let at = |a: f64, length_mm: f64| model.sensitivity_per_mm(ratio(a), mm(length_mm), &morphology).unwrap();
        prop_assert!(at(f64::min(a * farther, 1.0), length_mm) < at(a, length_mm));
        prop_assert!(at(a, length_mm * farther) < at(a, length_mm));
    }

    /// Holds at the tip of the paper's whisker, where setpoints are computed. For shorter or softer whiskers, or nearer
    /// to the chamber, the sensitivity has a peak; see the next test.
    #[test]
    fn property_sensitivity_rises_with_pressure(
        formulation in formulations(), length_mm in 52.0..120.0, pressure_mpa in 0.0..0.199, step_mpa in 1e-4..0.2,
    ) {
        let model = Model::nguyen_2021(formulation);
        let higher_mpa = f64::min(pressure_mpa + step_mpa, 0.2);
        let at = |q: f64| {
            model.sensitivity_per_mm(ContactRatio::TIP, mm(length_mm), &model.morphology(mpa(q))).unwrap()
        };
        prop_assert!(at(higher_mpa) > at(pressure_mpa));
    }

    #[test]
    fn property_sensitivity_has_at_most_one_peak_over_pressure(
        model in models(), a in 0.45..1.0, length_mm in 45.0..100.0,
    ) {
        let at = |q: f64| model.sensitivity_per_mm(ratio(a), mm(length_mm), &model.morphology(mpa(q))).unwrap();
        let curve: Vec<f64> = (0..=100).map(|k| at(0.002 * f64::from(k))).collect();
        let first_fall = curve.windows(2).position(|w| w[1] <= w[0]).unwrap_or(curve.len());
        prop_assert!(curve.windows(2).skip(first_fall).all(|w| w[1] < w[0]));
        // From zero pressure on it rises at first.
        prop_assert!(first_fall > 0);
    }

    #[test]
    fn property_in_range_exactly_within_the_compensable_range(
        model in models(), length_mm in 20.0..120.0, target_mm in 20.0..120.0, before_mpa in 0.0..0.2,
    ) {
        let asked = compensator(length_mm, before_mpa);
        let (shortest, longest) =
            compensable_range(&model, target(target_mm, before_mpa), asked.pressure_min, asked.pressure_max);
        prop_assume!((length_mm - shortest.mm()).abs() > 1e-6 && (length_mm - longest.mm()).abs() > 1e-6);
        let solution = solve_setpoint(
            &model, target(target_mm, before_mpa), Offset::NONE, &model, asked, Offset::NONE, Objective::Tip,
        ).unwrap();
        let expected = match solution {
            Solution::InRange(_) => shortest.mm() < length_mm && length_mm < longest.mm(),
            Solution::NeedsBelow(_) => length_mm < shortest.mm(),
            Solution::NeedsAbove(_) => length_mm > longest.mm(),
        };
        prop_assert!(expected, "{length_mm} mm in {shortest:?} to {longest:?}");
    }

    #[test]
    fn property_length_is_the_inverse_of_sensitivity(
        model in models(), a in 0.3..1.0, length_mm in 20.0..170.0, pressure_mpa in 0.0..0.2,
    ) {
        let morphology = model.morphology(mpa(pressure_mpa));
        if let Ok(sensitivity) = model.sensitivity_per_mm(ratio(a), mm(length_mm), &morphology) {
            let back = model.length_from_sensitivity(sensitivity, ratio(a), &morphology).unwrap();
            prop_assert!((back.mm() / length_mm - 1.0).abs() < 1e-9, "{} instead of {length_mm}", back.mm());
        }
    }

    #[test]
    fn property_no_length_beyond_the_ends(
        model in models(), a in 0.2..1.0, pressure_mpa in 0.0..0.2, factor in 1.001..10.0_f64,
    ) {
        let morphology = model.morphology(mpa(pressure_mpa));
        let invert = |s: f64| model.length_from_sensitivity(s, ratio(a), &morphology);
        let longest = model.longest();
        let least = model.sensitivity_per_mm(ratio(a), longest, &morphology).unwrap();
        prop_assert_eq!(invert(least / factor), Err(LengthError::LongerThanCone { nearest: longest }));
        let Err(LengthError::ShorterThanChamber { nearest }) = invert(1e3) else { panic!("a length for 1000 per mm") };
        prop_assert!(model.check_length(nearest).is_ok());
        let greatest = model.sensitivity_per_mm(ratio(a), nearest, &morphology).unwrap();
        prop_assert!(invert(greatest * factor).is_err());
        for nonsense in [0.0, -factor, f64::NAN, f64::INFINITY] {
            let refused = matches!(invert(nonsense), Err(LengthError::NotPositive { .. }));
            prop_assert!(refused);
        }
    }

    #[test]
    fn property_slope_is_the_derivative(
        model in models(), a in 0.45..1.0, length_mm in 45.0..120.0, pressure_mpa in 0.0..0.2,
    ) {
        let morphology = model.morphology(mpa(pressure_mpa));
        let (sensitivity, slope) = model.sensitivity_and_slope(ratio(a), mm(length_mm), &morphology).unwrap();
        let log_at = |length_mm: f64| model.sensitivity_per_mm(ratio(a), mm(length_mm), &morphology).unwrap().ln();
        let step_mm = 1e-3;
        let difference = (log_at(length_mm + step_mm) - log_at(length_mm - step_mm)) / (2.0 * step_mm);
        let numerical = difference * (length_mm + morphology.elongation_mm);
        prop_assert!((slope / numerical - 1.0).abs() < 1e-6, "{slope} instead of {numerical}");
        prop_assert_eq!(sensitivity, model.sensitivity_per_mm(ratio(a), mm(length_mm), &morphology).unwrap());
    }

    #[test]
    fn property_self_compensation_only_lowers_the_pressure(
        model in models(), offset in offsets(), length_mm in 55.0..80.0, cut_mm in 0.01..8.0, pressure_mpa in 0.0..0.2,
    ) {
        let solution = solve_setpoint(
            &model, target(length_mm, pressure_mpa), offset,
            &model, compensator(length_mm - cut_mm, pressure_mpa), offset, Objective::Tip,
        ).unwrap();
        prop_assert!(solution.setpoint().pressure.mpa() <= pressure_mpa);
        let above = matches!(solution, Solution::NeedsAbove(_));
        prop_assert!(!above);
    }

    #[test]
    fn property_setpoint_meets_the_tip_and_is_finite(
        target_model in models(), model in models(), target_offset in offsets(), offset in offsets(),
        length_mm in 20.0..120.0, target_mm in 20.0..120.0, before_mpa in 0.0..0.2, target_mpa in 0.0..0.2,
        objective in prop_oneof![Just(Objective::Tip), Just(Objective::Mean), Just(Objective::Shape)],
    ) {
        let solution = solve_setpoint(
            &target_model, target(target_mm, target_mpa), target_offset,
            &model, compensator(length_mm, before_mpa), offset, objective,
        ).unwrap();
        let setpoint = solution.setpoint();
        prop_assert!((0.0..=0.2).contains(&setpoint.pressure.mpa()));
        prop_assert!(setpoint.error.by_ratio.iter().all(|error| error.is_finite() && *error >= 0.0));
        prop_assert!(setpoint.gain.by_ratio.iter().all(|gain| gain.is_finite() && *gain > 0.0));
        prop_assert!(setpoint.reading_gain == 1.0 || objective == Objective::Shape);
        let used = setpoint.error.by_ratio.iter().zip(setpoint.error.used).filter(|(_, used)| *used);
        let mean = used.map(|(error, _)| error).sum::<f64>() / setpoint.error.ratios_used().max(1) as f64;
        prop_assert!((setpoint.error.mean - mean).abs() <= 1e-12 * mean.max(1.0));
        if objective == Objective::Tip {
            let gain = setpoint.gain.by_ratio[CONTACT_RATIOS.len() - 1];
            match solution {
                Solution::InRange(_) => prop_assert!((gain - 1.0).abs() < 1e-9),
                Solution::NeedsBelow(_) => prop_assert!(gain < 1.0),
                Solution::NeedsAbove(_) => prop_assert!(gain > 1.0),
            }
        }
    }

    #[test]
    fn property_equal_offsets_cancel_at_the_tip(
        model in models(), level in -0.2..0.2, length_mm in 60.0..75.0, pressure_mpa in 0.02..0.18,
    ) {
        let offset = Offset { level, slope: 0.0 };
        let solve = |offset: Offset| solve_setpoint(
            &model, target(70.0, pressure_mpa), offset, &model, compensator(length_mm, pressure_mpa), offset, Objective::Tip,
        ).unwrap().setpoint().pressure.mpa();
        prop_assert!((solve(offset) - solve(Offset::NONE)).abs() < 1e-9);
    }

    #[test]
    fn property_modulus_is_the_inverse_of_axial_strain(model in models(), pressure_mpa in 1e-4..0.2) {
        let strain = model.axial_strain(mpa(pressure_mpa));
        let e2_mpa = model.geometry().youngs_modulus_from_axial_strain(mpa(pressure_mpa), strain).unwrap();
        let expected = model.k2(mpa(pressure_mpa)) * model.calibration().youngs_modulus_mpa;
        prop_assert!((e2_mpa / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn property_compensation_error_is_zero_at_the_target_and_one_before(
        before in 1e-4..1e-1, target in 1e-4..1e-1,
    ) {
        prop_assume!(before != target);
        prop_assert_eq!(compensation_error(target, before, target), Some(0.0));
        prop_assert_eq!(compensation_error(before, before, target), Some(1.0));
        prop_assert_eq!(compensation_error(before, target, target), None);
    }
}

#[test]
fn property_contact_on_the_chamber_is_refused_and_left_out() {
    let model = Model::nguyen_2021(Formulation::Published);
    let morphology = model.morphology(mpa(0.1));
    let chamber_end_mm = model.chamber_end(&morphology).mm();
    // 0.45 of 30 mm is 13.8 mm under pressure, which lies on the chamber.
    let refusal = model.response(ratio(0.45), mm(30.0), &morphology).unwrap_err();
    assert!(refusal.contact_mm < chamber_end_mm);
    let solution = solve_setpoint(
        &model,
        target(32.0, 0.1),
        Offset::NONE,
        &model,
        compensator(30.0, 0.1),
        Offset::NONE,
        Objective::Tip,
    );
    let error = solution.unwrap().setpoint().error;
    let on_body = |a: f64| model.response(ratio(a), mm(30.0), &morphology).is_ok();
    assert_eq!(error.used, CONTACT_RATIOS.map(on_body));
    assert!(error.ratios_used() < CONTACT_RATIOS.len());
    let first_used = error.used.iter().position(|used| *used).unwrap();
    assert_eq!(error.by_ratio[0], error.by_ratio[first_used]);
}

#[test]
fn property_nothing_to_compensate_has_no_error() {
    let model = Model::nguyen_2021(Formulation::Published);
    for objective in [Objective::Tip, Objective::Mean, Objective::Shape] {
        let same = solve_setpoint(
            &model,
            target(70.0, 0.1),
            Offset::NONE,
            &model,
            compensator(70.0, 0.1),
            Offset::NONE,
            objective,
        );
        let Solution::InRange(setpoint) = same.unwrap() else { panic!("out of range") };
        assert!((setpoint.pressure.mpa() - 0.1).abs() < 1e-9);
        assert_eq!((setpoint.error.ratios_used(), setpoint.error.mean), (0, 0.0));
        assert!(setpoint.gain.by_ratio.iter().all(|gain| (gain - 1.0).abs() < 1e-9));
    }
}

#[test]
fn property_range_of_one_pressure() {
    let model = Model::nguyen_2021(Formulation::Published);
    let solve = |length_mm: f64, objective: Objective| {
        let fixed = Compensator { pressure_min: mpa(0.1), pressure_max: mpa(0.1), ..compensator(length_mm, 0.05) };
        solve_setpoint(&model, target(70.0, 0.1), Offset::NONE, &model, fixed, Offset::NONE, objective).unwrap()
    };
    for objective in [Objective::Tip, Objective::Mean] {
        assert!(matches!(solve(70.0, objective), Solution::InRange(_)));
        assert!(matches!(solve(65.0, objective), Solution::NeedsBelow(_)));
        assert!(matches!(solve(75.0, objective), Solution::NeedsAbove(_)));
    }
}

#[test]
fn property_nothing_breaks_at_the_limits_of_the_units() {
    let model = Model::nguyen_2021(Formulation::Published);
    for pressure in [Megapascal::ZERO, Megapascal::EXAMINED_MAX, mpa(1.0)] {
        let morphology = model.morphology(pressure);
        assert!(morphology.wall_mm > 0.0);
        for length in [mm(1000.0), model.longest(), mm(180.0)] {
            let (sensitivity, slope) = model.sensitivity_and_slope(ContactRatio::TIP, length, &morphology).unwrap();
            assert!(sensitivity > 0.0 && sensitivity.is_finite() && slope.is_finite());
        }
    }
    assert!(model.normal_mode(mm(0.0)).f.is_finite() && model.normal_mode(mm(1000.0)).f.is_finite());
}

#[test]
fn property_a_model_is_refused_by_the_condition_that_fails() {
    let (geometry, calibration) = (Geometry::nguyen_2021(), Calibration::nguyen_2021());
    let refusal = |g: Geometry, c: Calibration| Model::new(g, c, Formulation::Published).unwrap_err().to_string();
    assert_eq!(refusal(Geometry { l_mm: 1.0, ..geometry }, calibration), "chamber end l must lie beyond the cap c");
    assert_eq!(refusal(Geometry { t_mm: 0.0, ..geometry }, calibration), "t must be a number above 0, not 0");
    assert!(refusal(Geometry { poisson_ratio: 0.6, ..geometry }, calibration).contains("Poisson"));
    assert!(refusal(Geometry { xss_mm: 14.0, ..geometry }, calibration).contains("x_ss + e"));
    assert!(refusal(Geometry { dm_large_mm: 18.0, ..geometry }, calibration).contains("positive thickness"));
    assert!(refusal(Geometry { d2_mid_small_mm: 14.0, ..geometry }, calibration).contains("1 %"));
    assert!(refusal(geometry, Calibration { c: f64::NAN, ..calibration }).contains("calibration c"));
    assert!(refusal(geometry, Calibration { a: -1.0, ..calibration }).contains("not below 0"));
    assert!(refusal(geometry, Calibration { elongation_gain_mm: 50.0, ..calibration }).contains("gain G is too large"));
    assert_eq!(
        Model::new(geometry, calibration, Formulation::Published).unwrap(),
        Model::nguyen_2021(Formulation::Published)
    );
}

/// The cross section of the wall shrinks as the chamber gets longer, by Poisson's ratio in both directions across it.
#[test]
fn property_a_wall_by_volume_thins_by_its_cross_section() {
    let model = Model::nguyen_2021(Formulation::Published);
    let other = model.with_wall_by_volume();
    let g = *model.geometry();
    let mid_mm = 0.5 * (g.d2_mid_large_mm + g.d2_mid_small_mm);
    let area = |wall_mm: f64| wall_mm * (mid_mm - g.t_mm + wall_mm);
    for pressure in [0.01, 0.05, 0.1] {
        let (own, by_volume) =
            (model.morphology(Megapascal::known(pressure)), other.morphology(Megapascal::known(pressure)));
        let stretch = 1.0 + by_volume.elongation_mm / (g.l_mm - g.c_mm);
        let kept = area(by_volume.wall_mm) / area(g.t_mm) * stretch.powf(2.0 * g.poisson_ratio);
        assert!((kept - 1.0).abs() < 0.01, "{pressure} MPa: {kept}");
        let thinner = (g.t_mm - own.wall_mm) / (g.t_mm - by_volume.wall_mm);
        assert!((thinner - 1.73).abs() < 0.02, "{pressure} MPa: {thinner}");
        assert_eq!(own.elongation_mm, by_volume.elongation_mm);
    }
}
