//! One whisker: the reference level, the contact in progress, and what may be told.
//!
//! All is relative to a reference level. While it is not certain that it is rest ([`Rest`]), contacts are held back;
//! they are told once it is, and forgotten if another level is rest.

mod contact;
mod reference;
mod step;

use std::collections::VecDeque;

use crate::air::{Air, Phase};
use crate::baseline::Baseline;
use crate::condition::{Condition, Missing, Watch};
use crate::intake::{Bin, Intake};
use crate::rest::Rest;
use crate::settling::Settling;
use crate::touch::{Ring, Touch};
use crate::{Contact, Counts, Event, Params, Sample};

/// A contact has ended if its strain stays below this part of the largest for this long. s.
const LOW: (f64, f64) = (0.3, 0.4);
/// A contact is reported so long after its onset, when it is certain that it was no shaking. s.
const CERTAIN_S: f64 = 0.18;
/// The same for a whisker that has shaken in the last minute: shaking that begins weakly is recognised later.
const CERTAIN_SHAKEN_S: f64 = 0.5;

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

/// A step of air.
#[derive(Clone, Copy, Debug)]
struct Step {
    phase: Phase,
    /// The shift was known before it.
    known: bool,
    /// The base has not moved since its begin, as far as is known.
    still: bool,
    mm: Option<f64>,
    /// Reference of both gauges at its begin, and whether it was surely rest.
    levels: [f64; 2],
    sure: bool,
    /// It began in a hold.
    held: bool,
    until_s: f64,
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
    /// Contacts that may yet prove to be shaking, the oldest first.
    young: VecDeque<Young>,
    held: VecDeque<Contact>,
    out: VecDeque<Event>,
    watch: Watch,
    last_peak: f64,
    last_sign: f64,
    last_end_s: f64,
    low_since_s: f64,
    /// The step of air that moves the baseline, or has, and is not learned.
    step: Option<Step>,
    before_gap_s: f64,
    /// The last bin shook.
    shook: bool,
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
            young: VecDeque::new(),
            held: VecDeque::new(),
            out: VecDeque::new(),
            watch: Watch::default(),
            last_peak: 0.0,
            last_sign: 0.0,
            low_since_s: 0.0,
            last_end_s: f64::NEG_INFINITY,
            step: None,
            before_gap_s: 0.0,
            shook: false,
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
        (self.baseline.strain + self.air.shift()[0], self.baseline.sd(self.intake.grain))
    }

    /// Strain to which contacts are relative, once the noise is known. It need not be rest while that is not sure.
    #[must_use]
    pub fn reference(&self) -> Option<f64> {
        self.baseline.ready().then_some(self.baseline().0)
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
        self.watch.condition(self.intake.shake.is_shaking(), self.intake.glitches.part)
    }

    /// Takes the next sample.
    pub fn push(&mut self, sample: Sample) -> Option<Event> {
        if self.intake.push(&self.params, sample) {
            self.gap(&sample);
        }
        while let Some(bin) = self.intake.next(&self.params) {
            self.before_gap_s = bin.t_s;
            self.bin(bin);
        }
        self.out.pop_front()
    }

    fn gap(&mut self, sample: &Sample) {
        if let State::Touch(_) = self.state {
            self.intake.counts.interrupted += 1;
        }
        self.ring.clear();
        self.intake.counts.interrupted += self.young.len() as u64;
        self.young.clear();
        self.step = None;
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

    fn bin(&mut self, mut bin: Bin) {
        self.air.compensate(&mut bin);
        let bin = &bin;
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
        if !self.is_in_step() {
            self.find_rest(bin);
        }
        self.calm_down(bin);
        self.forget_shaking(bin);
        match &mut self.state {
            State::Learning | State::Away => {}
            State::Quiet { .. } => self.quiet(bin),
            State::Touch(_) => self.touch(bin),
            State::Settling(_) => self.settling(bin),
        }
        self.tell(bin);
    }
}
