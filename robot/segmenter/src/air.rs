//! Steps of air: a change of the pressure in the whisker moves the baseline, by as much per MPa as steps at rest tell.

use crate::intake::Bin;

/// Changes of the setpoint and of the pressure that count. MPa.
const SETPOINT_MPA: f64 = 0.000_5;
const PRESSURE_MPA: f64 = 0.003;
/// The baseline moves for so long after a change of the setpoint, and of the pressure. s.
const AFTER_S: (f64, f64) = (1.0, 0.6);
/// Readings that contradict the setpoint for longer than this count instead: a driver reads once a second at least. s.
const CONTRADICT_S: f64 = 1.2;
/// A change that no setpoint explains may go on: the next one is at most this times as large, and comes after this times the time
/// since the last one, at most so many s.
const LEAKS_ON: f64 = 1.5;
const LEAKS_ON_MAX_S: f64 = 5.0;
/// Time constant of a chamber before its readings tell it, and its range. s.
const FILLS_S: (f64, f64, f64) = (0.2, 0.05, 20.0);
/// Part of the way of the pressure since the last reading that is not known: the chamber may fill half or twice as fast.
const UNKNOWN: f64 = 0.25;
/// Part of a shift that the history of the rubber changes, and part of the earlier steps that the next one leaves.
const HISTORY: f64 = 0.05;
const FADE: f64 = 0.8;
/// The baseline follows the rest of a step for so long. s.
const SETTLES_S: f64 = 0.5;
/// A shift is known if its standard deviation is less than this part of it.
const KNOWN: f64 = 0.3;

/// State of a step of air.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Phase {
    /// It moves the baseline.
    Moves,
    /// The pressure stands, and the baseline follows the rest of the step.
    Settles,
    #[default]
    Over,
}

/// The pressure, between two readings by a filter of first order to the setpoint, or to a reading that contradicts it.
#[derive(Clone, Debug, Default)]
struct Chamber {
    mpa: Option<f64>,
    setpoint_mpa: f64,
    aim_mpa: f64,
    /// Distance from the newest reading, and since when it contradicts.
    off_mpa: f64,
    off_since_s: Option<f64>,
    /// Way of the pressure that a reading has shown at once, and no setpoint explains. The baseline may have followed it.
    jump_mpa: f64,
    fills_s: f64,
    /// Time and pressure of the last reading that counts, or of the change of the setpoint.
    known: (f64, f64),
    reading_mpa: Option<f64>,
    last_s: f64,
}

/// Shift of the strains per MPa: a straight line through the steps, the newest with the most weight.
#[derive(Clone, Debug, Default)]
struct Response {
    /// Sums of the squares of the ways of the pressure, of their products with the shifts, and of the squares of their
    /// products with the errors.
    squares: f64,
    products: [f64; 2],
    errors: f64,
}

/// The pressure, and the strains that it makes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Air {
    chamber: Chamber,
    response: Response,
    /// Strains that air has added since the start, as far as they are known.
    shift: [f64; 2],
    until_s: f64,
    /// Pressure before the step.
    before_mpa: f64,
    phase: Phase,
}

impl Air {
    /// Takes the shift by the air out of the strains of a bin.
    pub(crate) fn compensate(&mut self, bin: &mut Bin) {
        let before = self.chamber.mpa;
        if let Some(after_s) = self.chamber.push(bin) {
            if self.phase != Phase::Moves {
                self.before_mpa = before.unwrap_or(0.0);
            }
            self.until_s = self.until_s.max(bin.t_s + after_s);
        }
        self.phase = match bin.t_s {
            t_s if t_s < self.until_s => Phase::Moves,
            t_s if t_s < self.until_s + SETTLES_S => Phase::Settles,
            _ => Phase::Over,
        };
        if let Some((before, now)) = before.zip(self.chamber.mpa) {
            for gauge in 0..2 {
                self.shift[gauge] += self.response.per_mpa(gauge) * (now - before);
            }
        }
        bin.strain -= self.shift[0];
        bin.strain_2 = bin.strain_2.map(|strain_2| strain_2 - self.shift[1]);
    }

    pub(crate) fn phase(&self) -> Phase {
        self.phase
    }

    pub(crate) fn shift(&self) -> [f64; 2] {
        self.shift
    }

    /// Whether earlier steps tell the shift within this strain, or a part of it.
    pub(crate) fn is_known(&self, within: f64) -> bool {
        let way_mpa = (self.chamber.setpoint_mpa - self.before_mpa).abs();
        let shift = (self.response.per_mpa(0) * way_mpa).abs();
        self.response.squares > 0.0 && self.response.error() * way_mpa < within.max(KNOWN * shift)
    }

    /// Possible error of the strain: the unknown part of the shift, and that of the pressure. The pressure is between the
    /// newest reading and where it should be by now.
    pub(crate) fn doubt(&self) -> f64 {
        let all_mpa = self.chamber.setpoint_mpa - self.before_mpa;
        let left_mpa = self.chamber.setpoint_mpa - self.chamber.known.1;
        let shift = self.response.error() * all_mpa.abs();
        let (per_mpa, jump_mpa) = (self.response.per_mpa(0).abs(), LEAKS_ON * self.chamber.jump_mpa);
        match self.phase {
            Phase::Moves => shift + per_mpa * (UNKNOWN * left_mpa.abs()).max(self.chamber.off_mpa).max(jump_mpa),
            Phase::Settles => shift + per_mpa * jump_mpa,
            Phase::Over => 0.0,
        }
    }

    /// Whether a reading has just shown at least half of the step.
    pub(crate) fn has_read_half(&self) -> bool {
        let (known_s, mpa) = self.chamber.known;
        let left_mpa = (self.chamber.setpoint_mpa - mpa).abs();
        known_s == self.chamber.last_s && left_mpa < (mpa - self.before_mpa).abs()
    }

    /// The rest of a step is a step of its own.
    pub(crate) fn begin(&mut self) {
        self.before_mpa = self.chamber.mpa.unwrap_or(0.0);
    }

    /// After a step, the strains had moved by this more than was known; less than this tells nothing.
    pub(crate) fn learn(&mut self, off: [f64; 2], noise: f64) {
        let way_mpa = self.chamber.mpa.unwrap_or(0.0) - self.before_mpa;
        if way_mpa.abs() > PRESSURE_MPA {
            self.response.learn(way_mpa, off, noise);
        }
    }
}

impl Chamber {
    /// Returns for how long the baseline moves after this bin, if it brings news.
    fn push(&mut self, bin: &Bin) -> Option<f64> {
        let dt_s = (bin.t_s - self.last_s).max(0.0);
        self.last_s = bin.t_s;
        let reading_mpa =
            bin.pressure_mpa.filter(|mpa| self.reading_mpa.is_none_or(|before| (mpa - before).abs() > PRESSURE_MPA));
        let news = reading_mpa.filter(|_| self.reading_mpa.is_some());
        self.reading_mpa = reading_mpa.or(self.reading_mpa);
        let setpoint_mpa = bin.setpoint_mpa.or(self.reading_mpa)?;
        let Some(mpa) = self.mpa else {
            (self.mpa, self.setpoint_mpa, self.fills_s) = (Some(setpoint_mpa), setpoint_mpa, FILLS_S.0);
            self.aim_mpa = setpoint_mpa;
            self.known = (bin.t_s, setpoint_mpa);
            return None;
        };
        let mut again_s: f64 = 0.0;
        let mut mpa = self.aim_mpa + (mpa - self.aim_mpa) * (-dt_s / self.fills_s).exp();
        if let Some(reading_mpa) = news {
            let left = (self.setpoint_mpa - reading_mpa) / (self.setpoint_mpa - self.known.1);
            let is_on_its_way = left > 0.0 && left < 1.0;
            if is_on_its_way {
                self.fills_s = ((self.known.0 - bin.t_s) / left.ln()).clamp(FILLS_S.1, FILLS_S.2);
            }
            self.jump_mpa = if is_on_its_way { 0.0 } else { (reading_mpa - mpa).abs() };
            if !is_on_its_way {
                // A leak goes on: the next one may come after as long.
                again_s = (LEAKS_ON * (bin.t_s - self.known.0)).min(LEAKS_ON_MAX_S);
            }
            mpa = reading_mpa;
            self.aim_mpa = if is_on_its_way { self.setpoint_mpa } else { reading_mpa };
            self.known = (bin.t_s, mpa);
        }
        let contradicts = self.contradicts(bin, mpa);
        if let Some(reading_mpa) = contradicts.filter(|_| self.off_since_s.is_none()) {
            self.jump_mpa = (reading_mpa - mpa).abs();
            (mpa, self.aim_mpa) = (reading_mpa, reading_mpa);
            self.known = (bin.t_s, mpa);
        }
        self.mpa = Some(mpa);
        if (setpoint_mpa - self.setpoint_mpa).abs() > SETPOINT_MPA {
            (self.setpoint_mpa, self.aim_mpa) = (setpoint_mpa, setpoint_mpa);
            self.known = (bin.t_s, mpa);
            (self.fills_s, self.jump_mpa) = (FILLS_S.0, 0.0);
            return Some(AFTER_S.0);
        }
        news.or(contradicts).map(|_| AFTER_S.1.max(again_s))
    }

    /// The newest reading, if it contradicts the pressure that should be by now. It has done so for long, and counts, once
    /// `off_since_s` is none.
    fn contradicts(&mut self, bin: &Bin, mpa: f64) -> Option<f64> {
        self.off_mpa = bin.pressure_mpa.map_or(0.0, |reading_mpa| (reading_mpa - mpa).abs());
        // Twice the noise of readings must not end it and begin it again.
        let least_mpa = if self.off_since_s.is_some() { 0.5 } else { 1.0 } * PRESSURE_MPA;
        let reading_mpa = bin.pressure_mpa.filter(|_| self.off_mpa > least_mpa);
        let since_s = self.off_since_s.filter(|_| reading_mpa.is_some()).unwrap_or(bin.t_s);
        self.off_since_s = reading_mpa.map(|_| since_s).filter(|since_s| bin.t_s - since_s <= CONTRADICT_S);
        reading_mpa
    }
}

impl Response {
    fn per_mpa(&self, gauge: usize) -> f64 {
        if self.squares > 0.0 { self.products[gauge] / self.squares } else { 0.0 }
    }

    /// Standard deviation of [`Response::per_mpa`] of the first gauge.
    fn error(&self) -> f64 {
        let history = HISTORY * self.per_mpa(0);
        if self.squares > 0.0 { (self.errors.sqrt() / self.squares).hypot(history) } else { 0.0 }
    }

    fn learn(&mut self, way_mpa: f64, off: [f64; 2], noise: f64) {
        let error = if self.squares > 0.0 { off[0] } else { 0.0 };
        let per_mpa = [self.per_mpa(0), self.per_mpa(1)];
        self.squares = FADE * self.squares + way_mpa * way_mpa;
        self.errors = FADE * FADE * self.errors + way_mpa * way_mpa * (error * error + noise * noise);
        for ((product, off), per_mpa) in self.products.iter_mut().zip(off).zip(per_mpa) {
            *product = FADE * *product + way_mpa * (off + per_mpa * way_mpa);
        }
    }
}
