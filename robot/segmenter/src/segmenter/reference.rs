//! The reference level: finding rest, and holding contacts back until the level is known to be rest.

use super::{CERTAIN_S, LOW, Segmenter, State};
use crate::intake::Bin;
use crate::{Contact, Event};

/// Most contacts that are held back. Beyond that the oldest is given up, and counted as doubtful.
const HELD: usize = 32;

impl Segmenter {
    /// Learns which level is rest, and makes it the reference.
    pub(super) fn find_rest(&mut self, bin: &Bin) {
        let sd = self.baseline.sd(self.intake.grain);
        let same = self.rest.tolerance(sd);
        let same = match &self.state {
            // A weak touch after a strong one is not rest.
            State::Touch(touch) if !self.provisional => same.min((self.params.release * touch.level()).max(6.0 * sd)),
            State::Learning | State::Away | State::Quiet { .. } | State::Touch(_) | State::Settling(_) => same,
        };
        if !self.rest.push(&self.params, bin, sd, self.intake.period_s, same) {
            return;
        }
        let (Some(rest), is_here) = (self.rest.level(), self.rest.is_here()) else {
            if let (State::Away, Some(here)) = (&self.state, self.rest.here()) {
                self.refer_to(bin, here.strain, here.strain_2, true);
            }
            return;
        };
        let off = (self.baseline.strain - rest.strain).abs() > self.rest.tolerance(sd);
        if is_here {
            // A touch after which the strain stands at rest has ended, even if rest has moved meanwhile.
            if let (State::Touch(touch), false) = (&self.state, self.provisional)
                && touch.strain() < LOW.0 * touch.peak_strain()
            {
                self.end_touch(bin);
            }
            if off || matches!(self.state, State::Away) {
                self.forget_held();
                self.refer_to(bin, rest.strain, rest.strain_2, true);
            }
            self.provisional = false;
            self.elections = self.rest.elections;
        } else if !off {
            self.provisional = false;
            self.elections = self.rest.elections;
        } else if !self.provisional && self.elections != self.rest.elections {
            self.forget_held();
            self.refer_to(bin, rest.strain, rest.strain_2, false);
        } else if let (State::Away, Some(here)) = (&self.state, self.rest.here()) {
            self.refer_to(bin, here.strain, here.strain_2, true);
        }
    }

    /// Forgets the contacts that are held back: their reference was no rest.
    fn forget_held(&mut self) {
        self.intake.counts.doubtful += self.held.len() as u64;
        self.held.clear();
    }

    /// Makes a level the reference. `is_here` tells whether the strain is at this level now.
    fn refer_to(&mut self, bin: &Bin, strain: f64, strain_2: f64, is_here: bool) {
        let before = self.young.len();
        self.young.retain(|young| young.sure);
        self.intake.counts.doubtful += (before - self.young.len()) as u64;
        self.baseline.begin(bin.t_s, strain, strain_2);
        self.elections = self.rest.elections;
        self.state = if is_here { State::Quiet { above: 0, sign: 1.0 } } else { State::Away };
    }

    /// Shaking may hide a move of the baseline. When it ends, the strain becomes the baseline if the move was so small
    /// that shaking hid it.
    pub(super) fn calm_down(&mut self, bin: &Bin) {
        let ends = std::mem::replace(&mut self.shook, bin.shaking) && !bin.shaking;
        let hidden = self.params.onset_sds * self.baseline.shaking_sd(self.intake.grain);
        let is_hidden = (bin.strain - self.baseline.strain).abs() < hidden;
        if let (State::Quiet { .. }, true) = (&self.state, ends && is_hidden) {
            self.state = State::Quiet { above: 0, sign: 1.0 };
            self.baseline.begin(bin.t_s, bin.strain, bin.strain_2.unwrap_or(0.0));
            if !self.provisional {
                self.rest.moved(self.baseline.strain, self.baseline.strain_2);
            }
        }
    }

    /// Forgets contacts that began just before shaking, because shaking that begins looks like an onset.
    pub(super) fn forget_shaking(&mut self, bin: &Bin) {
        if !bin.shaking {
            return;
        }
        self.young.clear();
        if let State::Touch(touch) = &self.state
            && touch.age_s() < CERTAIN_S
            && touch.began_calm()
        {
            self.state = State::Quiet { above: 0, sign: 1.0 };
        }
    }

    /// Reports contacts as soon as it is certain that they were no shaking, and that their reference was rest.
    pub(super) fn tell(&mut self, bin: &Bin) {
        while let Some(young) = self.young.pop_front_if(|young| bin.t_s >= young.certain_s) {
            if young.sure {
                self.tell_contact(young.contact);
            } else {
                self.held.push_back(young.contact);
            }
            if self.held.len() > HELD {
                self.held.pop_front();
                self.intake.counts.doubtful += 1;
            }
        }
        if !self.rest.is_sure() || self.provisional {
            return;
        }
        while let Some(contact) = self.held.pop_front() {
            self.tell_contact(contact);
        }
    }

    fn tell_contact(&mut self, contact: Contact) {
        self.rest.contact(contact.strain.signum());
        self.watch.contact(&contact);
        self.out.push_back(Event::Contact(contact));
    }
}
