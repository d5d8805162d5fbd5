//! The figures of one row.

use super::healthy::Healthy;
use super::incident::{Compensated, Found};
use super::{Row, StatedPlace};

/// A cut from this size on counts in [`Figures::found_from_2_mm`], mm.
const LARGE_MM: f64 = 2.0;

/// The figures of one row.
#[derive(Debug, Clone, PartialEq)]
pub struct Figures {
    /// Row of the table: nuisance and strength.
    pub row: Row,
    /// Kind of place that the robot states with its contacts.
    pub place: StatedPlace,
    /// Reports about healthy whiskers.
    pub healthy: Healthy,
    /// The whiskers that were cut or worn.
    pub found: Vec<Found>,
}

/// A share, as a number of cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Share {
    /// Cases that have the property.
    pub count: usize,
    /// Number of all cases.
    pub of: usize,
}

/// Median and 90 % quantile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Median of the values.
    pub median: f64,
    /// 90 % quantile.
    pub most: f64,
}

impl Share {
    fn among<T>(all: impl Iterator<Item = T>, has: impl Fn(&T) -> bool) -> Self {
        all.fold(Self { count: 0, of: 0 }, |share, one| Self {
            count: share.count + usize::from(has(&one)),
            of: share.of + 1,
        })
    }

    /// As a ratio; `None` without cases.
    #[must_use]
    pub fn ratio(self) -> Option<f64> {
        (self.of > 0).then(|| self.count as f64 / self.of as f64)
    }
}

impl Spread {
    fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.filter(|value| value.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted.get(((sorted.len() as f64 * share) as usize).min(sorted.len().wrapping_sub(1)));
        Some(Self { median: *at(0.5)?, most: *at(0.9)? })
    }
}

impl Figures {
    /// Cuts that were reported as a trim (of wear: as erosion or trim).
    #[must_use]
    pub fn found(&self) -> Share {
        Share::among(self.found.iter(), |one| one.call.is_some())
    }

    /// The same of at least 2 mm.
    #[must_use]
    pub fn found_from_2_mm(&self) -> Share {
        Share::among(self.found.iter().filter(|one| one.size_mm >= LARGE_MM), |one| one.call.is_some())
    }

    /// Contacts from the cut to the alarm.
    #[must_use]
    pub fn alarm(&self) -> Option<Spread> {
        self.contacts(|one| one.alarm)
    }

    /// Contacts from the cut to the report.
    #[must_use]
    pub fn call(&self) -> Option<Spread> {
        self.contacts(|one| one.call)
    }

    /// Contacts from the cut to the setpoint.
    #[must_use]
    pub fn setpoint(&self) -> Option<Spread> {
        self.contacts(|one| one.setpoint)
    }

    fn contacts(&self, of: fn(&Found) -> Option<u64>) -> Option<Spread> {
        Spread::of(self.found.iter().filter_map(of).map(|contacts| contacts as f64))
    }

    /// Error of the reported length, mm: median and standard deviation.
    #[must_use]
    pub fn length_error_mm(&self) -> Option<(f64, f64)> {
        let errors: Vec<f64> = self.found.iter().filter_map(|one| Some(one.length?.0)).collect();
        let count = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / count;
        let variance = errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / count;
        Some((Spread::of(errors.iter().copied())?.median, variance.sqrt()))
    }

    /// Reported lengths whose 95 % interval contains the truth.
    #[must_use]
    pub fn length_covered(&self) -> Share {
        Share::among(self.found.iter().filter_map(|one| one.length), |&length| Found::is_covered(length))
    }

    /// Lengths 300 and 2,000 contacts after a change, or after its end, whose 95 % interval contains the truth, reported or not.
    #[must_use]
    pub fn length_after_covered(&self) -> [Share; 2] {
        [0, 1].map(|moment| {
            let lengths = self.found.iter().filter_map(|one| one.length_after[moment]);
            Share::among(lengths, |&length| Found::is_covered(length))
        })
    }

    /// Lengths at the end of each trial whose 95 % interval contains the truth, reported or not.
    #[must_use]
    pub fn length_end_covered(&self) -> Share {
        Share::among(self.found.iter(), |one| Found::is_covered(one.length_end))
    }

    fn compensated(&self) -> impl Iterator<Item = Compensated> + '_ {
        self.found.iter().filter_map(|one| one.compensated)
    }

    /// Cut whiskers that are compensated at the end.
    #[must_use]
    pub fn served(&self) -> Share {
        Share::among(self.found.iter(), |one| one.compensated.is_some())
    }

    /// True error of the compensations, as a ratio: mean.
    #[must_use]
    pub fn error_true(&self) -> Option<f64> {
        mean(self.compensated().map(|one| one.truth))
    }

    /// Measured error, as a ratio: mean.
    #[must_use]
    pub fn error_measured(&self) -> Option<f64> {
        mean(self.compensated().filter_map(|one| Some(one.measured?.0)))
    }

    /// Predicted error, as a ratio: mean.
    #[must_use]
    pub fn error_predicted(&self) -> Option<f64> {
        mean(self.compensated().map(|one| one.predicted.0))
    }

    /// Mean error of the readings with gain, as a ratio: while a whisker wore, else at the end.
    #[must_use]
    pub fn reading_error(&self) -> Option<f64> {
        mean(self.found.iter().filter_map(|one| one.worn_reading.or_else(|| one.compensated?.reading)))
    }

    /// Mean error of the readings with gain 300 contacts after the first setpoint, as a ratio.
    #[must_use]
    pub fn soon_reading_error(&self) -> Option<f64> {
        mean(self.found.iter().filter_map(|one| one.soon?.reading))
    }

    /// Errors measured 300 contacts after the first setpoint whose 95 % interval contains the truth.
    #[must_use]
    pub fn soon_measured_covered(&self) -> Share {
        let soon = self.found.iter().filter_map(|one| one.soon);
        let errors = soon.filter_map(|one| one.measured.map(|(mean, sd)| (mean - one.truth, sd)));
        Share::among(errors, |&error| Found::is_covered(error))
    }

    /// Measured errors whose 95 % interval contains the truth over all contact ratios.
    #[must_use]
    pub fn measured_covered(&self) -> Share {
        let errors = self.compensated().filter_map(|one| one.measured.map(|(mean, sd)| (mean - one.truth, sd)));
        Share::among(errors, |&error| Found::is_covered(error))
    }

    /// Predicted errors whose 95 % interval contains the truth at the pressure that was decided.
    #[must_use]
    pub fn predicted_covered(&self) -> Share {
        Share::among(self.compensated().map(|one| one.predicted), |&(_, (low, high), truth)| {
            low <= truth && truth <= high
        })
    }

    /// Reports of something else about cut whiskers: erosion, loss of sensitivity, the same cut once more.
    #[must_use]
    pub fn wrong(&self) -> u64 {
        self.found.iter().map(|one| one.wrong).sum()
    }

    /// Compensations that ended without cause.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.found.iter().map(|one| one.lost).sum()
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}
