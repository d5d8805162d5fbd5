//! A robot's clock, estimated from the times in its messages.
//!
//! Each message gives one sample of the clock's offset: `robot time - now`, where `now` is the supervisor's clock when the
//! message was received. A message that was delayed by d gives `offset - d`, with d >= 0: delay only lowers a sample. So the
//! largest sample is the best one, as long as the robot's times are right. One wrong time must not move the estimate, so
//! the largest sample is not simply taken:
//!
//! - Samples of the same [`SLOT`] are one sample: the largest that is not more than [`NEAR`] ahead of the estimate. So
//!   one right message in a slot outweighs all wrong ones in it, and messages that are sent again do not
//!   outnumber the new ones.
//! - The offset is the median of the last [`SAMPLES`] samples; of an even number, the lower one of the two in the middle. At
//!   least four wrong samples in a row move it, which takes 4 slots (8 s) where messages come all the time, and four
//!   messages where they come every 10 s. The same holds for a clock that was stepped: it is followed after that.
//! - A robot does not keep `status` and `setpoint_state` to send them again. While these come, times of
//!   contacts are left out: after an outage, old contacts would lower most samples.
//!
//! What it gives:
//!
//! - A constant offset, also of years (a robot that believes it is 1970): the offset, less the median delay of some
//!   milliseconds.
//! - A clock that drifts by 100 ppm: an error of 100 us for each second of the samples' age, so 4 ms with a status every 10 s.
//! - A clock that was stepped: followed as above, in either direction.
//! - Old contacts after an outage: no effect where status messages come, else an estimate that is too low until new contacts
//!   come. A setpoint then expires early, which is safe.
//! - A robot that lies in most of its messages: an offset of its choice, for its own setpoints.
//!
//! The first two samples are not checked by others. They are believed where they agree with the supervisor's clock within
//! [`NEAR`] (the contract asks for 2 s); otherwise no setpoint goes out before the third.

use std::ops::RangeInclusive;

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use smallvec::SmallVec;

use crate::counts;
use crate::units::Micros;

/// Samples that count. Odd, so that there is one in the middle.
const SAMPLES: usize = 7;
/// From so many samples on, no single one can move the offset.
const SETTLED: usize = 3;
/// Messages within this time are one sample, once there are [`SAMPLES`].
const SLOT: Micros = Micros(2_000_000);
/// Live samples younger than this displace contacts: six times the longest pause between two statuses.
const LIVE_FOR: Micros = Micros(60_000_000);
/// How far ahead of the estimate a time is still a matter of delays, in microseconds.
const NEAR_US: i64 = 10_000_000;
/// Times further ahead than this of the estimate, and of the supervisor's clock, are implausible, in microseconds.
const AHEAD_MAX_US: i64 = 60_000_000;
/// Times further behind than this are, too, in microseconds: 30 days, because contacts may wait out a long outage.
const BEHIND_MAX_US: i64 = 30 * 86_400_000_000;

/// What a time was told with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Told {
    /// Sent at that time: `status` and `setpoint_state`.
    Live,
    /// Sent at that time or later: `contacts`.
    Later,
}

/// The clock of one boot of a robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Clock {
    samples: SmallVec<[Sample; SAMPLES]>,
    /// When a message was received last, by the supervisor's clock.
    heard: Option<Micros>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Sample {
    /// When its slot began, by the supervisor's clock.
    at: Micros,
    /// The robot's time less the supervisor's, in microseconds.
    offset_us: i64,
    is_live: bool,
}

impl Clock {
    /// A message was received at `now`, and says that it was `robot_time`; 0 stands for a message without a time.
    pub(super) fn hear(&mut self, now: Micros, robot_time: Micros, told: Told) {
        self.heard = Some(now);
        if robot_time == Micros::default() {
            return;
        }
        let is_live = told == Told::Live;
        let newest_live = self.samples.iter().rev().find(|one| one.is_live);
        let has_recent_live = newest_live.is_some_and(|one| now.since(one.at) < LIVE_FOR);
        if !is_live && has_recent_live && self.live() >= SETTLED {
            return;
        }
        let offset_us = offset_us(now, robot_time);
        let limit_us = self.settled_us().unwrap_or(0).saturating_add(NEAR_US);
        let is_full = self.samples.len() >= SAMPLES;
        match self.samples.last_mut() {
            Some(last) if is_full && last.is_live == is_live && is_same_slot(last.at, now) => {
                last.offset_us = better(last.offset_us, offset_us, limit_us);
            }
            Some(_) | None => {
                if is_full {
                    // Live samples stay longer, unless there are no new ones.
                    let oldest = self.samples.iter().position(|one| !one.is_live && (is_live || has_recent_live));
                    self.samples.remove(oldest.unwrap_or(0));
                }
                self.samples.push(Sample { at: now, offset_us, is_live });
            }
        }
        if is_live && self.live() >= SETTLED {
            self.samples.retain(|one| one.is_live);
        }
    }

    fn live(&self) -> usize {
        self.samples.iter().filter(|one| one.is_live).count()
    }

    /// The robot's time less the supervisor's, in microseconds; none before the first sample.
    fn offset_us(&self) -> Option<i64> {
        let mut falling: SmallVec<[i64; SAMPLES]> = self.samples.iter().map(|one| one.offset_us).collect();
        falling.sort_unstable_by(|one, other| other.cmp(one));
        falling.get(falling.len() / 2).copied()
    }

    /// The same, once no single sample can move it.
    fn settled_us(&self) -> Option<i64> {
        self.offset_us().filter(|_| self.samples.len() >= SETTLED)
    }

    /// What time it is for the robot; none before its clock is known well enough to let a setpoint expire by it.
    pub(super) fn robot_time(&self, now: Micros) -> Option<Micros> {
        let offset_us = self.offset_us()?;
        let is_known = self.samples.len() >= SETTLED || offset_us.abs() <= NEAR_US;
        is_known.then(|| Micros(now.0.saturating_add_signed(offset_us)))
    }

    /// Whether the clock is known well enough to let a setpoint expire by it.
    pub(super) fn is_known(&self) -> bool {
        self.robot_time(Micros::default()).is_some()
    }

    /// When a message was received last, by the supervisor's clock.
    pub(super) fn heard(&self) -> Option<Micros> {
        self.heard
    }

    /// Known and heard, for a question that rests on neither.
    pub(super) fn assume_known(&mut self, now: Micros) {
        self.heard = Some(now);
        if !self.is_known() {
            self.samples.clear();
            self.samples.push(Sample { at: now, offset_us: 0, is_live: true });
        }
    }

    /// The times that can be right: neither further ahead than [`AHEAD_MAX_US`] of both clocks, nor further behind
    /// than [`BEHIND_MAX_US`]. Before the estimate has settled, no time is too far behind: the robot may believe it is 1970.
    pub(super) fn plausible(&self, now: Micros) -> RangeInclusive<Micros> {
        let earliest = self.settled_us().map_or(Micros::default(), |settled_us| {
            let offset_us = settled_us.min(0).saturating_sub(BEHIND_MAX_US);
            Micros(now.0.saturating_add_signed(offset_us))
        });
        earliest..=*self.plausible_of_older_boot(now).end()
    }

    /// The same for an older boot, whose clock may have been further behind.
    pub(super) fn plausible_of_older_boot(&self, now: Micros) -> RangeInclusive<Micros> {
        let offset_us = self.settled_us().unwrap_or(0).max(0).saturating_add(AHEAD_MAX_US);
        Micros::default()..=Micros(now.0.saturating_add_signed(offset_us))
    }
}

fn offset_us(now: Micros, robot_time: Micros) -> i64 {
    let [now, robot_time] = [now, robot_time].map(|time| i64::try_from(time.0).unwrap_or(i64::MAX));
    robot_time.saturating_sub(now)
}

/// A supervisor's clock that was set back begins a new slot.
fn is_same_slot(began: Micros, now: Micros) -> bool {
    began <= now && now.since(began) < SLOT
}

/// The sample that says more about the offset, of two in a slot: the larger one, unless it is beyond the limit.
fn better(one: i64, other: i64, limit: i64) -> i64 {
    match (one <= limit, other <= limit) {
        (true, true) => one.max(other),
        (false, false) => one.min(other),
        (true, false) => one,
        (false, true) => other,
    }
}

/// Times by how far they are from the newest, and offsets with as few digits as they have.
impl BorshSerialize for Clock {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        let heard = self.heard.unwrap_or_default();
        (self.heard.is_some(), self.samples.len() as u8).serialize(writer)?;
        counts::write_long(heard.0, writer)?;
        self.samples.iter().try_for_each(|one| {
            one.is_live.serialize(writer)?;
            counts::write_time(one.at, heard, writer)?;
            counts::write_time(Micros(one.offset_us as u64), Micros::default(), writer)
        })
    }
}

impl BorshDeserialize for Clock {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (is_heard, count) = <(bool, u8)>::deserialize_reader(reader)?;
        if usize::from(count) > SAMPLES {
            return Err(counts::refused("a clock has too many samples"));
        }
        let heard = Micros(counts::read_long(reader)?);
        let mut read = Self { samples: SmallVec::new(), heard: is_heard.then_some(heard) };
        for _ in 0..count {
            let is_live = bool::deserialize_reader(reader)?;
            let at = counts::read_time(heard, reader)?;
            let offset_us = counts::read_time(Micros::default(), reader)?.0 as i64;
            read.samples.push(Sample { at, offset_us, is_live });
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Micros = Micros(1_795_248_000_000_000);
    const SECOND_US: i64 = 1_000_000;
    const YEAR_US: i64 = 365 * 86_400 * SECOND_US;

    /// So many milliseconds after the start.
    fn at(ms: u64) -> Micros {
        Micros(START.0 + 1000 * ms)
    }

    fn told(now: Micros, offset_us: i64) -> Micros {
        Micros(now.0.saturating_add_signed(offset_us))
    }

    /// Hears a message every 500 ms from `from_ms` on.
    fn hear(clock: &mut Clock, from_ms: u64, messages: u64, offset_us: i64, kind: Told) {
        for message in 0..messages {
            let now = at(from_ms + 500 * message);
            clock.hear(now, told(now, offset_us), kind);
        }
    }

    /// How far the estimate is ahead of a true offset.
    fn ahead_us(clock: &Clock, now: Micros, offset_us: i64) -> i64 {
        let robot_time = clock.robot_time(now).expect("known");
        robot_time.0 as i64 - told(now, offset_us).0 as i64
    }

    #[test]
    fn no_single_message_moves_it_wherever_it_comes() {
        for kind in [Told::Live, Told::Later] {
            for place in 0..40 {
                for wrong_us in [YEAR_US, -YEAR_US / 100, 23 * SECOND_US, 9 * SECOND_US, -23 * SECOND_US] {
                    let mut clock = Clock::default();
                    for message in 0..40_u64 {
                        let now = at(700 * message);
                        let offset_us = if message == place { wrong_us } else { 0 };
                        clock.hear(now, told(now, offset_us), kind);
                        if let Some(robot_time) = clock.robot_time(now) {
                            let ahead_us = robot_time.0 as i64 - now.0 as i64;
                            // The first alone is believed within the tolerance.
                            assert!(
                                ahead_us <= if place == 0 && message == 0 { NEAR_US } else { 0 },
                                "{place} {message}"
                            );
                        }
                    }
                    assert_eq!(ahead_us(&clock, at(28_000), 0), 0, "{kind:?} {place} {wrong_us}");
                }
            }
        }
    }

    #[test]
    fn wrong_messages_in_every_slot_do_not_outweigh_right_ones() {
        let mut clock = Clock::default();
        hear(&mut clock, 0, 7, 0, Told::Live);
        for message in 0..2000 {
            let now = at(4_000 + 100 * message);
            let offset_us = if message % 10 == 0 { 0 } else { YEAR_US };
            clock.hear(now, told(now, offset_us), Told::Live);
        }
        assert_eq!(ahead_us(&clock, at(300_000), 0), 0);
    }

    #[test]
    fn a_robot_in_1970_is_known_by_its_third_message_and_one_in_time_by_its_first() {
        let mut clock = Clock::default();
        let since_1970_us = 5_000_000 - START.0 as i64;
        for message in 0..3 {
            assert_eq!(clock.robot_time(at(100)), None, "{message}");
            clock.hear(at(message), told(at(message), since_1970_us), Told::Later);
        }
        assert_eq!(ahead_us(&clock, at(10_000), since_1970_us), 0);
        assert!(clock.plausible(at(10_000)).contains(&Micros(15_000_000)));

        let mut clock = Clock::default();
        clock.hear(at(0), told(at(0), -30_000), Told::Later);
        assert_eq!(ahead_us(&clock, at(60_000), 0), -30_000);
    }

    #[test]
    fn a_first_time_that_is_years_off_lets_no_setpoint_out() {
        let mut clock = Clock::default();
        clock.hear(at(0), told(at(0), YEAR_US), Told::Live);
        assert!(!clock.plausible(at(0)).contains(&told(at(0), YEAR_US)) && !clock.is_known());
        clock.hear(at(10), at(10), Told::Live);
        assert_eq!(ahead_us(&clock, at(20), 0), 0);
    }

    #[test]
    fn a_clock_that_is_stepped_is_followed_within_a_minute_in_either_direction() {
        for (step_us, kind) in [(3_600 * SECOND_US, Told::Live), (-3_600 * SECOND_US, Told::Live)]
            .into_iter()
            .chain([(-3 * SECOND_US, Told::Later), (YEAR_US, Told::Later)])
        {
            let mut clock = Clock::default();
            hear(&mut clock, 0, 60, 0, kind);
            hear(&mut clock, 30_000, 24, step_us, kind);
            assert_eq!(ahead_us(&clock, at(42_000), step_us), 0, "{step_us} {kind:?}");
            assert!(clock.plausible(at(42_000)).contains(&told(at(42_000), step_us)));
        }
        // With a status every ten seconds.
        let mut clock = Clock::default();
        for message in 0..20 {
            let now = at(10_000 * message);
            clock.hear(now, told(now, if message < 16 { 0 } else { 3_600 * SECOND_US }), Told::Live);
        }
        assert_eq!(ahead_us(&clock, at(200_000), 3_600 * SECOND_US), 0);
    }

    #[test]
    fn old_contacts_that_are_sent_again_do_not_lower_it_while_statuses_come() {
        let mut clock = Clock::default();
        hear(&mut clock, 0, 20, 0, Told::Live);
        for ms in (10_000..100_000).step_by(20) {
            // Two minutes old, then a status every ten seconds.
            clock.hear(at(ms), told(at(ms), -120 * SECOND_US), Told::Later);
            if ms % 10_000 == 0 {
                clock.hear(at(ms), at(ms), Told::Live);
            }
            assert_eq!(ahead_us(&clock, at(ms), 0), 0, "{ms}");
        }
        assert!(clock.plausible(at(100_000)).contains(&told(at(100_000), -120 * SECOND_US)));
    }

    #[test]
    fn old_contacts_alone_lower_it_until_new_ones_come() {
        let mut clock = Clock::default();
        hear(&mut clock, 0, 60, -120 * SECOND_US, Told::Later);
        assert_eq!(ahead_us(&clock, at(30_000), 0), -120 * SECOND_US, "too early is safe");
        hear(&mut clock, 30_000, 24, 0, Told::Later);
        assert_eq!(ahead_us(&clock, at(42_000), 0), 0);
    }

    #[test]
    fn contacts_count_again_where_statuses_have_ceased() {
        let mut clock = Clock::default();
        hear(&mut clock, 0, 20, 0, Told::Live);
        hear(&mut clock, 80_000, 40, 5 * SECOND_US, Told::Later);
        assert_eq!(ahead_us(&clock, at(100_000), 5 * SECOND_US), 0);
    }

    #[test]
    fn a_drift_of_100_ppm_and_a_delay_are_errors_of_milliseconds() {
        let mut clock = Clock::default();
        for message in 0..400_u64 {
            let sent = at(10_000 * message);
            let drift_us = (sent.0 - START.0) as i64 / 10_000;
            let now = Micros(sent.0 + 20_000 + 977 * (message % 7));
            clock.hear(now, told(sent, drift_us), Told::Live);
            if message >= 7 {
                let ahead_us = ahead_us(&clock, now, drift_us);
                assert!((-40_000..=0).contains(&ahead_us), "{ahead_us}");
            }
        }
    }

    #[test]
    fn times_that_cannot_be_are_told_from_those_that_can() {
        let mut clock = Clock::default();
        hear(&mut clock, 0, 20, 0, Told::Live);
        let now = at(10_000);
        for (offset_us, is_plausible) in [
            (0, true),
            (59 * SECOND_US, true),
            (61 * SECOND_US, false),
            (YEAR_US, false),
            (-29 * 86_400 * SECOND_US, true),
            (-YEAR_US, false),
        ] {
            assert_eq!(clock.plausible(now).contains(&told(now, offset_us)), is_plausible, "{offset_us}");
            let is_of_older = offset_us <= AHEAD_MAX_US;
            assert_eq!(clock.plausible_of_older_boot(now).contains(&told(now, offset_us)), is_of_older, "{offset_us}");
        }
        assert!([0, u64::MAX].iter().all(|&time| !clock.plausible(now).contains(&Micros(time))));
    }

    #[test]
    fn property_what_is_stored_is_read_again() {
        let mut clock = Clock::default();
        for message in 0..50 {
            let bytes = borsh::to_vec(&clock).unwrap();
            assert!(bytes.len() <= 160, "{}", bytes.len());
            assert_eq!(borsh::from_slice::<Clock>(&bytes).unwrap(), clock);
            let kind = if message % 3 == 0 { Told::Live } else { Told::Later };
            let offset_us = [0, -YEAR_US, i64::MAX, 7, -1][message as usize % 5];
            clock.hear(at(1_700 * message), told(at(1_700 * message), offset_us), kind);
        }
        let too_many = [1, 8, 0];
        assert!(borsh::from_slice::<Clock>(&too_many).is_err());
    }
}
