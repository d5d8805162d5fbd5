//! Times at which the estimate of the whiskers' present lengths is published to a robot.
//!
//! None of this is stored: the estimate is published again after each takeover.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_core::estimation::LengthEstimate;
use vibrissa_core::mechanics::{CONTACT_RATIOS, Offset};
use vibrissa_core::robot::Robot;
use vibrissa_core::robot::effect::Condition;
use vibrissa_core::units::ContactRatio;
use vibrissa_edge::interval::Z95;

/// Change of a length from which on the robot is told, mm: 0.2 mm change a reading by about 0.7 %.
const CHANGE_MM: f64 = 0.2;
/// Least change of a length of which the robot is told, mm, however certain the length is.
const CHANGE_MIN_MM: f64 = 0.02;
/// Ratio of standard deviations from which on the robot is told that a length has become more or less certain.
const SD_RATIO: f64 = 2.0;
/// Pressures closer than this are the same, MPa: the last digit that is told.
const SAME_MPA: f64 = 5e-6;
/// Gains closer than this are the same, as a ratio: the last digit that is told.
const SAME_GAIN: f64 = 5e-5;
/// Change of the offset from the model from which on the robot is told another response: about 0.3 mm of a touch's
/// place.
const CHANGE_OFFSET: f64 = 0.01;
/// Shortest interval between two estimates of a robot with up to [`WHISKERS_PER_INTERVAL`] whiskers; larger messages are
/// less frequent in proportion. A fleet that learns, or wears off, changes with each contact.
const INTERVAL: Duration = Duration::from_secs(1);
const WHISKERS_PER_INTERVAL: usize = 100;

/// Factors on a whisker's strain at [`CONTACT_RATIOS`].
pub(crate) type Gain = [f64; CONTACT_RATIOS.len()];

/// State of one whisker that its robot must know.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WhiskerState {
    pub(crate) length: LengthEstimate,
    pub(crate) condition: Condition,
    /// The setpoint in force, MPa.
    pub(crate) pressure_mpa: f64,
    pub(crate) gain: Option<Box<Gain>>,
    /// Offset from the model, which moves the whisker's response.
    pub(crate) offset: Offset,
}

/// The estimates of one robot.
#[derive(Debug)]
pub(crate) struct Estimates {
    /// The last published estimate, by whisker.
    sent: Vec<WhiskerState>,
    told_at: Option<Instant>,
    due: Due,
}

/// Whether an estimate must be published.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Due {
    /// Nothing but contacts since the last comparison, and no length has changed.
    No,
    /// If anything differs from the last published estimate.
    IfChanged,
    /// In any case.
    Always,
}

impl Default for Estimates {
    /// A robot to which this supervisor has published no estimate.
    fn default() -> Self {
        Self { sent: Vec::new(), told_at: None, due: Due::Always }
    }
}

impl Estimates {
    /// Makes an estimate due, because the robot may not have the last one.
    pub(crate) fn repeat(&mut self) {
        self.due = Due::Always;
    }

    /// Makes a comparison due, because something other than a contact has happened.
    pub(crate) fn compare(&mut self) {
        self.due = self.due.max(Due::IfChanged);
    }

    /// Makes a comparison due if a contact has changed a length enough. Called for each contact.
    #[inline]
    pub(crate) fn contact(&mut self, whisker: usize, length: &LengthEstimate) {
        if self.sent.get(whisker).is_some_and(|sent| has_changed(&sent.length, length)) {
            self.compare();
        }
    }

    /// Whether an estimate may be due now.
    pub(crate) fn is_due(&self, now: Instant) -> bool {
        let pause = INTERVAL.mul_f64((self.sent.len() as f64 / WHISKERS_PER_INTERVAL as f64).max(1.0));
        self.due > Due::No && self.told_at.is_none_or(|told_at| now >= told_at + pause)
    }

    /// The whiskers as the robot must be told now; `None` if it knows all this already.
    pub(crate) fn next(&mut self, now: Instant, robot: &Robot) -> Option<&[WhiskerState]> {
        let sent = std::mem::take(&mut self.sent);
        let states = (0..robot.whisker_count()).filter_map(|at| state(robot, at, sent.get(at)));
        let news = self.news(now, &sent, states);
        let is_news = news.is_some();
        self.sent = news.unwrap_or(sent);
        is_news.then_some(&self.sent[..])
    }

    /// The present states, if the robot must be told them.
    fn news(
        &mut self,
        now: Instant,
        sent: &[WhiskerState],
        states: impl Iterator<Item = WhiskerState> + Clone,
    ) -> Option<Vec<WhiskerState>> {
        // A robot without a factsheet gets its estimate later.
        states.clone().next()?;
        let due = std::mem::replace(&mut self.due, Due::No);
        let mut left = sent.iter();
        let is_known = |new: WhiskerState| left.next().is_some_and(|sent| !new.differs_from(sent));
        if due < Due::Always && states.clone().all(is_known) && left.next().is_none() {
            return None;
        }
        self.told_at = Some(now);
        Some(states.collect())
    }
}

impl WhiskerState {
    fn differs_from(&self, sent: &Self) -> bool {
        let has_other_gain = match (&self.gain, &sent.gain) {
            (None, None) => false,
            (Some(new), Some(sent)) => new.iter().zip(sent.iter()).any(|(new, sent)| (new - sent).abs() > SAME_GAIN),
            (Some(_), None) | (None, Some(_)) => true,
        };
        has_changed(&sent.length, &self.length)
            || self.condition != sent.condition
            || (self.pressure_mpa - sent.pressure_mpa).abs() > SAME_MPA
            || has_other_gain
            || self.has_other_offset(sent)
    }

    fn has_other_offset(&self, sent: &Self) -> bool {
        let ends = [CONTACT_RATIOS[0], 1.0].map(ContactRatio::known);
        ends.into_iter().any(|end| (self.offset.at(end) - sent.offset.at(end)).abs() > CHANGE_OFFSET)
    }
}

/// Whether a length has changed by half its 95 % interval or by [`CHANGE_MM`], or has become more or less certain.
fn has_changed(sent: &LengthEstimate, now: &LengthEstimate) -> bool {
    let most_mm = (Z95 * sent.sd_mm.min(now.sd_mm)).clamp(CHANGE_MIN_MM, CHANGE_MM);
    (now.length.mm() - sent.length.mm()).abs() > most_mm
        || now.sd_mm > SD_RATIO * sent.sd_mm
        || sent.sd_mm > SD_RATIO * now.sd_mm
}

/// The present state of a whisker. While a new setpoint of a compensation is on its way, the gain that the robot was told
/// stays in force.
fn state(robot: &Robot, at: usize, sent: Option<&WhiskerState>) -> Option<WhiskerState> {
    let view = robot.whisker(at)?;
    let serves = robot.compensations().iter().find(|one| one.compensator() == at && !one.is_proposed());
    let gain = serves.and_then(|one| match one.is_settled() {
        true => Some(Box::new(*one.gain())),
        false => sent.and_then(|sent| sent.gain.clone()),
    });
    let (length, condition, pressure_mpa) = (view.length, view.condition, view.setpoint.mpa());
    Some(WhiskerState { length, condition, pressure_mpa, gain, offset: view.offset })
}

#[cfg(test)]
mod tests {
    use vibrissa_core::units::Millimetre;

    use super::*;

    fn whisker(length_mm: f64, sd_mm: f64) -> WhiskerState {
        let length = LengthEstimate { length: Millimetre::known(length_mm), sd_mm };
        let (condition, pressure_mpa, offset) = (Condition::Healthy, 0.1, Offset::default());
        WhiskerState { length, condition, pressure_mpa, gain: None, offset }
    }

    impl Estimates {
        /// Whether a robot with these whiskers is told of them.
        fn tells(&mut self, now: Instant, states: &[WhiskerState]) -> bool {
            let sent = std::mem::take(&mut self.sent);
            let news = self.news(now, &sent, states.iter().cloned());
            let is_news = news.is_some();
            self.sent = news.unwrap_or(sent);
            assert!(!is_news || self.sent == states, "told something else");
            is_news
        }
    }

    /// The estimates of a robot that was told these whiskers at `now`.
    fn after_sending(now: Instant, whiskers: &[WhiskerState]) -> Estimates {
        let mut estimates = Estimates::default();
        assert!(estimates.tells(now, whiskers));
        estimates
    }

    #[test]
    fn a_robot_is_told_first_and_then_only_what_has_changed() {
        let now = Instant::now();
        let whole = [whisker(70.0, 0.3), whisker(65.0, 0.3)];
        let mut estimates = after_sending(now, &whole);
        assert!(!estimates.is_due(now + INTERVAL), "nothing has happened");
        estimates.compare();
        assert!(estimates.is_due(now + INTERVAL));
        assert!(!estimates.tells(now + INTERVAL, &whole), "nothing has changed");
        estimates.repeat();
        assert!(estimates.tells(now + INTERVAL, &whole), "repeated although nothing has changed");
        type Change = fn(&mut WhiskerState);
        let changes: [(&str, Change); 8] = [
            ("length", |one| one.length.length = Millimetre::known(65.21)),
            ("certainty", |one| one.length.sd_mm = 0.14),
            ("doubt", |one| one.length.sd_mm = 0.61),
            ("condition", |one| one.condition = Condition::Suspected),
            ("pressure", |one| one.pressure_mpa = 0.1001),
            ("level", |one| one.offset.level = 0.011),
            ("slope", |one| one.offset.slope = -0.05),
            ("gain", |one| one.gain = Some(Box::new([1.01; CONTACT_RATIOS.len()]))),
        ];
        for (name, change) in changes {
            let mut estimates = after_sending(now, &whole);
            let mut changed = whole.to_vec();
            change(&mut changed[1]);
            estimates.compare();
            assert!(estimates.tells(now + INTERVAL, &changed), "{name}");
            estimates.compare();
            assert!(!estimates.tells(now + 2 * INTERVAL, &changed), "{name}: once");
        }
        let mut estimates = after_sending(now, &whole);
        estimates.compare();
        assert!(estimates.tells(now + INTERVAL, &whole[..1]), "fewer whiskers");
        estimates.compare();
        assert!(estimates.tells(now + INTERVAL, &whole), "more whiskers");
    }

    #[test]
    fn a_contact_makes_a_comparison_due_by_the_change_and_the_certainty_of_the_length() {
        for (length_mm, sd_mm, told_sd_mm, is_due) in [
            (69.85, 0.3, 0.3, false),
            (69.79, 0.3, 0.3, true),
            (70.21, 0.3, 0.3, true),
            // Half the interval: 0.098 mm.
            (69.93, 0.05, 0.05, false),
            (69.89, 0.05, 0.05, true),
            // Nothing below 0.02 mm.
            (69.985, 0.001, 0.001, false),
            (69.975, 0.001, 0.001, true),
            (70.0, 0.14, 0.3, true),
            (70.0, 0.61, 0.3, true),
        ] {
            let now = Instant::now();
            let mut estimates = after_sending(now, &[whisker(70.0, told_sd_mm)]);
            estimates.contact(0, &whisker(length_mm, sd_mm).length);
            assert_eq!(estimates.is_due(now + INTERVAL), is_due, "{length_mm} {sd_mm}");
        }
    }

    #[test]
    fn estimates_of_a_length_that_changes_with_each_contact_have_a_limited_rate() {
        let start = Instant::now();
        for (whiskers, told_most) in [(6, 61), (1000, 7)] {
            let mut states: Vec<WhiskerState> = (0..whiskers).map(|_| whisker(70.0, 0.3)).collect();
            let mut estimates = after_sending(start, &states);
            let mut count = 1;
            // A minute of contacts, 100 a second.
            for contact in 1..=6000_u32 {
                let now = start + Duration::from_millis(10) * contact;
                states[0].length.length = Millimetre::known(70.0 - 0.005 * f64::from(contact));
                estimates.contact(0, &states[0].length);
                if estimates.is_due(now) && estimates.tells(now, &states) {
                    count += 1;
                }
            }
            assert!(count <= told_most && count + 25 > told_most, "{whiskers} whiskers: {count}");
        }
    }

    #[test]
    fn a_robot_without_a_factsheet_is_told_later() {
        let now = Instant::now();
        let mut estimates = Estimates::default();
        assert!(!estimates.tells(now, &[]));
        assert!(estimates.is_due(now), "still due");
    }
}
