//! Whether the whisker shakes, as on a robot that drives: the strain goes to and fro, whatever its level.
//!
//! In 0.15 s a touch goes up, or down, or both: its path is at most twice its range. Shaking at 30 Hz has nine times. A
//! few glitches have a long path, too, but most of the samples between them stand still.

use std::collections::VecDeque;

/// Time that is looked at. s.
const WINDOW_S: f64 = 0.15;
/// Fewest samples in it that tell shaking.
const FEWEST: usize = 7;
/// Samples are averaged over this time. s.
const SPACING_S: f64 = 0.003_5;
/// Path over range from which on it shakes.
const TURNS: f64 = 2.9;
/// Part of the steps that must be larger than this part of the range.
const MOVING: (f64, f64) = (0.6, 0.1);
/// Range from which on it shakes, in standard deviations of the noise.
const RANGE_SDS: f64 = 10.0;
/// A turn of the strain that counts, in standard deviations of the noise.
const TURN_SDS: f64 = 5.0;
/// It shakes for so long after the last sign of it. s.
const AFTER_S: f64 = 0.3;
/// It may begin again for so long. s.
const AGAIN_S: f64 = 60.0;

#[derive(Clone, Debug, Default)]
pub(crate) struct Shake {
    strains: VecDeque<(f64, f64)>,
    sum: f64,
    count: f64,
    last_s: Option<f64>,
    now_s: f64,
    shaking: bool,
    /// Range of the strain when it was last seen to shake.
    pub(crate) range: f64,
    /// Standard deviation of the strain when it does not shake; 0 if not known.
    pub(crate) calm_sd: f64,
}

impl Shake {
    pub(crate) fn gap(&mut self) {
        self.strains.clear();
        (self.sum, self.count) = (0.0, 0.0);
    }

    /// Takes a strain.
    pub(crate) fn push(&mut self, t_s: f64, strain: f64) {
        self.sum += strain;
        self.now_s = t_s;
        self.count += 1.0;
        if self.strains.back().is_none_or(|(last_s, _)| t_s - last_s >= SPACING_S) {
            self.strains.push_back((t_s, self.sum / self.count));
            (self.sum, self.count) = (0.0, 0.0);
            while self.strains.front().is_some_and(|(first_s, _)| t_s - first_s > WINDOW_S) {
                self.strains.pop_front();
            }
            if self.sees_shaking() {
                self.last_s = Some(t_s);
            }
        }
        self.shaking = self.last_s.is_some_and(|last_s| t_s - last_s < AFTER_S);
    }

    /// Whether the whisker has shaken a moment ago, and may do so again.
    pub(crate) fn has_shaken(&self) -> bool {
        self.last_s.is_some_and(|last_s| self.now_s - last_s < AGAIN_S)
    }

    pub(crate) fn is_shaking(&self) -> bool {
        self.shaking
    }

    fn sees_shaking(&mut self) -> bool {
        if self.calm_sd <= 0.0 || self.strains.len() < FEWEST {
            return false;
        }
        let (mut low, mut high) = (f64::MAX, f64::MIN);
        for (_, strain) in &self.strains {
            low = low.min(*strain);
            high = high.max(*strain);
        }
        let range = high - low;
        let steps = self.strains.iter().zip(self.strains.iter().skip(1));
        let moving = steps.filter(|(before, after)| (after.1 - before.1).abs() > MOVING.1 * range).count();
        if range < RANGE_SDS * self.calm_sd || (moving as f64) < MOVING.0 * (self.strains.len() - 1) as f64 {
            return false;
        }
        // The path from turn to turn, of those that are not the noise.
        let least = TURN_SDS * self.calm_sd;
        let first = self.strains.front().map_or(0.0, |(_, strain)| *strain);
        let (mut path, mut turn, mut extreme, mut up) = (0.0, first, first, true);
        for (_, strain) in &self.strains {
            let goes_on = if up { *strain > extreme } else { *strain < extreme };
            if goes_on {
                extreme = *strain;
            } else if (strain - extreme).abs() > least {
                path += (extreme - turn).abs();
                (turn, extreme, up) = (extreme, *strain, !up);
            }
        }
        path += (extreme - turn).abs();
        let shakes = path > TURNS * range;
        if shakes {
            self.range = range;
        }
        shakes
    }
}
