//! The whisker that the helper touches while the check sends estimates with other lengths.

use vibrissa_protocol::{Factsheet, PlaceKind};

use super::action::Spot;

/// The second length as a multiple of the first one. A longer one, because distances beyond the length have no ratio.
const LONGER: f64 = 1.25;
/// Longest length that an estimate may have, in mm.
const LENGTH_MAX_MM: f64 = 1000.0;

/// The whisker of the test.
#[derive(Debug, Clone)]
pub(super) struct Touched {
    pub(super) spot: Spot,
    /// Its length on the factsheet.
    pub(super) length_mm: f64,
}

impl Touched {
    /// The whisker of the trial if it has contact ratios, otherwise the first one with contact ratios.
    pub(super) fn choose(factsheet: &Factsheet, trial: Option<Spot>) -> Option<Self> {
        let all = factsheet.arrays.iter().flat_map(|array| array.whiskers.iter().map(move |one| (&array.array, one)));
        let with_ratio = all.filter(|(_, one)| one.place.unwrap_or(PlaceKind::Ratio) == PlaceKind::Ratio);
        let all: Vec<Self> = with_ratio
            .map(|(array, one)| Self {
                spot: Spot { array: array.clone(), whisker: one.whisker },
                length_mm: one.length_mm,
            })
            .collect();
        let at = all.iter().position(|one| Some(&one.spot) == trial.as_ref()).unwrap_or(0);
        all.into_iter().nth(at)
    }

    /// The lengths of the first and the second estimate.
    pub(super) fn lengths_mm(&self) -> (f64, f64) {
        let longer_mm = LONGER * self.length_mm;
        if longer_mm <= LENGTH_MAX_MM { (self.length_mm, longer_mm) } else { (self.length_mm / LONGER, self.length_mm) }
    }
}
