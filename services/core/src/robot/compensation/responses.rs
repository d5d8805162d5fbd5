//! The measured responses of Eq. 35: smooth curves with the causes of their uncertainty.

use crate::estimation::uncertainty::{Curve, Uncertain, interval95, mean_error, moments};
use crate::estimation::{Belief, Carried, Nominal, OwnCalibration, ResponseBins, Smooth};
use crate::mechanics::{
    ByRatio, CONTACT_RATIOS, EVEN_WEIGHTS, LOG_MODULUS, Model, Objective, Offset, RatioWeights, Setpoint, UsualContacts,
};
use crate::policy::READING_GAINS;
use crate::robot::Robot;
use crate::robot::compensation::Compensation;
use crate::robot::effect::WhiskerIndex;
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// 97.5 % quantile of the standard normal distribution.
const NORMAL_975: f64 = 1.959_964;

/// Largest standard deviation of the compensator's response relative to the target where contacts tell it, log sensitivity: a
/// cut of 5 mm is 0.17.
const TOLD_SD: f64 = 0.05;

/// Contacts from which the distribution of a whisker's contact ratios is known.
const LEARNED_RATIOS_CONTACTS: u32 = 100;
/// Contact ratios with a smaller share of the contacts are not usual.
const USUAL_SHARE: f64 = 0.01;
/// Part of the weights that does not depend on the robot's contacts.
const EVEN_SHARE: f64 = 0.2;

/// Indices of the responses.
pub(in crate::robot) const AFTER: usize = 0;
pub(in crate::robot) const BEFORE: usize = 1;
pub(in crate::robot) const TARGET: usize = 2;

/// Source of the level of a compensator's response.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) enum LevelFrom {
    /// The length filter, if it knows the level better than the averages.
    Filter,
    /// The averaged contacts alone.
    Contacts,
}

/// The three responses of Eq. 35, ln s by contact ratio.
pub(in crate::robot) struct MeasuredResponses {
    pub responses: Uncertain<3>,
    /// The compensator's difference from the model.
    pub held: Smooth,
    /// Where all three are known: the contact lies beyond each chamber.
    pub known: [bool; CONTACT_RATIOS.len()],
    /// Usual contacts of the compensator.
    pub usual: UsualContacts,
}

impl MeasuredResponses {
    /// Eq. 35 with the compensator's response multiplied by a gain: its mean over the contact ratios.
    pub(in crate::robot) fn error(&self, gain: Option<&Curve>) -> f64 {
        self.error_of(log_gain(gain))(&self.responses.mean)
    }

    /// The standard deviation of [`Self::error`].
    pub(in crate::robot) fn error_sd(&self, gain: Option<&Curve>) -> f64 {
        moments(&self.responses.cases(self.error_of(log_gain(gain)))).1
    }

    /// Mean of Eq. 35 over all cases that the contacts leave open, and its standard deviation. The error has a longer tail
    /// above than below: the standard deviation is large enough that the mean and 1.96 of it hold 97.5 of 100 cases.
    /// Contact ratios about which the contacts tell nothing are left out: robots may touch one part of a whisker alone.
    pub(in crate::robot) fn expected_error(&self) -> (f64, f64) {
        let certain_ratios = over(&self.certain_ratios(), &EVEN_WEIGHTS);
        let errors = self.responses.cases(|[after, before, target]| mean_error(after, before, target, &certain_ratios));
        let (mean, sd) = moments(&errors);
        let (_, high) = interval95(errors);
        (mean, sd.max((high - mean) / NORMAL_975))
    }

    /// The contact ratios at which the contacts tell the compensator's response relative to the target; all known ones if
    /// they tell it nowhere.
    fn certain_ratios(&self) -> [bool; CONTACT_RATIOS.len()] {
        let variance = |k: usize| {
            self.responses.causes.iter().map(|cause| (cause[AFTER][k] - cause[TARGET][k]).powi(2)).sum::<f64>()
        };
        let certain_ratios = std::array::from_fn(|k| self.known[k] && variance(k) <= TOLD_SD.powi(2));
        if certain_ratios.contains(&true) { certain_ratios } else { self.known }
    }

    fn error_of(&self, log_gain: Curve) -> impl Fn(&[Curve; 3]) -> f64 {
        let known = over(&self.known, &EVEN_WEIGHTS);
        move |[after, before, target]| mean_error(&sum(after, &log_gain), before, target, &known)
    }

    /// The remaining gain: target / compensator, by contact ratio or as one number.
    pub(in crate::robot) fn gain(&self, objective: Objective) -> Curve {
        let [after, _, target] = &self.responses.mean;
        match objective {
            Objective::Tip | Objective::Mean => std::array::from_fn(|k| (target[k] - after[k]).exp()),
            Objective::Shape => reading_gain(after, target, &over(&self.certain_ratios(), &self.usual.weights)),
        }
    }

    /// The error that a gain measured now would leave, for it is measured no better than the responses.
    pub(in crate::robot) fn error_of_own_gain(&self, objective: Objective) -> f64 {
        moments(&self.responses.cases(self.error_of(log_gain(Some(&self.gain(objective)))))).0
    }

    /// The responses as the robot reads them, with a factor on the compensator's.
    pub(in crate::robot) fn read_with(&mut self, reading_gain: f64) {
        self.responses.mean[AFTER].iter_mut().for_each(|log| *log += reading_gain.ln());
    }

    /// A response as sensitivities, where all three are known.
    pub(in crate::robot) fn per_mm(&self, response: usize) -> ByRatio {
        std::array::from_fn(|k| self.known[k].then(|| self.responses.mean[response][k].exp()))
    }
}

impl Robot {
    /// Usual contacts of a whisker.
    pub(in crate::robot) fn usual_contacts(&self, index: WhiskerIndex) -> UsualContacts {
        let usual = self.whiskers[index].usual_contacts();
        // Where only touch tests have a place, the places are the supervisor's and no habit.
        let weights = if self.states_no_place(index) { EVEN_WEIGHTS } else { usual.weights };
        UsualContacts { weights, ..usual }
    }

    /// The responses of a running compensation; the compensator's from `after` and the earlier belief `carried`.
    pub(in crate::robot) fn measured_responses(
        &self,
        params: &Params,
        running: &Compensation,
        carried: &Carried,
        after: &ResponseBins,
        from: LevelFrom,
    ) -> Option<MeasuredResponses> {
        let (one, target) = (&self.whiskers[running.compensator()], &self.whiskers[running.target()]);
        let (model, target_model) = (one.model(params)?, target.model(params)?);
        let held = Smooth::from(carried, after);
        let whole = Smooth::through(&target.whole);
        let mut known = [true; CONTACT_RATIOS.len()];
        let mut log = |model: &Model, length, pressure| log_curve(model, length, pressure, &mut known);
        let after_mean = sum(&log(model, running.length, running.pressure), &held.by_ratio());
        let target_mean = sum(&log(target_model, target.sheet.length, target.sheet.pressure), &whole.by_ratio());
        let (before_mean, before) = if let Some(before) = &running.before {
            let before = Smooth::through(before);
            (sum(&log(model, running.length_before(one), running.pressure_before), &before.by_ratio()), Some(before))
        } else {
            // Between its cut and its setpoint the whisker had too few contacts for a measured response: the model at
            // the estimated length, with the deviation that it had while whole.
            let belief = one.belief(model);
            let pressures = (one.sheet.pressure, running.pressure_before);
            let moved = one.change(model, &belief, running.length, pressures, |from, to| {
                Belief::change(&belief.predict, from, to)
            });
            let nearer = one.offset_moved_at(running.length);
            let differs = sum(&sum(&whole.by_ratio(), &nearer), &moved);
            let mean = sum(&log(model, running.length, running.pressure_before), &differs);
            (mean, None)
        };
        let mut responses = Uncertain { mean: [after_mean, before_mean, target_mean], causes: Vec::new() };
        self.level(params, running, &held, after, from, &mut responses);
        let sd_mm = one.filter.relative_length().sd_mm.max(running.length_sd_mm);
        let by_length = |pressure| by_length(model, running.length, pressure, sd_mm);
        // Its ratios are distances over the estimated length.
        let is_by_length = self.states_no_ratio(running.compensator());
        if is_by_length {
            responses.moves(&[by_length(running.pressure)], if before.is_some() { &[AFTER] } else { &[AFTER, BEFORE] });
        }
        match before {
            Some(before) => {
                responses.moves(&whole.causes(), &[TARGET]);
                responses.moves(&[target.lag(params, &target.whole)], &[TARGET]);
                responses.moves(&before.causes(), &[BEFORE]);
                responses.moves(&[one.lag(params, &one.whole)], &[BEFORE]);
            }
            None => {
                responses.moves(&whole.causes(), &[TARGET, BEFORE]);
                responses.moves(&[target.lag(params, &target.whole)], &[TARGET, BEFORE]);
                if !is_by_length {
                    responses.moves(&[by_length(running.pressure_before)], &[BEFORE]);
                }
            }
        }
        Some(MeasuredResponses { responses, held, known, usual: self.usual_contacts(running.compensator()) })
    }
}

impl Robot {
    /// Adds the uncertainty of the compensator's response, and takes its level from the length filter if that knows it
    /// better. The filter follows a gain that wanders, and averages tell where it was.
    fn level(
        &self,
        params: &Params,
        running: &Compensation,
        held: &Smooth,
        after: &ResponseBins,
        from: LevelFrom,
        responses: &mut Uncertain<3>,
    ) {
        let one = &self.whiskers[running.compensator()];
        let lag = one.lag(params, after);
        let causes = held.causes();
        let present = match from {
            // A filter that follows a walk knows the present better than any average.
            LevelFrom::Filter if running.averages_alone() && one.walks.rate() == 0.0 => None,
            LevelFrom::Filter => one.spread.mean().and_then(|at| one.present(params, running, at)),
            LevelFrom::Contacts => None,
        };
        if let Some((at, log, variance)) = present {
            let value = |curve: &Curve| at_ratio(curve, at);
            let own_variance = causes.iter().map(|cause| value(cause).powi(2)).sum::<f64>() + lag[0].powi(2);
            if variance < own_variance {
                let off = log - value(&held.by_ratio());
                responses.mean[AFTER].iter_mut().for_each(|mean| *mean += off);
                let bent = causes.map(|cause| cause.map(|one| one - value(&cause)));
                responses.moves(&bent, &[AFTER]);
                responses.moves(&[[variance.sqrt(); CONTACT_RATIOS.len()]], &[AFTER]);
                return;
            }
        }
        responses.moves(&causes, &[AFTER]);
        responses.moves(&[lag], &[AFTER]);
    }
}

/// The weights of some contact ratios; 0 for the others.
pub(in crate::robot) fn over(ratios: &[bool; CONTACT_RATIOS.len()], weights: &RatioWeights) -> RatioWeights {
    std::array::from_fn(|k| if ratios[k] { weights[k] } else { 0.0 })
}

/// The one factor that brings a response closest to the target, in log sensitivity.
pub(in crate::robot) fn reading_gain(after: &Curve, target: &Curve, weights: &RatioWeights) -> Curve {
    let used = || (0..CONTACT_RATIOS.len()).filter(|&k| weights[k] > 0.0);
    let all: f64 = used().map(|k| weights[k]).sum();
    let gain = (used().map(|k| weights[k] * (target[k] - after[k])).sum::<f64>() / all.max(f64::MIN_POSITIVE)).exp();
    [gain.clamp(*READING_GAINS.start(), *READING_GAINS.end()); CONTACT_RATIOS.len()]
}

/// A curve between its points.
fn at_ratio(curve: &Curve, ratio: ContactRatio) -> f64 {
    let last = CONTACT_RATIOS.len() - 1;
    let steps = (ratio.a() - CONTACT_RATIOS[0]) / (CONTACT_RATIOS[1] - CONTACT_RATIOS[0]);
    let k = (steps.max(0.0) as usize).min(last - 1);
    curve[k] + (steps - k as f64) * (curve[k + 1] - curve[k])
}

impl Whisker {
    /// The present response by the length filter, where the robot touches: contact ratio, ln of it over the model's at the
    /// compensation's length, and variance.
    fn present(&self, params: &Params, running: &Compensation, at: ContactRatio) -> Option<(ContactRatio, f64, f64)> {
        let model = self.model(params)?;
        let morphology = model.morphology(running.pressure);
        let length = self.filter.length().length;
        let (here, slope) = model.sensitivity_and_slope(at, length, &morphology).ok()?;
        let (reference, _) = model.sensitivity_and_slope(at, running.length, &morphology).ok()?;
        let doubt = self.walks.doubt();
        let log = (here / reference).ln() + self.filter.offset().at(at) + doubt.by;
        let slope = slope * length.mm() / (length.mm() + morphology.elongation_mm);
        Some((at, log, self.filter.response_variance(at, slope) + doubt.variance))
    }

    /// Standard deviation of the gain from that of averages over its past, as a curve.
    fn lag(&self, params: &Params, bins: &ResponseBins) -> Curve {
        [self.gain_lag(params, bins); CONTACT_RATIOS.len()]
    }

    /// Standard deviation of the gain from that of averages over its past, log sensitivity: an average lags by a third of
    /// the contacts that it remembers.
    pub(in crate::robot) fn gain_lag(&self, params: &Params, bins: &ResponseBins) -> f64 {
        let contact_variance = self.contact_log_sd(params).powi(2) * self.noise.inflation();
        let remembered = contact_variance * bins.felt().map(|bin| 1.0 / bin.variance()).sum::<f64>();
        self.walks.doubt().rate * (remembered / 3.0).sqrt()
    }

    /// Share of each contact ratio in the contacts of its whole time. A fifth is spread evenly: habits change, and the best
    /// shape over a short part of a whisker would move much air for nothing elsewhere.
    fn usual_ratios(&self) -> RatioWeights {
        let contacts = self.whole.contacts();
        if contacts < LEARNED_RATIOS_CONTACTS {
            return EVEN_WEIGHTS;
        }
        let share = |k: usize| f64::from(self.whole.bin(k).contacts()) / f64::from(contacts);
        std::array::from_fn(|k| (1.0 - EVEN_SHARE) * share(k) + EVEN_SHARE / CONTACT_RATIOS.len() as f64)
    }

    /// Its usual contacts. With a stated range of the gauge, the largest usual deflection limits the sensitivity at each contact
    /// ratio that is touched, or at all while the distribution of the ratios is not known.
    fn usual_contacts(&self) -> UsualContacts {
        let contacts = self.whole.contacts();
        let least = (USUAL_SHARE * f64::from(contacts)) as u32;
        let is_touched = |k: usize| contacts < LEARNED_RATIOS_CONTACTS || self.whole.bin(k).contacts() > least;
        let largest_mm = f64::from(self.rare.largest_deflection_mm);
        let per_mm_max = self.sheet.strain_max.filter(|_| largest_mm > 0.0).map(|strain_max| strain_max / largest_mm);
        UsualContacts {
            weights: self.usual_ratios(),
            per_mm_max: std::array::from_fn(|k| per_mm_max.filter(|_| is_touched(k))),
        }
    }

    /// Belief about its own calibration.
    pub(in crate::robot) fn belief(&self, model: &Model) -> Belief {
        let nominal = self.nominal();
        match &self.rare.own {
            Some(own) => own.belief(model, &nominal),
            None => OwnCalibration::default().belief(model, &nominal),
        }
    }

    /// Whether its response was measured at another than its nominal pressure.
    pub(in crate::robot) fn knows_own_calibration(&self) -> bool {
        self.rare.own.as_ref().is_some_and(|own| own.is_informed())
    }

    /// Belief about its response at a setpoint, against the model at its present length.
    pub(in crate::robot) fn carried(&self, params: &Params, setpoint: &Setpoint) -> Carried {
        let Some(model) = self.model(params) else { return Carried::default() };
        let belief = self.belief(model);
        let length = self.filter.relative_length();
        self.change(model, &belief, length.length, (self.sheet.pressure, setpoint.pressure), |from, to| {
            let mut causes = belief.causes(from, to).to_vec();
            causes.push(by_length(model, length.length, setpoint.pressure, length.sd_mm));
            causes.push(self.lag(params, &self.whole));
            let change = sum(&Belief::change(&belief.predict, from, to), &self.offset_moved_at(length.length));
            Smooth::through(&self.whole).carried(&change, &causes)
        })
    }

    /// Change of its offset from the whole length to this one.
    pub(in crate::robot) fn offset_moved_at(&self, length: Millimetre) -> Curve {
        let whole = self.whole_offset();
        curve(whole.shortened(length.mm() / self.sheet.length.mm()).beyond(whole))
    }

    fn nominal(&self) -> Nominal<'_> {
        Nominal { length: self.sheet.length, pressure: self.sheet.pressure, bins: &self.whole }
    }

    /// Something about the change between two pressures.
    pub(in crate::robot) fn change<T>(
        &self,
        model: &Model,
        belief: &Belief,
        length: Millimetre,
        (from, to): (Megapascal, Megapascal),
        of: impl Fn(&crate::mechanics::LogChanges, &crate::mechanics::LogChanges) -> T,
    ) -> T {
        let family = model.family(belief.predict[LOG_MODULUS]);
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
