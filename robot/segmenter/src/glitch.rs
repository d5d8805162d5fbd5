//! Glitches of the converter: runs of one to three samples that jump away from the strain and back.
//!
//! A sample that jumps waits until it is clear whether the strain comes back. A run that is flat and comes back is a
//! glitch; a touch rises and falls. A gauge reaches its limit by rising: a jump to the limit from below half of it is
//! a glitch, unless it lasts.

use std::collections::VecDeque;

use crate::{Params, Sample};

/// Samples of the longest glitch.
const LONGEST: usize = 3;
/// Samples after which a jump is a change of the strain even if it goes to the limit, or if they do not agree.
const LONGEST_WAIT: usize = 8;
/// Samples agree if each differs from the one before by less than this part of the height of the jump.
const SMOOTH: f64 = 0.6;
/// A run whose samples differ by less than this part of its height is flat.
const FLAT: f64 = 0.15;
/// The strain is back if it is away by less than this part of the height of the jump.
const BACK: f64 = 0.25;
/// A step may be larger by this factor than the one before it: a whisker accelerates.
const STEEPER: f64 = 2.5;
/// Weight of a sample in the mean of the differences of neighbours.
const WEIGHT: f64 = 0.03;
/// The same for the first samples, and their number.
const BEGIN_WEIGHT: f64 = 0.3;
const BEGIN: u32 = 20;
/// Time of the shortest touch, and part of glitches from which on a converter has glitches. us.
const SHORTEST_TOUCH_US: u64 = 39_000;
const HAS_GLITCHES: f64 = 0.003;
/// Weight of a sample in the part of glitches.
const PART_WEIGHT: f64 = 0.002;

/// Strains of both gauges.
type Pair = [f64; 2];

#[derive(Clone, Debug, Default)]
pub(crate) struct Glitches {
    /// The newest strains that are no glitch, and their change from the ones before.
    good: Option<Pair>,
    step: Pair,
    /// Mean absolute difference of neighbours, without jumps.
    rough: Pair,
    begun: u32,
    waiting: VecDeque<Sample>,
    /// Part of the newest samples that were glitches.
    pub(crate) part: f64,
}

fn pair(sample: &Sample) -> Pair {
    [sample.strain, sample.strain_2.unwrap_or(0.0)]
}

fn at_limit(params: &Params, strains: Pair) -> bool {
    strains.iter().any(|strain| strain.abs() >= params.strain_limit)
}

impl Glitches {
    /// Mean absolute difference of neighbours at the first gauge.
    pub(crate) fn roughness(&self) -> f64 {
        self.rough[0]
    }

    /// Begins anew after a gap; the roughness stays.
    pub(crate) fn gap(&mut self) {
        self.good = None;
        self.step = Pair::default();
        self.waiting.clear();
    }

    /// Takes a sample; hands out those that are no glitch, and returns how many samples were. While the whisker shakes,
    /// only samples at the limit are glitches.
    pub(crate) fn push(&mut self, params: &Params, sample: Sample, shakes: bool, out: &mut VecDeque<Sample>) -> u64 {
        let strains = pair(&sample);
        if shakes {
            out.extend(self.waiting.drain(..).filter(|sample| !at_limit(params, pair(sample))));
            if at_limit(params, strains) {
                return 1;
            }
            (self.good, self.step) = (Some(strains), Pair::default());
            out.push_back(sample);
            return 0;
        }
        let Some(good) = self.good else {
            return self.begin(params, sample, out);
        };
        let count = self.waiting.len();
        let near = (0..2).all(|gauge| {
            let heights = self.waiting.iter().map(|sample| (pair(sample)[gauge] - good[gauge]).abs());
            let height = heights.fold(f64::INFINITY, f64::min);
            let moved = (STEEPER * self.step[gauge].abs() * (count + 1) as f64).min(BACK * height);
            (strains[gauge] - good[gauge]).abs() <= params.glitch_sds * self.rough[gauge] + moved
        });
        if near {
            let dropped = self.come_back(params, good, sample.t_us, out);
            self.accept(sample, out);
            return dropped;
        }
        self.waiting.push_back(sample);
        let from_below = good.iter().all(|strain| strain.abs() < 0.5 * params.strain_limit);
        let to_limit = from_below && self.waiting.iter().any(|sample| at_limit(params, pair(sample)));
        let count = self.waiting.len();
        if count > LONGEST_WAIT || (count > LONGEST && !to_limit && self.agrees(good)) {
            return self.change(params, good, out);
        }
        0
    }

    /// Whether the newest samples that wait follow from each other.
    fn agrees(&self, good: Pair) -> bool {
        let newest = self.waiting.len() - LONGEST - 1;
        (0..2).all(|gauge| {
            let strains = || self.waiting.iter().skip(newest).map(move |sample| pair(sample)[gauge]);
            let height = strains().map(|strain| (strain - good[gauge]).abs()).fold(0.0, f64::max);
            let most = SMOOTH * height + 4.0 * self.rough[gauge];
            strains().zip(strains().skip(1)).all(|(before, after)| (after - before).abs() <= most)
        })
    }

    /// The strain has changed: hands out what waits, but for the samples that do not fit the newest ones.
    fn change(&mut self, params: &Params, good: Pair, out: &mut VecDeque<Sample>) -> u64 {
        let newest = self.waiting.len() - LONGEST - 1;
        let clipped = self.waiting.iter().skip(newest).all(|sample| at_limit(params, pair(sample)));
        let mut dropped = self.waiting.len();
        self.waiting.retain(|sample| clipped || !at_limit(params, pair(sample)));
        dropped -= self.waiting.len();
        let newest = self.waiting.len().saturating_sub(LONGEST + 1);
        let middle = [0, 1].map(|gauge| {
            let mut strains: Vec<f64> = self.waiting.iter().skip(newest).map(|sample| pair(sample)[gauge]).collect();
            strains.sort_by(f64::total_cmp);
            let half = strains.len() / 2;
            strains
                .get(half)
                .zip(strains.get(half.saturating_sub(1 - strains.len() % 2)))
                .map_or(0.0, |(a, b)| 0.5 * (a + b))
        });
        while let Some(sample) = self.waiting.pop_front() {
            let fits = (0..2).all(|gauge| {
                let reach = (middle[gauge] - good[gauge]).abs() + 4.0 * self.rough[gauge];
                (pair(&sample)[gauge] - middle[gauge]).abs() <= reach
            });
            if fits {
                self.accept(sample, out);
            } else {
                dropped += 1;
            }
        }
        self.part += PART_WEIGHT * dropped as f64;
        dropped as u64
    }

    /// Without a strain before it, two samples must agree.
    fn begin(&mut self, params: &Params, sample: Sample, out: &mut VecDeque<Sample>) -> u64 {
        let Some(before) = self.waiting.pop_front() else {
            self.waiting.push_back(sample);
            return 0;
        };
        if at_limit(params, pair(&before)) && !at_limit(params, pair(&sample)) {
            self.waiting.push_back(sample);
            return 1;
        }
        self.good = Some(pair(&before));
        self.accept(before, out);
        self.waiting.clear();
        self.push(params, sample, false, out)
    }

    /// The strain is back at `good`: what waits is a glitch if it is flat.
    fn come_back(&mut self, params: &Params, good: Pair, now_us: u64, out: &mut VecDeque<Sample>) -> u64 {
        let Some(first) = self.waiting.front() else { return 0 };
        let strains = |gauge: usize| self.waiting.iter().map(move |sample| pair(sample)[gauge]);
        let flat = (0..2).all(|gauge| {
            let (low, high) = strains(gauge).fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
            let height = (high - good[gauge]).abs().max((low - good[gauge]).abs());
            let noise = 4.0 * self.rough[gauge];
            // Glitches in a row may go both ways.
            high - low <= FLAT * height + noise || (low < good[gauge] - noise && high > good[gauge] + noise)
        });
        // A run as long as the shortest touch is a glitch of a converter that has glitches.
        let long = now_us - first.t_us > SHORTEST_TOUCH_US && !at_limit(params, pair(first));
        if flat && self.waiting.len() == 1 {
            self.part += PART_WEIGHT;
        }
        if (flat && (!long || self.part > HAS_GLITCHES)) || self.waiting.len() > LONGEST {
            let dropped = self.waiting.len() as u64;
            self.waiting.clear();
            self.part += PART_WEIGHT * dropped as f64;
            return dropped;
        }
        self.release(out);
        0
    }

    fn release(&mut self, out: &mut VecDeque<Sample>) {
        while let Some(sample) = self.waiting.pop_front() {
            self.accept(sample, out);
        }
    }

    fn accept(&mut self, sample: Sample, out: &mut VecDeque<Sample>) {
        let strains = pair(&sample);
        let good = self.good.unwrap_or(strains);
        for gauge in 0..2 {
            self.step[gauge] = strains[gauge] - good[gauge];
            let most = 3.0 * self.rough[gauge];
            let step = self.step[gauge].abs();
            // Whatever the first step is, the next ones soon tell how rough the stream is.
            let weight = if self.begun < BEGIN { BEGIN_WEIGHT } else { WEIGHT };
            let first = self.rough[gauge] == 0.0;
            self.rough[gauge] += if first { step } else { weight * (step.min(most) - self.rough[gauge]) };
        }
        self.begun = self.begun.saturating_add(1);
        self.part *= 1.0 - PART_WEIGHT;
        self.good = Some(strains);
        out.push_back(sample);
    }
}
