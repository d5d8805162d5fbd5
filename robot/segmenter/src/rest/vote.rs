//! The votes of a stand, and the election of rest.

use super::{Level, Rest, Run};
use crate::Params;

/// Levels that are remembered.
const LEVELS: usize = 6;
/// Part of each score that the next stand leaves.
const FADE: f64 = 0.8;
/// Votes of a visit, of deflection, of a stated sign, of the sign of all contacts so far; and the largest score.
const VISIT: f64 = 1.0;
const DEFLECTION: f64 = 0.7;
const SIGN: f64 = 2.0;
const SIGN_SEEN: f64 = 1.0;
pub(super) const PROOF: f64 = 5.0;
/// Lead that makes a level rest: the first time, against a level that is sure, and against one in doubt.
const LEAD: (f64, f64, f64) = (1.25, 3.0, 1.0);
/// Visits without one to rest that a level needs to become rest, if rest is sure and if it is in doubt: a vote between
/// two levels of a touch does not count against rest.
const VISITS: (u32, u32) = (3, 2);
/// Difference of deflections that counts. mm.
const LESS_MM: f64 = 0.3;

impl Rest {
    /// A stand begins: its level gains a visit, and the step to it is a vote.
    pub(super) fn stand(&mut self, params: &Params, same: f64) {
        let Run { strain, strain_2, deflection_mm, .. } = self.run;
        let before = self.at;
        if let Some(at) = before {
            self.largest_step = self.largest_step.max((strain - self.levels[at].strain).abs()).max(self.far.abs());
        }
        let here = self.nearest(strain, same).unwrap_or_else(|| self.new_level());
        let level = &mut self.levels[here];
        (level.strain, level.strain_2, level.last_s) = (strain, strain_2, self.run.since_s);
        self.run.level = Some(here);
        let returned = before == Some(here);
        let paused = self.before_pause.take();
        if (returned && self.far.abs() < 2.0 * same) || (before.is_none() && paused == Some(here)) {
            self.at = Some(here);
            (self.far, self.far_mm) = (0.0, None);
            return;
        }
        self.levels.iter_mut().for_each(|level| level.score *= FADE);
        self.levels[here].score += VISIT;
        self.levels[here].visits += 1;
        if self.rest == Some(here) {
            self.levels.iter_mut().for_each(|level| level.visits = 0);
        }
        if let Some(before) = before {
            // The step goes from the level before to here, or far away and back to here.
            let (from, step, mm, to) = if returned {
                (here, self.far, self.far_mm, None)
            } else {
                (before, strain - self.levels[before].strain, deflection_mm, Some(here))
            };
            let way_mm = self.left_mm.zip(mm).map_or(0.0, |(left_mm, mm)| mm - left_mm);
            let pressed = if way_mm.abs() > LESS_MM { DEFLECTION * way_mm.signum() } else { 0.0 };
            let (sign, weight) = if params.sign == 0.0 {
                (f64::from(self.signs.signum()), if self.signs.abs() >= 5 { SIGN_SEEN } else { 0.0 })
            } else {
                (params.sign, SIGN)
            };
            let signed = weight * sign * step.signum();
            // A stated sign may be wrong: the deflection says so, and contacts get the sign that they have.
            let is_refuted = params.sign != 0.0 && pressed * signed < 0.0;
            self.vote(from, to, pressed + if is_refuted { 0.0 } else { signed });
        }
        self.at = Some(here);
        (self.far, self.far_mm) = (0.0, None);
        self.levels.iter_mut().for_each(|level| level.score = level.score.clamp(-PROOF, PROOF));
    }

    /// For the one level, against the other.
    fn vote(&mut self, level: usize, against: Option<usize>, vote: f64) {
        self.levels[level].score += vote;
        if let Some(against) = against {
            self.levels[against].score -= vote;
        }
    }

    fn nearest(&self, strain: f64, within: f64) -> Option<usize> {
        let off = |index: &usize| (self.levels[*index].strain - strain).abs();
        (0..self.levels.len()).min_by(|a, b| off(a).total_cmp(&off(b))).filter(|index| off(index) <= within)
    }

    /// A place for a new level: that of the oldest one which is neither rest nor the last stand.
    fn new_level(&mut self) -> usize {
        if self.levels.len() < LEVELS {
            self.levels.push(Level::default());
            return self.levels.len() - 1;
        }
        let free = (0..LEVELS).filter(|index| Some(*index) != self.rest && Some(*index) != self.at);
        let oldest = free.min_by(|a, b| self.levels[*a].last_s.total_cmp(&self.levels[*b].last_s)).unwrap_or(0);
        self.levels[oldest] = Level::default();
        oldest
    }

    pub(super) fn elect(&mut self, level: Option<usize>) {
        self.elections += u32::from(self.rest != level);
        self.rest = level;
        self.doubt = false;
        self.levels.iter_mut().for_each(|level| level.visits = 0);
    }

    pub(super) fn decide(&mut self) {
        let best = |but: Option<usize>| {
            let others = (0..self.levels.len()).filter(|index| Some(*index) != but);
            others.max_by(|a, b| self.levels[*a].score.total_cmp(&self.levels[*b].score))
        };
        let score = |index: Option<usize>| index.map_or(0.0, |index| self.levels[index].score);
        match self.rest {
            None => {
                let first = best(None);
                if score(first) - score(best(first)).max(0.0) >= LEAD.0 {
                    self.elect(first);
                }
            }
            Some(rest) => {
                let other = best(Some(rest));
                let (lead, visits) = if self.doubt { (LEAD.2, VISITS.1) } else { (LEAD.1, VISITS.0) };
                let returns = other.is_some_and(|other| self.levels[other].visits >= visits);
                if returns && score(other) - score(Some(rest)) >= lead {
                    self.elect(other);
                } else if self.run.level == Some(rest) && score(Some(rest)) - score(other) >= lead {
                    self.doubt = false;
                }
            }
        }
    }
}
