//! The compensation error (Eq. 35), measured from the compensator's contacts.
//!
//! Each contact-ratio bin has an error of its own. The mean comes from the smooth responses of [`super::responses`], with the
//! uncertainty due to noise, the walk of the gain, the length, and places where the robot does not touch.

use crate::estimation::{Bin, Innovation, ResponseBins};
use crate::mechanics::{CONTACT_RATIOS, ErrorProfile, Model, Offset, compensation_error};
use crate::robot::Robot;
use crate::robot::compensation::Compensation;
use crate::robot::compensation::responses::{AFTER, LevelFrom};
use crate::robot::effect::{CompensationError, Condition, Effect, ErrorBin, Origin, Response, WhiskerIndex};
use crate::robot::event::Contact;
use crate::robot::params::Params;
use crate::robot::state::whisker::Whisker;
use crate::units::{ContactRatio, Megapascal, Millimetre};

/// Relative standard deviation that a modelled response is taken to have: that of a learned offset.
const MODEL_SD: f64 = 0.01;

/// Standard deviation of the level of a response with lasting noise, log sensitivity, however many contacts tell it. Another
/// room or scale moves all readings of a robot by 3 % half of the time, and hides in such noise. It belongs to no whisker.
/// In the mix of nuisances the 95 % interval of the measured error holds the truth in 85 % of the cases without it, and in
/// 92 % with it.
pub(super) const UNNOTICED_SHIFT_SD: f64 = 0.02;

/// Responses that deviate from the model by more than this, in log sensitivity, are invalid and ignored: e^20 is 5e8.
const LOG_DEVIATION_MAX: f64 = 20.0;

/// A response at one contact ratio: log of strain per mm, its variance, where it comes from.
#[derive(Clone, Copy)]
struct LogResponse {
    log_per_mm: f64,
    variance: f64,
    origin: Origin,
}

/// The model and the averages that a response is taken from.
struct Reference<'a> {
    model: &'a Model,
    length: Millimetre,
    pressure: Megapascal,
    bins: Option<&'a ResponseBins>,
    offset: Offset,
}

impl Reference<'_> {
    /// Measured where the bin has enough contacts, otherwise the model with the learned offset.
    fn at(&self, ratio: ContactRatio, contacts_min: u32) -> Option<LogResponse> {
        let morphology = self.model.morphology(self.pressure);
        let model_log = self.model.sensitivity_per_mm(ratio, self.length, &morphology).ok()?.ln();
        let measured: Option<Bin> = self.bins.and_then(|bins| bins.measured(ratio, contacts_min));
        Some(match measured {
            Some(bin) => {
                LogResponse { log_per_mm: model_log + bin.mean(), variance: bin.variance(), origin: Origin::Measured }
            }
            None => LogResponse {
                log_per_mm: model_log + self.offset.at(ratio),
                variance: MODEL_SD.powi(2),
                origin: Origin::Model,
            },
        })
    }
}

impl Robot {
    /// Takes a compensator's contact in, records its three responses, and from time to time the error.
    pub(in crate::robot) fn measure(
        &mut self,
        params: &Params,
        index: WhiskerIndex,
        (position, ratio): (usize, ContactRatio),
        contact: &Contact<'_>,
        seen: &Innovation,
        effects: &mut Vec<Effect>,
    ) {
        let Some(at) = self.head.compensations.iter().position(|one| one.compensator() == index) else { return };
        let whisker = &self.whiskers[index];
        let running = &mut self.head.compensations[at];
        let held = (whisker.air.setpoint.mpa() - running.pressure.mpa()).abs() < 1e-4;
        // Its baseline and noise are to be known first, if it is learned anew.
        if !running.settled || !held || whisker.condition == Condition::Learning {
            return;
        }
        let Some(model) = whisker.model(params) else { return };
        let morphology = model.morphology(running.compared_at(contact.pressure));
        let Ok(model_per_mm) = model.sensitivity_per_mm(seen.ratio, running.length, &morphology) else { return };
        // The strain by deflection alone; outliers get a larger variance.
        let strain = contact.strain.ratio() - whisker.filter.baseline_strain().0;
        if strain <= 0.0 {
            return;
        }
        let deviation = (strain / (model_per_mm * contact.deflection.mm())).ln() - seen.by_circumstances;
        if deviation.is_nan() || deviation.abs() > LOG_DEVIATION_MAX {
            return;
        }
        let noise_variance = seen.noise_variance / seen.seen.sound.max(1e-3);
        let walk = whisker.walks.doubt().rate;
        let before = running.after.contacts();
        running.after.add(seen.ratio, deviation, noise_variance, walk);
        running.refining.since_gain.add(seen.ratio, deviation, noise_variance, walk);
        let contacts = running.after.contacts();
        if contacts < before {
            running.refining.halve();
        }
        let running = &self.head.compensations[at];
        effects.extend(self.response(params, running, (position, ratio), contact).map(Effect::Response));
        if self.states_no_place(index) {
            // Reviewed at the end of the touch test.
            return;
        }
        if contacts.is_multiple_of(params.measurement.every_contacts) {
            effects.extend(self.error(params, running).map(|error| Effect::Error(Box::new(error))));
        }
        self.refine(params, at, effects);
    }

    /// A touch test of a compensator without places is done: only its contacts tell gain and error.
    pub(in crate::robot) fn measure_test(&mut self, params: &Params, index: WhiskerIndex, effects: &mut Vec<Effect>) {
        let is_its = |one: &Compensation| one.compensator() == index && one.settled;
        let Some(at) = self.head.compensations.iter().position(is_its).filter(|_| self.states_no_place(index)) else {
            return;
        };
        if self.head.compensations[at].after.contacts() == 0 {
            return;
        }
        let running = &self.head.compensations[at];
        effects.extend(self.error(params, running).map(|error| Effect::Error(Box::new(error))));
        self.refine(params, at, effects);
    }

    fn response(
        &self,
        params: &Params,
        running: &Compensation,
        (position, ratio): (usize, ContactRatio),
        contact: &Contact<'_>,
    ) -> Option<Response> {
        let least = params.measurement.bin_contacts_min;
        let before = self.before(params, running)?.at(ratio, least)?;
        let target = self.whole_target(params, running)?.at(ratio, least)?;
        Some(Response {
            position,
            compensation: running.id,
            ratio,
            deflection: contact.deflection,
            after: contact.strain,
            before: before.log_per_mm.exp() * contact.deflection.mm(),
            before_origin: before.origin,
            target: target.log_per_mm.exp() * contact.deflection.mm(),
            target_origin: target.origin,
        })
    }

    /// The target while it was whole.
    fn whole_target<'a>(&'a self, params: &'a Params, running: &Compensation) -> Option<Reference<'a>> {
        let target: &Whisker = &self.whiskers[running.target()];
        Some(Reference {
            model: target.model(params)?,
            length: target.sheet.length,
            pressure: target.sheet.pressure,
            bins: Some(&target.whole),
            offset: target.whole_offset(),
        })
    }

    /// The compensator before its pressure changed. A trimmed whisker's own response between the cut and the
    /// change has too few contacts: there the model at the estimated length serves, with its whole offset.
    fn before<'a>(&'a self, params: &'a Params, running: &'a Compensation) -> Option<Reference<'a>> {
        let one: &Whisker = &self.whiskers[running.compensator()];
        Some(Reference {
            model: one.model(params)?,
            length: running.length_before(one),
            pressure: running.pressure_before,
            bins: running.before.as_ref(),
            offset: one.whole_offset().shortened(running.length_before(one).mm() / one.sheet.length.mm()),
        })
    }

    /// The compensation error (Eq. 35) of a compensation of this robot, as it is known now; none before it is measured.
    #[must_use]
    pub fn error(&self, params: &Params, running: &Compensation) -> Option<CompensationError> {
        let length_variance = {
            let estimate = self.whiskers[running.compensator()].filter.relative_length();
            (estimate.sd_mm.max(running.length_sd_mm) / estimate.length.mm()).powi(2)
        };
        let bins: Vec<ErrorBin> = CONTACT_RATIOS
            .iter()
            .filter_map(|&ratio| self.error_bin(params, running, ratio, length_variance))
            .collect();
        if bins.is_empty() {
            return None;
        }
        let mut felt =
            self.measured_responses(params, running, &running.refining.carried, &running.after, LevelFrom::Filter)?;
        if self.whiskers[running.compensator()].noise.is_lasting(&params.noise) {
            felt.responses.moves(&[[UNNOTICED_SHIFT_SD; CONTACT_RATIOS.len()]], &[AFTER]);
        }
        let air_alone = running.reading_gain().map(|gain| {
            let by_air = felt.expected_error();
            felt.read_with(gain);
            by_air
        });
        let (mean, sd) = felt.expected_error();
        Some(CompensationError {
            compensation: running.id,
            pressure: running.pressure,
            contacts: running.after.contacts(),
            mean,
            sd,
            air_alone,
            bins,
            with_gain: running.error_with_gain(self, params),
        })
    }

    fn error_bin(&self, params: &Params, running: &Compensation, ratio: f64, length_variance: f64) -> Option<ErrorBin> {
        let least = params.measurement.bin_contacts_min;
        let ratio = ContactRatio::new(ratio).ok()?;
        let one = &self.whiskers[running.compensator()];
        let model = one.model(params)?;
        let after = Reference {
            model,
            length: running.length,
            pressure: running.pressure,
            bins: Some(&running.after),
            offset: Offset::NONE,
        }
        .at(ratio, least)
        .filter(|after| after.origin == Origin::Measured)?;
        let target = self.whole_target(params, running)?.at(ratio, least)?;
        let mut before = self.before(params, running)?.at(ratio, least)?;
        if before.origin == Origin::Model {
            let morphology = model.morphology(running.pressure_before);
            let (_, slope) = model.sensitivity_and_slope(ratio, running.length, &morphology).ok()?;
            before.variance += slope.powi(2) * length_variance;
            // A trimmed whisker's own offset is best known from its own measured whole response.
            if running.before.is_none() && target.origin == Origin::Measured {
                let whole_offset = one.whole_offset().at(ratio);
                before.log_per_mm += one.whole.measured(ratio, least).map_or(0.0, |bin| bin.mean() - whole_offset);
            }
        }
        let by_gain = running.reading_gain().map_or(0.0, f64::ln);
        let read = LogResponse { log_per_mm: after.log_per_mm + by_gain, ..after };
        let (error, sd) = error_with_sd(read, before, target)?;
        Some(ErrorBin {
            ratio: ratio.a(),
            contacts: running.after.measured(ratio, least).map_or(0, |bin| bin.contacts()),
            after_per_mm: after.log_per_mm.exp(),
            before_per_mm: before.log_per_mm.exp(),
            before_origin: before.origin,
            target_per_mm: target.log_per_mm.exp(),
            target_origin: target.origin,
            error,
            sd,
        })
    }
}

/// Eq. 35 with its standard deviation to first order in the three log responses.
fn error_with_sd(after: LogResponse, before: LogResponse, target: LogResponse) -> Option<(f64, f64)> {
    let [ac, bc, t] = [after, before, target].map(|response| response.log_per_mm.exp());
    // As in a prediction: too small a difference is nothing to divide by.
    if (bc - t).abs() <= ErrorProfile::LEAST_DIFFERENCE * t {
        return None;
    }
    let error = compensation_error(ac, bc, t)?;
    let span = bc - t;
    let by_after = ac / span;
    let by_before = (ac - t) * bc / span.powi(2);
    let by_target = t * (ac - bc) / span.powi(2);
    let variance =
        by_after.powi(2) * after.variance + by_before.powi(2) * before.variance + by_target.powi(2) * target.variance;
    Some((error, variance.sqrt()))
}
