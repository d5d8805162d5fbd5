//! One whisker: the reference level, the contact in progress, and what may be told.
//!
//! All is relative to a reference level. While it is not certain that it is rest ([`Rest`]), contacts are held back;
//! they are told once it is, and forgotten if another level is rest.

use std::collections::VecDeque;

use crate::air::Air;
use crate::baseline::Baseline;
use crate::condition::{Condition, Missing, Watch};
use crate::intake::{Bin, Intake};
use crate::rest::Rest;
use crate::settling::{Settled, Settling};
use crate::touch::{Ring, Touch};
use crate::{Contact, Counts, Event, Params, Sample};

/// Bins above the threshold that make an onset.
const ABOVE: usize = 2;
/// A rest of the last contact, in the other direction right after it, is no contact: part of its strain, and the
/// longest times since its end and of the rest. s.
const REMAINS: (f64, f64, f64) = (0.2, 0.6, 1.0);
/// Right after a contact the rubber creeps: part of its strain that is added to the threshold, and for how long. s.
const AFTER: (f64, f64) = (0.02, 3.0);
/// A contact has ended if its strain stays below this part of the largest for this long. s.
const LOW: (f64, f64) = (0.3, 0.4);
/// A contact is told so long after its onset, when it is certain that it was no shaking. s.
const CERTAIN_S: f64 = 0.18;
/// Part of the samples that are glitches from which on several in a row are likely, and the shortest contact then, in s
/// and samples.
const GLITCHES: (f64, f64, f64) = (0.005, 0.06, 6.0);
/// A touch whose deflection changes by less is held: what changes then with the air is the baseline. mm.
const HELD_MM: f64 = 0.15;
/// Contacts that are held back at most.
const HELD: usize = 32;

#[derive(Clone, Debug)]
enum State {
    /// The noise is not known.
    Learning,
    /// At another level than the reference: in a touch whose begin was not seen, or not known where.
    Away,
    /// At the reference; so many bins in a row exceed the threshold, in this direction.
    Quiet { above: usize, sign: f64 },
    /// Something touches.
    Touch(Box<Touch>),
    /// The contact has ended, and the whisker swings.
    Settling(Settling),
}

#[derive(Clone, Copy, Debug)]
struct Young {
    contact: Contact,
    certain_s: f64,
    /// Rest was sure at its begin.
    sure: bool,
}

/// Finds the contacts of one whisker.
#[derive(Clone, Debug)]
pub struct Segmenter {
    params: Params,
    intake: Intake,
    baseline: Baseline,
    rest: Rest,
    air: Air,
    ring: Ring,
    state: State,
    /// The reference was chosen as there was no other: it need not be rest.
    provisional: bool,
    /// Elections of rest when the reference was chosen.
    elections: u32,
    /// Rest was sure when the contact in progress began.
    sure: bool,
    /// A contact that may yet prove to be shaking.
    young: Option<Young>,
    held: VecDeque<Contact>,
    out: VecDeque<Event>,
    watch: Watch,
    last_peak: f64,
    last_sign: f64,
    last_end_s: f64,
    low_since_s: f64,
    in_air: bool,
    /// Deflection when the air began to move the baseline.
    air_mm: Option<f64>,
    before_gap_s: f64,
}

impl Segmenter {
    /// A segmenter that knows nothing yet.
    #[must_use]
    pub fn new(params: Params) -> Segmenter {
        Segmenter {
            params,
            intake: Intake::default(),
            baseline: Baseline::default(),
            rest: Rest::default(),
            air: Air::default(),
            ring: Ring::new(),
            state: State::Learning,
            provisional: true,
            elections: 0,
            sure: false,
            young: None,
            held: VecDeque::new(),
            out: VecDeque::new(),
            watch: Watch::default(),
            last_peak: 0.0,
            last_sign: 0.0,
            low_since_s: 0.0,
            last_end_s: f64::NEG_INFINITY,
            in_air: false,
            air_mm: None,
            before_gap_s: 0.0,
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

    /// Reference level, and the standard deviation of the noise after averaging to 250 values a second.
    #[must_use]
    pub fn baseline(&self) -> (f64, f64) {
        (self.baseline.strain, self.baseline.sd(self.intake.grain))
    }

    /// How far its findings can be relied on.
    #[must_use]
    pub fn condition(&self) -> Condition {
        let rate_hz = self.rate_hz();
        if rate_hz > 0.0 && rate_hz < self.params.least_rate_hz {
            return Condition::Learning(Missing::Rate);
        }
        if !self.baseline.ready() {
            return Condition::Learning(Missing::Stillness);
        }
        if self.rest.level().is_none() {
            return Condition::Learning(Missing::Rest);
        }
        let unexplained = match &self.state {
            State::Touch(touch) => touch.age_s() > self.params.longest_s && !touch.is_pressed(),
            State::Learning | State::Away | State::Quiet { .. } | State::Settling(_) => false,
        };
        if unexplained || !self.rest.is_sure() {
            return Condition::Lost;
        }
        self.watch.condition(&self.params, self.intake.shake.is_shaking(), self.intake.glitches.part)
    }

    /// Takes the next sample.
    pub fn push(&mut self, sample: Sample) -> Option<Event> {
        if self.intake.push(&self.params, sample) {
            self.gap(&sample);
        }
        while let Some(bin) = self.intake.next(&self.params) {
            self.bin(&bin);
            self.before_gap_s = bin.t_s;
        }
        self.out.pop_front()
    }

    fn gap(&mut self, sample: &Sample) {
        if let State::Touch(_) = self.state {
            self.intake.counts.interrupted += 1;
        }
        self.ring.clear();
        self.young = None;
        if self.baseline.ready() {
            self.state = State::Away;
            self.provisional = true;
            self.rest.shake();
            let gap_s = self.intake.seconds(sample.t_us) - self.before_gap_s;
            if gap_s > self.params.forget_s {
                self.rest.forget();
            }
        } else {
            self.baseline = Baseline::default();
        }
    }

    fn bin(&mut self, bin: &Bin) {
        self.ring.push(*bin);
        let grain = self.intake.grain;
        self.baseline.shake(bin.shaking, self.intake.shake.range, grain);
        self.baseline.limit_noise(self.intake.glitches.roughness(), grain);
        self.intake.shake.calm_sd = if self.baseline.ready() { self.baseline.calm_sd(grain) } else { 0.0 };
        if !self.baseline.ready() {
            self.baseline.learn(bin, grain, self.intake.glitches.roughness());
            if self.baseline.ready() {
                self.state = State::Quiet { above: 0, sign: 1.0 };
            }
            return;
        }
        if self.moved_by_air(bin) {
            return;
        }
        self.find_rest(bin);
        self.forget_shaking(bin);
        match &mut self.state {
            State::Learning | State::Away => {}
            State::Quiet { .. } => self.quiet(bin),
            State::Touch(_) => self.touch(bin),
            State::Settling(_) => self.settling(bin),
        }
        self.tell(bin);
    }

    /// Whether air moves the baseline now. At rest the reference follows; in a touch it is in doubt afterwards.
    fn moved_by_air(&mut self, bin: &Bin) -> bool {
        let moves = self.air.push(bin);
        if moves && !self.in_air {
            self.rest.shake();
            self.air_mm = bin.deflection_mm;
        }
        self.in_air = moves;
        if !moves {
            return false;
        }
        self.rest.pause();
        // While the base moves, the strain may be a touch's.
        let still = self.air_mm.zip(bin.deflection_mm).is_none_or(|(mm, now)| (now - mm).abs() < HELD_MM);
        match &mut self.state {
            State::Quiet { .. } | State::Settling(_) if still => {
                self.baseline.follow_air(bin);
                if !self.provisional {
                    self.rest.moved(self.baseline.strain, self.baseline.strain_2);
                }
                self.state = State::Quiet { above: 0, sign: 1.0 };
            }
            State::Quiet { .. } | State::Settling(_) => self.state = State::Away,
            State::Touch(touch) => {
                let held = still && bin.deflection_mm.is_some();
                touch.push_air(bin, held);
                self.low_since_s = bin.t_s;
                if held && !self.provisional {
                    (self.baseline.strain, self.baseline.strain_2) = touch.baseline();
                    self.rest.moved(self.baseline.strain, self.baseline.strain_2);
                }
            }
            State::Learning | State::Away => {}
        }
        true
    }

    /// Learns which level is rest, and makes it the reference.
    fn find_rest(&mut self, bin: &Bin) {
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
                self.held.clear();
                self.refer_to(bin, rest.strain, rest.strain_2, true);
            }
            self.provisional = false;
            self.elections = self.rest.elections;
        } else if !off {
            self.provisional = false;
            self.elections = self.rest.elections;
        } else if !self.provisional && self.elections != self.rest.elections {
            self.held.clear();
            self.refer_to(bin, rest.strain, rest.strain_2, false);
        } else if let (State::Away, Some(here)) = (&self.state, self.rest.here()) {
            self.refer_to(bin, here.strain, here.strain_2, true);
        }
    }

    fn refer_to(&mut self, bin: &Bin, strain: f64, strain_2: f64, is_here: bool) {
        self.young = self.young.filter(|young| young.sure);
        self.baseline.begin(bin.t_s, strain, strain_2);
        self.elections = self.rest.elections;
        self.state = if is_here { State::Quiet { above: 0, sign: 1.0 } } else { State::Away };
    }

    /// Shaking that begins looks like an onset.
    fn forget_shaking(&mut self, bin: &Bin) {
        if !bin.shaking {
            return;
        }
        self.young = None;
        if let State::Touch(touch) = &self.state
            && touch.age_s() < CERTAIN_S
            && touch.began_calm()
        {
            self.state = State::Quiet { above: 0, sign: 1.0 };
        }
    }

    /// Tells contacts that are certain.
    fn tell(&mut self, bin: &Bin) {
        if let Some(young) = self.young
            && bin.t_s >= young.certain_s
        {
            self.young = None;
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
        self.watch.contact(&self.params, &contact);
        self.out.push_back(Event::Contact(contact));
    }

    fn threshold(&self, t_s: f64) -> f64 {
        let grain = self.intake.grain;
        let (part, time_s) = AFTER;
        let after = part * self.last_peak * (1.0 - (t_s - self.last_end_s) / time_s).max(0.0);
        (self.params.onset_sds * self.baseline.sd(grain) + after).max(self.params.least_strain).max(2.5 * grain)
    }

    fn quiet(&mut self, bin: &Bin) {
        let grain = self.intake.grain;
        let threshold = self.threshold(bin.t_s);
        let residual = bin.strain - self.baseline.strain;
        let State::Quiet { above, sign } = &mut self.state else { return };
        if residual.abs() <= threshold {
            *above = 0;
            self.baseline.follow(&self.params, bin, grain);
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

    fn touch(&mut self, bin: &Bin) {
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

    fn end_touch(&mut self, bin: &Bin) {
        let State::Touch(touch) = &self.state else { return };
        let intake = &self.intake;
        let contact = touch.end(&self.params, &self.ring, intake.period_s, |t_s| intake.time_us(t_s));
        let shortest_s = GLITCHES.1.max(GLITCHES.2 * intake.period_s);
        if intake.glitches.part > GLITCHES.0 && touch.age_s() < shortest_s {
            self.settle(bin);
            return;
        }
        self.young = Some(Young { contact, certain_s: touch.onset_s + CERTAIN_S, sure: self.sure });
        self.last_peak = touch.peak_strain();
        self.last_sign = touch.sign();
        self.settle(bin);
    }

    fn settle(&mut self, bin: &Bin) {
        self.state = State::Settling(Settling::new(bin));
    }

    fn settling(&mut self, bin: &Bin) {
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
