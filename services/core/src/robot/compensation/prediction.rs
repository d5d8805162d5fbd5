//! Uncertainty of a candidate's predicted error, before the setpoint is tried.
//!
//! Causes: the change of this chamber's rubber with the pressure (10 %, and the choice of formulation), the deviations
//! of the whole target and compensator from the model at their nominal pressures, the compensator's length, a step of the
//! robot that hides in lasting noise. All causes vary together; 95 % of the cases lie in the interval. As long as no visit at another
//! pressure tells how the response changes, the lower end also serves a chamber whose wall keeps its volume.

use crate::estimation::cubature::CASES;
use crate::estimation::uncertainty::{Curve, Uncertain, interval95, mean_error};
use crate::estimation::{Belief, Smooth};
use crate::mechanics::{ByRatio, CONTACT_RATIOS, EVEN_WEIGHTS, LOG_MODULUS, Model, Objective, Setpoint};
use crate::policy::Fitness;
use crate::robot::Robot;
use crate::robot::compensation::error_measurement::UNNOTICED_SHIFT_SD;
use crate::robot::compensation::responses::{AFTER, BEFORE, TARGET, by_length, curve, log_curve, over, sum};
use crate::robot::effect::WhiskerIndex;
use crate::robot::params::Params;
use crate::units::{Megapascal, Millimetre};

/// Cases of one decision for all its candidates together, and the fewest for each: a decision over a large array must
/// not take seconds.
const CASES_A_DECISION: usize = 12_800;
const CASES_MIN: u32 = 16;

/// Share of the cases above the lower end of a prediction with a wall that keeps its volume. Few cases lie near that end, where the
/// level fits and only the shape is wrong. Of 50 compensations in the row `wall` the intervals hold 40 with 97.5 % of all cases, and
/// 50 with 99 % of half of them.
const LOWER: f64 = 0.99;

/// Cases for each of so many candidates.
pub(in crate::robot) fn cases_for_each(candidates: usize) -> u32 {
    let share = CASES_A_DECISION / candidates.max(1);
    u32::try_from(share).unwrap_or(CASES).clamp(CASES_MIN, CASES)
}

impl Robot {
    /// The 95 % interval of the mean error (Eq. 35) that a candidate will have at its setpoint, as ratios.
    pub(in crate::robot) fn predicted_interval(
        &self,
        params: &Params,
        (target, compensator): (WhiskerIndex, WhiskerIndex),
        (fitness, belief): (&Fitness<'_>, &Belief),
        setpoint: &Setpoint,
        cases: u32,
    ) -> Option<(f64, f64)> {
        let (broken, one) = (&self.whiskers[target], &self.whiskers[compensator]);
        let (model, target_model) = (fitness.model, broken.model(params)?);
        let (own, whole) = (Smooth::through(&one.whole), Smooth::through(&broken.whole));
        let family = model.family(belief.predict[LOG_MODULUS]);
        let changes = |pressure: Megapascal| family.log_changes(model, fitness.length, pressure);
        let (from, to) = (changes(fitness.pressure), changes(setpoint.pressure));

        let mut known = [true; CONTACT_RATIOS.len()];
        // The line that the filter holds by now, and the bend that only the bins know.
        let since_whole = curve(fitness.offset.beyond(one.whole_offset()));
        let differs = sum(&own.by_ratio(), &since_whole);
        let before = sum(&log_curve(model, fitness.length, fitness.pressure, &mut known), &differs);
        let moved = Belief::change(&belief.mean, &from, &to);
        let by_gain = [setpoint.reading_gain.ln(); CONTACT_RATIOS.len()];
        let after = sum(&sum(&log_curve(model, fitness.length, setpoint.pressure, &mut known), &differs), &moved);
        let after = sum(&after, &by_gain);
        let at_target = log_curve(target_model, broken.sheet.length, broken.sheet.pressure, &mut known);
        let mut responses = Uncertain { mean: [after, before, sum(&at_target, &whole.by_ratio())], causes: Vec::new() };

        if target == compensator {
            // It moves all three alike, and with that nothing in Eq. 35.
            responses.moves(&own.causes(), &[]);
        } else {
            responses.moves(&own.causes(), &[AFTER, BEFORE]);
            responses.moves(&whole.causes(), &[TARGET]);
        }
        responses.moves(&belief.causes(&from, &to), &[AFTER]);
        let sd_mm = one.filter.relative_length().sd_mm;
        responses.moves(&[by_length(model, fitness.length, fitness.pressure, sd_mm)], &[AFTER, BEFORE]);
        if one.noise.is_lasting(&params.noise) {
            responses.moves(&[[UNNOTICED_SHIFT_SD; CONTACT_RATIOS.len()]], &[AFTER, BEFORE]);
        }
        let weights = match fitness.objective {
            Objective::Tip | Objective::Mean => &EVEN_WEIGHTS,
            Objective::Shape => &fitness.usual.weights,
        };
        let weights = over(&known, weights);
        let of = |[after, before, target]: &[Curve; 3]| mean_error(after, before, target, &weights);
        let (mut low, high) = interval95(responses.some_cases(cases, of));
        if setpoint.pressure != fitness.pressure && !one.knows_own_calibration() {
            let by_wall = wall_by_volume(model, fitness.length, (fitness.pressure, setpoint.pressure));
            responses.mean[AFTER] = sum(&responses.mean[AFTER], &by_wall);
            low = low.min(lower_end(responses.some_cases(cases / 2, of)));
        }
        Some((low.min(setpoint.error.mean), high.max(setpoint.error.mean)))
    }
}

/// The value that [`LOWER`] of the values exceed.
fn lower_end(mut values: Vec<f64>) -> f64 {
    let at = (values.len() as f64 * (1.0 - LOWER)) as usize;
    *values.select_nth_unstable_by(at, f64::total_cmp).1
}

/// By how much more ln s changes between two pressures if the chamber's wall keeps its volume.
fn wall_by_volume(model: &Model, length: Millimetre, (from, to): (Megapascal, Megapascal)) -> Curve {
    let other = model.with_wall_by_volume();
    let of = |model: &Model, pressure: Megapascal| model.log_sensitivities(length, pressure);
    let (before, after) = ((of(&other, from), of(model, from)), (of(&other, to), of(model, to)));
    let off =
        |(other, own): &(ByRatio, ByRatio), k: usize| other[k].zip(own[k]).map_or(0.0, |(other, own)| other - own);
    std::array::from_fn(|k| off(&after, k) - off(&before, k))
}
