//! Air for the shape, gain for the level: [`Objective::Shape`].

use vibrissa_core::mechanics::{
    ByRatio, CONTACT_RATIOS, Compensator, EVEN_WEIGHTS, Formulation, Model, Objective, Offset, RatioWeights, Setpoint,
    Solution, UsualContacts, compensation_error, solve_setpoint, solve_setpoint_as_felt,
};
use vibrissa_core::units::{ContactRatio, Megapascal};

use super::{compensator, mm, mpa, target};

fn solve(model: &Model, asked: Compensator, target_mm: f64) -> Solution {
    solve_setpoint(model, target(target_mm, 0.1), Offset::NONE, model, asked, Offset::NONE, Objective::Shape).unwrap()
}

fn shape(model: &Model, length_mm: f64, target_mm: f64) -> Setpoint {
    *solve(model, compensator(length_mm, 0.1), target_mm).setpoint()
}

/// Mean error in %, pressure in MPa and gain, as a program independent of this one computes them from the paper's
/// equations. It minimises the mean error itself, so its pressure differs by up to 5 kPa where the error is flat.
#[test]
fn golden_air_for_the_shape_leaves_one_number() {
    let models = [Formulation::Published, Formulation::Consistent].map(Model::nguyen_2021);
    for (length_mm, target_mm, errors, pressure_mpa, gain) in [
        (68.0, 70.0, [0.6, 0.6], 0.092, 0.955),
        (65.0, 70.0, [0.5, 0.5], 0.082, 0.887),
        (62.0, 70.0, [0.3, 0.3], 0.070, 0.825),
        (60.0, 70.0, [0.3, 0.3], 0.062, 0.784),
        (55.0, 70.0, [0.3, 0.3], 0.040, 0.690),
        (50.0, 70.0, [0.3, 0.3], 0.016, 0.603),
        (40.0, 70.0, [2.0, 1.5], 0.0, 0.397),
        (70.0, 65.0, [0.6, 0.5], 0.120, 1.128),
    ] {
        let [published, consistent] = models.each_ref().map(|model| shape(model, length_mm, target_mm));
        let name = format!("{length_mm} mm for {target_mm} mm: {published:?} {consistent:?}");
        assert!((published.pressure.mpa() - pressure_mpa).abs() < 0.005, "{name}");
        assert!((published.reading_gain - gain).abs() < 0.01, "{name}");
        for (setpoint, percent) in [(published, errors[0]), (consistent, errors[1])] {
            assert!((100.0 * setpoint.error.mean - percent).abs() < 0.15, "{name}");
        }
    }
}

/// The paper's pressure for the tip leaves 20 %, and moves three times as much air.
#[test]
fn paper_case_1_with_a_gain_moves_a_third_of_the_air() {
    let model = Model::nguyen_2021(Formulation::Published);
    let setpoint = shape(&model, 65.0, 70.0);
    assert!(setpoint.error.mean < 0.006 && setpoint.air_error > 0.5, "{setpoint:?}");
    assert!((0.1 - setpoint.pressure.mpa()) < 0.4 * (0.1 - 0.048), "{setpoint:?}");
    assert_eq!(setpoint.gain.by_ratio, [setpoint.reading_gain; CONTACT_RATIOS.len()]);
}

/// A robot without air, or without a choice of pressure, has the gain alone: 6.6 % instead of 100 %.
#[test]
fn golden_the_gain_alone_serves_without_air() {
    let model = Model::nguyen_2021(Formulation::Published);
    let fixed = Compensator { pressure_min: mpa(0.1), pressure_max: mpa(0.1), ..compensator(65.0, 0.1) };
    let setpoint = match solve(&model, fixed, 70.0) {
        Solution::InRange(setpoint) => setpoint,
        other => panic!("{other:?}"),
    };
    assert_eq!((setpoint.pressure.mpa(), (1000.0 * setpoint.error.mean).round()), (0.1, 66.0), "{setpoint:?}");
    assert!((setpoint.air_error - 1.0).abs() < 1e-12, "{setpoint:?}");
}

/// ln(target / compensator) at all contact ratios.
fn logs(model: &Model, length_mm: f64, target_mm: f64, q: Megapascal) -> [f64; CONTACT_RATIOS.len()] {
    CONTACT_RATIOS.map(|a| {
        let at = |length_mm: f64, q: Megapascal| {
            model.sensitivity_per_mm(ContactRatio::new(a).unwrap(), mm(length_mm), &model.morphology(q)).unwrap()
        };
        (at(target_mm, mpa(0.1)) / at(length_mm, q)).ln()
    })
}

fn moments(weights: &RatioWeights, logs: &[f64; CONTACT_RATIOS.len()]) -> (f64, f64) {
    let all: f64 = weights.iter().sum();
    let mean_of =
        |of: &dyn Fn(f64) -> f64| weights.iter().zip(logs).map(|(weight, log)| weight * of(*log)).sum::<f64>();
    let mean = mean_of(&|log| log) / all;
    (mean, mean_of(&|log| (log - mean).powi(2)) / all)
}

/// A robot that touches its whiskers near the tip, mostly.
const NEAR_THE_TIP: RatioWeights = [0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 2.0, 5.0, 2.0, 0.1, 0.1];

fn weighted(model: &Model, length_mm: f64, target_mm: f64, weights: &RatioWeights) -> Setpoint {
    usual(model, length_mm, target_mm, &UsualContacts { weights: *weights, ..UsualContacts::UNKNOWN })
}

fn usual(model: &Model, length_mm: f64, target_mm: f64, usual: &UsualContacts) -> Setpoint {
    let straight = |_: Megapascal| [0.0; CONTACT_RATIOS.len()];
    *solve_setpoint_as_felt(
        (model, target(target_mm, 0.1), &straight),
        (model, compensator(length_mm, 0.1), &straight),
        Objective::Shape,
        usual,
    )
    .unwrap()
    .setpoint()
}

/// Sensitivities at all contact ratios, 1/mm.
fn per_mm(model: &Model, length_mm: f64, q: Megapascal) -> [f64; CONTACT_RATIOS.len()] {
    CONTACT_RATIOS
        .map(|a| model.sensitivity_per_mm(ContactRatio::new(a).unwrap(), mm(length_mm), &model.morphology(q)).unwrap())
}

/// Eq. 35 by its definition, each contact ratio with its weight.
#[test]
fn brute_force_the_predicted_error_has_the_weights_of_the_contacts() {
    let model = Model::nguyen_2021(Formulation::Published);
    for (length_mm, target_mm) in [(65.0, 70.0), (55.0, 70.0), (70.0, 65.0)] {
        for weights in [EVEN_WEIGHTS, NEAR_THE_TIP] {
            let ours = weighted(&model, length_mm, target_mm, &weights);
            let [after, before] = [ours.pressure, mpa(0.1)].map(|q| per_mm(&model, length_mm, q));
            let target = per_mm(&model, target_mm, mpa(0.1));
            let error = |k: usize| compensation_error(ours.reading_gain * after[k], before[k], target[k]).unwrap();
            let sum: f64 = (0..CONTACT_RATIOS.len()).map(|k| weights[k] * error(k)).sum();
            let expected = sum / weights.iter().sum::<f64>();
            assert!((ours.error.mean - expected).abs() < 1e-12, "{length_mm} for {target_mm}: {ours:?} {expected}");
        }
    }
}

/// Strains of the target's usual largest deflection reach the end of the gauge's range at 0.45 and are below it elsewhere.
#[test]
fn brute_force_the_best_shape_within_the_range_of_the_gauge() {
    const STEPS: u32 = 20_000;
    let model = Model::nguyen_2021(Formulation::Published);
    let all: ByRatio = [Some(()); CONTACT_RATIOS.len()].map(|_| Some(0.0));
    let near_the_tip: ByRatio = std::array::from_fn(|k| (CONTACT_RATIOS[k] > 0.75).then_some(0.0));
    let mut limited = 0;
    for (length_mm, target_mm) in [(69.0, 70.0), (65.0, 70.0), (60.0, 70.0), (55.0, 70.0), (70.0, 65.0)] {
        let target = per_mm(&model, target_mm, mpa(0.1));
        for touched in [all, near_the_tip] {
            // The range ends at this share of the target's own largest sensitivity where the robot touches.
            for share in [0.9, 1.0, 1.05, 1.2, 2.0] {
                let largest =
                    (0..target.len()).filter(|&k| touched[k].is_some()).map(|k| target[k]).fold(0.0, f64::max);
                let per_mm_max = touched.map(|one| one.map(|_| share * largest));
                let fits = |q: f64| {
                    let after = per_mm(&model, length_mm, mpa(q));
                    let limit = |k: usize| Some(per_mm_max[k]?.max(target[k]));
                    (0..after.len()).all(|k| limit(k).is_none_or(|limit| after[k] <= limit * (1.0 + 1e-9)))
                };
                let variance = |q: f64| moments(&EVEN_WEIGHTS, &logs(&model, length_mm, target_mm, mpa(q))).1;
                let grid = (0..=STEPS).map(|k| 0.2 * f64::from(k) / f64::from(STEPS)).filter(|&q| fits(q));
                let best = grid.min_by(|a, b| variance(*a).total_cmp(&variance(*b))).unwrap_or(0.0);
                let ours = usual(&model, length_mm, target_mm, &UsualContacts { weights: EVEN_WEIGHTS, per_mm_max });
                let name = format!("{length_mm} for {target_mm}, {share}: {} and {best}", ours.pressure.mpa());
                assert!((ours.pressure.mpa() - best).abs() <= 0.2 / f64::from(STEPS), "{name}");
                assert!(fits(ours.pressure.mpa()) || best == 0.0, "{name}");
                let free = weighted(&model, length_mm, target_mm, &EVEN_WEIGHTS);
                assert!(
                    ours.pressure.mpa() <= free.pressure.mpa() + 1e-9,
                    "more air is taken away, never less: {name}"
                );
                limited += u32::from(ours.pressure != free.pressure);
            }
        }
    }
    assert!(limited > 10, "{limited}");
}

#[test]
fn without_a_range_of_the_gauge_the_pressure_is_the_same_to_the_last_bit() {
    let model = Model::nguyen_2021(Formulation::Published);
    let wide = UsualContacts { per_mm_max: [Some(1.0); CONTACT_RATIOS.len()], ..UsualContacts::UNKNOWN };
    for (length_mm, target_mm) in [(65.0, 70.0), (55.0, 70.0), (70.0, 65.0)] {
        let free = shape(&model, length_mm, target_mm);
        assert_eq!(usual(&model, length_mm, target_mm, &UsualContacts::UNKNOWN), free);
        assert_eq!(usual(&model, length_mm, target_mm, &wide), free);
    }
}

/// Where the robot touches, the reading is better for it.
#[test]
fn property_the_shape_is_best_where_the_weights_are() {
    for formulation in [Formulation::Published, Formulation::Consistent] {
        let model = Model::nguyen_2021(formulation);
        for (length_mm, target_mm) in [(65.0, 70.0), (55.0, 70.0), (40.0, 70.0), (70.0, 65.0)] {
            let error = |weights| {
                let error = weighted(&model, length_mm, target_mm, weights).error;
                error.by_ratio.iter().zip(NEAR_THE_TIP).map(|(error, weight)| weight * error).sum::<f64>()
            };
            let (own, even) = (error(&NEAR_THE_TIP), error(&EVEN_WEIGHTS));
            assert!(own < 0.9 * even, "{length_mm} for {target_mm}: {own} {even}");
        }
    }
}

/// Ever finer grids around the best point of the last one.
#[test]
fn brute_force_the_best_shape() {
    const STEPS: u32 = 200;
    for formulation in [Formulation::Published, Formulation::Consistent] {
        let model = Model::nguyen_2021(formulation);
        for (length_mm, target_mm) in
            [(69.0, 70.0), (65.0, 70.0), (55.0, 70.0), (40.0, 70.0), (70.0, 65.0), (85.0, 70.0)]
        {
            for weights in [EVEN_WEIGHTS, NEAR_THE_TIP] {
                let variance = |q: f64| moments(&weights, &logs(&model, length_mm, target_mm, mpa(q))).1;
                let (mut low, mut high) = (0.0, 0.2);
                let mut best = 0.0;
                let mut valleys = None;
                while high - low > 1e-9 {
                    let grid: Vec<f64> =
                        (0..=STEPS).map(|k| low + (high - low) * f64::from(k) / f64::from(STEPS)).collect();
                    let values: Vec<f64> = grid.iter().map(|&q| variance(q)).collect();
                    valleys.get_or_insert(values.windows(3).filter(|w| w[1] < w[0] && w[1] < w[2]).count());
                    let at = (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap();
                    best = grid[at];
                    (low, high) = (grid[at.saturating_sub(1)], grid[(at + 1).min(values.len() - 1)]);
                }
                let ours = weighted(&model, length_mm, target_mm, &weights);
                let (q, gain) = (ours.pressure, ours.reading_gain);
                assert!((q.mpa() - best).abs() < 1e-8, "{length_mm} for {target_mm}: {} and {best}", q.mpa());
                assert!(variance(q.mpa()) <= variance(best) + 1e-15, "{length_mm} for {target_mm}");
                let expected = moments(&weights, &logs(&model, length_mm, target_mm, q)).0.exp();
                assert!((gain / expected - 1.0).abs() < 1e-9, "{length_mm} for {target_mm}: {gain} and {expected}");
                // One valley, so the search may rely on its grid.
                assert!(valleys.unwrap() <= 1, "{length_mm} for {target_mm}");
            }
        }
    }
}
