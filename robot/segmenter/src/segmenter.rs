//! The states: learning, quiet, contact, settling.

use crate::baseline::Baseline;
use crate::intake::{Bin, Intake, Taken};
use crate::touch::{Ring, Touch};
use crate::{Counts, Event, Params, Sample};

/// Bins above the threshold that make an onset.
const ABOVE: usize = 2;
/// Time without change after a contact, until the next can begin. s.
const STILL_S: f64 = 0.04;
/// Longest wait for it. s.
const SETTLE_S: f64 = 0.5;
/// Part of the last contact's strain that counts as no change, between two filters of 15 and 80 ms.
const STILL: f64 = 0.01;
const STILL_FILTERS_S: (f64, f64) = (0.015, 0.08);
/// A rest of the last contact, in the other direction right after it, is no contact: part of its strain, and the
/// longest times since its end and of the rest. s.
const REST: (f64, f64, f64) = (0.2, 0.6, 1.0);
/// Right after a contact the rubber creeps: part of its strain that is added to the threshold, and for how long. s.
const AFTER: (f64, f64) = (0.02, 3.0);

/// A contact has ended if its strain stays below this part of the largest for this long. s.
const LOW: (f64, f64) = (0.3, 0.4);

#[derive(Clone, Debug)]
enum State {
    /// Learns baseline and noise.
    Learning,
    /// Nothing touches; so many bins in a row exceed the threshold, in this direction.
    Quiet { above: usize, sign: f64 },
    /// Something touches.
    Contact(Box<Touch>),
    /// The contact has ended, and the whisker swings.
    Settling { since_s: f64, still_s: f64, last_s: f64, level: f64, level_2: f64, slow: f64 },
}

/// Finds the contacts of one whisker.
#[derive(Clone, Debug)]
pub struct Segmenter {
    params: Params,
    intake: Intake,
    baseline: Baseline,
    ring: Ring,
    state: State,
    last_peak: f64,
    last_sign: f64,
    last_end_s: f64,
    low_since_s: f64,
}

impl Segmenter {
    /// A segmenter that first learns the baseline, for 0.4 s.
    #[must_use]
    pub fn new(params: Params) -> Segmenter {
        Segmenter {
            params,
            intake: Intake::default(),
            baseline: Baseline::default(),
            ring: Ring::new(),
            state: State::Learning,
            last_peak: 0.0,
            last_sign: 0.0,
            low_since_s: 0.0,
            last_end_s: f64::NEG_INFINITY,
        }
    }

    /// Numbers of samples and contacts that were left out.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.intake.counts
    }

    /// Samples per second; 0 before the third sample.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        if self.intake.period_s > 0.0 { 1.0 / self.intake.period_s } else { 0.0 }
    }

    /// Strain without a touch, and the standard deviation of its noise after averaging to 250 values a second.
    #[must_use]
    pub fn baseline(&self) -> (f64, f64) {
        (self.baseline.strain, self.baseline.sd(self.intake.grain))
    }

    /// Takes the next sample.
    pub fn push(&mut self, sample: Sample) -> Option<Event> {
        match self.intake.push(&self.params, sample) {
            Taken::Nothing => None,
            Taken::Gap => {
                self.gap();
                None
            }
            Taken::Bin(bin) => self.bin(bin),
        }
    }

    fn gap(&mut self) {
        if let State::Contact(_) = self.state {
            self.intake.counts.interrupted += 1;
        }
        self.ring.clear();
        self.state = State::Learning;
        self.baseline = Baseline::default();
    }

    fn bin(&mut self, bin: Bin) -> Option<Event> {
        self.ring.push(bin);
        let grain = self.intake.grain;
        match &mut self.state {
            State::Learning => {
                if !self.baseline.begun() {
                    self.baseline.begin(&bin, bin.strain, bin.strain_2.unwrap_or(0.0));
                }
                self.baseline.learn(&bin);
                if self.baseline.ready() {
                    self.state = State::Quiet { above: 0, sign: 1.0 };
                }
                None
            }
            State::Quiet { .. } => self.quiet(&bin),
            State::Contact(touch) => {
                let strain = touch.push(&bin);
                if !touch.rise_done() || touch.age_s() < 0.1 {
                    touch.find_onset(&self.ring);
                }
                let rest = touch.sign() != self.last_sign
                    && touch.peak_strain() < REST.0 * self.last_peak
                    && touch.began_s() - self.last_end_s < REST.1;
                if rest && touch.age_s() > REST.2 {
                    self.settle(&bin);
                    return None;
                }
                let released = strain < (self.params.release * touch.peak_strain()).max(2.0 * self.baseline.sd(grain));
                // What creep of earlier contacts leaves may exceed the threshold: a rest that does not fall is an end,
                // too.
                if strain > LOW.0 * touch.peak_strain() {
                    self.low_since_s = bin.t_s;
                }
                let released = released || bin.t_s - self.low_since_s > LOW.1;
                if !released && touch.age_s() < self.params.longest_s {
                    return None;
                }
                let intake = &self.intake;
                let contact = touch.end(&self.params, &self.ring, intake.period_s, |t_s| intake.time_us(t_s));
                self.last_peak = touch.peak_strain();
                self.last_sign = touch.sign();
                self.settle(&bin);
                Some(Event::Contact(contact))
            }
            State::Settling { since_s, still_s, last_s, level, level_2, slow } => {
                let dt_s = bin.t_s - *last_s;
                *last_s = bin.t_s;
                let weight = dt_s / (STILL_FILTERS_S.0 + dt_s);
                *level += weight * (bin.strain - *level);
                *level_2 += weight * (bin.strain_2.unwrap_or(0.0) - *level_2);
                *slow += dt_s / (STILL_FILTERS_S.1 + dt_s) * (bin.strain - *slow);
                let most = (STILL * self.last_peak).max(2.0 * self.baseline.sd(grain));
                // A swing is faster than both filters.
                let swings = (bin.strain - *level).abs() > 2.0 * most;
                if swings || (*slow - *level).abs() > most {
                    *still_s = bin.t_s;
                }
                let still = bin.t_s - *still_s > STILL_S.max(2.5 * self.intake.period_s);
                if still || bin.t_s - *since_s > SETTLE_S {
                    self.baseline.begin(&bin, *level, *level_2);
                    self.last_end_s = bin.t_s;
                    self.state = State::Quiet { above: 0, sign: 1.0 };
                }
                None
            }
        }
    }

    fn settle(&mut self, bin: &Bin) {
        self.state = State::Settling {
            since_s: bin.t_s,
            still_s: bin.t_s,
            last_s: bin.t_s,
            level: bin.strain,
            level_2: bin.strain_2.unwrap_or(0.0),
            slow: bin.strain,
        };
    }

    fn threshold(&self, t_s: f64) -> f64 {
        let grain = self.intake.grain;
        let (part, time_s) = AFTER;
        let after = part * self.last_peak * (1.0 - (t_s - self.last_end_s) / time_s).max(0.0);
        (self.params.onset_sds * self.baseline.sd(grain) + after).max(self.params.least_strain).max(2.5 * grain)
    }

    fn quiet(&mut self, bin: &Bin) -> Option<Event> {
        let grain = self.intake.grain;
        let threshold = self.threshold(bin.t_s);
        let residual = bin.strain - self.baseline.strain;
        let State::Quiet { above, sign } = &mut self.state else {
            return None;
        };
        if residual.abs() <= threshold {
            *above = 0;
            self.baseline.follow(&self.params, bin, grain);
            return None;
        }
        if *above > 0 && residual.signum() != *sign {
            *above = 0;
        }
        *sign = residual.signum();
        *above += 1;
        if *above < ABOVE {
            return None;
        }
        let levels = (self.baseline.strain, self.baseline.strain_2);
        let touch = Touch::begin(&self.ring, levels, *sign, self.baseline.sd(grain), *above);
        self.low_since_s = bin.t_s;
        let t_us = self.intake.time_us(touch.onset_s);
        self.state = State::Contact(Box::new(touch));
        Some(Event::Onset { t_us, found_us: self.intake.time_us(bin.t_s) })
    }
}
