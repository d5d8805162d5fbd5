//! What kind of change it is: the kinds compared by how much of the contacts' log likelihood each explains.
//!
//! Each kind is represented by its own hypotheses, whose windows began where a change of that kind is
//! likeliest to have begun, with the size fitted. A cut explained as erosion from its best start still gains 8/9 of
//! what the cut does, and the other way round, unless erosion would have to be faster than it can be: so telling
//! a small cut from erosion takes several times the contacts of the alarm, and no rule can do without them.

use super::candidate::{Candidates, Fit};
use super::hypothesis::{ALL, Kind};
use super::start::CONTACTS_MAX;
use crate::estimation::filter::STATES;

/// A confirmed change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// What kind.
    pub kind: Kind,
    /// Size: the step of ln length, or a slope per contact of ln length or of strain; negative is shorter.
    pub size: f64,
    /// Variance of the size.
    pub variance: f64,
    /// What the filter's state lacks by now per unit of size.
    pub lacking: [f64; STATES],
    /// Contacts since the likeliest start.
    pub contacts: u32,
}

/// The best explanation of one kind.
#[derive(Debug, Clone, Copy)]
pub(super) struct Explanation {
    pub index: usize,
    pub fit: Fit,
}

/// Sizes that a kind may have.
pub(super) fn limits(kind: Kind, erosion_per_contact_max: f64) -> (f64, f64) {
    match kind {
        Kind::Shorter => (f64::NEG_INFINITY, 0.0),
        Kind::LessSensitive => (0.0, f64::INFINITY),
        Kind::Eroding => (-erosion_per_contact_max, 0.0),
        Kind::Drifting => (f64::NEG_INFINITY, f64::INFINITY),
    }
}

/// The hypothesis of a kind that explains most, of those whose window has at least so many contacts: a single
/// outlier after the alarm is no explanation of the alarm.
pub(super) fn best(
    candidates: &Candidates,
    kind: Kind,
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
