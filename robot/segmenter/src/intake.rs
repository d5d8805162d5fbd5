//! From samples to bins: checks, single glitches, and at most 250 values a second.

use crate::{Counts, Params, Sample};

/// Samples that come faster are averaged in bins of this width. s.
const BIN_S: f64 = 0.004;

/// Average of the samples of a bin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Bin {
    /// Seconds since the first sample.
    pub(crate) t_s: f64,
    pub(crate) strain: f64,
    pub(crate) strain_2: Option<f64>,
    pub(crate) deflection_mm: Option<f64>,
    pub(crate) distance_mm: Option<f64>,
    pub(crate) saturated: bool,
}

/// Result of the checks of a sample.
pub(crate) enum Taken {
    Nothing,
    /// Samples were missing before this one.
    Gap,
    Bin(Bin),
}

/// State of the intake.
#[derive(Clone, Debug, Default)]
pub(crate) struct Intake {
    pub(crate) counts: Counts,
    first_us: Option<u64>,
    last_us: u64,
    /// Spacing of the samples, filtered. s.
    pub(crate) period_s: f64,
    /// The last two samples, for the median of three.
    before: [Option<Sample>; 2],
    saturated: bool,
    sum: Bin,
    sum_2: f64,
    count: u32,
    count_2: u32,
    /// Smallest difference of two samples: the converter's step.
    pub(crate) grain: f64,
}

impl Intake {
    pub(crate) fn time_us(&self, t_s: f64) -> u64 {
        self.first_us.unwrap_or(0).saturating_add((t_s.max(0.0) * 1e6) as u64)
    }

    pub(crate) fn push(&mut self, params: &Params, sample: Sample) -> Taken {
        let numbers = [Some(sample.strain), sample.strain_2, sample.deflection_mm, sample.distance_mm];
        if numbers.into_iter().flatten().any(|number| !number.is_finite()) {
            self.counts.not_a_number += 1;
            return Taken::Nothing;
        }
        if self.first_us.is_some() && sample.t_us <= self.last_us {
            self.counts.out_of_order += 1;
            return Taken::Nothing;
        }
        let first = self.first_us.is_none();
        self.first_us.get_or_insert(sample.t_us);
        let dt_s = if first { 0.0 } else { (sample.t_us - self.last_us) as f64 * 1e-6 };
        self.last_us = sample.t_us;
        if sample.strain.abs() >= params.strain_limit
            || sample.strain_2.is_some_and(|two| two.abs() >= params.strain_limit)
        {
            self.counts.saturated += 1;
            self.saturated = true;
        }
        if !first {
            if dt_s > params.gap_s.max(5.0 * self.period_s) {
                self.before = [None, Some(sample)];
                self.count = 0;
                return Taken::Gap;
            }
            self.period_s = if self.period_s == 0.0 { dt_s } else { self.period_s + 0.05 * (dt_s - self.period_s) };
        }
        let [oldest, middle] = self.before;
        self.before = [middle, Some(sample)];
        let (Some(oldest), Some(middle)) = (oldest, middle) else {
            return Taken::Nothing;
        };
        let step = (sample.strain - middle.strain).abs();
        if step > 0.0 && (self.grain == 0.0 || step < self.grain) {
            self.grain = step;
        }
        self.gather(oldest, middle, sample)
    }

    /// Adds the middle sample, with the median of three in place of its strains.
    fn gather(&mut self, oldest: Sample, middle: Sample, newest: Sample) -> Taken {
        if self.count == 0 {
            self.sum = Bin::default();
            self.sum_2 = 0.0;
            self.count_2 = 0;
        }
        let t_s = (middle.t_us - self.first_us.unwrap_or(0)) as f64 * 1e-6;
        self.sum.t_s += t_s;
        self.sum.strain += median(oldest.strain, middle.strain, newest.strain);
        if let (Some(oldest), Some(middle), Some(newest)) = (oldest.strain_2, middle.strain_2, newest.strain_2) {
            self.sum_2 += median(oldest, middle, newest);
            self.count_2 += 1;
        }
        self.sum.deflection_mm = middle.deflection_mm;
        self.sum.distance_mm = middle.distance_mm;
        self.sum.saturated |= self.saturated;
        self.saturated = false;
        self.count += 1;
        let wanted = (BIN_S / self.period_s.max(1e-5) + 0.25).floor().max(1.0);
        if f64::from(self.count) < wanted {
            return Taken::Nothing;
        }
        let count = f64::from(self.count);
        let strain_2 = (self.count_2 == self.count).then(|| self.sum_2 / count);
        self.count = 0;
        Taken::Bin(Bin { t_s: self.sum.t_s / count, strain: self.sum.strain / count, strain_2, ..self.sum })
    }
}

fn median(a: f64, b: f64, c: f64) -> f64 {
    a.min(b).max(a.max(b).min(c))
}
