//! Determines the kind of a change by comparing how much of the contacts' log likelihood each kind explains.
//!
//! Each kind is represented by its own hypotheses, each with its most likely start and a fitted size. A cut
//! explained as erosion from its best start still gains 8/9 of the log likelihood of the cut, and vice versa,
//! unless the erosion would be faster than its limit. So telling a small cut from erosion takes several times the
//! contacts of the alarm, whatever the rule.

use super::candidate::{Candidates, Fit};
use super::hypothesis::{ALL, HypothesisKind};
use super::start::CONTACTS_MAX;
use crate::estimation::filter::STATES;

/// A confirmed change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Kind of the change.
    pub kind: HypothesisKind,
    /// Size: step of ln length, or slope per contact of ln length or of strain. Negative lengths are losses.
    pub size: f64,
    /// Variance of the size.
    pub variance: f64,
    /// Remaining state error of the filter per unit of size.
    pub lacking: [f64; STATES],
    /// Contacts since the most likely start.
    pub contacts: u32,
}

/// The best explanation of one kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Explanation {
    pub index: usize,
    pub fit: Fit,
}

/// Lower and upper limit of a kind's size, in the unit of
/// [`Hypothesis::size`](super::hypothesis::Hypothesis::size).
pub(super) fn limits(kind: HypothesisKind, erosion_per_contact_max: f64) -> (f64, f64) {
    match kind {
        HypothesisKind::Shorter => (f64::NEG_INFINITY, 0.0),
        HypothesisKind::LessSensitive => (0.0, f64::INFINITY),
        HypothesisKind::Eroding => (-erosion_per_contact_max, 0.0),
        HypothesisKind::Drifting => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// The hypothesis of a kind with the largest gain, among those with at least `contacts_min` contacts since their
/// start: a single outlier after the alarm does not explain the alarm.
pub(super) fn best(
    candidates: &Candidates,
    kind: HypothesisKind,
    erosion_per_contact_max: f64,
    contacts_min: u32,
) -> Option<Explanation> {
    let of_kind = ALL.iter().enumerate().filter(|(_, supposed)| supposed.kind == kind);
    of_kind
        .map(|(index, _)| (index, candidates.evidence(index)))
        .filter(|(_, evidence)| evidence.contacts() >= contacts_min.min(CONTACTS_MAX))
        .filter_map(|(index, evidence)| {
            let fit = evidence.fit(limits(kind, erosion_per_contact_max))?;
            Some(Explanation { index, fit })
        })
        .max_by(|a, b| a.fit.gain.total_cmp(&b.fit.gain))
}

impl Change {
    /// The step that changes as much as this since its start.
    #[must_use]
    pub fn as_step(&self) -> Self {
        if !self.kind.is_gradual() {
            return *self;
        }
        let contacts = f64::from(self.contacts.max(1));
        Self {
            size: self.size * contacts,
            variance: self.variance * contacts.powi(2),
            lacking: self.lacking.map(|lacking| lacking / contacts),
            ..*self
        }
    }

    pub(super) fn of(candidates: &Candidates, explained: &Explanation) -> Self {
        Self {
            kind: ALL[explained.index].kind,
            size: explained.fit.size,
            variance: explained.fit.variance,
            lacking: candidates.lacking(explained.index),
            contacts: candidates.contacts(explained.index),
        }
    }
}
