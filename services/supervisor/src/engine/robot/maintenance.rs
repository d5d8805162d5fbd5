//! Facts for the maintenance of a robot's whiskers, and when they are published.
//!
//! The published facts are not stored: a new owner publishes them again.

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Duration;

use tokio::time::Instant;
use vibrissa_core::robot::effect::Condition;
use vibrissa_core::robot::{Robot, WhiskerView};
use vibrissa_edge::contract::whisker_condition;
use vibrissa_edge::interval::length_interval_mm;
use vibrissa_protocol::{Name, Timestamp, WhiskerMaintenance};

/// Largest wear in the contract, mm.
const WEAR_MAX_MM: f64 = 1000.0;
/// Largest number of contacts in the contract.
const CONTACTS_MAX: f64 = 1e9;

/// The facts about one robot.
#[derive(Debug, Default)]
pub(crate) struct Maintenance {
    /// End of the last touch test that was done, µs since 1970 UTC by the supervisor's clock, by row of the whisker.
    tested_us: BTreeMap<i64, i64>,
    /// Hash of the facts that were published last.
    told: Option<u64>,
    /// Time of the last comparison.
    compared_at: Option<Instant>,
}

impl Maintenance {
    /// Notes that a touch test of a whisker was done.
    pub(crate) fn tested(&mut self, whisker_id: i64, ended_us: i64) {
        self.tested_us.insert(whisker_id, ended_us);
    }

    /// Forgets the tests of a whisker that was replaced.
    pub(crate) fn replaced(&mut self, whisker_id: i64) {
        self.tested_us.remove(&whisker_id);
    }

    /// Makes the facts due, because the broker may not have the last ones.
    pub(crate) fn repeat(&mut self) {
        self.told = None;
    }

    /// Whether so much time has passed since the last comparison.
    pub(crate) fn is_due(&self, now: Instant, every: Duration) -> bool {
        self.compared_at.is_none_or(|at| now >= at + every)
    }

    /// The facts to publish now; `None` if they are as published last, or if there is no factsheet yet.
    pub(crate) fn next(&mut self, now: Instant, robot: &Robot, whisker_ids: &[i64]) -> Option<Vec<WhiskerMaintenance>> {
        let fact = |(at, id): (usize, &i64)| entry(&robot.whisker(at)?, self.tested_us.get(id).copied());
        let facts: Vec<_> = whisker_ids.iter().enumerate().filter_map(fact).collect();
        if facts.is_empty() {
            return None;
        }
        self.compared_at = Some(now);
        let hash = hash_of(&facts);
        (self.told.replace(hash) != Some(hash)).then_some(facts)
    }
}

fn hash_of(facts: &[WhiskerMaintenance]) -> u64 {
    let mut hasher = DefaultHasher::new();
    // The text has every published digit.
    format!("{facts:?}").hash(&mut hasher);
    hasher.finish()
}

/// The facts about a whisker that was tested last at this time; `None` if its array has no name of the contract.
fn entry(view: &WhiskerView<'_>, tested_us: Option<i64>) -> Option<WhiskerMaintenance> {
    let (low_mm, high_mm) = length_interval_mm(&view.relative_length);
    // A whisker that is learned has its factory length, which nothing has shown yet.
    let is_known = view.condition != Condition::Learning || tested_us.is_some();
    let is_finite = low_mm.is_finite() && high_mm.is_finite();
    let factory_length_mm = view.sheet.length.mm();
    let wear_mm = |length_mm: f64| {
        let lost_mm = (factory_length_mm - length_mm).clamp(0.0, WEAR_MAX_MM);
        (is_known && is_finite).then(|| (10.0 * lost_mm).round() / 10.0)
    };
    let left = view.erosion.map(|erosion| erosion.contacts_left);
    Some(WhiskerMaintenance {
        array: Name::new(view.array).ok()?,
        whisker: view.sheet.number,
        condition: whisker_condition(view.condition),
        factory_length_mm,
        wear_mm: wear_mm(view.length.length.mm()),
        wear_low_mm: wear_mm(high_mm),
        wear_high_mm: wear_mm(low_mm),
        last_calibration: tested_us.and_then(|us| u64::try_from(us).ok()).map(Timestamp),
        contacts_left: left.and_then(|left| left.mean).and_then(two_digits),
        contacts_left_low: left.and_then(|left| left.low).and_then(two_digits),
        contacts_left_high: left.and_then(|left| left.high).and_then(two_digits),
    })
}

/// A number of contacts with two significant digits; `None` if it is not finite.
fn two_digits(contacts: f64) -> Option<f64> {
    if !contacts.is_finite() {
        return None;
    }
    let contacts = contacts.clamp(0.0, CONTACTS_MAX);
    let unit = 10_f64.powi(contacts.max(10.0).log10().floor() as i32 - 1);
    Some((contacts / unit).round() * unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_have_two_digits() {
        for (contacts, told) in [
            (0.0, Some(0.0)),
            (7.4, Some(7.0)),
            (99.6, Some(100.0)),
            (5_249.0, Some(5_200.0)),
            (1e15, Some(1e9)),
            (f64::NAN, None),
            (f64::INFINITY, None),
        ] {
            assert_eq!(two_digits(contacts), told, "{contacts}");
        }
    }
}
