//! The motion of a whisker as one driver knows it, for the strain that another one reads.
//!
//! A board reads the gauge, and a host moves the whisker. Values are joined by the robot's time: a sample of strain
//! gets the deflection, the distance and the ratio that lie between two values of the motion at most [`GAP_US`] apart.
//! Samples wait for the motion of their time for at most [`WAIT_US`], and go on without it afterwards.

use std::collections::VecDeque;

use vibrissa_segmenter::Sample;

use crate::contract::{Moment, Now};

/// Longest time between two values of the motion that is bridged, in microseconds.
pub(super) const GAP_US: u64 = 300_000;
/// Longest time that strain waits for the motion of its time, in microseconds.
pub(super) const WAIT_US: u64 = 1_000_000;
/// Time after its last line for which a motion is expected to go on, in microseconds.
const LIVE_US: u64 = 2_000_000;
/// Shortest time between two values that are kept, in microseconds.
const SPACING_US: u64 = 10_000;
/// Most values that are kept: some 40 s, longer than the longest contact.
const POINTS_MAX: usize = 4_096;
/// Most samples that wait: those of [`WAIT_US`] at 2 kHz, twice.
const WAITING_MAX: usize = 4_096;

/// The motion at a time.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Point {
    /// By the robot's clock, in microseconds.
    pub(super) t_us: u64,
    pub(super) deflection_mm: Option<f64>,
    pub(super) distance_mm: Option<f64>,
    pub(super) ratio: Option<f64>,
}

/// A sample that waits for the motion.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    sample: Sample,
    /// The robot's clock minus the clock of the stream, in microseconds.
    offset_us: i64,
    until: Moment,
}

/// A sample with all values that are known, and the offset from the clock of its stream to the robot's.
pub(super) type Joined = (Sample, i64);

/// The motion of one whisker.
#[derive(Debug, Default)]
pub(super) struct Motion {
    from: Option<usize>,
    heard: Moment,
    points: VecDeque<Point>,
    waiting: VecDeque<Waiting>,
    /// A touch test of the motion, with the times of its first and its newest value.
    test: Option<(String, u64, u64)>,
}

impl Motion {
    /// The driver of the motion, if its last line is not too old.
    pub(super) fn from(&self, now: Now) -> Option<usize> {
        self.from.filter(|_| now.at < self.heard + LIVE_US)
    }

    /// Takes the values of a line, the oldest first.
    pub(super) fn take(&mut self, from: usize, points: impl Iterator<Item = Point>, test_id: Option<&str>, now: Now) {
        (self.from, self.heard) = (Some(from), now.at);
        for point in points {
            if let Some(test_id) = test_id {
                self.test = match self.test.take() {
                    Some((id, first_us, _)) if id == test_id => Some((id, first_us, point.t_us)),
                    _ => Some((test_id.to_owned(), point.t_us, point.t_us)),
                };
            }
            self.add(point);
        }
    }

    fn add(&mut self, point: Point) {
        match self.points.back() {
            // A clock that went back: the values before it say nothing of what follows.
            Some(newest) if point.t_us + GAP_US < newest.t_us => self.points.clear(),
            Some(newest) if point.t_us <= newest.t_us => return,
            Some(_) | None => {}
        }
        // The newest one may be as near as it likes; those before it are thinned.
        let before = self.points.len().checked_sub(2).map(|at| self.points[at].t_us);
        if before.is_some_and(|before_us| point.t_us < before_us + SPACING_US) {
            self.points.pop_back();
        }
        if self.points.len() >= POINTS_MAX {
            self.points.pop_front();
        }
        self.points.push_back(point);
    }

    /// The motion at a time by the robot's clock; none where it is not known.
    pub(super) fn at(&self, t_us: u64) -> Option<Point> {
        let after = self.points.partition_point(|point| point.t_us < t_us);
        let next = self.points.get(after)?;
        if next.t_us == t_us {
            return Some(*next);
        }
        let before = self.points.get(after.checked_sub(1)?)?;
        if next.t_us - before.t_us > GAP_US {
            return None;
        }
        let part = (t_us - before.t_us) as f64 / (next.t_us - before.t_us) as f64;
        let between = |a: Option<f64>, b: Option<f64>| match (a, b) {
            (Some(a), Some(b)) => Some(a + part * (b - a)),
            (one, other) => one.or(other),
        };
        Some(Point {
            t_us,
            deflection_mm: between(before.deflection_mm, next.deflection_mm),
            distance_mm: between(before.distance_mm, next.distance_mm),
            ratio: between(before.ratio, next.ratio),
        })
    }

    /// The touch test that the motion was doing at a time.
    pub(super) fn test_at(&self, t_us: u64) -> Option<&str> {
        let (id, first_us, last_us) = self.test.as_ref()?;
        (*first_us..=last_us.saturating_add(GAP_US)).contains(&t_us).then_some(id)
    }

    /// Lets a sample wait for the motion of its time.
    pub(super) fn wait(&mut self, sample: Sample, offset_us: i64, now: Now) {
        self.waiting.push_back(Waiting { sample, offset_us, until: now.at + WAIT_US });
    }

    /// The samples that wait no longer, with the motion of their time.
    pub(super) fn ready(&mut self, now: Now) -> Vec<Joined> {
        let newest_us = self.points.back().map(|point| point.t_us);
        let mut ready = Vec::new();
        while let Some(&Waiting { mut sample, offset_us, until }) = self.waiting.front() {
            let t_us = sample.t_us.saturating_add_signed(offset_us);
            let is_known = newest_us.is_some_and(|newest_us| t_us <= newest_us);
            if !is_known && now.at < until && self.waiting.len() <= WAITING_MAX {
                break;
            }
            self.waiting.pop_front();
            if let Some(point) = self.at(t_us) {
                sample.deflection_mm = sample.deflection_mm.or(point.deflection_mm);
                sample.distance_mm = sample.distance_mm.or(point.distance_mm);
            }
            ready.push((sample, offset_us));
        }
        ready
    }

    /// Moment at which the oldest waiting sample goes on without a motion.
    pub(super) fn until(&self) -> Option<Moment> {
        self.waiting.front().map(|waiting| waiting.until)
    }

    /// All samples that wait, because the strain has its own motion from now on.
    pub(super) fn flush(&mut self) -> Vec<Joined> {
        self.waiting.drain(..).map(|waiting| (waiting.sample, waiting.offset_us)).collect()
    }

    /// The stream of strain begins anew.
    pub(super) fn forget_waiting(&mut self) {
        self.waiting.clear();
    }

    /// A driver has gone: its motion has ended.
    pub(super) fn lose(&mut self, driver: usize) {
        if self.from == Some(driver) {
            *self = Self { waiting: std::mem::take(&mut self.waiting), ..Self::default() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moving(times_us: &[u64]) -> Motion {
        let mut motion = Motion::default();
        let points =
            times_us.iter().map(|&t_us| Point { t_us, deflection_mm: Some(t_us as f64 / 1e5), ..Point::default() });
        motion.take(1, points, None, Now::of_us(0));
        motion
    }

    #[test]
    fn a_motion_is_known_between_two_near_values_only() {
        let motion = moving(&[0, 100_000, 500_000]);
        assert_eq!(motion.at(50_000).unwrap().deflection_mm, Some(0.5));
        assert_eq!(motion.at(100_000).unwrap().deflection_mm, Some(1.0));
        assert_eq!((motion.at(300_000), motion.at(500_001)), (None, None), "a gap, and the future");
    }

    #[test]
    fn a_fast_motion_takes_bounded_memory() {
        let motion = moving(&(0..100_000).map(|sample| sample * 500).collect::<Vec<u64>>());
        assert!((1_000..=POINTS_MAX).contains(&motion.points.len()), "{}", motion.points.len());
        let at_us = 49_000_250;
        assert!((motion.at(at_us).unwrap().deflection_mm.unwrap() - at_us as f64 / 1e5).abs() < 1e-6);
    }

    #[test]
    fn a_clock_that_goes_back_begins_a_new_motion() {
        let motion = moving(&[10_000_000, 10_100_000, 1_000_000, 1_100_000]);
        assert!(motion.at(10_050_000).is_none() && motion.at(1_050_000).is_some());
    }
}
