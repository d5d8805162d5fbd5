//! After a contact: until the whisker has come to rest.

use crate::intake::Bin;

/// Time without change until the next contact can begin. s.
const STILL_S: f64 = 0.04;
/// Longest wait for it. s.
const SETTLE_S: f64 = 0.5;
/// Part of the last contact's strain that counts as no change, between two filters of 15 and 80 ms.
const STILL: f64 = 0.01;
const STILL_FILTERS_S: (f64, f64) = (0.015, 0.08);
/// The strain is back if it is so near the reference, and changes by no more than that, as parts of the last contact's
/// strain, for so long and so many bins. s.
const BACK: (f64, f64, f64, u32) = (0.05, 0.008, 0.02, 3);

pub(crate) enum Settled {
    NotYet,
    /// At these strains of both gauges.
    At(f64, f64),
}

#[derive(Clone, Debug)]
pub(crate) struct Settling {
    since_s: f64,
    still_s: f64,
    last_s: f64,
    level: f64,
    level_2: f64,
    slow: f64,
    back_s: f64,
    back: u32,
    first: f64,
    sum: f64,
    sum_2: f64,
}

impl Settling {
    pub(crate) fn new(bin: &Bin) -> Settling {
        Settling {
            since_s: bin.t_s,
            still_s: bin.t_s,
            last_s: bin.t_s,
            level: bin.strain,
            level_2: bin.strain_2.unwrap_or(0.0),
            slow: bin.strain,
            back_s: bin.t_s,
            back: 0,
            first: bin.strain,
            sum: 0.0,
            sum_2: 0.0,
        }
    }

    /// Takes a bin after a contact of this strain from this reference.
    pub(crate) fn push(&mut self, bin: &Bin, reference: f64, peak: f64, sd: f64, period_s: f64) -> Settled {
        let dt_s = bin.t_s - self.last_s;
        self.last_s = bin.t_s;
        let weight = dt_s / (STILL_FILTERS_S.0 + dt_s);
        let strain_2 = bin.strain_2.unwrap_or(0.0);
        self.level += weight * (bin.strain - self.level);
        self.level_2 += weight * (strain_2 - self.level_2);
        self.slow += dt_s / (STILL_FILTERS_S.1 + dt_s) * (bin.strain - self.slow);
        let near = (bin.strain - reference).abs() < (BACK.0 * peak).max(3.0 * sd);
        if near && self.back > 0 && (bin.strain - self.first).abs() > (BACK.1 * peak).max(4.0 * sd) {
            self.back = 0;
        }
        if !near || self.back == 0 {
            (self.back, self.back_s, self.sum, self.sum_2) = (0, bin.t_s, 0.0, 0.0);
            self.first = bin.strain;
        }
        if near {
            self.back += 1;
            self.sum += bin.strain;
            self.sum_2 += strain_2;
        }
        if self.back >= BACK.3 && bin.t_s - self.back_s > BACK.2 {
            let count = f64::from(self.back);
            return Settled::At(self.sum / count, self.sum_2 / count);
        }
        let most = (STILL * peak).max(2.0 * sd);
        // A swing is faster than both filters.
        let swings = (bin.strain - self.level).abs() > 2.0 * most;
        if swings || (self.slow - self.level).abs() > most {
            self.still_s = bin.t_s;
        }
        let still = bin.t_s - self.still_s > STILL_S.max(2.5 * period_s);
        if still || bin.t_s - self.since_s > SETTLE_S {
            return Settled::At(self.level, self.level_2);
        }
        Settled::NotYet
    }
}
