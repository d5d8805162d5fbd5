//! Estimates how fast a chamber loses air, and detects a regulator that keeps refilling it.
//!
//! **Rate.** While the valves are shut, the logarithm of the pressure falls along a line. Its slope is estimated
//! within each interval without valve activity (the setpoint is constant, the regulator reports no movement, and
//! the pressure does not jump) and pooled over the intervals: one slope, an intercept for each interval, weighted
//! by pressure squared because a sensor's errors are absolute. For coarse sensors, a few readings are averaged
//! before the logarithm is taken; the sensor's noise makes the mean resolve less than a step. The confidence
//! interval comes from batch means ([`super::trend`]) plus the possible effect of rounding to sensor steps on the
//! slope, or from the scatter of the slopes of several intervals if that is larger. Old intervals fade with the
//! time constant [`LeakParams::memory`].
//!
//! The rate is per second and relative to the **gauge** pressure, which robots report: rate times gauge pressure is
//! the loss in MPa per second. (Relative to the absolute pressure, which gas laws use, it is smaller by p / (p +
//! 0.101 MPa). A leak into the open air ends at gauge pressure zero, and for small leaks the outflow is nearly
//! proportional to the gauge pressure.)
//!
//! **Refills.** If a regulator refills a leak faster than the readings can follow, the pressure shows no falling
//! line, but valve activity at a constant setpoint ([`super::refill`]). Then no rate is reported, because that of
//! the line would be wrong.
//!
//! **Patterns.** A regulator that dithers or hunts looks like a leak. Its own pattern is learned first, and a leak is called
//! for evidence beyond it ([`super::air_habit`]).

use borsh::io::{Read, Result, Write};
use borsh::{BorshDeserialize, BorshSerialize};

use super::air_habit::OTHERS;
use super::leak_test::LeakTest;
use super::pool::Pool;
use super::refill::Refills;
use super::sealed_interval::SealedInterval;
use super::trend::Interval;
use crate::encoding;
use crate::units::{Megapascal, Micros};

/// Parameters of the leak estimation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeakParams {
    /// Resolution of the robots' pressure sensors, MPa.
    pub sensor_step_mpa: f64,
    /// Smallest refill of a regulator, MPa: about one step of its sensor.
    pub refill_mpa: f64,
    /// Readings are ignored for this long after a setpoint or a valve has moved.
    pub settling: Micros,
    /// Longest interval before it is closed, so that a changing rate is not averaged without limit; at most 1000 s.
    pub interval_max: Micros,
    /// Time constant with which closed intervals fade.
    pub memory: Micros,
    /// A chamber leaks if the lower bound of its rate, or of the loss that refills replace, exceeds this, per
    /// second. Sound chambers lose 3e-5 to 1e-4 per second; at 5e-4 a chamber at 0.1 MPa loses 1 kPa, a third of
    /// the pressure tolerance, in 20 s.
    pub rate_max_per_s: f64,
    /// A chamber also leaks if its pressure leaps more often than this, per second. Pressure behind tight valves
    /// hardly ever leaps.
    pub leaps_max_per_s: f64,
}

impl Default for LeakParams {
    fn default() -> Self {
        Self {
            sensor_step_mpa: 0.0012,
            refill_mpa: 0.0012,
            settling: Micros::from_s(3.0),
            interval_max: Micros::from_s(200.0),
            memory: Micros::from_s(300.0),
            rate_max_per_s: 5e-4,
            leaps_max_per_s: 0.15,
        }
    }
}

/// Source of a reading. Readings of one source are in time order, but not those of both together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A `status` message.
    Status,
    /// A contact in a `contacts` message.
    Contact,
}

/// Number of readings in one average.
const READINGS_A_BIN: u32 = 8;
/// Shortest span of an average, in seconds.
const BIN_SPAN_MIN_S: f64 = 0.5;
/// An average is closed after this span, however few readings it has, in seconds.
const BIN_SPAN_MAX_S: f64 = 8.0;
/// An average above one of the two before it by more than this share of a refill: the regulator refilled.
const JUMP_REFILLS: f64 = 0.6;
/// An average below the previous one by more than this many refills: the regulator vented. A leak may be steep,
/// too.
const VENT_REFILLS: f64 = 1.2;
/// Pressures below this have no useful logarithm, MPa.
const LEAST_MPA: f64 = 0.005;
/// A status older than the previous readings by more than this means that the robot's clock was set back.
const CLOCK_SET_BACK: Micros = Micros(10_000_000);
/// Part of each threshold that counts while a leak is called.
const STILL: f64 = 0.5;
/// Names of the flags of a stored [`LeakWatch`], in stored order.
pub(crate) const FLAGS: [&str; 8] =
    ["quiet_from", "refills by status", "refills by contacts", "closed", "open", "rate", "is_leaking", "test"];

/// The estimator's state for one chamber.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LeakWatch {
    /// Readings before this time by the robot's clock are ignored.
    quiet_from: Micros,
    bin: Bin,
    open: Option<SealedInterval>,
    closed: Pool,
    refills: [Refills; 2],
    is_leaking: bool,
    rate: Rate,
    test: LeakTest,
}

/// Reported rate, per second: its mean and half the width of its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, BorshSerialize, BorshDeserialize)]
struct Rate {
    mean: f32,
    half: f32,
}

impl Rate {
    /// No rate is reported.
    const NONE: Self = Self { mean: 0.0, half: -1.0 };
}

impl Default for Rate {
    fn default() -> Self {
        Self::NONE
    }
}

/// Sums of the readings in the present average.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Bin {
    since: Micros,
    readings: u32,
    seconds: f32,
    mpa: f32,
}

/// What the readings of a longer time show.
struct Evidence {
    /// Lower bound of the loss that refills replace, per second.
    refilled: f64,
    /// Refills, leaps and the falling line, relative to their thresholds.
    relative: [f64; OTHERS],
    /// Leaps between contacts, relative to their threshold.
    quick: f64,
    /// Rate of the falling lines.
    fitted: Option<Interval>,
}

impl LeakWatch {
    /// The setpoint is another one: the readings before and after it do not compare. A small move may be over between two
    /// statuses.
    pub fn interrupt(&mut self, params: &LeakParams) {
        self.close(params);
        self.bin = Bin::default();
        self.refills.iter_mut().for_each(Refills::interrupt);
        self.test.interrupt();
    }

    /// Valves are or may be open on purpose: readings until `settling` has passed are ignored.
    pub fn disturbed(&mut self, params: &LeakParams, at: Micros) {
        self.interrupt(params);
        self.quiet_from = at.after(params.settling);
    }

    /// Whether `settling` has passed since the last intended valve movement.
    #[must_use]
    pub fn is_quiet(&self, at: Micros) -> bool {
        at >= self.quiet_from
    }

    /// Adds one pressure reading, at a time of the robot's clock, while the setpoint is constant. Old readings,
    /// which a robot sends again, are ignored.
    pub fn read(&mut self, params: &LeakParams, source: Source, at: Micros, pressure: Megapascal) {
        if source == Source::Status && at.after(CLOCK_SET_BACK) < self.bin.since.max(self.quiet_from) {
            // Only contacts are sent again: the robot's clock was set back.
            let test = std::mem::take(&mut self.test).begun_anew();
            *self = Self { closed: self.closed, is_leaking: self.is_leaking, test, ..Self::default() };
        }
        if !self.is_quiet(at) {
            return;
        }
        if source == Source::Status
            && let Some(is_leaking) = self.test.read(self.is_leaking, at, pressure.mpa() / params.refill_mpa)
        {
            self.is_leaking = is_leaking || self.seems_to_leak(params);
        }
        self.refills[source as usize].read(params.refill_mpa, at, pressure.mpa());
        if self.bin.readings > 0 {
            let span_s = at.since(self.bin.since).as_s();
            let enough = self.bin.readings >= READINGS_A_BIN && span_s >= BIN_SPAN_MIN_S;
            if at.after(Micros::from_s(BIN_SPAN_MAX_S)) < self.bin.since {
                return;
            }
            if enough || span_s >= BIN_SPAN_MAX_S {
                self.take_bin(params);
            }
        }
        self.bin.add(at, pressure.mpa());
    }

    fn take_bin(&mut self, params: &LeakParams) {
        let bin = std::mem::take(&mut self.bin);
        let count = f64::from(bin.readings);
        let (since, mpa, seconds) = (bin.since, f64::from(bin.mpa) / count, f64::from(bin.seconds) / count);
        if mpa < LEAST_MPA {
            return self.close(params);
        }
        let too_long = |open: &SealedInterval| open.is_full() || since.since(open.since) >= params.interval_max;
        let leapt = |open: &SealedInterval| {
            let refilled = |before_mpa: f32| mpa - f64::from(before_mpa) > JUMP_REFILLS * params.refill_mpa;
            let vented = f64::from(open.waiting.1) - mpa > VENT_REFILLS * params.refill_mpa;
            vented || refilled(open.waiting.1) || open.before_mpa().is_some_and(refilled)
        };
        if self.open.as_ref().is_some_and(|open| too_long(open) || leapt(open)) {
            self.close(params);
        }
        match &mut self.open {
            Some(open) => open.follow(since.since(open.since).as_s() + seconds, mpa),
            None => self.open = Some(SealedInterval::new(since, seconds, mpa)),
        }
        self.judge(params);
    }

    fn close(&mut self, params: &LeakParams) {
        let Some(open) = self.open.take() else { return };
        self.closed.fade((-open.span_s() / params.memory.as_s()).exp());
        let mut own = Pool::default();
        own.add(params.sensor_step_mpa, &open);
        let apart = |one: Interval, other: Interval| one.high < other.low || other.high < one.low;
        if own.rate().zip(self.closed.rate()).is_some_and(|(own, before)| apart(own, before)) {
            // A leak began or was repaired: a long quiet interval would outweigh many short ones after it.
            self.closed = own;
        } else {
            self.closed.add(params.sensor_step_mpa, &open);
        }
    }

    /// Updates the rate, and calls a leak that the line or the refills show. Its end is left to the test of the statuses,
    /// once all evidence has fallen to half of its threshold.
    fn judge(&mut self, params: &LeakParams) {
        let Some(Evidence { refilled, relative, quick, fitted }) = self.evidence(params) else { return };
        if !self.is_leaking {
            self.test.learn_others(relative);
            if self.test.is_exceeded_by(relative, quick, 1.0) {
                self.is_leaking = true;
                self.test.begin(true);
            }
        }
        let part = if self.is_leaking { STILL } else { 1.0 };
        let is_refilled = relative[..2].iter().any(|&one| one > part);
        if fitted.is_some_and(|rate| refilled > rate.high.max(0.0)) {
            // The line does not explain the refills: it belongs to an earlier time, or refills are faster than the
            // readings.
            self.closed = Pool::default();
        }
        let accepted = fitted.filter(|rate| refilled <= rate.high.max(0.0) && (!is_refilled || rate.low > 0.0));
        self.rate =
            accepted.map_or(Rate::NONE, |rate| Rate { mean: rate.mean as f32, half: (rate.high - rate.mean) as f32 });
    }

    fn seems_to_leak(&self, params: &LeakParams) -> bool {
        self.evidence(params).is_some_and(|evidence| self.test.is_exceeded_by(evidence.relative, evidence.quick, STILL))
    }

    /// What the readings of a longer time show. None before the first average.
    fn evidence(&self, params: &LeakParams) -> Option<Evidence> {
        let mpa = self.open.as_ref().map(|open| f64::from(open.mpa))?;
        let greatest = |of: &dyn Fn(&Refills) -> f64| self.refills.iter().map(of).fold(0.0, f64::max);
        let refilled = greatest(&|refills| refills.least_mpa_per_s(params.refill_mpa)) / mpa;
        let leaps = greatest(&Refills::least_leaps_per_s);
        let fitted = self.fitted_rate_per_s(params);
        // The test is repeated for the chamber's whole life, so the threshold lies well beyond the interval's bound.
        let surely = |rate: Interval| rate.mean - 1.6 * (rate.mean - rate.low);
        let fallen = fitted.map_or(0.0, |rate| if self.is_leaking { rate.mean } else { surely(rate) });
        let (rate_max, leaps_max) = (params.rate_max_per_s, params.leaps_max_per_s);
        let quick = self.refills[Source::Contact as usize].least_leaps_per_s() / leaps_max;
        let relative = [refilled / rate_max, leaps / leaps_max, fallen / rate_max];
        Some(Evidence { refilled, relative, quick, fitted })
    }

    /// Whether the chamber leaks.
    #[must_use]
    pub fn is_leaking(&self) -> bool {
        self.is_leaking
    }

    /// Relative rate per second at which the gauge pressure falls while the valves are shut, with its 95 %
    /// interval. `None` until there are enough readings. While no line shows a leak that was called, the
    /// bounds of its likeliest rate by the test; `None` if refills are faster than the statuses.
    #[must_use]
    pub fn rate_per_s(&self) -> Option<Interval> {
        let [mean, half] = [self.rate.mean, self.rate.half].map(f64::from);
        let fitted = (self.rate != Rate::NONE).then_some(Interval { mean, low: mean - half, high: mean + half });
        if !self.is_leaking {
            return fitted;
        }
        // A line through refills that are smaller than the sensor's noise falls too slowly.
        let likeliest = self.test.likeliest();
        fitted.filter(|rate| rate.high >= likeliest.least_per_s).or(likeliest.rate)
    }

    fn fitted_rate_per_s(&self, params: &LeakParams) -> Option<Interval> {
        let mut pool = self.closed;
        if let Some(open) = &self.open {
            pool.add(params.sensor_step_mpa, open);
        }
        pool.interval()
    }
}

impl LeakWatch {
    /// Its flags, in stored order.
    pub(crate) fn is(&self) -> [bool; FLAGS.len()] {
        let [status, contact] = &self.refills;
        [
            self.quiet_from != Micros::default(),
            *status != Refills::default(),
            *contact != Refills::default(),
            self.closed != Pool::default(),
            self.open.is_some(),
            self.rate != Rate::NONE,
            self.is_leaking,
            self.test != LeakTest::default(),
        ]
    }
}

/// Compact encoding: absent parts take no space, and times are written relative to the start of the present
/// average.
impl BorshSerialize for LeakWatch {
    fn serialize<W: Write>(&self, writer: &mut W) -> Result<()> {
        let is = self.is();
        let [is_quiet, _, _, closed, _, rate, _, test] = is;
        (encoding::pack_flags(is) as u8).serialize(writer)?;
        let Bin { since: from, readings, seconds, mpa } = self.bin;
        from.serialize(writer)?;
        encoding::write_u32(readings, writer)?;
        (seconds, mpa).serialize(writer)?;
        if is_quiet {
            encoding::write_time(self.quiet_from, from, writer)?;
        }
        for refills in self.refills.iter().filter(|&one| *one != Refills::default()) {
            refills.write(from, writer)?;
        }
        if closed {
            self.closed.serialize(writer)?;
        }
        self.open.iter().try_for_each(|open| open.write(from, writer))?;
        if rate {
            self.rate.serialize(writer)?;
        }
        if test { self.test.write(from, writer) } else { Ok(()) }
    }
}

impl LeakWatch {
    /// Reads stored bytes of this version of the whisker, or of one before version 8.
    ///
    /// # Errors
    /// The bytes end, or cannot have been written.
    pub fn read_stored<R: Read>(is_before_8: bool, reader: &mut R) -> Result<Self> {
        let [is_quiet, by_status, by_contact, closed, open, rate, is_leaking, test] =
            encoding::unpack_flags(u8::deserialize_reader(reader)?.into())?;
        let from = Micros::deserialize_reader(reader)?;
        let readings = encoding::read_u32(reader)?;
        let (seconds, mpa) = BorshDeserialize::deserialize_reader(reader)?;
        let mut read = Self { is_leaking, bin: Bin { since: from, readings, seconds, mpa }, ..Self::default() };
        if is_quiet {
            read.quiet_from = encoding::read_time(from, reader)?;
        }
        for (refills, _) in read.refills.iter_mut().zip([by_status, by_contact]).filter(|(_, is_there)| *is_there) {
            *refills = Refills::read_again(from, reader)?;
        }
        if closed {
            read.closed = Pool::deserialize_reader(reader)?;
        }
        if open {
            read.open = Some(SealedInterval::read(from, reader)?);
        }
        if rate {
            read.rate = Rate::deserialize_reader(reader)?;
        }
        if test {
            let read_test = if is_before_8 { LeakTest::read_before_8 } else { LeakTest::read_again };
            read.test = read_test(from, reader)?;
        }
        Ok(read)
    }
}

impl Bin {
    fn add(&mut self, at: Micros, mpa: f64) {
        if self.readings == 0 {
            self.since = at;
        }
        self.readings += 1;
        // A contact may arrive a little after a younger status.
        self.seconds += (at.since(self.since).as_s() - self.since.since(at).as_s()) as f32;
        self.mpa += mpa as f32;
    }
}
