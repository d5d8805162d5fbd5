//! Compares with `golden.json`, which an independent implementation has computed by numerical quadrature.

use serde_json::Value;
use vibrissa_core::mechanics::{
    CONTACT_RATIOS, Calibration, Formulation, Geometry, Model, Objective, Offset, Response, Solution, solve_setpoint,
};

use super::{assert_close, compensator, mm, mpa, ratio, target};

const RELATIVE: f64 = 1e-9;

fn golden() -> Value {
    serde_json::from_str(include_str!("../../golden/golden.json")).unwrap()
}

fn number(entry: &Value, key: &str) -> f64 {
    entry[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {entry}"))
}

fn entries<'v>(golden: &'v Value, key: &str) -> &'v [Value] {
    let entries = golden[key].as_array().unwrap();
    assert!(!entries.is_empty(), "{key}");
    entries
}

fn assert_response(response: &Response, expected: &Value) {
    let pairs = [
        ("delta1", response.delta1_per_mm),
        ("delta2", response.delta2_per_mm),
        ("delta3", response.delta3_per_mm),
        ("kappa", response.kappa),
        ("f", response.f),
        ("strain_per_mm", response.strain_per_mm),
    ];
    for (key, ours) in pairs {
        assert_close(&format!("{key} of {expected}"), ours, number(expected, key), RELATIVE);
    }
}

#[test]
fn golden_geometry_and_calibration() {
    let golden = golden();
    let (theirs, ours) = (&golden["geometry"], Geometry::nguyen_2021());
    let pairs = [
        ("D1", ours.d1_large_mm),
        ("L1", ours.l1_mm),
        ("D2", ours.d2_large_mm),
        ("L2", ours.l2_mm),
        ("D3", ours.d3_large_mm),
        ("L3", ours.l3_mm),
        ("D2b", ours.d2_mid_large_mm),
        ("L2b", ours.l2_mid_mm),
        ("d2b", ours.d2_mid_small_mm),
        ("Dm", ours.dm_large_mm),
        ("Lm", ours.lm_mm),
        ("dm", ours.dm_small_mm),
        ("c", ours.c_mm),
        ("t", ours.t_mm),
        ("l", ours.l_mm),
        ("e", ours.e_mm),
        ("xss", ours.xss_mm),
        ("nu", ours.poisson_ratio),
        ("inner_diameter_at_c", ours.d2_mid_large_mm - ours.t_mm),
    ];
    for (key, ours) in pairs {
        assert_close(key, ours, number(theirs, key), RELATIVE);
    }
    let (theirs, ours) = (&golden["calibration"], Calibration::nguyen_2021());
    let pairs = [("C", ours.c), ("A", ours.a), ("b", ours.b_per_mpa), ("E", ours.youngs_modulus_mpa)];
    for (key, ours) in pairs {
        assert_close(key, ours, number(theirs, key), RELATIVE);
    }
}

#[test]
fn golden_normal_mode() {
    let model = Model::nguyen_2021(Formulation::Published);
    for expected in entries(&golden(), "normal_mode_eq_10_to_17") {
        let response = model.normal_mode(mm(number(expected, "contact_distance")));
        assert_response(&response, expected);
    }
}

#[test]
fn golden_morphology() {
    let model = Model::nguyen_2021(Formulation::Published);
    for expected in entries(&golden(), "morphology_table_2") {
        let pressure = mpa(number(expected, "Q"));
        let ours = model.morphology(pressure);
        let pairs = [
            ("k2", ours.k2),
            ("delta_l", ours.elongation_mm),
            ("t_q", ours.wall_mm),
            ("D2b_q", ours.d2_mid_large_mm),
            ("d2b_q", ours.d2_mid_small_mm),
            ("L2b_q", ours.l2_mid_mm),
            ("l_q", ours.chamber_end_mm),
            ("x_ss_q", ours.gauge_start_mm),
            ("delta_l", model.elongation(pressure).mm()),
            ("k2", model.k2(pressure)),
        ];
        for (key, ours) in pairs {
            assert_close(&format!("{key} at {} MPa", pressure.mpa()), ours, number(expected, key), RELATIVE);
        }
    }
}

#[test]
fn golden_compensation_mode() {
    for (formulation, key) in [
        (Formulation::Published, "compensation_mode_published"),
        (Formulation::Consistent, "compensation_mode_consistent"),
    ] {
        let model = Model::nguyen_2021(formulation);
        for expected in entries(&golden(), key) {
            let (a, length) = (ratio(number(expected, "a")), mm(number(expected, "La")));
            let morphology = model.morphology(mpa(number(expected, "Q")));
            let response = model.response(a, length, &morphology).unwrap();
            assert_response(&response, expected);
            assert_close("A", response.contact_mm, number(expected, "A"), RELATIVE);
            let sensitivity = model.sensitivity_per_mm(a, length, &morphology).unwrap();
            assert_close("sensitivity", sensitivity, number(expected, "strain_per_mm"), RELATIVE);
            let back = model.length_from_sensitivity(sensitivity, a, &morphology).unwrap();
            assert_close("length", back.mm(), length.mm(), RELATIVE);
        }
    }
}

fn solve(formulation: Formulation, entry: &Value) -> Solution {
    let model = Model::nguyen_2021(formulation);
    let pressure_mpa = number(entry, "initial_pressure");
    solve_setpoint(
        &model,
        target(number(entry, "target_length"), pressure_mpa),
        Offset::NONE,
        &model,
        compensator(number(entry, "compensator_length"), pressure_mpa),
        Offset::NONE,
        Objective::Tip,
    )
    .unwrap()
}

#[test]
fn golden_setpoints() {
    for (formulation, key) in
        [(Formulation::Published, "setpoints_published"), (Formulation::Consistent, "setpoints_consistent")]
    {
        for expected in entries(&golden(), key) {
            let Solution::InRange(ours) = solve(formulation, expected) else {
                panic!("out of range: {expected}");
            };
            let difference_mpa = (ours.pressure.mpa() - number(expected, "Q")).abs();
            assert!(difference_mpa < 1e-9, "pressure off by {difference_mpa} MPa: {expected}");
            // The slope of k2 is at most 15.3 per MPa.
            assert_close("k2", ours.k2, number(expected, "k2"), 1.6e-8);
            assert!((100.0 * ours.error.mean - number(expected, "mean_error_percent")).abs() < 1e-6);
            assert_eq!(ours.error.ratios_used(), CONTACT_RATIOS.len());
            for (a, error) in CONTACT_RATIOS.iter().zip(ours.error.by_ratio) {
                let key = if *a == 1.0 { "1.0".to_owned() } else { format!("{a}") };
                let theirs = number(&expected["error_percent_by_contact_ratio"], &key);
                assert!((100.0 * error - theirs).abs() < 1e-6, "a = {a}: {error} instead of {theirs} %");
            }
        }
    }
}

#[test]
fn golden_out_of_range() {
    for (formulation, key) in
        [(Formulation::Published, "infeasible_published"), (Formulation::Consistent, "infeasible_consistent")]
    {
        for expected in entries(&golden(), key) {
            match (solve(formulation, expected), expected["why"].as_str().unwrap()) {
                (Solution::NeedsBelow(at), "needs a pressure below 0 MPa") => assert_eq!(at.pressure, mpa(0.0)),
                (Solution::NeedsAbove(at), "needs a pressure above 0.2 MPa") => assert_eq!(at.pressure, mpa(0.2)),
                (solution, why) => panic!("{solution:?} instead of: {why}"),
            }
        }
    }
}
