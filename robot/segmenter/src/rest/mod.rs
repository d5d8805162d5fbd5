//! Which level of the strain is rest.
//!
//! A stream may begin in a touch, and air, gaps and slow changes move the baseline. So each level at which the strain
//! stands still is a candidate for rest, and has a score. Four witnesses vote:
//!
//! - **Motion without strain.** The base moves, and the strain stands still: nothing touches. This proves rest.
//! - **Pressure against the object.** Of two levels, rest is the one with less deflection.
//! - **Sign.** A touch moves the strain the way that is stated, or that all contacts so far had. Where the deflection
//!   contradicts the stated sign, the deflection counts.
//! - **Return.** Rest recurs; touches differ. So a level gains by each visit. Two levels that take turns gain alike,
//!   and this witness alone does not decide between them.
//!
//! Votes fade with each stand of the strain. Between steps all levels drift together.

mod vote;

use crate::Params;
use crate::intake::Bin;
use vote::PROOF;

/// A stand lasts at least so long, and so many bins. s.
const STAND_S: f64 = 0.08;
const STAND_BINS: u32 = 4;
/// A bin belongs to a stand within so many standard deviations, and this part of the largest recent step.
const STILL: (f64, f64) = (4.0, 0.005);
/// Two stands are at the same level within so many standard deviations, and this part of the largest recent step: what
/// creep and loop leave.
const SAME: (f64, f64) = (6.0, 0.1);
/// Time in which the largest recent step is forgotten, and in which a stand follows the strain. s.
const FORGET_S: f64 = 30.0;
const FOLLOW_S: f64 = 1.0;
/// Part of the scores that a gap or a step of air leaves.
const SHAKEN: f64 = 0.3;
/// Motion without strain that proves rest, in at most so long. mm, s.
const FREE_MM: f64 = 1.0;
const FREE_S: f64 = 0.5;

#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Level {
    pub(crate) strain: f64,
    pub(crate) strain_2: f64,
    score: f64,
    /// Visits since the strain was last at rest.
    visits: u32,
    last_s: f64,
}

/// Bins in a row at one level.
#[derive(Clone, Copy, Debug, Default)]
struct Run {
    strain: f64,
    strain_2: f64,
    since_s: f64,
    count: u32,
    /// The level that it is a stand at.
    level: Option<usize>,
    deflection_mm: Option<f64>,
    /// Time and deflection with which motion is compared.
    anchor: Option<(f64, f64)>,
    free: bool,
}

/// The levels and their scores.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rest {
    levels: Vec<Level>,
    run: Run,
    last_s: f64,
    /// Level of the last stand, its last deflection, and the farthest point since.
    at: Option<usize>,
    /// The same, when what happened since is no evidence.
    before_pause: Option<usize>,
    left_mm: Option<f64>,
    off: f64,
    far: f64,
    far_mm: Option<f64>,
    largest_step: f64,
    rest: Option<usize>,
    /// How often another level became rest.
    pub(crate) elections: u32,
    doubt: bool,
    /// Number of contacts in a row with one sign, with that sign.
    signs: i32,
}

impl Rest {
    /// The level that is rest, if that is decided.
    pub(crate) fn level(&self) -> Option<Level> {
        self.rest.map(|rest| self.levels[rest])
    }

    /// Whether the strain stands at rest.
    pub(crate) fn is_here(&self) -> bool {
        self.rest.is_some() && self.rest == self.run.level
    }

    /// The level at which the strain stands.
    pub(crate) fn here(&self) -> Option<Level> {
        self.run.level.map(|level| self.levels[level])
    }

    pub(crate) fn is_sure(&self) -> bool {
        self.rest.is_some() && !self.doubt
    }

    /// Largest difference of two visits to one level.
    pub(crate) fn tolerance(&self, sd: f64) -> f64 {
        (SAME.0 * sd).max(SAME.1 * self.largest_step)
    }

    /// A contact of this sign was found, and rest was sure.
    pub(crate) fn contact(&mut self, sign: f64) {
        let sign = if sign > 0.0 { 1 } else { -1 };
        self.signs = if self.signs * sign < 0 { sign } else { (self.signs + sign).clamp(-20, 20) };
    }

    /// After a gap, or after a step of air, all levels may have moved.
    pub(crate) fn shake(&mut self) {
        self.levels.iter_mut().for_each(|level| level.score *= SHAKEN);
        self.doubt = true;
        self.pause();
    }

    /// What happens now is no evidence.
    pub(crate) fn pause(&mut self) {
        self.run = Run::default();
        self.largest_step = self.largest_step.max(self.far.abs());
        self.before_pause = self.at.take().or(self.before_pause);
    }

    /// All levels are different now; signs stay.
    pub(crate) fn forget(&mut self) {
        *self = Rest { signs: self.signs, elections: self.elections + 1, ..Rest::default() };
    }

    /// Rest is at this strain now: a contact has ended there, or air has moved it.
    pub(crate) fn moved(&mut self, strain: f64, strain_2: f64) {
        let Some(rest) = self.rest else { return };
        let by = strain - self.levels[rest].strain;
        let by_2 = strain_2 - self.levels[rest].strain_2;
        for (index, level) in self.levels.iter_mut().enumerate() {
            // Where the strain stands now, it has moved already.
            if index == rest || Some(index) != self.run.level {
                level.strain += by;
                level.strain_2 += by_2;
            }
        }
    }

    /// Looks at a bin; returns whether a stand began, or rest was proven. Stands within `same` are at one level.
    pub(crate) fn push(&mut self, params: &Params, bin: &Bin, sd: f64, period_s: f64, same: f64) -> bool {
        let dt_s = (bin.t_s - self.last_s).max(0.0);
        self.last_s = bin.t_s;
        self.largest_step *= (1.0 - dt_s / FORGET_S).max(0.0);
        if let Some(at) = self.at {
            let off = bin.strain - self.levels[at].strain;
            // Two bins must agree.
            let both = if off * self.off > 0.0 { off.signum() * off.abs().min(self.off.abs()) } else { 0.0 };
            if both.abs() > self.far.abs() {
                (self.far, self.far_mm) = (both, bin.deflection_mm);
            }
            self.off = off;
        }
        let still = STILL.0 * sd + STILL.1 * self.largest_step;
        let residual = bin.strain - self.run.strain;
        if self.run.count == 0 || residual.abs() > still {
            if self.run.level.is_some() {
                self.left_mm = self.run.deflection_mm;
            }
            self.run = Run {
                strain: bin.strain,
                strain_2: bin.strain_2.unwrap_or(0.0),
                since_s: bin.t_s,
                count: 1,
                deflection_mm: bin.deflection_mm,
                ..Run::default()
            };
            return false;
        }
        let weight = (1.0 / f64::from(self.run.count + 1)).max(dt_s / (FOLLOW_S + dt_s));
        let by = weight * residual;
        let by_2 = weight * (bin.strain_2.unwrap_or(0.0) - self.run.strain_2);
        self.run.count += 1;
        self.run.strain += by;
        self.run.strain_2 += by_2;
        self.run.deflection_mm = bin.deflection_mm;
        if self.run.level.is_none() {
            let long = bin.t_s - self.run.since_s >= STAND_S.max(2.5 * period_s);
            if long && self.run.count >= STAND_BINS {
                self.stand(params, same);
                self.decide();
                return true;
            }
            return false;
        }
        for level in &mut self.levels {
            level.strain += by;
            level.strain_2 += by_2;
        }
        self.moves_freely(bin)
    }

    /// Whether the base moves while the strain stands: the proof of rest. At the end of the scale it stands in any touch.
    fn moves_freely(&mut self, bin: &Bin) -> bool {
        if bin.saturated {
            self.run.anchor = None;
            return false;
        }
        let (Some(here), Some(mm), false) = (self.run.level, bin.deflection_mm, self.run.free) else {
            return false;
        };
        match self.run.anchor {
            Some((at_s, at_mm)) if bin.t_s - at_s <= FREE_S => {
                if (mm - at_mm).abs() < FREE_MM {
                    return false;
                }
                self.run.free = true;
                self.levels.iter_mut().for_each(|level| level.score = level.score.min(0.0));
                self.levels[here].score = PROOF;
                self.elect(Some(here));
                true
            }
            _ => {
                self.run.anchor = Some((bin.t_s, mm));
                false
            }
        }
    }
}
