//! Decides on a confirmed suspicion: which kind of change it is, or that the gain has wandered.

use super::detector::{DetectionParams, Detector, Others, Situation, Suspicion, Verdict};
use super::hypothesis::{ALL, HypothesisKind};
use super::kinds::{Change, Explanation, best};
use crate::estimation::gain_walk::Wandering;
use crate::estimation::noise::NoiseScale;

/// Log likelihood that a step must gain over any gradual change to be reported. A wrong trim changes pressures; a
/// late one can wait.
const STEP_LOG_RATIO: f64 = 9.0;
/// The same for an unsteady whisker whose noise lasts from contact to contact: on it, slow nuisances that look like neither of
/// the two exceed a low limit by chance within some hundred contacts. A step that never does is followed as a wandering gain.
/// With 9 the mix of nuisances gives 0.74 false trims in a million contacts, and with 22 it gives 0.33. It costs a tenth of
/// the reports of 3 mm, a third of those of 2 mm, and none of larger cuts.
const LASTING_STEP_LOG_RATIO: f64 = 22.0;
/// Log likelihood that erosion must gain over a step.
const GRADUAL_LOG_RATIO: f64 = 3.0;
/// Log likelihood that a baseline drift must gain over a step.
const DRIFT_LOG_RATIO: f64 = 6.0;
/// Lead that excludes any gradual change, even if the step leaves a residual slope: far from the length at which
/// the model is linearised, a large cut always leaves one.
const SURELY_STEP_LOG_RATIO: f64 = 30.0;
/// Log likelihood that a change must gain over a wandering gain to be reported: the threshold of the alarm, which holds
/// for a constant gain, holds for a wandering one, too. With 10, walks of 3 % in 5,000 contacts gave more
/// than twice as many false trims.
const CHANGE_LOG_RATIO: f64 = 13.0;
/// The same for erosion that is faster than any ageing: 5 % of the sensitivity in 10,000 contacts are 2e-6 of the length with
/// each contact.
const EROSION_LOG_RATIO: f64 = 6.0;
const SURELY_EROSION: f64 = 2e-5;
/// A step that began longer ago must gain more, by one for each of so many further contacts: creep, habits and ageing add up
/// to slow changes that no random walk describes. This takes away two thirds of the false trims of a mix of nuisances
/// (6.3 to 1.8 in a million contacts), and nearly all reports of 0.5 mm, which is 1.7 % of the sensitivity.
const LONG_AGO_CONTACTS: f64 = 500.0;
const CONTACTS_PER_LOG_RATIO: f64 = 50.0;
/// Loss of log length from which erosion of an unsteady whisker is reported: 4 mm of 70, which is 12 % of the sensitivity.
/// With 3.5 mm the mix of nuisances gives 1.4 false reports of erosion in a million contacts, and with 4 mm it gives 0.8.
const EROSION_LOSS_MIN: f64 = 0.06;
/// Loss of log length up to which a touch test confirms a cut of a steady whisker, too: 4 mm of 70. Steps and walks of the gain that
/// pass for a cut are of this size.
const SMALL_LOSS: f64 = 0.06;
/// Fall of sensitivity of an unsteady whisker that is reported as a loss, in log length: 10 % of the sensitivity. Without it
/// the mix gives as many false losses as reports of erosion.
const FALL_MIN: f64 = 0.047;
/// Log likelihood that a wandering gain must gain over any change.
const WANDERS_LOG_RATIO: f64 = 2.0;
/// Log likelihood gained by a further loss beside the step that may still be chance: 0.9 standard deviations.
const GOES_ON_LOG_RATIO: f64 = 0.4;
/// Log likelihood gained by a further loss that is certainly not chance: two standard deviations.
const SURELY_GOES_ON_LOG_RATIO: f64 = 2.0;
/// Largest loss of ln length per contact by erosion that is compared with a step which explains the contacts alone. Faster
/// erosion explains a cut of 2 mm for some tens of contacts. It counts only where the loss certainly goes on.
const EROSION_BESIDE_STEP: f64 = 0.01 / 70.0;
/// After this multiple of the contacts at the alarm, plus this many, the kind is decided without a sufficient lead.
const PATIENCE: (u32, u32) = (4, 400);

impl Detector {
    /// Verdict on a confirmed suspicion: `Looking` while its kind cannot be determined.
    pub(super) fn decided(&self, params: &DetectionParams, suspicion: &Suspicion, situation: &Situation) -> Verdict {
        let Situation { eroding, checks, wandering, noise, lasting } = *situation;
        let unsteady = noise > NoiseScale::UNSTEADY_MIN;
        let kind = ALL[usize::from(suspicion.candidate)].kind;
        let impatient = suspicion.contacts_since > PATIENCE.0 * suspicion.contacts_at_alarm + PATIENCE.1;
        match (kind, checks.others) {
            (HypothesisKind::Drifting, _) | (_, Others::Not) => {}
            (_, Others::NotYet) if impatient => {}
            (_, Others::NotYet) => return Verdict::Looking,
            (_, Others::Too) => {
                let felt = if kind == HypothesisKind::LessSensitive { kind } else { HypothesisKind::Shorter };
                let felt = best(&self.candidates, felt, params.erosion_per_contact_max, suspicion.contacts_since);
                return felt.map_or(Verdict::Looking, |felt| Verdict::Shared(Change::of(&self.candidates, &felt)));
            }
        }
        if self.wanders(params, &wandering) {
            return Verdict::Wandered;
        }
        // A touch test refutes a step that is no cut.
        let is_tested = checks.touch_test && !impatient;
        let step_lead = if lasting && !is_tested { LASTING_STEP_LOG_RATIO } else { STEP_LOG_RATIO };
        match self.told_apart(params, suspicion.contacts_since, impatient, (eroding, lasting), step_lead) {
            Some(explained) if unsteady && !eroding && self.is_little_erosion(&explained) => Verdict::Looking,
            Some(explained) if unsteady && self.is_little_fall(&explained) => Verdict::Wandered,
            Some(explained) if self.lead(&explained, &wandering) >= 0.0 => {
                let is_doubtful = unsteady || explained.fit.size.abs() < SMALL_LOSS;
                if is_tested && is_doubtful && ALL[explained.index].kind == HypothesisKind::Shorter {
                    return Verdict::Unconfirmed;
                }
                Verdict::Changed(Change::of(&self.candidates, &explained))
            }
            // More contacts decide, within the limit of patience.
            Some(_) | None if impatient => Verdict::Wandered,
            Some(_) | None => Verdict::Looking,
        }
    }

    /// Whether a change is erosion that has taken off less than is reported. It may go on.
    fn is_little_erosion(&self, explained: &Explanation) -> bool {
        let contacts = f64::from(self.candidates.contacts(explained.index));
        ALL[explained.index].kind == HypothesisKind::Eroding && explained.fit.size.abs() * contacts < EROSION_LOSS_MIN
    }

    /// Whether a change is a fall of sensitivity that other nuisances explain as well.
    fn is_little_fall(&self, explained: &Explanation) -> bool {
        ALL[explained.index].kind == HypothesisKind::LessSensitive && explained.fit.size.abs() < FALL_MIN
    }

    /// Lead of a change over a wandering gain, beyond the least one for which the change is reported.
    fn lead(&self, explained: &Explanation, wandering: &Wandering) -> f64 {
        let kind = ALL[explained.index].kind;
        let is_wear = kind == HypothesisKind::Eroding && explained.fit.size.abs() > SURELY_EROSION;
        let longer = f64::from(self.candidates.contacts(explained.index)) - LONG_AGO_CONTACTS;
        let more = if kind.is_gradual() { 0.0 } else { longer.max(0.0) / CONTACTS_PER_LOG_RATIO };
        explained.fit.gain - wandering.log_ratio - more - if is_wear { EROSION_LOG_RATIO } else { CHANGE_LOG_RATIO }
    }

    /// Whether a wandering gain clearly explains the contacts better than any change.
    fn wanders(&self, params: &DetectionParams, wandering: &Wandering) -> bool {
        let kinds =
            [HypothesisKind::Shorter, HypothesisKind::LessSensitive, HypothesisKind::Eroding, HypothesisKind::Drifting];
        let gain = |kind| best(&self.candidates, kind, params.erosion_per_contact_max, 1);
        kinds.into_iter().filter_map(gain).all(|one| wandering.log_ratio - one.fit.gain > WANDERS_LOG_RATIO)
    }

    /// The kind that explains the contacts, or `None` while the evidence does not separate the kinds.
    fn told_apart(
        &self,
        params: &DetectionParams,
        contacts_since: u32,
        impatient: bool,
        (eroding, lasting): (bool, bool),
        step_lead: f64,
    ) -> Option<Explanation> {
        let best_of = |kind| best(&self.candidates, kind, 0.0, contacts_since);
        let gain = |one: &Option<Explanation>| one.map_or(0.0, |one| one.fit.gain);
        let larger = |a: Option<Explanation>, b: Option<Explanation>| if gain(&b) > gain(&a) { b } else { a };
        let step = larger(best_of(HypothesisKind::Shorter), best_of(HypothesisKind::LessSensitive));
        let goes_on = step.map_or(0.0, |step| self.gain_of_going_on(step.index));
        let most = params.erosion_per_contact_max;
        let most = if goes_on > SURELY_GOES_ON_LOG_RATIO { most } else { most.min(EROSION_BESIDE_STEP) };
        let erosion = best(&self.candidates, HypothesisKind::Eroding, most, contacts_since);
        let gradual = larger(erosion, best_of(HypothesisKind::Drifting));
        let drifts = gradual.is_some_and(|gradual| ALL[gradual.index].kind == HypothesisKind::Drifting);
        let lead = gain(&step) - gain(&gradual);
        // Erosion must be shown to continue. A drift shows in small deflections, so it must lead by more.
        let needed = match (drifts, goes_on > SURELY_GOES_ON_LOG_RATIO) {
            (true, _) => DRIFT_LOG_RATIO,
            (false, true) => GRADUAL_LOG_RATIO,
            (false, false) => f64::INFINITY,
        };
        let surely = lead - goes_on > SURELY_STEP_LOG_RATIO;
        if surely || (lead - goes_on > step_lead && goes_on < GOES_ON_LOG_RATIO) {
            step
        } else if eroding || lead < -needed {
            // On an eroding whisker the filter lags behind or runs ahead: this is not a new change.
            gradual.or(step)
        } else if impatient && !lasting {
            if goes_on < SURELY_GOES_ON_LOG_RATIO && !drifts { step.or(gradual) } else { gradual.or(step) }
        } else {
            None
        }
    }

    fn gain_of_going_on(&self, index: usize) -> f64 {
        self.continuations.gain_of_going_on(index, &self.candidates.evidence(index))
    }
}
