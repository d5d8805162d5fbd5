//! Closed intervals of a chamber's pressure, pooled: one slope, an intercept for each interval.

use borsh::{BorshDeserialize, BorshSerialize};

use super::sealed_interval::SealedInterval;
use super::trend::{Interval, Slope};

/// Least degrees of freedom of a reported rate.
const LEAST_FREEDOM: f64 = 4.0;
/// Least total span of a reported rate, in seconds: trembling valves shift the pressure a little now and then.
const LEAST_S: f64 = 60.0;
/// Number of intervals from which on the scatter of their slopes counts.
const INTERVALS_FOR_SCATTER: f64 = 3.0;

/// Fading sums over closed intervals.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub(super) struct Pool {
    intervals: f32,
    seconds: f32,
    weight: f32,
    slope: f32,
    squares: f32,
    freedom: f32,
    /// Sum of weight^2 times the variance that rounding may add to a slope.
    rounding: f32,
    /// Sums of weight^2, weight^2 slope, weight^2 slope^2.
    scatter: [f32; 3],
}

impl Pool {
    pub(super) fn fade(&mut self, keep: f64) {
        let keep = keep as f32;
        for sum in [
            &mut self.intervals,
            &mut self.seconds,
            &mut self.weight,
            &mut self.slope,
            &mut self.squares,
            &mut self.freedom,
            &mut self.rounding,
        ] {
            *sum *= keep;
        }
        self.scatter = self.scatter.map(|sum| sum * keep);
    }

    /// Adds a closed interval. The step is that of the pressure sensor.
    pub(super) fn add(&mut self, sensor_step_mpa: f64, open: &SealedInterval) {
        let Some(Slope { per_x, weight, squares, freedom }) = open.slope() else { return };
        let mpa = f64::from(open.mpa);
        let by_pressure = mpa.powi(2);
        let weight = by_pressure * weight;
        self.intervals += 1.0;
        self.seconds += open.span_s() as f32;
        self.weight += weight as f32;
        self.slope += (weight * per_x) as f32;
        self.squares += (by_pressure * squares) as f32;
        self.freedom += freedom as f32;
        // Rounding errors are uniform over a step, so a line through a few of them is off by about a step over the
        // interval (1 / sqrt(12) times sqrt(12)), and by much less once the pressure falls through several steps.
        let step = sensor_step_mpa / mpa;
        let fallen = per_x.abs() * open.span_s();
        let rounding = step / open.span_s().max(1.0) * (step / fallen.max(step));
        self.rounding += (weight * rounding).powi(2) as f32;
        for (sum, power) in self.scatter.iter_mut().zip([1.0, per_x, per_x.powi(2)]) {
            *sum += (weight.powi(2) * power) as f32;
        }
    }

    pub(super) fn interval(&self) -> Option<Interval> {
        self.rate().filter(|_| f64::from(self.seconds) >= LEAST_S)
    }

    pub(super) fn rate(&self) -> Option<Interval> {
        let [intervals, weight, slope, squares, freedom, rounding] =
            [self.intervals, self.weight, self.slope, self.squares, self.freedom, self.rounding].map(f64::from);
        let all_freedom = freedom + (intervals - 1.0).max(0.0);
        if weight <= 0.0 || all_freedom < LEAST_FREEDOM {
            return None;
        }
        let slope = slope / weight;
        let within = if freedom > 0.0 { squares / freedom / weight } else { 0.0 };
        let [one, linear, square] = self.scatter.map(f64::from);
        let scatter = (square - 2.0 * slope * linear + slope.powi(2) * one).max(0.0) / weight.powi(2);
        let between = if intervals >= INTERVALS_FOR_SCATTER { scatter * intervals / (intervals - 1.0) } else { 0.0 };
        let within = within + rounding / weight.powi(2);
        Interval::of(-slope, within.max(between), all_freedom)
    }
}
