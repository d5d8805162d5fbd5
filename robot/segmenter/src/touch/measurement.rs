//! The measurement of a contact: plateau, peak, or the strain before a slip-off.

use super::series::{Line, Point, Ring};
use super::{LEVEL_S, Touch, relative};
use crate::{Contact, ContactKind, DistanceFusion, Params};

/// A slip-off is looked for in the last part of a contact: its least length. s.
const FALL_S: f64 = 0.15;
/// A step of less than this part of the steepest one does not belong to the fall.
const GENTLE: f64 = 0.25;
/// Part of the change between two samples that counts as the standard deviation of a strain before a slip-off.
const BETWEEN: f64 = 0.5;

/// A strain as the measurement of a contact, with its time and quality.
#[derive(Clone, Copy, Debug)]
struct Measured {
    point: Point,
    /// Number of independent bins to which the strain's noise corresponds, at least 1.
    bins: f64,
    /// Standard deviation of the strain by its change between two samples. m/m.
    between: f64,
    kind: ContactKind,
}

impl Touch {
    /// The contact, which ends with the newest bin of the ring.
    pub(crate) fn end(&self, params: &Params, ring: &Ring, period_s: f64, time_us: impl Fn(f64) -> u64) -> Contact {
        let slip = self.slip(params, ring, period_s).filter(|measured| measured.point.strain > 0.0);
        let measured = slip.unwrap_or_else(|| self.measured(period_s));
        let Point { strain, strain_2, .. } = measured.point;
        let noise = self.sd * (1.0 / measured.bins + 0.05).sqrt();
        let noise = if measured.kind == ContactKind::Peak { 1.5 * noise } else { noise };
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

    /// The mean of the plateau; without a plateau the peak.
    fn measured(&self, period_s: f64) -> Measured {
        match (self.plateau, self.plateau_point) {
            (Some(sums), Some(point)) => {
                let strain_2 = (sums.count_2 > 0.0).then(|| sums.strain_2 / sums.count_2);
                let point = Point { t_s: sums.t_s / sums.count, strain: sums.mean(), strain_2, ..point };
                Measured { point, bins: sums.count, between: 0.0, kind: ContactKind::Plateau }
            }
            _ => {
                let between = 0.5 * self.rise.slope().max(0.0) * period_s;
                Measured { point: self.peak, bins: 1.0, between, kind: ContactKind::Peak }
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
        // Bins from the newest to the oldest: the fall is the steepest step and those before it that are not gentle.
        let long_s = f64::max(FALL_S, 6.0 * period_s);
        let steps = || {
            let later = points().take_while(|point| end_s - point.t_s < long_s);
            later.zip(points().skip(1)).map(|(after, before)| (before, before.strain - after.strain))
        };
        let steepest = steps().map(|(_, fall)| fall).fold(0.0, f64::max);
        let falls = steps().skip_while(|(_, fall)| *fall < steepest).take_while(|(_, fall)| *fall > GENTLE * steepest);
        let level = falls.last()?.0.strain;
        let before = points().find(|point| point.strain >= 0.8 * level)?;
        let low =
            points().take_while(|point| point.t_s >= before.t_s).filter(|point| point.strain < 0.3 * level).last()?;
        let fall_s = low.t_s - before.t_s;
        // Part of the deflection since the onset that went back during the fall.
        let back = match (self.onset_deflection_mm, before.deflection_mm, low.deflection_mm) {
            (Some(onset), Some(before), Some(low)) if before != onset => Some((before - low) / (before - onset)),
            _ => None,
        };
        let slipped = match back {
            Some(back) => back < params.slip_of_deflection && fall_s < 0.15,
            None => {
                // A time between two events is uncertain by about one sampling period.
                let rise_s = self.reached_s(0.8 * level) - self.onset_s;
                let most_s = params.slip_s.max(1.5 * period_s);
                fall_s <= most_s && (fall_s - 0.5 * period_s).max(0.0) < params.slip_of_rise * rise_s
            }
        };
        if !slipped {
            return None;
        }
        let (mut line, mut line_2, mut bins) = (Line::default(), Line::default(), 0.0);
        let spread_s = f64::max(0.08, 4.5 * period_s);
        for point in points().filter(|point| point.t_s <= before.t_s && before.t_s - point.t_s < spread_s) {
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
        // The slip-off began between two samples. Until then, on average half a period, the strain went on as before.
        let ahead_s = 0.5 * period_s;
        let at = |line: &Line| if line.count >= 2.0 { line.at(ahead_s) } else { line.y / line.count };
        let between = if line.count >= 2.0 { BETWEEN * line.slope().abs() * period_s } else { 0.1 * level };
        let point = Point { strain: at(&line), strain_2: before.strain_2.map(|_| at(&line_2)), ..before };
        Some(Measured { point, bins: (bins / 4.0_f64).max(1.0), between, kind: ContactKind::SlipOff })
    }
}
