//! The true contact ratio that a stated one leads to expect.
//!
//! A stated contact ratio has an error of known size. A regression of the strain on stated ratios would flatten the
//! slope of the strain over the ratio, by the share that the errors have in the variance of the stated ratios (errors
//! in variables): 0.4 % for contacts all over the whisker, 11 % for contacts within a tenth of it. The filter would
//! learn that as a slope of the offset and extrapolate it to contacts elsewhere. Regression calibration removes the
//! cause: the model is evaluated at the expectation of the true ratio under the distribution of the robot's contacts,
//! `m + v / (v + error^2) (stated - m)`, with mean m and variance v of the true ratios.

use borsh::{BorshDeserialize, BorshSerialize};

use crate::units::ContactRatio;

/// Contacts from which a distribution is known well enough to be used.
const CONTACTS_MIN: f32 = 10.0;
/// Largest weight of the past, in contacts: habits change.
const MEMORY_CONTACTS: f32 = 300.0;
/// A contact this many standard deviations off the mean belongs to another habit. Even distributions end at 1.7.
const OTHER_HABIT_SD: f64 = 4.0;

/// Distribution of the places at which a robot touches a whisker at present.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct RatioSpread {
    mean: f32,
    /// Variance of the true ratios: that of the stated ones less that of their errors, so chance may make it negative.
    variance: f32,
    contacts: f32,
}

/// A contact ratio with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedRatio {
    /// Expected contact ratio.
    pub ratio: ContactRatio,
    /// Standard deviation of the true ratio around it.
    pub sd: f64,
}

impl RatioSpread {
    /// The true ratio, given the stated one and the standard deviation of its error.
    #[must_use]
    pub fn expected(&self, stated: ContactRatio, error_sd: f64) -> ExpectedRatio {
        let as_stated = ExpectedRatio { ratio: stated, sd: error_sd };
        if error_sd <= 0.0 || self.contacts < CONTACTS_MIN || self.is_elsewhere(stated, error_sd) {
            return as_stated;
        }
        let variance = f64::from(self.variance).max(0.0);
        let share = variance / (variance + error_sd * error_sd);
        let mean = f64::from(self.mean);
        match ContactRatio::new(mean + share * (stated.a() - mean)) {
            Ok(ratio) => ExpectedRatio { ratio, sd: error_sd * share.sqrt() },
            Err(_) => as_stated,
        }
    }

    /// Takes a stated ratio in. Contacts at the tip, which have no error, follow no distribution.
    pub fn learn(&mut self, stated: ContactRatio, error_sd: f64) {
        if error_sd <= 0.0 {
            return;
        }
        if self.contacts == 0.0 || self.contacts >= CONTACTS_MIN && self.is_elsewhere(stated, error_sd) {
            *self = Self { mean: stated.a() as f32, variance: 0.0, contacts: 1.0 };
            return;
        }
        self.contacts = (self.contacts + 1.0).min(MEMORY_CONTACTS);
        let weight = 1.0 / f64::from(self.contacts);
        let (mean, variance) = (f64::from(self.mean), f64::from(self.variance));
        let off = stated.a() - mean;
        // The mean moves towards the contact, so that the square is a share of a contact too small.
        let square = (1.0 - weight) * off * off - error_sd * error_sd;
        self.mean = (mean + weight * off) as f32;
        self.variance = (variance + (square - variance) / (f64::from(self.contacts) - 1.0)) as f32;
    }

    /// Whether a contact shows that the robot touches the whisker elsewhere by now.
    fn is_elsewhere(&self, stated: ContactRatio, error_sd: f64) -> bool {
        let variance = f64::from(self.variance).max(0.0) + error_sd * error_sd;
        (stated.a() - f64::from(self.mean)).powi(2) > OTHER_HABIT_SD * OTHER_HABIT_SD * variance
    }

    /// Whether all numbers are finite.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.mean.is_finite() && self.variance.is_finite() && self.contacts.is_finite()
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

    #[test]
    fn another_zone_begins_anew_and_a_tip_is_exact() {
        let mut spread = RatioSpread::default();
        for step in 0..500 {
            spread.learn(contact(step, (0.8, 0.9), 0.01).1, 0.01);
        }
        let tip = ExpectedRatio { ratio: ContactRatio::TIP, sd: 0.0 };
        assert_eq!(spread.expected(ContactRatio::TIP, 0.0), tip);
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
