//! The measured responses of Eq. 35: smooth curves with the causes of their uncertainty.

use crate::estimation::uncertainty::{Curve, Uncertain, mean_error, moments};
use crate::estimation::{Belief, Carried, CubatureCases, Nominal, OwnCalibration, ResponseBins, Smooth};
use crate::mechanics::{ByRatio, CONTACT_RATIOS, Model, Offset};
use crate::policy::Case;
use crate::robot::Robot;
use crate::robot::compensation::Compensation;
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Indices of the responses.
pub(in crate::robot) const AFTER: usize = 0;
pub(in crate::robot) const BEFORE: usize = 1;
pub(in crate::robot) const TARGET: usize = 2;

/// The three responses of Eq. 35, ln s by contact ratio.
pub(in crate::robot) struct MeasuredResponses {
    pub responses: Uncertain<3>,
    /// The compensator's difference from the model.
    pub held: Smooth,
    /// Where all three are known: the contact lies beyond each chamber.
    pub known: [bool; CONTACT_RATIOS.len()],
}

impl MeasuredResponses {
    /// Eq. 35 with the compensator's response multiplied by a gain: its mean over the contact ratios.
    pub(in crate::robot) fn error(&self, gain: Option<&Curve>) -> f64 {
        self.error_of(log_gain(gain))(&self.responses.mean)
    }

    /// The standard deviation of [`Self::error`].
    pub(in crate::robot) fn error_sd(&self, even: &CubatureCases, gain: Option<&Curve>) -> f64 {
        moments(&self.responses.cases(even, self.error_of(log_gain(gain)))).1
    }

    fn error_of(&self, log_gain: Curve) -> impl Fn(&[Curve; 3]) -> f64 {
        move |[after, before, target]| mean_error(&sum(after, &log_gain), before, target, &self.known)
    }

    /// The remaining gain: target / compensator.
    pub(in crate::robot) fn gain(&self) -> Curve {
        let [after, _, target] = &self.responses.mean;
        std::array::from_fn(|k| (target[k] - after[k]).exp())
    }

    /// The error that a gain measured now would leave, for it is measured no better than the responses.
    pub(in crate::robot) fn error_of_own_gain(&self, even: &CubatureCases) -> f64 {
        moments(&self.responses.cases(even, self.error_of(log_gain(Some(&self.gain()))))).0
    }

    /// A response as sensitivities, where all three are known.
    pub(in crate::robot) fn per_mm(&self, response: usize) -> ByRatio {
        std::array::from_fn(|k| self.known[k].then(|| self.responses.mean[response][k].exp()))
    }
}

impl Robot {
    /// The responses of a running compensation; the compensator's from `after` and the earlier belief `carried`.
    pub(in crate::robot) fn measured_responses(
        &self,
        params: &Params,
        running: &Compensation,
        carried: &Carried,
        after: &ResponseBins,
    ) -> Option<MeasuredResponses> {
        let (one, target) = (&self.whiskers[running.compensator()], &self.whiskers[running.target()]);
        let (model, target_model) = (one.model(params)?, target.model(params)?);
        let held = Smooth::from(carried, after);
        let whole = Smooth::through(&target.whole);
        let mut known = [true; CONTACT_RATIOS.len()];
        let mut log = |model: &Model, length, pressure| log_curve(model, length, pressure, &mut known);
        let after_mean = sum(&log(model, running.length, running.pressure), &held.by_ratio());
        let target_mean = sum(&log(target_model, target.sheet.length, target.sheet.pressure), &whole.by_ratio());
        let (before_mean, before) = if running.case == Case::SelfCompensation {
            // Between its cut and its setpoint the whisker had too few contacts for a measured response: the model at
            // the estimated length, with the deviation that it had while whole.
            let belief = one.belief(model);
            let moved = one.change(model, running.length, (one.sheet.pressure, running.pressure_before), |from, to| {
                Belief::change(&belief.predict, from, to)
            });
            let mean = sum(&log(model, running.length, running.pressure_before), &sum(&whole.by_ratio(), &moved));
            (mean, None)
        } else {
            let before = Smooth::through(running.before.as_ref().unwrap_or(&one.whole));
            (sum(&log(model, one.sheet.length, running.pressure_before), &before.by_ratio()), Some(before))
        };
        let mut responses = Uncertain { mean: [after_mean, before_mean, target_mean], causes: Vec::new() };
        responses.moves(&held.causes(), &[AFTER]);
        match before {
            Some(before) => {
                responses.moves(&whole.causes(), &[TARGET]);
                responses.moves(&before.causes(), &[BEFORE]);
            }
            None => {
                responses.moves(&whole.causes(), &[TARGET, BEFORE]);
                let sd_mm = one.filter.length().sd_mm;
                responses.moves(&[by_length(model, running.length, running.pressure_before, sd_mm)], &[BEFORE]);
            }
        }
        Some(MeasuredResponses { responses, held, known })
    }
}

impl Whisker {
    /// Belief about its own calibration.
    pub(in crate::robot) fn belief(&self, model: &Model) -> Belief {
        let nominal = self.nominal();
        match &self.rare.own {
            Some(own) => own.belief(model, &nominal),
            None => OwnCalibration::default().belief(model, &nominal),
        }
    }

    fn nominal(&self) -> Nominal<'_> {
        Nominal { length: self.sheet.length, pressure: self.sheet.pressure, bins: &self.whole }
    }

    /// Something about the change between two pressures.
    pub(in crate::robot) fn change<T>(
        &self,
        model: &Model,
        length: Millimetre,
        (from, to): (Megapascal, Megapascal),
        of: impl Fn(&crate::mechanics::LogChanges, &crate::mechanics::LogChanges) -> T,
    ) -> T {
        let family = model.family();
        of(&family.log_changes(model, length, from), &family.log_changes(model, length, to))
    }
}

/// The model's ln s; where a contact would lie on the chamber it is 0 and no longer known.
pub(in crate::robot) fn log_curve(
    model: &Model,
    length: Millimetre,
    pressure: Megapascal,
    known: &mut [bool; CONTACT_RATIOS.len()],
) -> Curve {
    let logs = model.log_sensitivities(length, pressure);
    std::array::from_fn(|k| {
        known[k] &= logs[k].is_some();
        logs[k].unwrap_or(0.0)
    })
}

/// By how much ln s moves if the length is one standard deviation more.
pub(in crate::robot) fn by_length(model: &Model, length: Millimetre, pressure: Megapascal, sd_mm: f64) -> Curve {
    let morphology = model.morphology(pressure);
    CONTACT_RATIOS.map(|a| {
        let slope = model.sensitivity_and_slope(ContactRatio::known(a), length, &morphology);
        slope.map_or(0.0, |(_, slope)| slope * sd_mm / (length.mm() + morphology.elongation_mm))
    })
}

fn log_gain(gain: Option<&Curve>) -> Curve {
    gain.map_or([0.0; CONTACT_RATIOS.len()], |gain| gain.map(f64::ln))
}

/// A straight line's values.
pub(in crate::robot) fn curve(offset: Offset) -> Curve {
    CONTACT_RATIOS.map(|a| offset.at(ContactRatio::known(a)))
}

pub(in crate::robot) fn sum(one: &Curve, other: &Curve) -> Curve {
    std::array::from_fn(|k| one[k] + other[k])
}
