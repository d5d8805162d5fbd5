//! The detector: a mixture of Shiryaev-Roberts statistics raises an alarm, and later contacts confirm or dismiss
//! it.
//!
//! **Why this statistic.** With R_j <- (1 + R_j) * likelihood ratio_j and weights that sum to one, the mixture R
//! minus the number of contacts is a martingale while nothing changes. So the mean number of contacts to R >= A is
//! at least A, for any mixture, any order of contact ratios and any predictable signature; more exactly, it is the
//! mean of R where it crosses A. So **the threshold is the configured mean number of contacts between false alarms,
//! times a share for the overshoot** (`THRESHOLD_SHARE`). The statistic needs innovations of known density. The
//! filter provides them from the first contact on, because the uncertainty of its state is part of their variance,
//! and the uncertainty of the noise scale is part of their density ([`crate::estimation::outlier`]). The statistic
//! sums over all starts of the change, so it needs no history, and over sizes and kinds, so it need not know them.
//!
//! **After an alarm.** An alarm is a suspicion. A sequential probability ratio test on the contacts after it (error
//! probabilities 2 %) confirms or dismisses it. Most false alarms end there, so false trims are rarer than the
//! configured rate. Then the kind of change is determined (`decision.rs`), and the array's other whiskers are
//! checked for the same change. After a decision everything starts anew.
//!
//! **A larger change meanwhile.** A suspected small change must not hide a large one: a step of at least twice its size
//! that began later, and would raise an alarm beside it, becomes the suspicion.
//!
//! **Cold start.** During the first [`DetectionParams::cold_start_contacts`] contacts no change is reported. The
//! statistics follow all the same from contact [`DetectionParams::followed_from`] on: the filter takes a change in the
//! cold start for an offset, and only a known start tells how much of the change it has absorbed.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::candidate::{Candidates, Fit};
use super::continuation::Continuations;
use super::hypothesis::{ALL, HypothesisKind};
use super::kinds::{Change, best, limits};
use super::start::Stored;
use crate::estimation::Innovation;
use crate::estimation::filter::LENGTH;
use crate::estimation::gain_walk::Wandering;

/// Threshold as a share of the configured mean number of contacts between false alarms. The statistic overshoots
/// its threshold by a factor, and the mean number of contacts is the mean of the statistic at the crossing. With
/// this share, 1e3, 1e4, 3e4 and 1e5 configured contacts gave 1.24, 1.24, 1.35 and 1.67 times as many (9,700, 970, 300 and
/// 120 alarms), and 1.08, 1.01, 1.03 and 1.30 times with 2 % outliers.
const THRESHOLD_SHARE: f64 = 0.5;
/// Smallest step, in ln length, that is searched for on an eroding whisker: its filter lags behind.
const LEAST_SHIFT_WHILE_ERODING: f64 = 0.02;
/// ln 50: both error probabilities of the confirmation test are 2 %.
const FRESH_LOOK_LOG_RATIO: f64 = 3.9;
/// A later change takes over the suspicion only if it is at least this many times as large: smaller ones belong to the
/// suspected one.
const LARGER: f64 = 2.0;
/// ... and if it is sudden: a suspected drift that goes on would explain it otherwise, contacts.
const SUDDEN_CONTACTS: u32 = 40;
/// Least size of it beside a suspected drift of the baseline, in ln length: 3.5 mm of 70. The drift is no length, so that
/// the sizes do not compare.
const LARGER_THAN_DRIFT: f64 = 0.05;
/// The detector is calm while every CUSUM likelihood ratio is below this value.
const CALM_BELOW: f64 = 20.0;
/// Its doubt is little while every one is below this value.
const LITTLE_DOUBT_BELOW: f64 = 1000.0;

/// Parameters of the detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DetectionParams {
    /// Mean number of contacts between false alarms of a healthy whisker (ARL0); it sets the threshold.
    pub contacts_between_false_alarms: f64,
    /// Number of contacts in which offset and noise are learned before any change is reported.
    pub cold_start_contacts: u32,
    /// Number of contacts after which the statistics follow during the cold start: noise and first loads come first.
    pub followed_from: u32,
    /// Largest loss of ln length per contact that may be erosion; faster losses are trims.
    pub erosion_per_contact_max: f64,
    /// Largest angle of a contact to the plane of the gauge where the robot does not state it, degrees; 0 if contacts keep
    /// their direction.
    pub contact_angle_deg_max: f64,
}

impl Default for DetectionParams {
    fn default() -> Self {
        Self {
            contacts_between_false_alarms: 1e6,
            cold_start_contacts: 150,
            followed_from: 50,
            erosion_per_contact_max: 0.0225 / 70.0,
            contact_angle_deg_max: 0.0,
        }
    }
}

impl DetectionParams {
    /// Largest change of log sensitivity by a turn of contacts without a stated angle: the gauge reads the cosine of the angle.
    #[must_use]
    pub fn turn_max(&self) -> f64 {
        if self.contact_angle_deg_max > 0.0 { -self.contact_angle_deg_max.to_radians().cos().ln() } else { 0.0 }
    }
}

/// The detector's state for one whisker.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Detector {
    pub(super) candidates: Candidates,
    pub(super) continuations: Continuations,
    suspicion: Option<Box<Suspicion>>,
}

#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub(super) struct Suspicion {
    pub candidate: u8,
    /// Fitted size at the alarm.
    size: f64,
    pub contacts_at_alarm: u32,
    pub contacts_since: u32,
    fresh_log_ratio: f64,
}

/// Evidence for a suspected change on the array's other whiskers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Others {
    /// They do not show it, or there are too few of them.
    Not,
    /// They show it too: the change belongs to the array, not to the whisker.
    Too,
    /// They have had too few contacts since.
    NotYet,
}

/// Sources besides the whisker's own contacts that a confirmed suspicion is checked with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Checks {
    /// Evidence of the array's other whiskers.
    pub others: Others,
    /// A touch test of the whisker is under way, or can begin now.
    pub touch_test: bool,
}

impl Checks {
    /// Neither witnesses nor a test.
    pub const NONE: Self = Self { others: Others::Not, touch_test: false };
}

/// Everything beside its contacts that decides about a suspected change of a whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Situation {
    /// The whisker is known to erode.
    pub eroding: bool,
    /// Other sources about a confirmed suspicion.
    pub checks: Checks,
    /// Evidence that the gain wanders instead.
    pub wandering: Wandering,
    /// Noise of a mean of contacts, as a multiple of the variance that the robot states.
    pub noise: f64,
    /// The noise lasts from contact to contact ([`NoiseScale::is_lasting`](crate::estimation::NoiseScale::is_lasting)).
    pub lasting: bool,
}

/// Result of one contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// No change is suspected.
    Quiet,
    /// Alarm: the next contacts test the suspicion.
    Alarm,
    /// The test has not decided yet.
    Looking,
    /// The contacts show a cut, but other causes can look the same: a touch test is to confirm it.
    Unconfirmed,
    /// The test has dismissed the alarm.
    Dismissed,
    /// The gain has wandered, which is no change of the whisker.
    Wandered,
    /// The test has confirmed a change of this whisker.
    Changed(Change),
    /// The test has confirmed a change that the array's other whiskers share.
    Shared(Change),
}

impl Detector {
    /// Updates the detector with one innovation.
    pub fn update(&mut self, params: &DetectionParams, seen: &Innovation, situation: &Situation) -> Verdict {
        let suspicion = self.suspicion.as_deref().map(|&suspicion| (suspicion, self.fresh_log_ratio(&suspicion, seen)));
        self.follow(seen);
        match suspicion {
            Some((suspicion, fresh)) => self.look(params, suspicion, fresh, situation),
            None => self.watch(params, situation.eroding),
        }
    }

    /// Updates the statistics with one innovation, without a verdict: for the cold start, so that a change in it has its
    /// true start when it is called later.
    pub fn follow(&mut self, seen: &Innovation) {
        let felt = self.candidates.update(seen);
        self.continuations.update(seen, &self.candidates, &felt);
    }

    /// Whether there is no sign of a change. Only then are reference responses and noise learned.
    ///
    /// The answer depends on past contacts alone, so it does not bias the learning.
    #[must_use]
    pub fn is_calm(&self) -> bool {
        self.suspicion.is_none() && self.candidates.cusum_max() < CALM_BELOW
    }

    /// Log likelihood ratio of the likeliest change, of the sizes that are searched for.
    #[must_use]
    pub fn log_ratio_max(&self) -> f64 {
        self.candidates.cusum_max().ln()
    }

    /// Whether nothing speaks for a change so strongly that it hardly comes from a scale that is not learned yet.
    #[must_use]
    pub fn has_little_doubt(&self) -> bool {
        self.suspicion.is_none() && self.candidates.cusum_max() < LITTLE_DOUBT_BELOW
    }

    /// Whether a change is suspected.
    #[must_use]
    pub fn is_suspicious(&self) -> bool {
        self.suspicion.is_some()
    }

    /// Contacts since the present suspicion began.
    #[must_use]
    pub fn contacts_suspected(&self) -> Option<u32> {
        self.suspicion.as_ref().map(|suspicion| suspicion.contacts_since)
    }

    /// The suspected change of ln length, fitted as a step, or `None` without a suspicion. The confirmed change may
    /// be of another kind.
    #[must_use]
    pub fn suspected_shift(&self) -> Option<Fit> {
        let suspicion = self.suspicion.as_deref()?;
        let kind = ALL[usize::from(suspicion.candidate)].kind;
        let least = suspicion.contacts_since;
        match kind {
            HypothesisKind::Drifting => None,
            HypothesisKind::LessSensitive => best(&self.candidates, kind, 0.0, least).map(|one| one.fit),
            HypothesisKind::Shorter | HypothesisKind::Eroding => {
                best(&self.candidates, HypothesisKind::Shorter, 0.0, least).map(|one| one.fit)
            }
        }
    }

    /// Most likely step of ln length with the same sign as `like`, or `None` if no contact supports one.
    #[must_use]
    pub fn felt(&self, like: f64) -> Option<Fit> {
        let kind = if like < 0.0 { HypothesisKind::Shorter } else { HypothesisKind::LessSensitive };
        best(&self.candidates, kind, 0.0, 1).map(|one| one.fit)
    }

    /// The step of [`Self::felt`], as a change.
    #[must_use]
    pub fn felt_change(&self, like: f64) -> Option<Change> {
        let kind = if like < 0.0 { HypothesisKind::Shorter } else { HypothesisKind::LessSensitive };
        best(&self.candidates, kind, 0.0, 1).map(|one| Change::of(&self.candidates, &one))
    }

    /// Mixture of the Shiryaev-Roberts statistics. An alarm is raised where it reaches `THRESHOLD_SHARE` times the
    /// configured mean number of contacts between false alarms.
    #[must_use]
    pub fn statistic(&self, eroding: bool) -> f64 {
        self.weighted(eroding).map(|(_, value)| value).sum()
    }

    fn weighted(&self, eroding: bool) -> impl Iterator<Item = (usize, f64)> + '_ {
        let looked_for = move |kind: HypothesisKind, size: f64| match kind {
            _ if !eroding => true,
            HypothesisKind::Shorter | HypothesisKind::LessSensitive => size.abs() >= LEAST_SHIFT_WHILE_ERODING,
            HypothesisKind::Eroding | HypothesisKind::Drifting => false,
        };
        ALL.iter()
            .enumerate()
            .filter(move |(_, supposed)| looked_for(supposed.kind, supposed.size))
            .map(|(index, supposed)| (index, supposed.weight * self.candidates.shiryaev(index)))
    }

    fn watch(&mut self, params: &DetectionParams, eroding: bool) -> Verdict {
        if self.statistic(eroding) < THRESHOLD_SHARE * params.contacts_between_false_alarms {
            return Verdict::Quiet;
        }
        let likeliest = self.weighted(eroding).max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(index, _)| index);
        let evidence = self.candidates.evidence(likeliest);
        match evidence.fit((f64::NEG_INFINITY, f64::INFINITY)) {
            Some(fit) => {
                self.suspicion = Some(Box::new(Suspicion {
                    candidate: likeliest as u8,
                    size: fit.size,
                    contacts_at_alarm: evidence.contacts(),
                    contacts_since: 0,
                    fresh_log_ratio: 0.0,
                }));
                Verdict::Alarm
            }
            // The most likely start is the next contact: there is no evidence to test.
            None => {
                *self = Self::default();
                Verdict::Dismissed
            }
        }
    }

    fn fresh_log_ratio(&self, suspicion: &Suspicion, seen: &Innovation) -> f64 {
        let signature = self.candidates.signature(usize::from(suspicion.candidate), seen);
        let under = seen.density.at(seen.standardised - signature * suspicion.size);
        (under.density / seen.seen.density).ln()
    }

    fn look(
        &mut self,
        params: &DetectionParams,
        mut suspicion: Suspicion,
        fresh_log_ratio: f64,
        situation: &Situation,
    ) -> Verdict {
        suspicion.fresh_log_ratio += fresh_log_ratio;
        suspicion.contacts_since = suspicion.contacts_since.saturating_add(1);
        if let Some(larger) = self.larger(params, &suspicion) {
            self.suspicion = Some(Box::new(larger));
            return Verdict::Alarm;
        }
        let gone = self.candidates.contacts(usize::from(suspicion.candidate)) == 0;
        if suspicion.fresh_log_ratio <= -FRESH_LOOK_LOG_RATIO || gone {
            self.dismiss();
            return Verdict::Dismissed;
        }
        let confirmed = suspicion.fresh_log_ratio >= FRESH_LOOK_LOG_RATIO;
        let verdict = if confirmed { self.decided(params, &suspicion, situation) } else { Verdict::Looking };
        if matches!(verdict, Verdict::Looking | Verdict::Unconfirmed) {
            self.suspicion = Some(Box::new(suspicion));
        } else {
            *self = Self::default();
        }
        verdict
    }

    /// A larger step after the suspected change, with evidence enough for its own alarm. Its size contains the part of the
    /// suspected change that the state lacks, so that a jump by it takes out both.
    fn larger(&self, params: &DetectionParams, suspicion: &Suspicion) -> Option<Suspicion> {
        let suspected = usize::from(suspicion.candidate);
        let since = self.candidates.contacts(suspected);
        let is_drift = ALL[suspected].kind == HypothesisKind::Drifting;
        let threshold = (THRESHOLD_SHARE * params.contacts_between_false_alarms).ln();
        let steps = ALL.iter().enumerate().filter(|(_, supposed)| !supposed.kind.is_gradual());
        let larger = steps.filter_map(|(index, supposed)| {
            let contacts = self.candidates.contacts(index);
            if contacts == 0 || contacts >= since.min(SUDDEN_CONTACTS) || self.candidates.log_ratio(index) < threshold {
                return None;
            }
            let fit = self.candidates.evidence(index).fit(limits(supposed.kind, 0.0))?;
            let step = self.lacks(index, fit.size);
            let (earlier, rest) = self.beside(suspected, index, step);
            let is_larger = step.abs() >= LARGER * earlier.abs() && (!is_drift || step.abs() >= LARGER_THAN_DRIFT);
            let takes_over = is_larger && rest + supposed.weight.ln() >= threshold;
            takes_over.then_some((index, fit, contacts, rest))
        });
        let (index, fit, contacts_at_alarm, _) = larger.max_by(|a, b| a.3.total_cmp(&b.3))?;
        let candidate = index as u8;
        Some(Suspicion { candidate, size: fit.size, contacts_at_alarm, contacts_since: 0, fresh_log_ratio: 0.0 })
    }

    /// The part of a suspected change that the state lacks, ln length, and the log likelihood that a later step of `step` gains
    /// beside it.
    ///
    /// A suspected step of size e, fitted to the contacts before the later one, explains those after it with an error of
    /// s - e. Two steps gain half of (s - e)^2 a b / (a + b) over one, with a and b the information of the two parts. A
    /// suspected gradual change explains a share q (2 - q) of what the step gains, with q = e / s.
    fn beside(&self, suspected: usize, later: usize, step: f64) -> (f64, f64) {
        let (all, after) = (self.candidates.evidence(suspected), self.candidates.evidence(later));
        let before = all.before(&after);
        match ALL[suspected].kind {
            HypothesisKind::Drifting => (0.0, self.candidates.log_ratio(later)),
            HypothesisKind::Eroding => {
                let fitted = all.fit((f64::NEG_INFINITY, f64::INFINITY));
                let earlier = fitted.map_or(0.0, |fit| self.lacks(suspected, fit.size));
                (earlier, (1.0 - (earlier / step).max(0.0)).powi(2) * self.candidates.log_ratio(later))
            }
            HypothesisKind::Shorter | HypothesisKind::LessSensitive => {
                let fitted = before.fit((f64::NEG_INFINITY, f64::INFINITY));
                let earlier = fitted.map_or(0.0, |fit| self.lacks(suspected, fit.size));
                let (a, b) = (before.sums().0, after.sums().0);
                (earlier, 0.5 * (step - earlier).powi(2) * a * b / (a + b))
            }
        }
    }

    /// The part of a change of ln length that the state lacks.
    fn lacks(&self, index: usize, size: f64) -> f64 {
        size * self.candidates.lacking(index)[LENGTH]
    }

    /// Ends the alarm. Gradual changes keep their starts: one dismissed too early would look like a step the next
    /// time.
    fn dismiss(&mut self) {
        self.suspicion = None;
        self.continuations = Continuations::default();
        self.candidates.dismiss();
    }
}

impl BorshSerialize for Detector {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        self.candidates.serialize(writer)?;
        self.continuations.write(&self.candidates, writer)?;
        self.suspicion.serialize(writer)
    }
}

crate::optional_parts::optional_fields!(Detector: candidates, continuations; suspicion: suspicion.is_some());

impl Detector {
    /// Reads stored bytes.
    ///
    /// # Errors
    /// The bytes end, or cannot have been written.
    pub fn read<R: Read>(stored: &Stored, reader: &mut R) -> Result<Self> {
        let candidates = Candidates::read(stored, reader)?;
        let continuations = Continuations::read(stored, &candidates, reader)?;
        Ok(Self { candidates, continuations, suspicion: BorshDeserialize::deserialize_reader(reader)? })
    }
}
