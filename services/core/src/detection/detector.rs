//! The detector: a mixture of Shiryaev-Roberts statistics over supposed changes, then a fresh look.
//!
//! **Why this statistic.** With R_j <- (1 + R_j) * likelihood ratio_j and weights that sum to one, the mixture
//! R minus the number of contacts is a martingale while nothing changes. So the mean number of contacts to
//! R >= A is at least A, for any mixture, any order of contact ratios and any predictable signature; more exactly,
//! it is the mean of R where it passes A. So **the threshold is the stated mean number of contacts between
//! false alarms, times a share for passing it by** (`THRESHOLD_SHARE`). It needs innovations whose
//! density is known, which the filter gives from the first contact on because its ignorance is part of their
//! variance and that of the noise's scale is part of their density ([`crate::estimation::outlier`]); it sums
//! over all starts of the change, so it keeps no history, and over sizes and kinds, so it need not know them.
//!
//! **What an alarm becomes.** An alarm is a suspicion. A sequential probability ratio test on the contacts
//! that come after it (error probabilities 2 %) confirms or dismisses it: most false alarms end there, so
//! false trims are rarer than stated. Then the kinds are told apart ([`super::kinds`]) and the array's other
//! whiskers are asked whether they feel it too. After a decision everything starts anew.
//!
//! **Cold start.** During the first [`DetectionParams::cold_start_contacts`] contacts nothing is called.

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::candidate::{Candidates, Fit};
use super::continuation::Continuations;
use super::hypothesis::{ALL, Kind};
use super::kinds::{Change, Explanation, best};
use crate::estimation::Innovation;

/// Threshold per stated mean number of contacts between false alarms: the statistic passes it by a factor,
/// and the mean number of contacts is the mean of where it arrives. With normal noise, everything learned, thresholds
/// of 1e3, 1e4 and 5.6e4 gave 1.7, 1.9 and 2.4 times as many contacts (2300, 400 and 150 alarms); with two outliers in a
/// hundred the last gave 1.1. So below some 2000 stated contacts the share promises a few percent too much.
const THRESHOLD_SHARE: f64 = 0.56;
/// Steps smaller than this are not looked for on a whisker that erodes: its filter lags behind.
const LEAST_SHIFT_WHILE_ERODING: f64 = 0.02;
/// ln 50: both error probabilities of the fresh look are 2 %.
const FRESH_LOOK_LOG_RATIO: f64 = 3.9;
/// How much more log likelihood than any gradual change a step must gain to be called one. A wrong trim
/// moves air; a late one can wait.
const STEP_LOG_RATIO: f64 = 9.0;
/// How much more than a step erosion must gain.
const GRADUAL_LOG_RATIO: f64 = 3.0;
/// How much more than a step a drift of the baseline must gain.
const DRIFT_LOG_RATIO: f64 = 6.0;
/// With this lead nothing gradual can be meant, whatever the step leaves: far from the length where the model is
/// linearised, a large cut always leaves something.
const SURELY_STEP_LOG_RATIO: f64 = 30.0;
/// Log likelihood that a further loss beside the step may gain and still be chance: nine tenths of a standard deviation.
const GOES_ON_LOG_RATIO: f64 = 0.4;
/// The same from which it is none: two standard deviations.
const SURELY_GOES_ON_LOG_RATIO: f64 = 2.0;
/// They are told apart by less after this many times the contacts at the alarm, and some more.
const PATIENCE: (u32, u32) = (4, 400);
/// A likelihood ratio that says something is going on.
const CALM_BELOW: f64 = 20.0;

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
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Detector {
    candidates: Candidates,
    continuations: Continuations,
    suspicion: Option<Box<Suspicion>>,
}

#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct Suspicion {
    candidate: u8,
    /// Size at the alarm, fitted.
    size: f64,
    contacts_at_alarm: u32,
    contacts_since: u32,
    fresh_log_ratio: f64,
}

/// What the array's other whiskers feel of a suspected change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Others {
    /// Nothing like it, or there are too few to ask.
    Not,
    /// The same: it is the array's, not the whisker's.
    Too,
    /// They have hardly been touched since.
    NotYet,
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
    /// It did, and the others feel it too.
    Shared(Change),
}

impl Detector {
    /// Takes one innovation in. `others` is asked for only where it matters.
    pub fn update(&mut self, params: &DetectionParams, seen: &Innovation, eroding: bool, others: Others) -> Verdict {
        let suspicion = self.suspicion.as_deref().map(|&suspicion| (suspicion, self.fresh_log_ratio(&suspicion, seen)));
        let felt = self.candidates.update(seen);
        self.continuations.update(seen, &self.candidates, &felt);
        match suspicion {
            Some((suspicion, fresh)) => self.look(params, suspicion, fresh, eroding, others),
            None => self.watch(params, eroding),
        }
    }

    /// Whether nothing at all is in the air: only then are reference responses and noise learned.
    ///
    /// It depends on past contacts alone, so what is learned is not biased by it.
    #[must_use]
    pub fn is_calm(&self) -> bool {
        self.suspicion.is_none() && self.candidates.cusum_max() < CALM_BELOW
    }

    /// Whether a change is suspected.
    #[must_use]
    pub fn is_suspicious(&self) -> bool {
        self.suspicion.is_some()
    }

    /// The suspected change of log length as a step, negative or positive, if one is suspected. What it is in the
    /// end may be another matter.
    #[must_use]
    pub fn suspected_shift(&self) -> Option<Fit> {
        let suspicion = self.suspicion.as_deref()?;
        let kind = ALL[usize::from(suspicion.candidate)].kind;
        let least = suspicion.contacts_since;
        match kind {
            Kind::Drifting => None,
            Kind::LessSensitive => best(&self.candidates, kind, 0.0, least).map(|one| one.fit),
            Kind::Shorter | Kind::Eroding => best(&self.candidates, Kind::Shorter, 0.0, least).map(|one| one.fit),
        }
    }

    /// The likeliest step of log length of the same sign as the given one, if any contact since its start
    /// speaks for it.
    #[must_use]
    pub fn felt(&self, like: f64) -> Option<Fit> {
        let kind = if like < 0.0 { Kind::Shorter } else { Kind::LessSensitive };
        best(&self.candidates, kind, 0.0, 1).map(|one| one.fit)
    }

    /// The mixture of Shiryaev-Roberts statistics; an alarm is raised where it reaches the stated mean number
    /// of contacts between false alarms.
    #[must_use]
    pub fn statistic(&self, eroding: bool) -> f64 {
        self.weighted(eroding).map(|(_, value)| value).sum()
    }

    fn weighted(&self, eroding: bool) -> impl Iterator<Item = (usize, f64)> + '_ {
        let looked_for = move |kind: Kind, size: f64| match kind {
            _ if !eroding => true,
            Kind::Shorter | Kind::LessSensitive => size.abs() >= LEAST_SHIFT_WHILE_ERODING,
            Kind::Eroding | Kind::Drifting => false,
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
            // The likeliest start is the next contact: nothing to look into.
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
        eroding: bool,
        others: Others,
    ) -> Verdict {
        suspicion.fresh_log_ratio += fresh_log_ratio;
        suspicion.contacts_since = suspicion.contacts_since.saturating_add(1);
        let gone = self.candidates.contacts(usize::from(suspicion.candidate)) == 0;
        if suspicion.fresh_log_ratio <= -FRESH_LOOK_LOG_RATIO || gone {
            self.dismiss();
            return Verdict::Dismissed;
        }
        let confirmed = suspicion.fresh_log_ratio >= FRESH_LOOK_LOG_RATIO;
        let verdict = if confirmed { self.decided(params, &suspicion, eroding, others) } else { Verdict::Looking };
        if verdict == Verdict::Looking {
            self.suspicion = Some(Box::new(suspicion));
        } else {
            *self = Self::default();
        }
        verdict
    }

    /// The alarm is over. Slow changes keep their starts: one that was dismissed too early would look like a
    /// step the next time.
    fn dismiss(&mut self) {
        self.suspicion = None;
        self.continuations = Continuations::default();
        self.candidates.dismiss();
    }

    /// What a confirmed suspicion is: looking on while that cannot be said.
    fn decided(&self, params: &DetectionParams, suspicion: &Suspicion, eroding: bool, others: Others) -> Verdict {
        let kind = ALL[usize::from(suspicion.candidate)].kind;
        let impatient = suspicion.contacts_since > PATIENCE.0 * suspicion.contacts_at_alarm + PATIENCE.1;
        match (kind, others) {
            (Kind::Drifting, _) | (_, Others::Not) => {}
            (_, Others::NotYet) if impatient => {}
            (_, Others::NotYet) => return Verdict::Looking,
            (_, Others::Too) => {
                let felt = if kind == Kind::LessSensitive { kind } else { Kind::Shorter };
                let felt = best(&self.candidates, felt, params.erosion_per_contact_max, suspicion.contacts_since);
                return felt.map_or(Verdict::Looking, |felt| Verdict::Shared(Change::of(&self.candidates, &felt)));
            }
        }
        match self.told_apart(params, suspicion.contacts_since, eroding, impatient) {
            Some(explained) => Verdict::Changed(Change::of(&self.candidates, &explained)),
            None => Verdict::Looking,
        }
    }

    /// The kind that explains the contacts; none while that cannot be said.
    fn told_apart(
        &self,
        params: &DetectionParams,
        contacts_since: u32,
        eroding: bool,
        impatient: bool,
    ) -> Option<Explanation> {
        let best_of = |kind| best(&self.candidates, kind, params.erosion_per_contact_max, contacts_since);
        let gain = |one: &Option<Explanation>| one.map_or(0.0, |one| one.fit.gain);
        let larger = |a: Option<Explanation>, b: Option<Explanation>| if gain(&b) > gain(&a) { b } else { a };
        let step = larger(best_of(Kind::Shorter), best_of(Kind::LessSensitive));
        let gradual = larger(best_of(Kind::Eroding), best_of(Kind::Drifting));
        let drifts = gradual.is_some_and(|gradual| ALL[gradual.index].kind == Kind::Drifting);
        let lead = gain(&step) - gain(&gradual);
        let goes_on = step.map_or(0.0, |step| self.gain_of_going_on(step.index));
        // Erosion must be seen to go on; a drift shows in small deflections, and so by more.
        let needed = match (drifts, goes_on > SURELY_GOES_ON_LOG_RATIO) {
            (true, _) => DRIFT_LOG_RATIO,
            (false, true) => GRADUAL_LOG_RATIO,
            (false, false) => f64::INFINITY,
        };
        let surely = lead - goes_on > SURELY_STEP_LOG_RATIO;
        if surely || (lead - goes_on > STEP_LOG_RATIO && goes_on < GOES_ON_LOG_RATIO) {
            step
        } else if eroding || lead < -needed {
            // On a whisker that erodes, the filter lags behind or runs ahead: no new change.
            gradual.or(step)
        } else if impatient {
            if goes_on < SURELY_GOES_ON_LOG_RATIO && !drifts { step.or(gradual) } else { gradual.or(step) }
        } else {
            None
        }
    }

    fn gain_of_going_on(&self, index: usize) -> f64 {
        self.continuations.gain_of_going_on(index, &self.candidates.evidence(index))
    }
}

impl BorshSerialize for Detector {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        self.candidates.serialize(writer)?;
        self.continuations.write(&self.candidates, writer)?;
        self.suspicion.serialize(writer)
    }
}

impl BorshDeserialize for Detector {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let candidates = Candidates::deserialize_reader(reader)?;
        let continuations = Continuations::read(&candidates, reader)?;
        Ok(Self { candidates, continuations, suspicion: BorshDeserialize::deserialize_reader(reader)? })
    }
}
