//! Values printed in the paper, and direct consequences of its equations.

use vibrissa_core::mechanics::{
    Calibration, Compensator, Formulation, Geometry, Model, Objective, Offset, Setpoint, Solution, compensable_range,
    solve_setpoint,
};
use vibrissa_core::units::{ContactRatio, Megapascal};

use super::{compensator, mm, mpa, target};

fn tip(model: &Model, compensator_mm: f64, target_mm: f64, pressure_mpa: f64) -> Solution {
    solve_setpoint(
        model,
        target(target_mm, pressure_mpa),
        Offset::NONE,
        model,
        compensator(compensator_mm, pressure_mpa),
        Offset::NONE,
        Objective::Tip,
    )
    .unwrap()
}

fn in_range(solution: Solution) -> Setpoint {
    match solution {
        Solution::InRange(setpoint) => setpoint,
        Solution::NeedsBelow(_) | Solution::NeedsAbove(_) => panic!("out of range: {solution:?}"),
    }
}

fn printed(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}")
}

#[test]
fn paper_case_1_and_self_compensation() {
    let setpoint = in_range(tip(&Model::nguyen_2021(Formulation::Published), 65.0, 70.0, 0.1));
    assert_eq!(printed(setpoint.pressure.mpa(), 4), "0.0480");
    assert_eq!(printed(setpoint.k2, 4), "1.5033");
    // The paper measured 20.385 %.
    assert_eq!(printed(100.0 * setpoint.error.mean, 2), "20.21");
}

#[test]
fn paper_case_2() {
    let setpoint = in_range(tip(&Model::nguyen_2021(Formulation::Published), 70.0, 65.0, 0.1));
    assert_eq!(printed(setpoint.pressure.mpa(), 3), "0.192");
    assert_eq!(printed(setpoint.k2, 4), "0.7365");
    // The paper measured 36.1837 %.
    assert_eq!(printed(100.0 * setpoint.error.mean, 2), "42.76");
}

#[test]
fn paper_cases_in_the_consistent_formulation() {
    let model = Model::nguyen_2021(Formulation::Consistent);
    let (case_1, case_2) = (in_range(tip(&model, 65.0, 70.0, 0.1)), in_range(tip(&model, 70.0, 65.0, 0.1)));
    assert_eq!(printed(case_1.pressure.mpa(), 4), "0.0570");
    assert_eq!(printed(100.0 * case_1.error.mean, 2), "21.28");
    assert_eq!(printed(case_2.pressure.mpa(), 4), "0.1561");
    assert_eq!(printed(100.0 * case_2.error.mean, 2), "34.46");
}

#[test]
fn paper_least_mean_error_of_case_1() {
    let model = Model::nguyen_2021(Formulation::Published);
    let solution = solve_setpoint(
        &model,
        target(70.0, 0.1),
        Offset::NONE,
        &model,
        compensator(65.0, 0.1),
        Offset::NONE,
        Objective::Mean,
    );
    let setpoint = in_range(solution.unwrap());
    assert_eq!(printed(setpoint.pressure.mpa(), 4), "0.0407");
    assert_eq!(printed(100.0 * setpoint.error.mean, 1), "15.3");
}

#[test]
fn paper_compensable_range() {
    let model = Model::nguyen_2021(Formulation::Published);
    for (pressure_mpa, shortest_mm, longest_mm) in
        [(0.05, "63.9", "82.5"), (0.1, "59.6", "76.2"), (0.15, "56.9", "72.2"), (0.2, "55.4", "70.0")]
    {
        let (shortest, longest) =
            compensable_range(&model, target(70.0, pressure_mpa), Megapascal::ZERO, Megapascal::EXAMINED_MAX);
        assert_eq!(printed(shortest.mm(), 1), shortest_mm);
        assert_eq!(printed(longest.mm(), 1), longest_mm);
        let inside = [shortest.mm() + 0.01, longest.mm() - 0.01];
        assert!(inside.iter().all(|&length| matches!(tip(&model, length, 70.0, pressure_mpa), Solution::InRange(_))));
        assert!(matches!(tip(&model, shortest.mm() - 0.01, 70.0, pressure_mpa), Solution::NeedsBelow(_)));
        assert!(matches!(tip(&model, longest.mm() + 0.01, 70.0, pressure_mpa), Solution::NeedsAbove(_)));
    }
}

#[test]
fn paper_sensitivity_falls_with_length() {
    let model = Model::nguyen_2021(Formulation::Published);
    let morphology = model.morphology(mpa(0.1));
    for (a, printed_slope) in [(1.0, "-2.43"), (0.45, "-1.84")] {
        let (_, slope) = model.sensitivity_and_slope(ContactRatio::new(a).unwrap(), mm(70.0), &morphology).unwrap();
        let with_length = slope * 70.0 / (70.0 + morphology.elongation_mm);
        assert_eq!(printed(with_length, 2), printed_slope, "a = {a}");
    }
}

#[test]
fn paper_calibration_constants() {
    assert_eq!(printed(Geometry::nguyen_2021().elongation_gain_mm(), 7), "8.6766199");
    let model = Model::nguyen_2021(Formulation::Published);
    assert_eq!(printed(model.k2(mpa(0.1)), 4), "1.1036");
    // Fig. 3B: both modes agree at zero pressure.
    let tip = model.response(ContactRatio::TIP, mm(70.0), &model.morphology(Megapascal::ZERO)).unwrap();
    let normal = model.normal_mode(mm(70.0));
    let k2 = Calibration::nguyen_2021().c + Calibration::nguyen_2021().a;
    assert!((tip.delta2_per_mm * k2 / normal.delta2_per_mm - 1.0).abs() < 1e-12);
}

/// "The damaged zone must not be within the length of region 2."
#[test]
fn paper_cut_into_the_chamber_is_refused() {
    let model = Model::nguyen_2021(Formulation::Published);
    assert!(model.check_length(mm(15.001)).is_ok());
    let refusal = model.check_length(mm(15.0)).unwrap_err();
    assert_eq!(refusal.to_string(), "a whisker of 15 mm is cut into its chamber, which ends at 15 mm");
    let short = Compensator { length: mm(14.0), ..compensator(65.0, 0.1) };
    let solve = |target_mm: f64, asked: Compensator| {
        solve_setpoint(&model, target(target_mm, 0.1), Offset::NONE, &model, asked, Offset::NONE, Objective::Tip)
    };
    assert!(solve(70.0, short).is_err());
    assert!(solve(14.0, compensator(65.0, 0.1)).is_err());
}
