//! One contact, from its onset to its end: its rise, its peak, its plateau, and its fall.

mod measurement;
mod series;

use crate::intake::Bin;
use series::{Line, Sums, deflection_at};
pub(crate) use series::{Point, Ring};

/// The line through the rise uses so much of it. s.
const RISE_S: f64 = 0.06;
/// Length of the blocks whose means are compared to find a plateau. s.
const BLOCK_S: f64 = 0.1;
/// Two blocks that differ by less than this part of the strain are a plateau.
const FLAT: f64 = 0.02;
/// The measurement uses so much of a plateau. s.
const PLATEAU_S: f64 = 0.3;
/// The level before a fall is the largest strain in this time. s.
const LEVEL_S: f64 = 0.3;
/// Time constant with which the level falls that an end is compared with, and the part of the peak that stays: a slide
/// to the tip gets weaker. s.
const LEVEL_FALLS: (f64, f64) = (1.0, 0.35);
/// A strain that stays within this part of it, and three standard deviations, for so long is a hold. s.
const HOLD: (f64, f64) = (0.01, 1.0);
/// Time constant with which the baseline follows the strain in a hold. s.
const HOLD_FOLLOWS_S: f64 = 1.0;
/// Deflection that shows that something presses, and for how long. mm, s.
const PRESSED: (f64, f64) = (0.3, 1.0);
/// Levels of the rise whose times are kept: each is 6 % above the one before.
const LEVELS: usize = 96;
const LEVEL_RATIO: f64 = 1.06;
/// Largest strain at which the last bin before the rise may have been, in standard deviations.
const HIDDEN_SDS: f64 = 3.0;

/// A contact that has not ended.
#[derive(Clone, Debug)]
pub(crate) struct Touch {
    sign: f64,
    baseline: f64,
    baseline_2: f64,
    sd: f64,
    /// First bin above the threshold, and the last one before it.
    first: Point,
    below_s: f64,
    pub(crate) onset_s: f64,
    onset_deflection_mm: Option<f64>,
    rise: Line,
    rise_done: bool,
    peak: Point,
    levels: [f64; LEVELS],
    level_count: usize,
    level_first: f64,
    level_next: f64,
    block: Sums,
    block_start_s: f64,
    block_before: Option<f64>,
    plateau: Option<Sums>,
    plateau_point: Option<Point>,
    saturated: bool,
    calm: bool,
    level: f64,
    hold: f64,
    hold_since_s: f64,
    pressed_s: f64,
    last: Point,
}

impl Touch {
    /// Begins with the newest bins of the ring, of which the last `above` exceed the threshold.
    pub(crate) fn begin(ring: &Ring, (baseline, baseline_2): (f64, f64), sign: f64, sd: f64, above: usize) -> Touch {
        let relative = |bin: &Bin| relative(bin, (baseline, baseline_2), sign);
        // Back to the last bin that noise can explain.
        let mut start = above;
        let mut below = None;
        for (age, bin) in ring.back().enumerate().skip(above) {
            if relative(bin).strain < 2.0 * sd {
                below = Some(relative(bin));
                break;
            }
            start = age + 1;
        }
        let first = ring.back().nth(start - 1).map(relative).unwrap_or_default();
        let below = below.unwrap_or(first);
        let mut touch = Touch {
            sign,
            baseline,
            baseline_2,
            sd,
            first,
            below_s: below.t_s,
            onset_s: first.t_s,
            onset_deflection_mm: below.deflection_mm,
            rise: Line::default(),
            rise_done: false,
            peak: first,
            levels: [0.0; LEVELS],
            level_count: 0,
            level_first: first.strain.max(f64::MIN_POSITIVE),
            level_next: first.strain.max(f64::MIN_POSITIVE),
            block: Sums::default(),
            block_start_s: first.t_s,
            block_before: None,
            plateau: None,
            plateau_point: None,
            saturated: false,
            calm: ring.back().next().is_some_and(|bin| !bin.shaking),
            level: 0.0,
            hold: 0.0,
            hold_since_s: first.t_s,
            pressed_s: f64::NEG_INFINITY,
            last: below,
        };
        for age in (0..start).rev() {
            if let Some(bin) = ring.back().nth(age) {
                touch.push(bin);
            }
        }
        touch.find_onset(ring);
        touch
    }

    /// Takes in the next bin; returns its strain.
    pub(crate) fn push(&mut self, bin: &Bin) -> f64 {
        let point = relative(bin, (self.baseline, self.baseline_2), self.sign);
        self.saturated |= bin.saturated;
        if !self.rise_done {
            let rising = self.rise.count < 1.0 || point.strain > 1.05 * self.peak.strain;
            if rising {
                self.rise.add(point.t_s - self.first.t_s, point.strain);
            }
            // A noisy slow rise is not strictly rising: only a fall, or the time, ends it.
            let flat = !rising && point.strain < self.peak.strain + self.sd;
            self.rise_done = point.t_s - self.first.t_s > RISE_S || (flat && self.rise.count > 2.0);
        }
        if point.strain > self.peak.strain {
            self.peak = point;
        }
        while self.level_count < LEVELS && point.strain >= self.level_next {
            self.levels[self.level_count] = point.t_s;
            self.level_count += 1;
            self.level_next *= LEVEL_RATIO;
        }
        self.find_plateau(&point);
        let dt_s = (point.t_s - self.last.t_s).max(0.0);
        self.level *= (1.0 - dt_s / LEVEL_FALLS.0).max(0.0);
        self.level = self.level.max(LEVEL_FALLS.1 * self.peak.strain).max(point.strain);
        self.follow_hold(&point, dt_s);
        let deflections = self.onset_deflection_mm.zip(point.deflection_mm);
        if deflections.is_some_and(|(onset, now)| now - onset > PRESSED.0) {
            self.pressed_s = point.t_s;
        }
        self.last = point;
        point.strain
    }

    /// Takes in a bin while air moves the baseline of a hold: all of the change is the air's.
    pub(crate) fn push_air(&mut self, bin: &Bin) {
        let point = relative(bin, (self.baseline, self.baseline_2), self.sign);
        self.baseline += self.sign * (point.strain - self.last.strain);
        if let (Some(now), Some(before)) = (point.strain_2, self.last.strain_2) {
            self.baseline_2 += self.sign * (now - before);
        }
        self.last = Point { strain: self.last.strain, strain_2: self.last.strain_2, ..point };
    }

    /// Whether the strain stands: nothing slides along the whisker.
    pub(crate) fn is_held(&self) -> bool {
        self.last.t_s - self.hold_since_s >= HOLD.1
    }

    /// In a hold what changes is the rubber and the drift: the baseline takes part in it.
    fn follow_hold(&mut self, point: &Point, dt_s: f64) {
        let off = point.strain - self.hold;
        if off.abs() > (HOLD.0 * self.hold).max(3.0 * self.sd) {
            (self.hold, self.hold_since_s) = (point.strain, point.t_s);
            return;
        }
        let weight = dt_s / (HOLD_FOLLOWS_S + dt_s);
        if point.t_s - self.hold_since_s < HOLD.1 {
            self.hold += weight * off;
            return;
        }
        self.baseline += self.sign * weight * off;
        if let (Some(strain_2), true) = (point.strain_2, point.strain > 0.0) {
            self.baseline_2 += self.sign * weight * off * strain_2 / point.strain;
        }
    }

    /// The strain of a touch without an end, which an end is compared with.
    pub(crate) fn level(&self) -> f64 {
        self.level
    }

    pub(crate) fn baseline(&self) -> (f64, f64) {
        (self.baseline, self.baseline_2)
    }

    /// Whether it began while nothing shook.
    pub(crate) fn began_calm(&self) -> bool {
        self.calm
    }

    pub(crate) fn strain(&self) -> f64 {
        self.last.strain
    }

    /// Whether a deflection shows that something presses, or did a moment ago.
    pub(crate) fn is_pressed(&self) -> bool {
        self.last.t_s - self.pressed_s < PRESSED.1
    }

    fn rise_level(&self, index: usize) -> f64 {
        self.level_first * LEVEL_RATIO.powi(index as i32)
    }

    /// Time at which the rise first reached this strain.
    fn reached_s(&self, strain: f64) -> f64 {
        let index = (0..self.level_count).find(|index| self.rise_level(*index) >= strain);
        index.map_or(self.peak.t_s, |index| self.levels[index])
    }

    fn find_plateau(&mut self, point: &Point) {
        if let Some(plateau) = &mut self.plateau {
            if point.t_s - self.block_start_s < PLATEAU_S && (point.strain / plateau.mean() - 1.0).abs() < 0.1 {
                plateau.add(point);
            }
            return;
        }
        self.block.add(point);
        if point.t_s - self.block_start_s < BLOCK_S || self.block.count < 3.0 {
            return;
        }
        let mean = self.block.mean();
        let noise = 3.0 * self.sd * (2.0 / self.block.count).sqrt();
        if self.block_before.is_some_and(|before| (mean - before).abs() < FLAT * mean + noise)
            && mean > 0.7 * self.peak.strain
        {
            self.plateau = Some(self.block);
            self.plateau_point = Some(*point);
            return;
        }
        self.block_before = Some(mean);
        self.block = Sums::default();
        self.block_start_s = point.t_s;
    }

    /// Extends the rise back to the baseline.
    pub(crate) fn find_onset(&mut self, ring: &Ring) {
        let gap_s = (self.first.t_s - self.below_s).max(0.0);
        let slope = self.rise.slope();
        let zero = if self.rise.count >= 3.0 && slope > 0.0 {
            -self.rise.at(0.0) / slope
        } else if self.rise.count >= 2.0 && slope > 0.0 {
            (-self.rise.at(0.0) / slope).max(-gap_s)
        } else {
            -0.5 * gap_s
        };
        // The last bin before the rise was within the noise: the onset is no earlier than a rise of this slope allows.
        let hidden_s = if slope > 0.0 { (HIDDEN_SDS * self.sd / slope).min(0.15) } else { 0.15 };
        self.onset_s = self.first.t_s + zero.clamp(-(gap_s + hidden_s), gap_s.max(0.004));
        if self.onset_deflection_mm.is_some() {
            self.onset_deflection_mm = deflection_at(ring, self.onset_s).or(self.onset_deflection_mm);
        }
    }

    /// Whether the onset was found as well as it can be.
    pub(crate) fn rise_done(&self) -> bool {
        self.rise_done
    }

    pub(crate) fn peak_strain(&self) -> f64 {
        self.peak.strain
    }

    pub(crate) fn sign(&self) -> f64 {
        self.sign
    }

    pub(crate) fn began_s(&self) -> f64 {
        self.first.t_s
    }

    /// Seconds since the onset.
    pub(crate) fn age_s(&self) -> f64 {
        self.last.t_s - self.onset_s
    }
}

fn relative(bin: &Bin, (baseline, baseline_2): (f64, f64), sign: f64) -> Point {
    Point {
        t_s: bin.t_s,
        strain: sign * (bin.strain - baseline),
        strain_2: bin.strain_2.map(|strain_2| sign * (strain_2 - baseline_2)),
        deflection_mm: bin.deflection_mm,
        distance_mm: bin.distance_mm,
    }
}
