//! The detector: a mixture of Shiryaev-Roberts statistics over supposed shifts, then a fresh look.
//!
//! **Why this statistic.** With R_j <- (1 + R_j) * likelihood ratio_j and weights that sum to one, the mixture
//! R minus the number of contacts is a martingale while nothing changes. So the mean number of contacts to
//! R >= A is at least A, for any mixture, any order of contact ratios and any predictable signature: **the
//! threshold is the stated mean number of contacts between false alarms itself.** It needs standardised
//! innovations that are independent and standard normal, which the filter gives from the first contact on
//! because its ignorance is part of their variance; it sums over all starts of the change, so it keeps no
//! history, and over shifts, so it need not know the size.
//!
//! **What an alarm becomes.** An alarm is a suspicion. A sequential probability ratio test on the contacts
//! that come after it (error probabilities 2 %) confirms or dismisses it: most false alarms end there, so
//! false trims are rarer than stated. Then step and slope are told apart by how much of the data's log
//! likelihood each gains, a slope being no faster than erosion can be: a large step at once, a small one or an
//! erosion when the contacts allow it. After a decision everything starts anew.
//!
//! **Cold start.** During the first [`DetectionParams::cold_start_contacts`] contacts nothing is called.

use borsh::{BorshDeserialize, BorshSerialize};

use super::candidate::{Candidate, log_likelihood_ratio};
use crate::estimation::Innovation;

/// Supposed shifts of ln length, with their weights in the mixture. 0.3 to 8.4 mm of 70 shorter; and longer,
/// which no trim explains: a gauge that comes loose, or a whisker that was exchanged.
const SHIFTS: [(f64, f64); 9] = [
    (-0.004, 0.12),
    (-0.008, 0.12),
    (-0.015, 0.14),
    (-0.03, 0.14),
    (-0.06, 0.14),
    (-0.12, 0.14),
    (0.01, 0.06),
    (0.04, 0.07),
    (0.15, 0.07),
];
/// Shifts smaller than this are not looked for on a whisker that erodes: its filter lags behind.
const LEAST_SHIFT_WHILE_ERODING: f64 = 0.02;
/// ln 50: both error probabilities of the fresh look are 2 %.
const FRESH_LOOK_LOG_RATIO: f64 = 3.9;
/// How much more log likelihood than a slope a step must gain to be called one. A slope's window hardly ever
/// begins where the slope did, so the slope's gain is understated.
const STEP_LOG_RATIO: f64 = 8.0;
/// How much more than a step a slope must gain.
const SLOPE_LOG_RATIO: f64 = 4.0;
/// They are told apart by less after this many times the contacts at the alarm, and some more.
const PATIENCE: (u32, u32) = (3, 300);

/// What the detector is told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectionParams {
    /// Mean number of contacts of a healthy whisker between false alarms (ARL0), and thereby the threshold.
    pub contacts_between_false_alarms: f64,
    /// Contacts in which offset and noise are learned before anything is called.
    pub cold_start_contacts: u32,
    /// Loss of log length per contact up to which a change may be erosion; faster ones are trims.
    pub erosion_per_contact_max: f64,
}

impl Default for DetectionParams {
    fn default() -> Self {
        Self { contacts_between_false_alarms: 1e6, cold_start_contacts: 150, erosion_per_contact_max: 0.01 / 70.0 }
    }
}

/// The detector's state for one whisker.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct Detector {
    candidates: [Candidate; SHIFTS.len()],
    suspicion: Option<Suspicion>,
}

#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct Suspicion {
    candidate: u8,
    shift: f64,
    contacts_at_alarm: u32,
    fresh_log_ratio: f64,
}

/// What the detector says after a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// Nothing.
    Quiet,
    /// The alarm: from now on the contacts are a fresh look.
    Alarm,
    /// Still looking.
    Looking,
    /// The fresh look did not bear the alarm out.
    Dismissed,
    /// It did.
    Changed(Change),
}

/// A confirmed change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Step or slope.
    pub kind: ChangeKind,
    /// Size: the step of ln length, or the slope of ln length per contact; negative is shorter.
    pub size: f64,
    /// Variance of the size.
    pub variance: f64,
    /// What the filter's state lacks by now per unit of size.
    pub lacking: [f64; 3],
    /// Contacts since the likeliest start.
    pub contacts: u32,
}

/// What kind of change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ChangeKind {
    /// At once.
    Step,
    /// Slowly, contact by contact.
    Slope,
}

impl Detector {
    /// Takes one innovation in.
    pub fn update(&mut self, params: &DetectionParams, seen: &Innovation, eroding: bool) -> Verdict {
        for (candidate, (shift, _)) in self.candidates.iter_mut().zip(SHIFTS) {
            candidate.update(shift, seen);
        }
        match self.suspicion {
            None => self.watch(params, eroding),
            Some(suspicion) => self.look(params, suspicion, seen, eroding),
        }
    }

    /// Whether nothing at all is in the air: only then are reference responses and noise learned.
    ///
    /// It depends on past contacts alone, so what is learned is not biased by it.
    #[must_use]
    pub fn is_calm(&self) -> bool {
        self.suspicion.is_none() && self.candidates.iter().all(|candidate| candidate.cusum() < 3.0)
    }

    /// The mixture of Shiryaev-Roberts statistics; an alarm is raised where it reaches the stated mean number
    /// of contacts between false alarms.
    #[must_use]
    pub fn statistic(&self, eroding: bool) -> f64 {
        self.weighted(eroding).map(|(_, value)| value).sum()
    }

    fn weighted(&self, eroding: bool) -> impl Iterator<Item = (usize, f64)> + '_ {
        let looked_for = move |shift: f64| !eroding || shift.abs() >= LEAST_SHIFT_WHILE_ERODING;
        let pairs = self.candidates.iter().zip(SHIFTS).enumerate();
        pairs
            .filter(move |(_, (_, (shift, _)))| looked_for(*shift))
            .map(|(index, (candidate, (_, weight)))| (index, weight * candidate.shiryaev()))
    }

    fn watch(&mut self, params: &DetectionParams, eroding: bool) -> Verdict {
        if self.statistic(eroding) < params.contacts_between_false_alarms {
            return Verdict::Quiet;
        }
        let likeliest = self.weighted(eroding).max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index);
        let evidence = self.candidates[likeliest].evidence();
        match evidence.step() {
            Some((shift, _)) => {
                self.suspicion = Some(Suspicion {
                    candidate: likeliest as u8,
                    shift,
                    contacts_at_alarm: evidence.contacts(),
                    fresh_log_ratio: 0.0,
                });
                Verdict::Alarm
            }
            // The likeliest start is the next contact: nothing to look into.
            None => {
                *self = Self::default();
                Verdict::Dismissed
            }
        }
    }

    fn look(
        &mut self,
        params: &DetectionParams,
        mut suspicion: Suspicion,
        seen: &Innovation,
        eroding: bool,
    ) -> Verdict {
        let candidate = &self.candidates[usize::from(suspicion.candidate)];
        let lacking = candidate.lacks_by_step();
        let expected: f64 = (0..3).map(|i| seen.row[i] * lacking[i]).sum::<f64>() / seen.variance.sqrt();
        suspicion.fresh_log_ratio += log_likelihood_ratio(expected * suspicion.shift, seen.standardised);
        if suspicion.fresh_log_ratio <= -FRESH_LOOK_LOG_RATIO || candidate.evidence().step().is_none() {
            *self = Self::default();
            return Verdict::Dismissed;
        }
        let confirmed = suspicion.fresh_log_ratio >= FRESH_LOOK_LOG_RATIO;
        match confirmed.then(|| self.told_apart(params, &suspicion, eroding)).flatten() {
            Some(change) => {
                *self = Self::default();
                Verdict::Changed(change)
            }
            None => {
                self.suspicion = Some(suspicion);
                Verdict::Looking
            }
        }
    }

    /// The change as a step or as a slope; none while they cannot be told apart.
    ///
    /// Each candidate's window began where its own size of shift is likeliest to have begun: a slope has a
    /// long window with the smallest shift, a step a window that fits it.
    fn told_apart(&self, params: &DetectionParams, suspicion: &Suspicion, eroding: bool) -> Option<Change> {
        let step = self.as_step(suspicion)?;
        if step.size > 0.0 && !eroding {
            return Some(step);
        }
        let limit = params.erosion_per_contact_max.copysign(step.size);
        let (slope, gain_of_slope) = self.as_slope(limit);
        let gain_of_step = self.candidates.iter().map(|one| one.evidence().gain_of_step()).fold(0.0, f64::max);
        let impatient = slope.contacts > PATIENCE.0 * suspicion.contacts_at_alarm + PATIENCE.1;
        if gain_of_step - gain_of_slope > STEP_LOG_RATIO {
            Some(step)
        } else if eroding || gain_of_slope - gain_of_step > SLOPE_LOG_RATIO {
            // On a whisker that erodes, the filter lags behind or runs ahead: no new change.
            Some(slope)
        } else if impatient {
            Some(if gain_of_step > gain_of_slope + SLOPE_LOG_RATIO { step } else { slope })
        } else {
            None
        }
    }

    fn as_step(&self, suspicion: &Suspicion) -> Option<Change> {
        let candidate = &self.candidates[usize::from(suspicion.candidate)];
        let (size, variance) = candidate.evidence().step()?;
        let contacts = candidate.evidence().contacts();
        Some(Change { kind: ChangeKind::Step, size, variance, lacking: candidate.lacks_by_step(), contacts })
    }

    fn as_slope(&self, limit: f64) -> (Change, f64) {
        let fits = self.candidates.iter().map(|candidate| (candidate, candidate.evidence().slope(limit)));
        let best = fits.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain));
        let (candidate, fit) =
            best.unwrap_or_else(|| (&self.candidates[0], self.candidates[0].evidence().slope(limit)));
        let change = Change {
            kind: ChangeKind::Slope,
            size: fit.per_contact,
            variance: fit.variance,
            lacking: candidate.lacks_by_slope(),
            contacts: candidate.evidence().contacts(),
        };
        (change, fit.gain)
    }
}
