//! A crowd of healthy robots in the core, without messages, for measurements of speed and size.
//!
//! The whiskers have contacts in turn, at random contact ratios and deflections, with noise on strains and
//! pressures. Each robot sends a status every second. The readings are drawn once and reused in a cycle, so that
//! they cost almost nothing compared with the core.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use rayon::prelude::*;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, ContactPlace, Factsheet, GaugeState, Link, RegulatorState, Task, TouchTests,
    WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, Outcome, Params, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

const ARRAY: &str = "left";
const BOOT: &str = "01926e4a-7d5e-7c3b-9f51-6b1f9e0c2d3a";
const PRESSURE_MPA: f64 = 0.1;
const WHOLE_MM: f64 = 70.0;
/// Standard deviation of the log sensitivity of one contact.
const NOISE: f64 = 0.03;
/// Standard deviation and resolution of a pressure reading, MPa.
const PRESSURE_NOISE_MPA: (f64, f64) = (0.0004, 0.0002);
/// Deviation of the whiskers' rubber from the model, in log sensitivity.
const OFFSET: f64 = 0.04;
/// Number of readings in the cycle: a prime, so that no whisker always gets the same ones.
const READINGS: usize = 8191;
/// Time between two contacts of a robot, in microseconds: 50 contacts per second.
const CONTACT_US: u64 = 20_000;
/// Time between two statuses, in microseconds.
const STATUS_US: u64 = 1_000_000;
const START_US: u64 = 1_795_248_000_000_000;

/// The readings of one contact.
#[derive(Debug, Clone, Copy)]
struct Reading {
    ratio: ContactRatio,
    deflection: Millimetre,
    strain: Strain,
    pressure: Megapascal,
}

/// One robot of the crowd.
#[derive(Debug, Clone)]
struct Member {
    robot: Robot,
    /// Number of contacts messages so far.
    seq: u64,
    /// Number of contacts so far.
    contacts: u64,
    /// Position in the cycle of readings.
    at: usize,
    now_us: u64,
    status_us: u64,
}

/// Reusable buffers, so that the crowd itself allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct Buffers {
    /// Effects of the last step.
    pub effects: Vec<Effect>,
    message: Vec<Contact<'static>>,
    statuses: Vec<WhiskerStatus<'static>>,
}

/// Robots with the same number of whiskers, in one array each.
#[derive(Debug, Clone)]
pub struct Crowd {
    params: Params,
    whiskers: u16,
    readings: Vec<Reading>,
    members: Vec<Member>,
}

impl Crowd {
    /// Connected robots; of their whiskers only the factsheet is known.
    #[must_use]
    pub fn new(robots: usize, whiskers: u16) -> Self {
        let params = Params::nguyen_2021(Formulation::Published);
        let mut crowd = Self { readings: readings(&params), params, whiskers, members: Vec::with_capacity(robots) };
        let factsheet = factsheet(whiskers);
        let mut effects = Vec::new();
        for number in 0..robots {
            let mut robot = Robot::new(1, Numbers::default());
            for event in [
                Event::Connection { boot_id: BOOT, link: Link::Online },
                Event::Factsheet { boot_id: BOOT, factsheet: &factsheet },
            ] {
                robot.step(&crowd.params, Micros(START_US), &event, &mut effects);
            }
            effects.clear();
            let at = number * 617 % READINGS;
            crowd.members.push(Member { robot, seq: 0, contacts: 0, at, now_us: START_US, status_us: START_US });
        }
        crowd
    }

    /// Makes this many contacts for each whisker, in messages of one contact per whisker. `done` is called after
    /// each robot.
    pub fn learn(&mut self, contacts: u32, done: &(dyn Fn() + Sync)) {
        let (params, whiskers, readings) = (&self.params, self.whiskers, &self.readings);
        self.members.par_iter_mut().for_each_init(Buffers::default, |buffers, member| {
            for _ in 0..contacts {
                member.contacts(params, readings, whiskers, usize::from(whiskers), buffers);
                if member.now_us >= member.status_us + STATUS_US {
                    member.status(params, whiskers, readings, buffers);
                }
            }
            done();
        });
    }

    /// Steps one message of a robot; its contacts are of consecutive whiskers.
    pub fn contacts(&mut self, robot: usize, contacts: usize, buffers: &mut Buffers) -> Outcome {
        self.members[robot].contacts(&self.params, &self.readings, self.whiskers, contacts, buffers)
    }

    /// Steps a robot's status of all whiskers, one second later.
    pub fn status(&mut self, robot: usize, buffers: &mut Buffers) -> Outcome {
        let member = &mut self.members[robot];
        member.now_us += STATUS_US;
        member.status(&self.params, self.whiskers, &self.readings, buffers)
    }

    /// Steps a tick of a robot.
    pub fn tick(&mut self, robot: usize, buffers: &mut Buffers) -> Outcome {
        buffers.effects.clear();
        let member = &mut self.members[robot];
        member.robot.step(&self.params, Micros(member.now_us), &Event::Tick, &mut buffers.effects)
    }

    /// State of a robot in the core.
    #[must_use]
    pub fn robot(&self, robot: usize) -> &Robot {
        &self.members[robot].robot
    }

    /// Number of robots.
    #[must_use]
    pub fn robots(&self) -> usize {
        self.members.len()
    }

    /// Mean size of a stored whisker, in bytes.
    #[must_use]
    pub fn stored_bytes_a_whisker(&self) -> f64 {
        let each = |member: &Member| -> usize {
            (0..member.robot.whisker_count())
                .filter_map(|index| member.robot.whisker_to_bytes(index))
                .map(|bytes| bytes.len())
                .sum()
        };
        let bytes: usize = self.members.iter().map(each).sum();
        bytes as f64 / (self.members.len() * usize::from(self.whiskers)).max(1) as f64
    }
}

impl Member {
    fn contacts(
        &mut self,
        params: &Params,
        readings: &[Reading],
        whiskers: u16,
        contacts: usize,
        buffers: &mut Buffers,
    ) -> Outcome {
        let Buffers { effects, message, .. } = buffers;
        message.clear();
        for _ in 0..contacts {
            let Reading { ratio, deflection, strain, pressure } = readings[self.at];
            self.at = (self.at + 1) % readings.len();
            let whisker = (self.contacts % u64::from(whiskers)) as u16;
            self.contacts += 1;
            self.now_us += CONTACT_US;
            let robot_time = Micros(self.now_us);
            message.push(Contact {
                array: ARRAY,
                whisker,
                robot_time,
                place: ContactPlace::Ratio { ratio, sd: None },
                deflection,
                strain,
                pressure,
                is_test: false,
                angle_is_stated: false,
                saturated: false,
                temperature_c: None,
            });
        }
        let event = Event::Contacts { boot_id: BOOT, seq: self.seq, contacts: message, missed: &[] };
        self.seq += 1;
        effects.clear();
        self.robot.step(params, Micros(self.now_us), &event, effects)
    }

    fn status(&mut self, params: &Params, whiskers: u16, readings: &[Reading], buffers: &mut Buffers) -> Outcome {
        let Buffers { effects, statuses, .. } = buffers;
        self.status_us = self.now_us;
        statuses.clear();
        statuses.extend((0..whiskers).map(|whisker| WhiskerStatus {
            array: ARRAY,
            whisker,
            pressure: readings[(self.at + usize::from(whisker)) % readings.len()].pressure,
            setpoint: Megapascal::known(PRESSURE_MPA),
            regulator: RegulatorState::Ok,
            gauge: GaugeState::Ok,
        }));
        effects.clear();
        let event = Event::Status { boot_id: BOOT, robot_time: Micros(self.now_us), whiskers: statuses };
        self.robot.step(params, Micros(self.now_us), &event, effects)
    }
}

fn factsheet(whiskers: u16) -> Factsheet {
    let sheet = |number: u16| WhiskerSheet {
        number,
        x_mm: 25.0 * f64::from(number % 6),
        y_mm: 25.0 * f64::from(number / 6),
        model: "nguyen-2021".into(),
        length: Millimetre::known(WHOLE_MM),
        pressure: Megapascal::known(PRESSURE_MPA),
        pressure_max: Megapascal::EXAMINED_MAX,
        // The simulated whiskers are exactly as long.
        length_tolerance_mm: 0.0,
        strain_max: None,
        neighbours: (0..whiskers).filter(|other| [1, 6].contains(&other.abs_diff(number))).collect(),
    };
    let array = ArraySheet {
        name: ARRAY.to_owned(),
        kind: ArrayKind::Type1,
        task: Task::Ratio,
        whiskers: (0..whiskers).map(sheet).collect(),
    };
    Factsheet {
        arrays: vec![array],
        touch_tests: TouchTests::default(),
        applies_gain: false,
        air_control: Default::default(),
    }
}

fn readings(params: &Params) -> Vec<Reading> {
    let mut random = ChaCha8Rng::seed_from_u64(20_211);
    let built_in = Model::nguyen_2021(Formulation::Published);
    let model = params.model("nguyen-2021").unwrap_or(&built_in);
    let (sd, step) = PRESSURE_NOISE_MPA;
    let mut one = |_| {
        let ratio = ContactRatio::known(random.random_range(0.45..=1.0));
        let deflection_mm: f64 = random.random_range(0.5..=6.0);
        let [strain, pressure]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut random));
        let pressure = Megapascal::known(PRESSURE_MPA + (pressure * sd / step).round() * step);
        let modelled = model.sensitivity_per_mm(ratio, Millimetre::known(WHOLE_MM), &model.morphology(pressure));
        let strain = modelled.unwrap_or_default() * deflection_mm * (OFFSET + NOISE * strain).exp();
        Reading { ratio, deflection: Millimetre::known(deflection_mm), strain: Strain::known(strain), pressure }
    };
    (0..READINGS).map(&mut one).collect()
}

/// Memory that a crowd takes.
#[derive(Debug, Clone, Copy)]
pub struct Size {
    /// Number of whiskers in the core.
    pub whiskers: usize,
    /// Resident memory of the process, in bytes; 0 if unknown.
    pub resident_bytes: u64,
    /// Peak of the resident memory, in bytes; 0 if unknown.
    pub resident_max_bytes: u64,
    /// Mean size of a stored whisker, in bytes.
    pub stored_bytes_a_whisker: f64,
}

/// Measures the memory of a crowd in which each whisker had `contacts` contacts. `done` is called after each robot.
#[must_use]
pub fn size(robots: usize, whiskers: u16, contacts: u32, done: &(dyn Fn() + Sync)) -> Size {
    let mut crowd = Crowd::new(robots, whiskers);
    crowd.learn(contacts, done);
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let of = |name: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(name));
        let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<u64>().ok());
        kib.map_or(0, |kib| 1024 * kib)
    };
    Size {
        whiskers: robots * usize::from(whiskers),
        resident_bytes: of("VmRSS:"),
        resident_max_bytes: of("VmHWM:"),
        stored_bytes_a_whisker: crowd.stored_bytes_a_whisker(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whisker_is_stored_in_two_kibibytes() {
        let mut crowd = Crowd::new(4, 24);
        for contacts in [40, 360, 1600] {
            crowd.learn(contacts, &|| ());
            let bytes = crowd.stored_bytes_a_whisker();
            assert!(bytes < 2048.0, "{bytes}");
        }
    }
}
