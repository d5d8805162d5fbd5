//! A contact from its onset until the whisker has come to rest.

use super::{CERTAIN_S, CERTAIN_SHAKEN_S, LOW, Segmenter, State, Young};
use crate::Event;
use crate::intake::Bin;
use crate::settling::{Settled, Settling};
use crate::touch::Touch;

/// Bins above the threshold that make an onset.
const ABOVE: usize = 2;
/// A rest of the last contact, in the other direction right after it, is no contact: part of its strain, and the
/// longest times since its end and of the rest. s.
const REMAINS: (f64, f64, f64) = (0.2, 0.6, 1.0);
/// Right after a contact the rubber creeps: part of its strain that is added to the threshold, and for how long. s.
const AFTER: (f64, f64) = (0.02, 3.0);
/// Part of the samples that are glitches from which on several in a row are likely, and the shortest contact then, in s
/// and samples.
const GLITCHES: (f64, f64, f64) = (0.005, 0.06, 6.0);
/// The shortest contact beyond the gauge's limit is longer by this factor.
const AT_LIMIT: f64 = 3.0;

impl Segmenter {
    pub(super) fn threshold(&self, t_s: f64) -> f64 {
        let grain = self.intake.grain;
        let (part, time_s) = AFTER;
        let after = part * self.last_peak * (1.0 - (t_s - self.last_end_s) / time_s).max(0.0);
        (self.params.onset_sds * self.baseline.sd(grain) + after + self.air.doubt())
            .max(self.params.least_strain)
            .max(2.5 * grain)
    }

    pub(super) fn quiet(&mut self, bin: &Bin) {
        let grain = self.intake.grain;
        let threshold = self.threshold(bin.t_s);
        let residual = bin.strain - self.baseline.strain;
        let State::Quiet { above, sign } = &mut self.state else { return };
        if residual.abs() <= threshold {
            *above = 0;
            if !self.follow_step(bin) {
                self.baseline.follow(&self.params, bin, grain);
            }
            return;
        }
        if *above > 0 && residual.signum() != *sign {
            *above = 0;
        }
        *sign = residual.signum();
        *above += 1;
        if *above < ABOVE {
            return;
        }
        let levels = (self.baseline.strain, self.baseline.strain_2);
        let touch = Touch::begin(&self.ring, levels, *sign, self.baseline.sd(grain), *above);
        self.low_since_s = bin.t_s;
        let t_us = self.intake.time_us(touch.onset_s);
        self.state = State::Touch(Box::new(touch));
        self.sure = self.rest.is_sure() && !self.provisional;
        if self.sure {
            self.out.push_back(Event::Onset { t_us, found_us: self.intake.time_us(bin.t_s) });
        }
    }

    pub(super) fn touch(&mut self, bin: &Bin) {
        if self.held_in_air(bin) {
            self.low_since_s = bin.t_s;
            return;
        }
        let State::Touch(touch) = &mut self.state else { return };
        let strain = touch.push(bin);
        (self.baseline.strain, self.baseline.strain_2) = touch.baseline();
        if !touch.rise_done() || touch.age_s() < 0.1 {
            touch.find_onset(&self.ring);
        }
        let remains = touch.sign() != self.last_sign
            && touch.peak_strain() < REMAINS.0 * self.last_peak
            && touch.began_s() - self.last_end_s < REMAINS.1;
        if remains && touch.age_s() > REMAINS.2 {
            self.settle(bin);
            return;
        }
        let level = touch.level();
        let sd = self.baseline.sd(self.intake.grain);
        // What creep of earlier contacts leaves may exceed the threshold: a rest that does not fall is an end, too.
        if strain > LOW.0 * level {
            self.low_since_s = bin.t_s;
        }
        if strain < (self.params.release * level).max(2.0 * sd) || bin.t_s - self.low_since_s > LOW.1 {
            self.end_touch(bin);
        }
    }

    pub(super) fn end_touch(&mut self, bin: &Bin) {
        let State::Touch(touch) = &self.state else { return };
        let intake = &self.intake;
        let mut contact = touch.end(&self.params, &self.ring, intake.period_s, |t_s| intake.time_us(t_s));
        contact.baseline += self.air.shift()[0];
        // Full-scale glitches may follow each other. A converter that ends below the gauge's limit has a short touch there, too.
        let is_beyond = touch.peak_strain().abs() >= self.params.strain_limit;
        let runs = if is_beyond { AT_LIMIT } else { 1.0 };
        let shortest_s = runs * GLITCHES.1.max(GLITCHES.2 * intake.period_s);
        if intake.glitches.part > GLITCHES.0 && touch.age_s() < shortest_s {
            self.settle(bin);
            return;
        }
        let certain_s = if self.intake.shake.has_shaken() { CERTAIN_SHAKEN_S } else { CERTAIN_S };
        self.young.push_back(Young { contact, certain_s: touch.onset_s + certain_s, sure: self.sure });
        self.last_peak = touch.peak_strain();
        self.last_sign = touch.sign();
        self.settle(bin);
    }

    fn settle(&mut self, bin: &Bin) {
        self.state = State::Settling(Settling::new(bin));
    }

    pub(super) fn settling(&mut self, bin: &Bin) {
        let State::Settling(settling) = &mut self.state else { return };
        let sd = self.baseline.sd(self.intake.grain);
        let reference = self.baseline.strain;
        let settled = settling.push(bin, reference, self.last_peak, sd, self.intake.period_s);
        let Settled::At(level, level_2) = settled else { return };
        if (level - reference).abs() > (LOW.0 * self.last_peak).max(6.0 * sd) && !self.provisional {
            // It fell, and is away again.
            self.state = State::Away;
            return;
        }
        self.baseline.begin(bin.t_s, level, level_2);
        self.last_end_s = bin.t_s;
        self.state = State::Quiet { above: 0, sign: 1.0 };
        if !self.provisional {
            self.rest.moved(level, level_2);
        }
    }
}
