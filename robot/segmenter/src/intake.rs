//! From samples to bins: checks, glitches, and at most 250 values a second, or 15 while the whisker shakes.

use std::collections::VecDeque;

use crate::glitch::Glitches;
use crate::shake::Shake;
use crate::{Counts, Params, Sample};

/// Samples that come faster are averaged in bins of this width. s.
const BIN_S: f64 = 0.004;
/// The same while the whisker shakes: two periods of 30 Hz. s.
const SHAKING_BIN_S: f64 = 0.066_7;

/// Average of the samples of a bin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bin {
    /// Seconds since the first sample.
    pub(crate) t_s: f64,
    pub(crate) strain: f64,
    pub(crate) strain_2: Option<f64>,
    pub(crate) deflection_mm: Option<f64>,
    pub(crate) distance_mm: Option<f64>,
    pub(crate) pressure_mpa: Option<f64>,
    pub(crate) setpoint_mpa: Option<f64>,
    pub(crate) saturated: bool,
    pub(crate) shaking: bool,
}

/// State of the intake.
#[derive(Clone, Debug, Default)]
pub(crate) struct Intake {
    pub(crate) counts: Counts,
    first_us: Option<u64>,
    last_us: u64,
    /// Spacing of the samples, filtered. s.
    pub(crate) period_s: f64,
    pub(crate) glitches: Glitches,
    good: VecDeque<Sample>,
    pub(crate) shake: Shake,
    sum: Bin,
    sum_2: f64,
    count: u32,
    count_2: u32,
    last_strain: Option<f64>,
    /// Smallest difference of two samples: the converter's step.
    pub(crate) grain: f64,
}

impl Intake {
    pub(crate) fn time_us(&self, t_s: f64) -> u64 {
        self.first_us.unwrap_or(0).saturating_add((t_s.max(0.0) * 1e6) as u64)
    }

    pub(crate) fn seconds(&self, t_us: u64) -> f64 {
        t_us.saturating_sub(self.first_us.unwrap_or(0)) as f64 * 1e-6
    }

    /// Takes a sample; returns whether samples were missing before it. [`Intake::next`] has the bins.
    pub(crate) fn push(&mut self, params: &Params, sample: Sample) -> bool {
        let numbers = [
            Some(sample.strain),
            sample.strain_2,
            sample.deflection_mm,
            sample.distance_mm,
            sample.pressure_mpa,
            sample.setpoint_mpa,
        ];
        if numbers.into_iter().flatten().any(|number| !number.is_finite()) {
            self.counts.not_a_number += 1;
            return false;
        }
        if self.first_us.is_some() && sample.t_us <= self.last_us {
            self.counts.out_of_order += 1;
            return false;
        }
        let first = self.first_us.is_none();
        self.first_us.get_or_insert(sample.t_us);
        let dt_s = if first { 0.0 } else { (sample.t_us - self.last_us) as f64 * 1e-6 };
        self.last_us = sample.t_us;
        // The first two samples tell the spacing.
        let spaced = self.period_s > 0.0 || dt_s > 1.0;
        let gap = !first && spaced && dt_s > params.gap_s.max(5.0 * self.period_s);
        if gap {
            self.glitches.gap();
            self.shake.gap();
            self.good.clear();
            self.count = 0;
            self.last_strain = None;
        } else if !first {
            self.period_s = if self.period_s == 0.0 { dt_s } else { self.period_s + 0.05 * (dt_s - self.period_s) };
        }
        // Glitches at the limit go to and fro, too.
        if sample.strain.abs() < params.strain_limit {
            self.shake.push(self.seconds(sample.t_us), sample.strain);
        }
        let shakes = self.shake.is_shaking() || sample.driving == Some(true);
        self.counts.glitches += self.glitches.push(params, sample, shakes, &mut self.good);
        gap
    }

    /// The next bin that is full.
    pub(crate) fn next(&mut self, params: &Params) -> Option<Bin> {
        while let Some(sample) = self.good.pop_front() {
            let step = self.last_strain.map_or(0.0, |last| (sample.strain - last).abs());
            self.last_strain = Some(sample.strain);
            if step > 0.0 && (self.grain == 0.0 || step < self.grain) {
                self.grain = step;
            }
            if let Some(bin) = self.gather(params, sample) {
                return Some(bin);
            }
        }
        None
    }

    fn gather(&mut self, params: &Params, sample: Sample) -> Option<Bin> {
        if self.count == 0 {
            self.sum = Bin::default();
            self.sum_2 = 0.0;
            self.count_2 = 0;
        }
        let t_s = (sample.t_us - self.first_us.unwrap_or(0)) as f64 * 1e-6;
        let shaking = self.shake.is_shaking() || sample.driving == Some(true);
        self.sum.t_s += t_s;
        self.sum.strain += sample.strain;
        if let Some(strain_2) = sample.strain_2 {
            self.sum_2 += strain_2;
            self.count_2 += 1;
        }
        let limit = params.strain_limit;
        if sample.saturated
            || sample.strain.abs() >= limit
            || sample.strain_2.is_some_and(|strain_2| strain_2.abs() >= limit)
        {
            self.counts.saturated += 1;
            self.sum.saturated = true;
        }
        self.sum.deflection_mm = sample.deflection_mm;
        self.sum.distance_mm = sample.distance_mm;
        self.sum.pressure_mpa = sample.pressure_mpa;
        self.sum.setpoint_mpa = sample.setpoint_mpa;
        self.sum.shaking = shaking;
        self.count += 1;
        let width_s = if shaking { SHAKING_BIN_S } else { BIN_S };
        let wanted = (width_s / self.period_s.max(1e-5) + 0.25).floor().max(1.0);
        if f64::from(self.count) < wanted {
            return None;
        }
        let count = f64::from(self.count);
        let strain_2 = (self.count_2 == self.count).then(|| self.sum_2 / count);
        self.count = 0;
        Some(Bin { t_s: self.sum.t_s / count, strain: self.sum.strain / count, strain_2, ..self.sum })
    }
}
