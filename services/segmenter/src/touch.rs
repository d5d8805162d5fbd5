//! One contact, from its onset to its end: where it rose from, its peak, its plateau, and how it fell.

use crate::intake::Bin;
use crate::{Contact, DistanceFusion, Kind, Params};

/// Bins that are kept: half a second at the highest rate.
const KEPT: usize = 128;
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
/// Levels of the rise whose times are kept: each is 6 % above the one before.
const LEVELS: usize = 96;
const LEVEL_RATIO: f64 = 1.06;

/// A bin relative to the baseline, positive in the direction of the contact.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Point {
    pub(crate) t_s: f64,
    pub(crate) strain: f64,
    pub(crate) strain_2: Option<f64>,
    pub(crate) deflection_mm: Option<f64>,
    pub(crate) distance_mm: Option<f64>,
}

/// The newest bins, as they came.
#[derive(Clone, Debug)]
pub(crate) struct Ring {
    bins: [Bin; KEPT],
    next: usize,
    count: usize,
}

impl Ring {
    pub(crate) fn new() -> Ring {
        Ring { bins: [Bin::default(); KEPT], next: 0, count: 0 }
    }

    pub(crate) fn clear(&mut self) {
        self.count = 0;
    }

    pub(crate) fn push(&mut self, bin: Bin) {
        self.bins[self.next] = bin;
        self.next = (self.next + 1) % KEPT;
        self.count = (self.count + 1).min(KEPT);
    }

    /// From the newest to the oldest.
    pub(crate) fn back(&self) -> impl Iterator<Item = &Bin> {
        (1..=self.count).map(move |age| &self.bins[(self.next + KEPT - age) % KEPT])
    }
}

/// Sums of a straight line through points.
#[derive(Clone, Copy, Debug, Default)]
struct Line {
    count: f64,
    t: f64,
    y: f64,
    tt: f64,
    ty: f64,
}

impl Line {
    fn add(&mut self, t: f64, y: f64) {
        self.count += 1.0;
        self.t += t;
        self.y += y;
        self.tt += t * t;
        self.ty += t * y;
    }

    fn slope(&self) -> f64 {
        let spread = self.count * self.tt - self.t * self.t;
        if spread > 0.0 { (self.count * self.ty - self.t * self.y) / spread } else { 0.0 }
    }

    fn at(&self, t: f64) -> f64 {
        self.y / self.count + self.slope() * (t - self.t / self.count)
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    count: f64,
    strain: f64,
    strain_2: f64,
    count_2: f64,
    t_s: f64,
}

impl Sums {
    fn add(&mut self, point: &Point) {
        self.count += 1.0;
        self.strain += point.strain;
        self.t_s += point.t_s;
        if let Some(strain_2) = point.strain_2 {
            self.strain_2 += strain_2;
            self.count_2 += 1.0;
        }
    }

    fn mean(&self) -> f64 {
        self.strain / self.count
    }
}

/// Largest strain at which the last bin before the rise may have been, in standard deviations.
const HIDDEN_SDS: f64 = 3.0;
/// Spacing of samples above which the median of three lags by a sample that counts. s.
const MEDIAN_S: f64 = 0.0035;
/// Part of the change between two samples that counts as the standard deviation of a strain before a slip-off.
const BETWEEN: f64 = 0.5;

/// The time of a strain, with what belongs to it.
#[derive(Clone, Copy, Debug)]
struct Measured {
    point: Point,
    bins: f64,
    /// Possible change of the strain between two samples at the measurement.
    between: f64,
    kind: Kind,
}

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
        self.last = point;
        point.strain
    }

    fn level(&self, index: usize) -> f64 {
        self.level_first * LEVEL_RATIO.powi(index as i32)
    }

    /// Time at which the rise first reached this strain.
    fn reached_s(&self, strain: f64) -> f64 {
        let index = (0..self.level_count).find(|index| self.level(*index) >= strain);
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

    /// The contact, which ends with the newest bin of the ring.
    pub(crate) fn end(&self, params: &Params, ring: &Ring, period_s: f64, time_us: impl Fn(f64) -> u64) -> Contact {
        let slip = self.slip(params, ring, period_s);
        let measured = slip.unwrap_or_else(|| self.measured(period_s));
        let Point { strain, strain_2, .. } = measured.point;
        let noise = self.sd * (1.0 / measured.bins + 0.05).sqrt();
        let noise = if measured.kind == Kind::Peak { 1.5 * noise } else { noise };
        let history = params.history_sd * strain;
        let ratio = strain_2.filter(|_| strain > 0.0).map(|strain_2| {
            let ratio = strain_2 / strain;
            let relative = 1.5 * noise / strain;
            (ratio, ratio.abs() * (params.ratio_sd * params.ratio_sd + 2.0 * relative * relative).sqrt())
        });
        let distance = ratio.and_then(|(ratio, sd)| {
            let mut fusion = DistanceFusion::default();
            fusion.add(ratio, sd);
            fusion.distance(params)
        });
        let deflection_mm =
            self.onset_deflection_mm.zip(measured.point.deflection_mm).map(|(onset, now)| (now - onset).abs());
        Contact {
            onset_us: time_us(self.onset_s),
            measured_us: time_us(measured.point.t_s),
            end_us: time_us(self.last.t_s),
            baseline: self.baseline,
            strain: self.sign * strain,
            strain_sd: (noise * noise + history * history + measured.between * measured.between).sqrt(),
            kind: measured.kind,
            tip: slip.is_some(),
            deflection_mm,
            distance_mm: measured.point.distance_mm,
            ratio,
            distance,
            saturated: self.saturated,
        }
    }

    fn measured(&self, period_s: f64) -> Measured {
        match (self.plateau, self.plateau_point) {
            (Some(sums), Some(point)) => {
                let strain_2 = (sums.count_2 > 0.0).then(|| sums.strain_2 / sums.count_2);
                let point = Point { t_s: sums.t_s / sums.count, strain: sums.mean(), strain_2, ..point };
                Measured { point, bins: sums.count, between: 0.0, kind: Kind::Plateau }
            }
            _ => {
                let between = 0.5 * self.rise.slope().max(0.0) * period_s;
                Measured { point: self.peak, bins: 1.0, between, kind: Kind::Peak }
            }
        }
    }

    /// The strain just before a slip-off, if the contact ended with one.
    fn slip(&self, params: &Params, ring: &Ring, period_s: f64) -> Option<Measured> {
        let end_s = self.last.t_s;
        let points = || {
            ring.back()
                .map(|bin| relative(bin, (self.baseline, self.baseline_2), self.sign))
                .take_while(|point| point.t_s >= self.first.t_s && end_s - point.t_s < LEVEL_S + 0.1)
        };
        let level = points().filter(|point| end_s - point.t_s < LEVEL_S).map(|point| point.strain).fold(0.0, f64::max);
        if level < 0.4 * self.peak.strain {
            return None;
        }
        let before = points().find(|point| point.strain >= 0.8 * level)?;
        let low =
            points().take_while(|point| point.t_s >= before.t_s).filter(|point| point.strain < 0.3 * level).last()?;
        let fall_s = low.t_s - before.t_s;
        let back = match (self.onset_deflection_mm, before.deflection_mm, low.deflection_mm) {
            (Some(onset), Some(before), Some(low)) if before != onset => Some((before - low) / (before - onset)),
            _ => None,
        };
        let slipped = match back {
            Some(back) => back < params.slip_of_deflection && fall_s < 0.15,
            None => {
                // Samples resolve no less than about one spacing.
                let rise_s = self.reached_s(0.8 * level) - self.onset_s;
                let most_s = params.slip_s.max(1.5 * period_s);
                fall_s <= most_s && (fall_s - 0.5 * period_s).max(0.0) < params.slip_of_rise * rise_s
            }
        };
        if !slipped {
            return None;
        }
        let (mut line, mut line_2, mut bins) = (Line::default(), Line::default(), 0.0);
        let is_lagging = |point: &Point| period_s > MEDIAN_S && point.t_s > before.t_s - 0.5 * period_s;
        let spread_s = f64::max(0.08, 4.5 * period_s);
        for point in points().filter(|point| point.t_s <= before.t_s && before.t_s - point.t_s < spread_s) {
            // The median of three gives the newest sample before a fall the strain of the one before it.
            if is_lagging(&point) {
                continue;
            }
            if point.strain < 0.5 * level {
                break;
            }
            line.add(point.t_s - before.t_s, point.strain);
            line_2.add(point.t_s - before.t_s, point.strain_2.unwrap_or(0.0));
            bins += 1.0;
        }
        if line.count < 1.0 {
            line.add(0.0, before.strain);
            line_2.add(0.0, before.strain_2.unwrap_or(0.0));
            bins = 1.0;
        }
        // The rise went on for some part of the time to the next sample.
        let ahead_s = 0.5 * period_s;
        let at = |line: &Line| if line.count >= 2.0 { line.at(ahead_s) } else { line.y / line.count };
        let between = if line.count >= 2.0 { BETWEEN * line.slope().abs() * period_s } else { 0.1 * level };
        let point = Point { strain: at(&line), strain_2: before.strain_2.map(|_| at(&line_2)), ..before };
        Some(Measured { point, bins: (bins / 4.0_f64).max(1.0), between, kind: Kind::SlipOff })
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

/// The deflection at a time that the ring covers, between two bins.
fn deflection_at(ring: &Ring, t_s: f64) -> Option<f64> {
    let mut later: Option<&Bin> = None;
    for bin in ring.back() {
        if bin.t_s <= t_s {
            let (mm, Some(later)) = (bin.deflection_mm?, later) else {
                return bin.deflection_mm;
            };
            let part = (t_s - bin.t_s) / (later.t_s - bin.t_s);
            return Some(mm + part * (later.deflection_mm? - mm));
        }
        later = Some(bin);
    }
    None
}
