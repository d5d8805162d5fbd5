//! Steps of air: the reference follows the unknown part of their shift, and the shift is learned.

use super::{Segmenter, State, Step};
use crate::air::Phase;
use crate::intake::Bin;

/// A touch whose deflection changes by less is held: what changes then with the air is the baseline. mm.
const HELD_MM: f64 = 0.15;
/// Longest time after a step in which its shift is learned, before the baseline drifts. s.
const LEARN_S: f64 = 10.0;

/// Part of half a step by which its shift may differ from that of the other half.
const EARLY: f64 = 0.2;

impl Segmenter {
    /// Whether air moves the baseline by an unknown shift now. At rest the reference follows; in a touch it is in doubt
    /// afterwards, unless the deflection shows that the touch is held.
    pub(super) fn moved_by_air(&mut self, bin: &Bin) -> bool {
        let phase = self.air.phase();
        if phase == Phase::Moves && self.step.is_none_or(|step| step.phase != Phase::Moves) {
            self.begin_step(bin);
        }
        let Some(mut step) = self.step else { return false };
        if phase == Phase::Moves {
            // While the base moves, the strain may be a touch's.
            step.still &= step.mm.zip(bin.deflection_mm).is_none_or(|(mm, now)| (now - mm).abs() < HELD_MM);
            step.known &= self.is_shift_known();
        }
        let ends = step.phase == Phase::Moves && phase != Phase::Moves;
        step.phase = phase;
        if phase != Phase::Over {
            step.until_s = bin.t_s + LEARN_S;
        }
        self.step = Some(step);
        if self.is_in_step() {
            self.rest.pause();
            if step.known {
                return false;
            }
            if !self.learn_early(bin, step) {
                self.follow_unknown(bin, step.still);
            }
            return true;
        }
        if ends && !step.known && !step.still {
            self.rest.shake();
        }
        self.learn_step(bin, step);
        false
    }

    /// Whether a step moves the strain, and its levels are no evidence.
    pub(super) fn is_in_step(&self) -> bool {
        self.step.is_some_and(|step| step.phase == Phase::Moves || (step.phase == Phase::Settles && step.known))
    }

    /// Whether earlier steps tell the shift well enough: as well as two visits to one level agree.
    fn is_shift_known(&self) -> bool {
        self.air.is_known(self.rest.tolerance(self.baseline.sd(self.intake.grain)))
    }

    fn begin_step(&mut self, bin: &Bin) {
        let held = matches!(&self.state, State::Touch(touch) if touch.is_held() && bin.deflection_mm.is_some());
        let known = self.is_shift_known();
        self.step = Some(Step {
            phase: Phase::Moves,
            known,
            still: true,
            mm: bin.deflection_mm,
            levels: [self.baseline.strain, self.baseline.strain_2],
            sure: self.rest.is_sure() && !self.provisional,
            held,
            until_s: bin.t_s,
        });
        if !known && bin.deflection_mm.is_none() {
            self.rest.shake();
        }
    }

    fn follow_unknown(&mut self, bin: &Bin, still: bool) {
        match &mut self.state {
            State::Quiet { .. } | State::Settling(_) if still => {
                self.follow_air(bin);
                self.state = State::Quiet { above: 0, sign: 1.0 };
            }
            State::Quiet { .. } | State::Settling(_) => self.state = State::Away,
            State::Touch(_) => {
                if !self.held_in_air(bin) {
                    let State::Touch(touch) = &mut self.state else { return };
                    touch.push(bin);
                }
                self.low_since_s = bin.t_s;
            }
            State::Learning | State::Away => {}
        }
    }

    /// The air moves the reference.
    fn follow_air(&mut self, bin: &Bin) {
        self.baseline.follow_air(bin);
        if !self.provisional {
            self.rest.moved(self.baseline.strain, self.baseline.strain_2);
        }
    }

    /// At rest the reference follows the rest of a step, once the pressure is known. Returns whether a step goes on.
    pub(super) fn follow_step(&mut self, bin: &Bin) -> bool {
        let is_in_step = self.is_in_step();
        if is_in_step && self.air.phase() == Phase::Settles {
            self.follow_air(bin);
        }
        is_in_step
    }

    /// In a hold all that changes while the air moves the baseline is the air's. Returns whether it is one.
    pub(super) fn held_in_air(&mut self, bin: &Bin) -> bool {
        let held = self.step.is_some_and(|step| step.phase == Phase::Moves && step.held && step.still);
        let State::Touch(touch) = &mut self.state else { return false };
        if !held {
            return false;
        }
        touch.push_air(bin);
        if !self.provisional {
            (self.baseline.strain, self.baseline.strain_2) = touch.baseline();
            self.rest.moved(self.baseline.strain, self.baseline.strain_2);
        }
        true
    }

    /// While the base stands and nothing touches, half of a step tells what the other half does. Returns whether it did.
    fn learn_early(&mut self, bin: &Bin, step: Step) -> bool {
        let stands =
            step.sure && step.still && bin.deflection_mm.is_some() && matches!(self.state, State::Quiet { .. });
        if !stands || !self.air.has_read_half() {
            return false;
        }
        let off = [bin.strain - step.levels[0], bin.strain_2.map_or(0.0, |strain_2| strain_2 - step.levels[1])];
        self.air.learn(off, self.threshold(bin.t_s).hypot(EARLY * off[0]));
        self.air.begin();
        self.baseline.begin(bin.t_s, bin.strain, bin.strain_2.unwrap_or(0.0));
        self.rest.moved(self.baseline.strain, self.baseline.strain_2);
        self.begin_step(bin);
        true
    }

    /// After a step: learns the shift, once the strain is surely at rest, or if it was held.
    fn learn_step(&mut self, bin: &Bin, step: Step) {
        if step.phase != Phase::Over {
            return;
        }
        let here = match &self.state {
            State::Quiet { .. } => true,
            State::Touch(_) => step.held && step.still,
            State::Learning | State::Away | State::Settling(_) => false,
        };
        if !step.sure || bin.t_s > step.until_s {
            self.step = None;
        } else if here && self.rest.is_sure() && !self.provisional {
            self.step = None;
            let off = [self.baseline.strain - step.levels[0], self.baseline.strain_2 - step.levels[1]];
            self.air.learn(off, self.threshold(bin.t_s));
        }
    }
}
