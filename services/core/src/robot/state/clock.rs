//! A robot's clock, estimated from the times in its messages.
//!
//! Each message gives one sample of the clock's offset: `robot time - now`, where `now` is the supervisor's clock when
//! the message was received. A message that was delayed by d gives `offset - d`, with d >= 0: delay only lowers a
//! sample. So the largest sample is the best one, as long as the robot's times are right. One wrong time must not move
//! the estimate, so the largest sample is not simply taken:
//!
//! - Samples of the same [`SLOT`] are one sample: the largest that is not more than [`NEAR`] ahead of the estimate. So
//!   one right message in a slot outweighs all wrong ones in it, and messages that are sent again do not
//!   outnumber the new ones.
//! - The offset is the median of the last [`SAMPLES`] samples; of an even number, the lower one of the two in the
//!   middle. At least four wrong samples in a row move it, which takes 4 slots (8 s) where messages come all the time,
//!   and four messages where they come every 10 s. The same holds for a clock that was stepped: it is followed after
//!   that.
//! - A robot does not keep `status` and `setpoint_state` to send them again. While these come, times of
//!   contacts are left out: after an outage, old contacts would lower most samples.
//!
//! Behaviour in typical cases:
//!
//! - A constant offset, also of years (a robot that believes it is 1970): the offset, less the median delay of some
//!   milliseconds.
//! - A clock that drifts by 100 ppm: an error of 100 us for each second of the samples' age, so 4 ms with a status
//!   every 10 s.
//! - A clock that was stepped: followed as above, in either direction.
//! - Old contacts after an outage: no effect where status messages come, else an estimate that is too low until new
//!   contacts come. A setpoint then expires early, which is safe.
//! - A robot that lies in most of its messages: an offset of its choice, for its own setpoints.
//!
//! An offset rests on the clock of the supervisor that measured it. Another supervisor, or one whose clock was stepped,
//! begins without samples: [`Clock::take_up`]. So a supervisor's wrong clock makes no time of a robot wrong.
//!
//! A robot that states its times in another unit, such as milliseconds, is decades off, and its times pass too slowly. Then a
//! setpoint would live for hours. So a clock that is far off is known only after its rate is: see [`TimeUnit`].
//!
//! The first two samples are not checked by others. They are believed where they agree with the supervisor's clock
//! within [`NEAR`] (the contract asks for 2 s); otherwise no setpoint goes out before the third.

use std::ops::RangeInclusive;

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};
use smallvec::SmallVec;

use crate::encoding;
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
/// Samples closer together than this say nothing about the rate of a clock, in microseconds.
const RATE_SPAN_MIN_US: i64 = 100_000;
/// The contract's times end at 2^53 us, in the year 2255. A clock that is less than a day before that lets no setpoint
/// expire.
const LATEST: Micros = Micros((1 << 53) - 86_400_000_000);

/// Trust in a time that a robot states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) enum TimeTrust {
    /// It can be right.
    Sound,
    /// It is far from the supervisor's clock, and the robot's is not known yet. Either may be wrong.
    Unproved,
    /// It is far from the robot's own clock.
    Far,
}

/// Whether a robot's times are in microseconds, by how fast they pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) enum TimeUnit {
    /// They agree with the supervisor's clock, or pass at between half and twice its rate.
    Right,
    /// Too few messages tell.
    Unproved,
    /// They pass at another rate.
    Wrong,
}

/// How a message's time relates to the moment at which the robot sent it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::robot) enum TimeKind {
    /// Sent at that time: `status` and `setpoint_state`.
    Live,
    /// Sent at that time or later: `contacts`.
    Recorded,
}

/// The clock of one boot of a robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::robot) struct Clock {
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

crate::optional_parts::optional_fields!(Clock: ;
    samples: !samples.is_empty(),
    heard: heard.is_some(),
);

impl Clock {
    /// A message was received at `now`, and says that it was `robot_time`; 0 stands for a message without a time.
    pub(in crate::robot) fn hear(&mut self, now: Micros, robot_time: Micros, kind: TimeKind) {
        self.heard = Some(now);
        if robot_time == Micros::default() {
            return;
        }
        let is_live = kind == TimeKind::Live;
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

    /// The current time by the robot's clock. `None` until that clock is known well enough to expire a setpoint by it.
    pub(in crate::robot) fn robot_time(&self, now: Micros) -> Option<Micros> {
        let offset_us = self.offset_us()?;
        let is_settled = self.samples.len() >= SETTLED && self.unit() == TimeUnit::Right;
        let is_known = is_settled || offset_us.abs() <= NEAR_US;
        Some(Micros(now.0.saturating_add_signed(offset_us))).filter(|robot_time| is_known && *robot_time < LATEST)
    }

    /// The unit of the robot's times. Most pairs of successive samples decide, so that a step of a clock does not.
    fn unit(&self) -> TimeUnit {
        if self.offset_us().is_none_or(|offset_us| offset_us.abs() <= AHEAD_MAX_US) {
            return TimeUnit::Right;
        }
        let (mut right, mut wrong) = (0, 0);
        for (one, next) in self.samples.iter().zip(self.samples.iter().skip(1)) {
            let span_us = offset_us(one.at, next.at);
            if span_us < RATE_SPAN_MIN_US {
                continue;
            }
            let passed_us = next.offset_us.saturating_sub(one.offset_us).saturating_add(span_us);
            let is_right = (span_us / 2..=2 * span_us).contains(&passed_us);
            *(if is_right { &mut right } else { &mut wrong }) += 1;
        }
        match right + wrong {
            0 | 1 => TimeUnit::Unproved,
            _ if wrong > right => TimeUnit::Wrong,
            _ => TimeUnit::Right,
        }
    }

    /// Whether messages that were sent just now show that the robot's times are not in microseconds. Contacts may be sent
    /// again, faster than they were made.
    pub(in crate::robot) fn has_wrong_unit(&self) -> bool {
        self.live() >= SETTLED && self.unit() == TimeUnit::Wrong
    }

    /// How far the robot's clock is ahead of the supervisor's, in microseconds: by messages that were sent just now, the
    /// last of them within a minute.
    pub(in crate::robot) fn ahead_us(&self, now: Micros) -> Option<i64> {
        let is_heard = self.heard.is_some_and(|heard| now.since(heard) < LIVE_FOR);
        self.settled_us().filter(|_| is_heard && self.live() >= SETTLED)
    }

    /// When a message was received last, by the supervisor's clock.
    pub(in crate::robot) fn heard(&self) -> Option<Micros> {
        self.heard
    }

    /// Known and heard, for a question that rests on neither.
    pub(in crate::robot) fn assume_known(&mut self, now: Micros) {
        self.heard = Some(now);
        if self.robot_time(now).is_none() {
            self.samples.clear();
            self.samples.push(Sample { at: now, offset_us: 0, is_live: true });
        }
    }

    /// Trust in a time of this boot.
    pub(in crate::robot) fn trust(&self, now: Micros, robot_time: Micros) -> TimeTrust {
        self.trust_within(&self.plausible(now), robot_time)
    }

    /// Trust in a time of an older boot.
    pub(in crate::robot) fn trust_of_older_boot(&self, now: Micros, robot_time: Micros) -> TimeTrust {
        self.trust_within(&self.plausible_of_older_boot(now), robot_time)
    }

    /// The supervisor's clock alone is no reason to reject a time: only the robot's own clock, once it is known, is.
    fn trust_within(&self, plausible: &RangeInclusive<Micros>, robot_time: Micros) -> TimeTrust {
        match (plausible.contains(&robot_time), self.settled_us()) {
            (true, _) => TimeTrust::Sound,
            (false, None) => TimeTrust::Unproved,
            (false, Some(_)) => TimeTrust::Far,
        }
    }

    /// Forgets the offset: it was measured by another supervisor's clock.
    pub(in crate::robot) fn take_up(&mut self) {
        self.samples.clear();
    }

    /// The times that can be right: neither further ahead than [`AHEAD_MAX_US`] of both clocks, nor further behind
    /// than [`BEHIND_MAX_US`]. Before the estimate has settled, no time is too far behind: the robot may believe it is
    /// 1970.
    fn plausible(&self, now: Micros) -> RangeInclusive<Micros> {
        let earliest = self.settled_us().map_or(Micros::default(), |settled_us| {
            let offset_us = settled_us.min(0).saturating_sub(BEHIND_MAX_US);
            Micros(now.0.saturating_add_signed(offset_us))
        });
        earliest..=*self.plausible_of_older_boot(now).end()
    }

    /// The same for an older boot, whose clock may have been further behind.
    fn plausible_of_older_boot(&self, now: Micros) -> RangeInclusive<Micros> {
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
        encoding::write_u64(heard.0, writer)?;
        self.samples.iter().try_for_each(|one| {
            one.is_live.serialize(writer)?;
            encoding::write_time(one.at, heard, writer)?;
            encoding::write_time(Micros(one.offset_us as u64), Micros::default(), writer)
        })
    }
}

impl BorshDeserialize for Clock {
    fn deserialize_reader<R: Read>(reader: &mut R) -> Result<Self> {
        let (is_heard, count) = <(bool, u8)>::deserialize_reader(reader)?;
        if usize::from(count) > SAMPLES {
            return Err(encoding::invalid("a clock has too many samples"));
        }
        let heard = Micros(encoding::read_u64(reader)?);
        let mut read = Self { samples: SmallVec::new(), heard: is_heard.then_some(heard) };
        for _ in 0..count {
            let is_live = bool::deserialize_reader(reader)?;
            let at = encoding::read_time(heard, reader)?;
            let offset_us = encoding::read_time(Micros::default(), reader)?.0 as i64;
            read.samples.push(Sample { at, offset_us, is_live });
        }
        Ok(read)
    }
}

#[cfg(test)]
mod tests;
