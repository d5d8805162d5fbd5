//! How fast a chamber loses its air, and how often its regulator must make it good.
//!
//! **Rate.** While the valves are shut the logarithm of the pressure falls along a line. Its slope is estimated
//! within each interval in which nothing opened a valve (the setpoint stands, the regulator says so, and the
//! pressure makes no jump), and pooled over the intervals: one slope, each interval its own intercept, weighted by
//! pressure squared, because a sensor's errors are absolute ones. Coarse sensors: a few readings are averaged
//! before their logarithm is taken, and the noise of a sensor carries its mean between two steps. The interval
//! comes from batch means ([`super::trend`]) and from what rounding to the sensor's steps may do to a slope, or, with
//! several intervals, from the scatter of their slopes if that is larger. What lies further back than [`LeakParams::memory`] fades.
//!
//! The rate is per second and relative to the **gauge** pressure, which is what robots tell: rate times gauge
//! pressure is the loss in MPa per second. (Relative to the absolute pressure, by which gas laws go, it is smaller
//! by p / (p + 0.101 MPa). A leak into the open ends at gauge pressure zero, and for small leaks the outflow goes
//! nearly with the gauge pressure.)
//!
//! **Refills.** A leak whose air is made good faster than readings can follow shows no falling line, but valves that
//! work although the setpoint stands ([`super::refill`]). Then no rate is told, because the line's would be wrong.

use borsh::{BorshDeserialize, BorshSerialize};

use super::refill::Refills;
use super::trend::{Interval, Slope, Trend};
use crate::units::{Megapascal, Micros};

/// How leaks are estimated, and what is called one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeakParams {
    /// A step of the robots' pressure sensors, MPa.
    pub sensor_step_mpa: f64,
    /// The least that a regulator lets in when it refills, MPa: about a step of its sensor.
    pub refill_mpa: f64,
    /// Readings are not used for this long after a setpoint or a valve has moved.
    pub settling: Micros,
    /// An interval is closed after this, so that what changes is not averaged over for ever.
    pub interval_max: Micros,
    /// Time constant with which closed intervals fade.
    pub memory: Micros,
    /// A leak is called when the rate's lower bound is above this, per second, or that of what refills make good. Sound chambers lose 3e-5 to 1e-4 per
    /// second; at five times as much a chamber at 0.1 MPa loses 1 kPa, a third of the pressures' tolerance, in 20 s.
    pub rate_max_per_s: f64,
    /// It is also called when the pressure leaps more often than this, per second: valves that hold leap hardly ever.
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

/// Where a reading comes from: each is in order by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// A status.
    Status,
    /// A contact.
    Contact,
}

/// Readings in one average.
const READINGS_A_BIN: u32 = 8;
/// An average spans at least this, in seconds ...
const BIN_SPAN_MIN_S: f64 = 0.5;
/// ... and is taken after this with what there is.
const BIN_SPAN_MAX_S: f64 = 8.0;
/// An average above one of the two before it by more than this part of a refill: the regulator filled.
const JUMP_REFILLS: f64 = 0.6;
/// An average below the one before by more than so many refills: it vented. A leak may be steep, too.
const VENT_REFILLS: f64 = 1.2;
/// A pressure below this has no useful logarithm, MPa.
const LEAST_MPA: f64 = 0.005;
/// The rate is stated with at least that many degrees of freedom.
const LEAST_FREEDOM: f64 = 4.0;
/// ... and over at least so many seconds: valves that tremble shift the pressure by a little now and then.
const LEAST_S: f64 = 60.0;
/// From so many intervals on the scatter of their slopes counts.
const INTERVALS_FOR_SCATTER: f64 = 3.0;
/// A status this much older than what came before it tells that the robot's clock was set back.
const CLOCK_SET_BACK: Micros = Micros(10_000_000);
/// The estimator's state for one chamber.
#[derive(Debug, Clone, PartialEq, Default, BorshSerialize, BorshDeserialize)]
pub struct LeakWatch {
    /// Readings before this, by the robot's clock, are not used.
    quiet_from: Micros,
    bin: Bin,
    open: Option<Stretch>,
    closed: Pool,
    refills: [Refills; 2],
    is_leaking: bool,
    /// Mean and bounds.
    rate_per_s: Option<[f32; 3]>,
}

/// Readings that are being averaged.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Bin {
    since: Micros,
    readings: u32,
    seconds: f32,
    mpa: f32,
}

/// An interval in which the valves are shut.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
struct Stretch {
    since: Micros,
    trend: Trend,
    mpa: f32,
    /// The newest average but one, and the newest, which waits until it is known that no valve opened in it.
    before_mpa: Option<f32>,
    waiting: (f32, f32),
}

/// Sums over closed intervals, fading.
#[derive(Debug, Clone, Copy, PartialEq, Default, BorshSerialize, BorshDeserialize)]
struct Pool {
    intervals: f32,
    seconds: f32,
    weight: f32,
    slope: f32,
    squares: f32,
    freedom: f32,
    /// Sum of weight^2 times the variance that rounding may add to a slope.
    rounding: f32,
    /// Sums of weight^2, weight^2 slope, weight^2 slope^2.
    scatter: [f32; 3],
}

impl LeakWatch {
    /// A valve is or may be open, on purpose: what comes now is no leak.
    pub fn disturbed(&mut self, params: &LeakParams, at: Micros) {
        self.close(params);
        self.bin = Bin::default();
        self.refills.iter_mut().for_each(Refills::interrupt);
        self.quiet_from = at.after(params.settling);
    }

    /// Whether no valve has moved on purpose for long enough.
    #[must_use]
    pub fn is_quiet(&self, at: Micros) -> bool {
        at >= self.quiet_from
    }

    /// Takes one reading of the pressure in, at a time of the robot's clock, while the setpoint is held. Old ones,
    /// which a robot sends again, change nothing.
    pub fn read(&mut self, params: &LeakParams, source: Source, at: Micros, pressure: Megapascal) {
        if source == Source::Status && at.after(CLOCK_SET_BACK) < self.bin.since.max(self.quiet_from) {
            // Only contacts are sent again: the robot's clock was set back.
            *self = Self { closed: self.closed, is_leaking: self.is_leaking, ..Self::default() };
        }
        if !self.is_quiet(at) {
            return;
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
        let too_long = |open: &Stretch| since.since(open.since) >= params.interval_max;
        let leapt = |open: &Stretch| {
            let refilled = |before_mpa: f32| mpa - f64::from(before_mpa) > JUMP_REFILLS * params.refill_mpa;
            let vented = f64::from(open.waiting.1) - mpa > VENT_REFILLS * params.refill_mpa;
            vented || refilled(open.waiting.1) || open.before_mpa.is_some_and(refilled)
        };
        if self.open.as_ref().is_some_and(|open| too_long(open) || leapt(open)) {
            self.close(params);
        }
        match &mut self.open {
            Some(open) => open.follow(since.since(open.since).as_s() + seconds, mpa),
            None => self.open = Some(Stretch::new(since, seconds, mpa)),
        }
        self.judge(params);
    }

    fn close(&mut self, params: &LeakParams) {
        let Some(open) = self.open.take() else { return };
        self.closed.fade((-open.span_s() / params.memory.as_s()).exp());
        let mut own = Pool::default();
        own.add(params, &open);
        let apart = |one: Interval, other: Interval| one.high < other.low || other.high < one.low;
        if own.rate().zip(self.closed.rate()).is_some_and(|(own, before)| apart(own, before)) {
            // A leak began or was mended: a long quiet interval would outweigh many short ones after it.
            self.closed = own;
        } else {
            self.closed.add(params, &open);
        }
    }

    /// States the rate, and calls a leak, or calls it over once all evidence is down to half of what it takes.
    fn judge(&mut self, params: &LeakParams) {
        let Some(mpa) = self.open.as_ref().map(|open| f64::from(open.mpa)) else { return };
        let greatest = |of: &dyn Fn(&Refills) -> f64| self.refills.iter().map(of).fold(0.0, f64::max);
        let refilled = greatest(&|refills| refills.least_mpa_per_s(params.refill_mpa)) / mpa;
        let leaps = greatest(&Refills::least_leaps_per_s);
        let fitted = self.fitted_rate_per_s(params);
        let part = if self.is_leaking { 0.5 } else { 1.0 };
        // It is asked again and again for as long as the chamber lives: well beyond the interval, for a call.
        let surely = |rate: Interval| rate.mean - 1.6 * (rate.mean - rate.low);
        let fallen = fitted.map_or(0.0, |rate| if self.is_leaking { rate.mean } else { surely(rate) });
        let is_refilled = refilled > part * params.rate_max_per_s || leaps > part * params.leaps_max_per_s;
        self.is_leaking = fallen > part * params.rate_max_per_s || is_refilled;
        if fitted.is_some_and(|rate| refilled > rate.high.max(0.0)) {
            // The line does not account for the refills: it is of the time before, or they outrun the readings.
            self.closed = Pool::default();
        }
        let told = fitted.filter(|rate| refilled <= rate.high.max(0.0) && (!is_refilled || rate.low > 0.0));
        self.rate_per_s = told.map(|rate| [rate.mean, rate.low, rate.high].map(|one| one as f32));
    }

    /// Whether the chamber is called leaking.
    #[must_use]
    pub fn is_leaking(&self) -> bool {
        self.is_leaking
    }

    /// The relative rate per second at which the gauge pressure falls while the valves are shut, with its 95 %
    /// interval; none until there is enough to tell, or when refills come too fast for the readings.
    #[must_use]
    pub fn rate_per_s(&self) -> Option<Interval> {
        self.rate_per_s.map(|rate| rate.map(f64::from)).map(|[mean, low, high]| Interval { mean, low, high })
    }

    fn fitted_rate_per_s(&self, params: &LeakParams) -> Option<Interval> {
        let mut pool = self.closed;
        if let Some(open) = &self.open {
            pool.add(params, open);
        }
        pool.told()
    }
}

impl Bin {
    fn add(&mut self, at: Micros, mpa: f64) {
        if self.readings == 0 {
            self.since = at;
        }
        self.readings += 1;
        // A contact may come a little after a status that is younger.
        self.seconds += (at.since(self.since).as_s() - self.since.since(at).as_s()) as f32;
        self.mpa += mpa as f32;
    }
}

impl Stretch {
    fn new(since: Micros, seconds: f64, mpa: f64) -> Self {
        let waiting = (seconds as f32, mpa as f32);
        Self { since, trend: Trend::new(u32::MAX / 2), mpa: mpa as f32, before_mpa: None, waiting }
    }

    fn follow(&mut self, seconds: f64, mpa: f64) {
        let waited = std::mem::replace(&mut self.waiting, (seconds as f32, mpa as f32));
        self.trend.add(f64::from(waited.0), f64::from(waited.1).ln());
        self.before_mpa = Some(waited.1);
    }

    fn span_s(&self) -> f64 {
        f64::from(self.waiting.0)
    }
}

impl Pool {
    fn fade(&mut self, keep: f64) {
        let keep = keep as f32;
        for sum in [
            &mut self.intervals,
            &mut self.seconds,
            &mut self.weight,
            &mut self.slope,
            &mut self.squares,
            &mut self.freedom,
            &mut self.rounding,
        ] {
            *sum *= keep;
        }
        self.scatter = self.scatter.map(|sum| sum * keep);
    }

    fn add(&mut self, params: &LeakParams, open: &Stretch) {
        let Some(Slope { per_x, weight, squares, freedom }) = open.trend.slope() else { return };
        let mpa = f64::from(open.mpa);
        let by_pressure = mpa.powi(2);
        let weight = by_pressure * weight;
        self.intervals += 1.0;
        self.seconds += open.span_s() as f32;
        self.weight += weight as f32;
        self.slope += (weight * per_x) as f32;
        self.squares += (by_pressure * squares) as f32;
        self.freedom += freedom as f32;
        // Rounding errors are uniform over a step, so that a line through a few of them is off by about a step over
        // the interval (1 / sqrt(12) times sqrt(12)): much less once the pressure falls through several steps.
        let step = params.sensor_step_mpa / mpa;
        let fallen = per_x.abs() * open.span_s();
        let rounding = step / open.span_s().max(1.0) * (step / fallen.max(step));
        self.rounding += (weight * rounding).powi(2) as f32;
        for (sum, power) in self.scatter.iter_mut().zip([1.0, per_x, per_x.powi(2)]) {
            *sum += (weight.powi(2) * power) as f32;
        }
    }

    fn told(&self) -> Option<Interval> {
        self.rate().filter(|_| f64::from(self.seconds) >= LEAST_S)
    }

    fn rate(&self) -> Option<Interval> {
        let [intervals, weight, slope, squares, freedom, rounding] =
            [self.intervals, self.weight, self.slope, self.squares, self.freedom, self.rounding].map(f64::from);
        let all_freedom = freedom + (intervals - 1.0).max(0.0);
        if weight <= 0.0 || all_freedom < LEAST_FREEDOM {
            return None;
        }
        let slope = slope / weight;
        let within = if freedom > 0.0 { squares / freedom / weight } else { 0.0 };
        let [one, linear, square] = self.scatter.map(f64::from);
        let scatter = (square - 2.0 * slope * linear + slope.powi(2) * one).max(0.0) / weight.powi(2);
        let between = if intervals >= INTERVALS_FOR_SCATTER { scatter * intervals / (intervals - 1.0) } else { 0.0 };
        let within = within + rounding / weight.powi(2);
        Interval::of(-slope, within.max(between), all_freedom)
    }
}
