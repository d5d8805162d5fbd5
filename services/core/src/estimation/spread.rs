//! The true contact ratio that a stated one leads to expect.
//!
//! A stated contact ratio has an error of known size. A regression of the strain on stated ratios would flatten the
//! slope of the strain over the ratio, by the share that the errors have in the variance of the stated ratios (errors
//! in variables): 0.4 % for contacts all over the whisker, 11 % for contacts within a tenth of it. The filter would
//! learn that as a slope of the offset and extrapolate it to contacts elsewhere. Regression calibration removes the
//! cause: the model is evaluated at the expectation of the true ratio under the distribution of the robot's contacts,
//! `m + v / (v + error^2) (stated - m)`, with mean m and variance v of the true ratios.

use borsh::io::{Read, Result};
use borsh::{BorshDeserialize, BorshSerialize};

use crate::units::ContactRatio;

/// Contacts from which a distribution is known well enough to be used.
const CONTACTS_MIN: f32 = 10.0;
/// Largest weight of the past, in contacts: habits change.
const MEMORY_CONTACTS: f32 = 300.0;
/// A contact this many standard deviations off the mean belongs to another habit. Even distributions end at 1.7.
const OTHER_HABIT_SD: f64 = 4.0;

/// Prior standard deviation of the scale of the errors' variance, and its range: robots state it to a factor of two or so.
const SCALE_SD: f32 = 1.5;
const SCALE_MIN_MAX: (f64, f64) = (1.0 / 16.0, 16.0);
/// Random walk of that scale per square root of a contact.
const SCALE_WANDER: f64 = 0.01;
/// Largest share of the variance of the stated ratios that their errors have.
const ERRORS_MOST: f64 = 0.95;

/// Distribution of the places at which a robot touches a whisker at present, and the size of the ratios' errors.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct RatioSpread {
    mean: f32,
    /// Variance of the stated ratios.
    variance: f32,
    contacts: f32,
    /// Variance of the errors relative to the stated one, with its own variance.
    scale: f32,
    scale_variance: f32,
}

impl Default for RatioSpread {
    fn default() -> Self {
        Self { mean: 0.0, variance: 0.0, contacts: 0.0, scale: 1.0, scale_variance: SCALE_SD * SCALE_SD }
    }
}

/// A contact ratio with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedRatio {
    /// Expected contact ratio.
    pub ratio: ContactRatio,
    /// Standard deviation of the true ratio around it.
    pub sd: f64,
    /// Mean of the distribution.
    pub mean: ContactRatio,
    /// Share of the distance of the stated ratio from the mean that the errors take, 0 to 1; 1 while the distribution is
    /// not known.
    pub lost: f64,
}

impl ExpectedRatio {
    /// A contact whose ratio is known without an error.
    #[must_use]
    pub fn exact(ratio: ContactRatio) -> Self {
        Self { ratio, sd: 0.0, mean: ratio, lost: 0.0 }
    }
}

/// A contact that tells of the errors' size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Deviation of log sensitivity from the prediction at the expected ratio.
    pub residual: f64,
    /// Variance of the residual, larger for a likely outlier.
    pub variance: f64,
    /// d(log sensitivity) / d(contact ratio).
    pub per_ratio: f64,
}

impl RatioSpread {
    /// The true ratio, given the stated one and the stated standard deviation of its error.
    #[must_use]
    pub fn expected(&self, stated: ContactRatio, error_sd: f64) -> ExpectedRatio {
        if error_sd <= 0.0 {
            return ExpectedRatio::exact(stated);
        }
        let sd = error_sd * f64::from(self.scale).sqrt();
        if self.contacts == 0.0 || self.is_elsewhere(stated, error_sd) {
            return ExpectedRatio { ratio: stated, sd, mean: stated, lost: 1.0 };
        }
        let mean = ContactRatio::new(self.mean.into()).unwrap_or(stated);
        if self.contacts < CONTACTS_MIN {
            return ExpectedRatio { ratio: stated, sd, mean, lost: 1.0 };
        }
        let lost = self.errors_share(error_sd, self.scale.into());
        let ratio = ContactRatio::new(stated.a() + lost * (mean.a() - stated.a())).unwrap_or(stated);
        let lost_most = self.errors_share(error_sd, f64::from(self.scale).max(1.0));
        ExpectedRatio { ratio, sd: sd * (1.0 - lost).sqrt(), mean, lost: lost_most }
    }

    /// Mean of the ratios at which the robot touches at present, once it is known.
    #[must_use]
    pub fn mean(&self) -> Option<ContactRatio> {
        (self.contacts >= CONTACTS_MIN).then(|| ContactRatio::new(self.mean.into()).ok()).flatten()
    }

    /// Share of the errors in the variance of the stated ratios.
    fn errors_share(&self, error_sd: f64, scale: f64) -> f64 {
        (scale * error_sd * error_sd / f64::from(self.variance)).min(ERRORS_MOST)
    }

    /// Takes a stated ratio in. Contacts at the tip, which have no error, follow no distribution.
    pub fn learn(&mut self, stated: ContactRatio, error_sd: f64) {
        if error_sd <= 0.0 {
            return;
        }
        if self.contacts == 0.0 || self.is_elsewhere(stated, error_sd) {
            *self = Self { mean: stated.a() as f32, variance: 0.0, contacts: 1.0, ..*self };
            return;
        }
        self.contacts = (self.contacts + 1.0).min(MEMORY_CONTACTS);
        let weight = 1.0 / f64::from(self.contacts);
        let (mean, variance) = (f64::from(self.mean), f64::from(self.variance));
        let off = stated.a() - mean;
        // The mean moves towards the contact, so that the square is a share of a contact too small.
        let square = (1.0 - weight) * off * off;
        self.mean = (mean + weight * off) as f32;
        self.variance = (variance + (square - variance) / (f64::from(self.contacts) - 1.0)) as f32;
    }

    /// Takes in the deviation of a contact from the prediction. If the errors are larger than they are taken for, the
    /// expected ratios are too far from the mean, and deviations go with their distance. The share that the errors take
    /// depends on their variance, which a scalar Kalman filter estimates.
    pub fn learn_errors(&mut self, stated: ContactRatio, error_sd: f64, seen: &Deviation) {
        if error_sd <= 0.0 || self.contacts < CONTACTS_MIN || self.is_elsewhere(stated, error_sd) {
            return;
        }
        // The expected ratio lies `scale share_of_one (mean - stated)` off the stated one, and the prediction follows it.
        // Ratios that were stated exactly alike have no variance; with errors of the least size they would have this one.
        let least = SCALE_MIN_MAX.0 * error_sd * error_sd;
        let share_of_one = error_sd * error_sd / f64::from(self.variance).max(least);
        let row = seen.per_ratio * share_of_one * (f64::from(self.mean) - stated.a());
        let uncertain = f64::from(self.scale_variance);
        let gain = uncertain * row / (row * row * uncertain + seen.variance);
        let scale = f64::from(self.scale) + gain * seen.residual;
        self.scale = scale.clamp(SCALE_MIN_MAX.0, SCALE_MIN_MAX.1) as f32;
        let left = (1.0 - gain * row) * uncertain + SCALE_WANDER * SCALE_WANDER;
        self.scale_variance = left.min(f64::from(SCALE_SD * SCALE_SD)) as f32;
    }

    /// Whether a contact shows that the robot touches the whisker elsewhere by now.
    fn is_elsewhere(&self, stated: ContactRatio, error_sd: f64) -> bool {
        let variance = f64::from(self.variance).max(error_sd * error_sd);
        self.contacts >= CONTACTS_MIN
            && (stated.a() - f64::from(self.mean)).powi(2) > OTHER_HABIT_SD * OTHER_HABIT_SD * variance
    }

    /// Reads a distribution as it was stored in version 7 of the whisker: with the variance of the true ratios instead of the
    /// stated ones. It is learned anew.
    ///
    /// # Errors
    /// The bytes end.
    pub fn read_7<R: Read>(reader: &mut R) -> Result<Self> {
        let _: [f32; 3] = BorshDeserialize::deserialize_reader(reader)?;
        Ok(Self::default())
    }

    /// Whether all numbers are finite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        [self.mean, self.variance, self.contacts, self.scale, self.scale_variance].iter().all(|one| one.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Evenly spread numbers in 0 to 1, independent for each purpose.
    fn even(step: u32, purpose: u32) -> f64 {
        let irrational = [0.618_033_988_749_894_8, 0.754_877_666_246_692_7, 0.569_840_290_998_053_2][purpose as usize];
        (f64::from(step) * irrational).fract()
    }

    /// A true ratio within a zone, and the ratio that is stated, whose error has a triangular density.
    fn contact(step: u32, zone: (f64, f64), error_sd: f64) -> (f64, ContactRatio) {
        let ratio = zone.0 + even(step, 0) * (zone.1 - zone.0);
        let error = (even(step, 1) + even(step, 2) - 1.0) * 6.0_f64.sqrt() * error_sd;
        (ratio, ContactRatio::known((ratio + error).clamp(0.05, 1.0)))
    }

    /// Slope of the least squares line of the true ratio over the expected one: 1 without bias.
    fn slope(zone: (f64, f64), error_sd: f64, corrected: bool) -> f64 {
        let mut spread = RatioSpread::default();
        let (mut sum, mut products, mut squares) = ((0.0, 0.0), 0.0, 0.0);
        let middle = f64::midpoint(zone.0, zone.1);
        for step in 0..20_000 {
            let (ratio, stated) = contact(step, zone, error_sd);
            let expected = if corrected { spread.expected(stated, error_sd).ratio } else { stated };
            let (x, y) = (expected.a() - middle, ratio - middle);
            sum = (sum.0 + x / 20_000.0, sum.1 + y / 20_000.0);
            products += x * y / 20_000.0;
            squares += x * x / 20_000.0;
            spread.learn(stated, error_sd);
        }
        (products - sum.0 * sum.1) / (squares - sum.0 * sum.0)
    }

    #[test]
    fn property_expected_ratios_do_not_flatten_a_slope() {
        for zone in [(0.8, 0.9), (0.5, 0.6), (0.45, 0.95)] {
            assert!((slope(zone, 0.01, true) - 1.0).abs() < 0.015, "{zone:?}: {}", slope(zone, 0.01, true));
        }
        assert!(slope((0.8, 0.9), 0.01, false) < 0.92, "without it the slope is flat");
    }

    /// The share of the errors was divided by zero: no contact of the whisker was plausible any more, and a cut was forgotten
    /// at the next restart.
    #[test]
    fn regress_ratios_that_are_stated_exactly_alike_leave_the_numbers_finite() {
        // 0.75 is exact in binary, 0.7 is not.
        for alike in [0.75, 0.7] {
            let mut spread = RatioSpread::default();
            (0..12).for_each(|_| spread.learn(ContactRatio::known(alike), 0.01));
            let other = ContactRatio::known(alike + 0.01);
            let seen = Deviation { residual: 0.05, variance: 1.4e-3, per_ratio: 3.0 };
            spread.learn_errors(other, 0.01, &seen);
            assert!(spread.is_sound(), "{spread:?}");
            assert!(spread.scale_variance > 1e-3, "one contact does not settle the size of the errors: {spread:?}");
            assert!(spread.expected(other, 0.01).sd.is_finite());
        }
    }

    #[test]
    fn another_zone_begins_anew_and_a_tip_is_exact() {
        let mut spread = RatioSpread::default();
        for step in 0..500 {
            spread.learn(contact(step, (0.8, 0.9), 0.01).1, 0.01);
        }
        assert_eq!(spread.expected(ContactRatio::TIP, 0.0), ExpectedRatio::exact(ContactRatio::TIP));
        let before = spread;
        spread.learn(ContactRatio::TIP, 0.0);
        assert_eq!(spread, before);
        let elsewhere = ContactRatio::known(0.55);
        assert_eq!(spread.expected(elsewhere, 0.01).ratio, elsewhere);
        spread.learn(elsewhere, 0.01);
        assert_eq!(spread.expected(ContactRatio::known(0.85), 0.01).sd, 0.01, "nothing is known of the new habit");
    }

    #[test]
    fn property_a_robot_that_always_touches_one_place_is_expected_there() {
        let mut spread = RatioSpread::default();
        for step in 0..500 {
            spread.learn(contact(step, (0.7, 0.7), 0.01).1, 0.01);
        }
        let expected = spread.expected(ContactRatio::known(0.72), 0.01);
        assert!((expected.ratio.a() - 0.7).abs() < 0.004 && expected.sd < 0.004, "{expected:?}");
    }
}
