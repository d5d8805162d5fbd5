//! Compares closed forms with numerical quadrature of the printed integrals, for a whisker with different tapers, and
//! searches with fine grids.

use vibrissa_core::mechanics::{
    CONTACT_RATIOS, Calibration, Formulation, Geometry, Model, Objective, Offset, Solution, compensation_error,
    solve_setpoint,
};
use vibrissa_core::units::ContactRatio;

use super::{assert_close, compensator, mm, mpa, ratio, target};

const RELATIVE: f64 = 1e-9;

/// Simpson's rule with 2000 intervals.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (n, step) = (2000, (to - from) / 2000.0);
    let inner: f64 = (1..n).map(|k| f(from + step * f64::from(k)) * if k % 2 == 1 { 4.0 } else { 2.0 }).sum();
    (f(from) + f(to) + inner) * step / 3.0
}

/// A wall that becomes thinner towards the base: D2 / L2 and Dm / Lm differ.
fn unequal_tapers() -> Geometry {
    Geometry {
        d1_large_mm: 22.0,
        l1_mm: 200.0,
        d2_large_mm: 21.5,
        l2_mm: 190.0,
        d3_large_mm: 19.0,
        l3_mm: 140.0,
        d2_mid_large_mm: 18.75,
        d2_mid_small_mm: 16.28,
        l2_mid_mm: 129.05,
        dm_large_mm: 16.0,
        dm_small_mm: 12.98,
        lm_mm: 90.0,
        c_mm: 3.0,
        t_mm: 3.3,
        l_mm: 20.0,
        e_mm: 3.0,
        xss_mm: 8.0,
        poisson_ratio: 0.47,
    }
}

/// An outer and an inner cone of equal length, the other case in which a term of eq. 24's closed form vanishes.
fn equal_cones() -> Geometry {
    Geometry { lm_mm: 190.0, ..unequal_tapers() }
}

fn models() -> Vec<Model> {
    let mut models = Vec::new();
    for geometry in [Geometry::nguyen_2021(), unequal_tapers(), equal_cones()] {
        let calibration =
            Calibration { c: 0.6, elongation_gain_mm: geometry.elongation_gain_mm(), ..Calibration::nguyen_2021() };
        for formulation in [Formulation::Published, Formulation::Consistent] {
            models.push(Model::new(geometry, calibration, formulation).unwrap());
        }
    }
    models
}

/// Eq. 24 without Q / E2, as printed, between two cross sections.
fn elongation_by_quadrature(g: &Geometry, from_mm: f64, to_mm: f64) -> f64 {
    let factor = g.dm_small_mm.powi(2) * g.l2_mm.powi(2) * g.lm_mm.powi(2);
    let denominator = |x: f64| {
        g.d2_large_mm.powi(2) * g.lm_mm.powi(2) * (g.l2_mm - x + g.c_mm).powi(2)
            - g.dm_large_mm.powi(2) * g.l2_mm.powi(2) * (g.lm_mm - x + g.c_mm).powi(2)
    };
    factor * integral(from_mm, to_mm, |x| 1.0 / denominator(x))
}

#[test]
fn brute_force_elongation() {
    for model in models() {
        let g = model.geometry();
        let whole = elongation_by_quadrature(g, g.c_mm, g.l_mm);
        assert_close("G", g.elongation_gain_mm(), whole, RELATIVE);
        let pressure = mpa(0.13);
        let morphology = model.morphology(pressure);
        let before_gauge = elongation_by_quadrature(g, g.c_mm, g.xss_mm) / whole * morphology.elongation_mm;
        assert_close("x_ss^q", morphology.gauge_start_mm, g.xss_mm + before_gauge, RELATIVE);
        let e2_mpa = model.k2(pressure) * model.calibration().youngs_modulus_mpa;
        let stretch_mm = elongation_by_quadrature(g, g.xss_mm, g.xss_mm + g.e_mm) * 0.13 / e2_mpa;
        assert_close("axial strain", model.axial_strain(pressure).ratio(), stretch_mm / g.e_mm, RELATIVE);
    }
}

/// delta1, delta2, delta3, kappa and f from the integrals of eq. 8 and 30 with the sizes of Table 2.
fn response_by_quadrature(model: &Model, contact_mm: f64, pressure_mpa: f64) -> [f64; 5] {
    let (g, cal) = (model.geometry(), model.calibration());
    let k2 = cal.c + cal.a * (-cal.b_per_mpa * pressure_mpa).exp();
    let stretch = cal.elongation_gain_mm * pressure_mpa / (k2 * cal.youngs_modulus_mpa);
    let radius = |x: f64| g.d2_large_mm / 2.0 * (g.l2_mm - x + g.c_mm) / g.l2_mm;
    let thinning = |x: f64| g.poisson_ratio * stretch * radius(x) / (g.l_mm - g.c_mm);
    let t = g.t_mm - (thinning(g.c_mm + 0.5) + thinning(g.l_mm)) / 2.0;
    let (d_large, d_small) = (g.d2_mid_large_mm - g.t_mm + t, g.dm_small_mm + t);
    let l = g.l_mm + stretch;
    let cone = d_large * (l - g.c_mm) / (d_large - d_small);
    let cubed = if model.formulation() == Formulation::Published { g.l2_mid_mm } else { cone };
    let gauge = g.xss_mm
        + stretch * elongation_by_quadrature(g, g.c_mm, g.xss_mm) / elongation_by_quadrature(g, g.c_mm, g.l_mm);
    let arm = |x: f64| contact_mm - x;
    let delta1 =
        64.0 * (g.l1_mm / g.d1_large_mm).powi(4) * integral(0.0, g.c_mm, |x| arm(x).powi(2) / (g.l1_mm - x).powi(4));
    let delta2 = 8.0 * (cubed / d_large).powi(3) / (k2 * t)
        * integral(g.c_mm, l, |x| arm(x).powi(2) / (cone - x + g.c_mm).powi(3));
    let delta3 = 64.0
        * (g.l3_mm / g.d3_large_mm).powi(4)
        * integral(l, contact_mm, |x| arm(x).powi(2) / (g.l3_mm - x + l).powi(4));
    let kappa = integral(gauge, gauge + g.e_mm, |x| {
        let u = cone - x + g.c_mm;
        (d_large / cone * u + t) * arm(x) / u.powi(3)
    });
    let f = 4.0 * (cubed / d_large).powi(3) / (k2 * t) * kappa / (delta1 + delta2 + delta3);
    [delta1, delta2, delta3, kappa, f]
}

#[test]
fn brute_force_response() {
    for model in models() {
        for (a, length_mm, pressure_mpa) in
            [(1.0, 70.0, 0.0), (0.45, 60.0, 0.1), (0.7, 81.0, 0.2), (0.95, 25.0, 0.05), (1.0, 110.0, 0.17)]
        {
            let ours = model.response(ratio(a), mm(length_mm), &model.morphology(mpa(pressure_mpa))).unwrap();
            let theirs = response_by_quadrature(&model, ours.contact_mm, pressure_mpa);
            let ours = [ours.delta1_per_mm, ours.delta2_per_mm, ours.delta3_per_mm, ours.kappa, ours.f];
            for (name, (ours, theirs)) in
                ["delta1", "delta2", "delta3", "kappa", "f"].iter().zip(ours.into_iter().zip(theirs))
            {
                assert_close(&format!("{name} at {a} of {length_mm} mm, {pressure_mpa} MPa"), ours, theirs, RELATIVE);
            }
        }
    }
}

/// Mean of eq. 35 over all contact ratios at a pressure.
fn mean_error(model: &Model, length_mm: f64, before_mpa: f64, target_mm: f64, target_mpa: f64, q: f64) -> f64 {
    let at = |a: f64, length_mm: f64, q: f64| {
        model.sensitivity_per_mm(ContactRatio::new(a).unwrap(), mm(length_mm), &model.morphology(mpa(q))).unwrap()
    };
    let errors = CONTACT_RATIOS.map(|a| {
        compensation_error(at(a, length_mm, q), at(a, length_mm, before_mpa), at(a, target_mm, target_mpa)).unwrap()
    });
    errors.iter().sum::<f64>() / errors.len() as f64
}

#[test]
fn brute_force_least_mean_error() {
    const STEPS: u32 = 4000;
    for formulation in [Formulation::Published, Formulation::Consistent] {
        let model = Model::nguyen_2021(formulation);
        for (length_mm, before_mpa, target_mm, target_mpa) in [
            (65.0, 0.1, 70.0, 0.1),
            (70.0, 0.1, 65.0, 0.1),
            (60.0, 0.15, 70.0, 0.15),
            (68.0, 0.1, 70.0, 0.1),
            (66.0, 0.02, 70.0, 0.18),
            (55.0, 0.1, 70.0, 0.1),
            (85.0, 0.1, 70.0, 0.1),
            (78.0, 0.05, 71.0, 0.09),
        ] {
            let solution = solve_setpoint(
                &model,
                target(target_mm, target_mpa),
                Offset::NONE,
                &model,
                compensator(length_mm, before_mpa),
                Offset::NONE,
                Objective::Mean,
            )
            .unwrap();
            let ours = solution.setpoint();
            assert_eq!(ours.error.ratios_used(), CONTACT_RATIOS.len());
            let error_at = |q: f64| mean_error(&model, length_mm, before_mpa, target_mm, target_mpa, q);
            assert_close("mean", ours.error.mean, error_at(ours.pressure.mpa()), 1e-12);
            let grid = |k: u32| 0.2 * f64::from(k) / f64::from(STEPS);
            let errors: Vec<f64> = (0..=STEPS).map(|k| error_at(grid(k))).collect();
            let best = (0..=STEPS).min_by(|&a, &b| errors[a as usize].total_cmp(&errors[b as usize])).unwrap();
            assert!(ours.error.mean <= errors[best as usize] + 1e-12, "{} at {}", errors[best as usize], grid(best));
            assert!((ours.pressure.mpa() - grid(best)).abs() <= 0.2 / f64::from(STEPS));
            let expected = match best {
                0 => Solution::NeedsBelow(*ours),
                STEPS => Solution::NeedsAbove(*ours),
                _ => Solution::InRange(*ours),
            };
            assert_eq!(solution, expected);
            // The error has a single minimum, so the search may rely on its grid.
            let valleys = errors.windows(3).filter(|w| w[1] < w[0] && w[1] < w[2]).count();
            assert!(valleys <= 1, "{valleys} valleys for {length_mm} mm as {target_mm} mm");
        }
    }
}
