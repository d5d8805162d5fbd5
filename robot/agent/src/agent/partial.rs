//! Contacts of which each driver says a part: one has the strain, and another one the deflection or the place.
//!
//! Two parts belong together if their times are at most [`GAP_US`] apart. A part waits for the other one for at most
//! [`WAIT_US`].

use std::collections::VecDeque;

use super::motion::{GAP_US, Point, WAIT_US};
use crate::contract::{Moment, Now};
use crate::driver::words::Contact;

/// Most parts that wait; beyond that the oldest has waited in vain.
const WAITING_MAX: usize = 64;

/// A part of a contact.
#[derive(Debug)]
pub(super) struct Partial {
    pub(super) line: Contact,
    /// By the robot's clock.
    pub(super) t_us: u64,
    pub(super) from: usize,
    until: Moment,
}

/// Parts of one whisker's contacts, the oldest first.
#[derive(Debug, Default)]
pub(super) struct Partials(VecDeque<Partial>);

/// Whether a line lacks the strain, the deflection or both.
pub(super) fn is_part(line: &Contact) -> bool {
    line.touched != Some(false) && (line.strain.is_none() || line.deflection_mm.is_none())
}

/// Fills what a line lacks.
fn fill(line: &mut Contact, other: &Contact) {
    // The place is one thing: that of one driver, with its deviation.
    if line.ratio.is_none() && line.distance_mm.is_none() && !line.tip {
        (line.ratio, line.ratio_sd) = (other.ratio, other.ratio_sd);
        (line.distance_mm, line.distance_sd_mm, line.tip) = (other.distance_mm, other.distance_sd_mm, other.tip);
    }
    line.deflection_mm = line.deflection_mm.or(other.deflection_mm);
    line.strain = line.strain.or(other.strain);
    line.saturated |= other.saturated;
    line.pressure_mpa = line.pressure_mpa.or(other.pressure_mpa);
    line.temperature_c = line.temperature_c.or(other.temperature_c);
    line.test_id = line.test_id.take().or_else(|| other.test_id.clone());
}

/// Fills what a line lacks with the motion of its time.
pub(super) fn fill_from(line: &mut Contact, point: Point) {
    if line.ratio.is_none() && line.distance_mm.is_none() && !line.tip {
        (line.ratio, line.distance_mm) = (point.ratio, point.distance_mm.filter(|_| point.ratio.is_none()));
    }
    line.deflection_mm = line.deflection_mm.or(point.deflection_mm.map(f64::abs));
}

impl Partials {
    /// The whole contact, if the other part of it waits; otherwise the line waits.
    pub(super) fn join(&mut self, from: usize, mut line: Contact, t_us: u64, now: Now) -> Option<(Contact, u64)> {
        let fits = |other: &Partial| {
            other.from != from
                && other.t_us.abs_diff(t_us) <= GAP_US
                && (line.strain.is_some() || other.line.strain.is_some())
                && (line.deflection_mm.is_some() || other.line.deflection_mm.is_some())
        };
        let nearest =
            (0..self.0.len()).filter(|&at| fits(&self.0[at])).min_by_key(|&at| self.0[at].t_us.abs_diff(t_us));
        let Some(other) = nearest.and_then(|at| self.0.remove(at)) else {
            self.0.push_back(Partial { line, t_us, from, until: now.at + WAIT_US });
            return None;
        };
        // The gauge knows the time of the touch best.
        let t_us = if line.strain.is_some() { t_us } else { other.t_us };
        fill(&mut line, &other.line);
        Some((line, t_us))
    }

    /// The next part that has waited in vain.
    pub(super) fn overdue(&mut self, now: Now) -> Option<Partial> {
        let is_over = self.0.len() > WAITING_MAX || self.0.front().is_some_and(|first| first.until <= now.at);
        is_over.then(|| self.0.pop_front()).flatten()
    }

    /// Moment at which the oldest part has waited in vain.
    pub(super) fn until(&self) -> Option<Moment> {
        self.0.front().map(|first| first.until)
    }
}
