//! An array of whiskers whose noise is not the ideal world's, connected directly to the core.
//!
//! The plant shares nothing with the simulator: each whisker has its own calibration, and a contact is a true ratio and
//! deflection, a strain with all nuisances, and the readings that the robot makes of them. Setpoints are applied at once.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use vibrissa_core::mechanics::{CONTACT_RATIOS, Calibration, Formulation, Geometry, Model};
use vibrissa_core::robot::effect::{AlarmKind, Command, Condition, Effect, TouchTest, Trim};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, ContactPlace, Distance, Factsheet, GaugeState, Link, RegulatorState,
    SetpointReport, Task, TouchTests, WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, Outcome, Params, Robot, WhiskerView};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

pub(crate) const ARRAY: &str = "a";
pub(super) const BOOT: &str = "b";
const CONTACT_US: u64 = 20_000;
const START_US: u64 = 1_000_000_000_000;
/// Rounds between two statuses.
const STATUS_ROUNDS: u64 = 50;
const WHOLE_MM: f64 = 70.0;
/// Temperature at installation.
const COOL_C: f64 = 22.0;

/// Habits of the robot and noise of its readings, as standard deviations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Noise {
    /// Range of the true contact ratios.
    pub ratios: (f64, f64),
    /// Range of the true deflections, mm.
    pub deflections_mm: (f64, f64),
    /// Independent noise of the strain, relative.
    pub strain: f64,
    /// Noise of the read deflection, relative.
    pub deflection: f64,
    /// Noise of the read contact ratio, absolute.
    pub ratio: f64,
    /// Noise of the strain that hangs together: its correlation from contact to contact, and its size, relative.
    pub correlated: (f64, f64),
    /// Share of contacts with ten times the independent noise.
    pub outliers: f64,
    /// Nonlinearity: change of log sensitivity per mm of deflection.
    pub bend_per_mm: f64,
    /// Error that all contact ratios of the robot share.
    pub ratio_off: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self {
            ratios: (0.45, 1.0),
            deflections_mm: (0.5, 6.0),
            strain: 0.02,
            deflection: 0.01,
            ratio: 0.01,
            correlated: (0.0, 0.0),
            outliers: 0.0,
            bend_per_mm: 0.0,
            ratio_off: 0.0,
        }
    }
}

/// The truth about one whisker.
pub(crate) struct Rubber {
    model: Model,
    /// Present length, mm.
    pub length_mm: f64,
    /// Factor on its strain: gauge, rubber.
    pub gain: f64,
    /// Angle of its contacts to the plane of its gauge, degrees.
    pub angle_deg: f64,
    /// Strain that its gauge reads without a contact.
    pub baseline_strain: f64,
    /// Change of its log sensitivity per K, from [`COOL_C`] on.
    pub per_k: f64,
    /// Present pressure of its chamber.
    pub pressure: Megapascal,
    /// Gain by contact ratio that was published with its last setpoint.
    pub published: Option<[f64; CONTACT_RATIOS.len()]>,
    /// Pressure that its sensor reads in a status, if another one.
    pub read: Option<Megapascal>,
    /// It is touched in each of so many rounds; 0: never.
    pub every: u64,
    correlated: f64,
}

/// The array, and the core that supervises it.
pub(crate) struct Rig {
    pub core: Robot,
    pub params: Params,
    pub whiskers: Vec<Rubber>,
    pub noise: Noise,
    /// Temperature that the robot reports, and the whiskers have.
    pub temperature_c: f64,
    /// Effects, each with the round in which it came, except single contacts and responses.
    pub effects: Vec<(u64, Effect)>,
    /// Rounds so far: contacts of each whisker.
    pub rounds: u64,
    /// The robot's answer to touch tests.
    pub(super) tests: Tests,
    /// The robot's distances are short by this, mm.
    pub(super) off_mm: f64,
    /// Its contacts state distances from the base, and no ratios.
    pub(crate) states_distance: bool,
    /// Its contacts state their angle to the plane of the gauge, and the strain is that in the plane.
    pub(crate) states_angle: bool,
    under_way: Vec<Command>,
    requested: Vec<TouchTest>,
    pub(super) random: ChaCha8Rng,
}

/// A robot's answer to a request of a touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Tests {
    /// Its factsheet offers none.
    NotOffered,
    /// It presses against a wall.
    Does,
    /// It sweeps the whisker over an object, up to the tip.
    Sweeps,
    Rejects,
    /// It says that they are done, and sends no touch.
    Empty,
    /// It never answers.
    Ignores,
}

impl Rig {
    /// Whiskers of 70 mm, each with a calibration up to 3 % off. The robot offers no touch tests.
    pub(crate) fn new(seed: u64, whiskers: usize) -> Self {
        Self::with_tests(seed, whiskers, Tests::NotOffered)
    }

    /// The same with a robot that offers touch tests.
    pub(crate) fn with_tests(seed: u64, whiskers: usize, tests: Tests) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let whiskers: Vec<Rubber> = (0..whiskers).map(|_| Rubber::new(&mut random)).collect();
        let params = Params::nguyen_2021(Formulation::Published);
        let core = Robot::new(1, Numbers::default());
        let (effects, under_way) = (Vec::new(), Vec::new());
        let mut rig = Self {
            core,
            params,
            whiskers,
            noise: Noise::default(),
            temperature_c: COOL_C,
            effects,
            rounds: 0,
            tests,
            off_mm: 0.0,
            states_distance: false,
            states_angle: false,
            under_way,
            requested: Vec::new(),
            random,
        };
        rig.step(&Event::Connection { boot_id: BOOT, link: Link::Online });
        let sheet = |number: u16| WhiskerSheet {
            number,
            x_mm: 25.0 * f64::from(number),
            y_mm: 0.0,
            model: "nguyen-2021".to_owned(),
            length: Millimetre::known(WHOLE_MM),
            pressure: Megapascal::known(0.1),
            pressure_max: Megapascal::EXAMINED_MAX,
            length_tolerance_mm: 0.5,
            strain_max: None,
            neighbours: Vec::new(),
        };
        let whiskers = (0..rig.whiskers.len() as u16).map(sheet).collect();
        let array = ArraySheet { name: ARRAY.to_owned(), kind: ArrayKind::Type2, task: Task::Ratio, whiskers };
        rig.step(&Event::Factsheet {
            boot_id: BOOT,
            factsheet: &Factsheet {
                arrays: vec![array],
                touch_tests: TouchTests {
                    tip: tests == Tests::Sweeps,
                    wall: !matches!(tests, Tests::NotOffered | Tests::Sweeps),
                },
                applies_gain: false,
                air_control: Default::default(),
            },
        });
        rig.status();
        rig
    }

    pub(super) fn now(&self) -> Micros {
        Micros(START_US + CONTACT_US * self.rounds)
    }

    pub(crate) fn step(&mut self, event: &Event<'_>) {
        self.tested(event);
    }

    /// Takes an event in, and keeps its effects.
    pub(super) fn tested(&mut self, event: &Event<'_>) -> Outcome {
        let mut effects = Vec::new();
        let outcome = self.core.step(&self.params, self.now(), event, &mut effects);
        for effect in effects {
            if let Effect::Command(command) | Effect::Resend(command) = &effect {
                self.under_way.push((**command).clone());
            }
            if let Effect::Test(test) = &effect {
                self.requested.push((**test).clone());
            }
            if !matches!(effect, Effect::Contact(_) | Effect::Response(_)) {
                self.effects.push((self.rounds, effect));
            }
        }
        outcome
    }

    fn status(&mut self) {
        let entry = |(one, whisker): (&Rubber, u16)| WhiskerStatus {
            array: ARRAY,
            whisker,
            pressure: one.read.unwrap_or(one.pressure),
            setpoint: one.pressure,
            regulator: RegulatorState::Ok,
            gauge: GaugeState::Ok,
        };
        let whiskers: Vec<WhiskerStatus<'_>> = self.whiskers.iter().zip(0..).map(entry).collect();
        self.step(&Event::Status { boot_id: BOOT, robot_time: self.now(), whiskers: &whiskers });
        self.step(&Event::Tick);
    }

    /// A second without contacts, and a status.
    pub(crate) fn wait_1_s(&mut self) {
        self.rounds += STATUS_ROUNDS;
        self.status();
    }

    /// Each whisker that is touched in each round has this many contacts, in turn. `before` is called before each round, with its number.
    pub(crate) fn run_with(&mut self, rounds: u64, mut before: impl FnMut(&mut Self)) {
        for _ in 0..rounds {
            before(self);
            let rounds = self.rounds;
            let is_touched = |one: &Rubber| one.every > 0 && rounds.is_multiple_of(one.every);
            let touched: Vec<usize> =
                (0..self.whiskers.len()).filter(|&index| is_touched(&self.whiskers[index])).collect();
            let contacts: Vec<Contact<'static>> = touched.into_iter().map(|index| self.contact(index)).collect();
            let seq = self.rounds;
            self.rounds += 1;
            self.step(&Event::Contacts { boot_id: BOOT, seq, contacts: &contacts, missed: &[] });
            for command in std::mem::take(&mut self.under_way) {
                self.whiskers[command.whisker].pressure = command.pressure;
                self.whiskers[command.whisker].published = command.gain;
                let (command, report) = (command.key, SetpointReport::Applied(command.pressure));
                self.step(&Event::Setpoint { boot_id: BOOT, command, report, robot_time: self.now() });
            }
            for test in std::mem::take(&mut self.requested) {
                self.answer(&test);
            }
            if self.rounds.is_multiple_of(STATUS_ROUNDS) {
                self.status();
            }
        }
    }

    /// Each whisker has this many contacts, in turn.
    pub(crate) fn run(&mut self, rounds: u64) {
        self.run_with(rounds, |_| ());
    }

    fn contact(&mut self, index: usize) -> Contact<'static> {
        self.contact_at(index, None)
    }

    /// A contact at a true ratio to the present length, or where the robot's habit has it.
    pub(super) fn contact_at(&mut self, index: usize, ratio: Option<f64>) -> Contact<'static> {
        let Self { noise, random, whiskers, temperature_c, off_mm, states_distance, states_angle, .. } = self;
        let one = &mut whiskers[index];
        let mut normal = || -> f64 { StandardNormal.sample(random) };
        let [strain_noise, deflection_noise, ratio_noise, fresh] = std::array::from_fn(|_| normal());
        let usual = random.random_range(noise.ratios.0..=noise.ratios.1);
        let ratio = ratio.unwrap_or(usual);
        let deflection_mm = random.random_range(noise.deflections_mm.0..=noise.deflections_mm.1);
        let outlier = if random.random::<f64>() < noise.outliers { 10.0 } else { 1.0 };
        let (keeps, size) = noise.correlated;
        one.correlated = keeps * one.correlated + size * (1.0 - keeps * keeps).sqrt() * fresh;
        let morphology = one.model.morphology(one.pressure);
        let (length, true_ratio) = (Millimetre::known(one.length_mm), ContactRatio::known(ratio));
        let per_mm = one.model.sensitivity_per_mm(true_ratio, length, &morphology).expect("beyond the chamber");
        let warm = one.per_k * (*temperature_c - COOL_C);
        let in_plane = if *states_angle { 1.0 } else { one.angle_deg.to_radians().cos() };
        let log_noise = noise.strain * outlier * strain_noise + one.correlated + noise.bend_per_mm * deflection_mm;
        let read_ratio = ratio + noise.ratio_off + noise.ratio * ratio_noise;
        let place = if *states_distance {
            let at = Millimetre::known(read_ratio * one.length_mm - *off_mm);
            ContactPlace::Distance(Distance { at, sd_mm: noise.ratio * WHOLE_MM })
        } else {
            ContactPlace::Ratio { ratio: ContactRatio::known(read_ratio.clamp(0.05, 1.0)), sd: None }
        };
        Contact {
            array: ARRAY,
            whisker: index as u16,
            robot_time: Micros(START_US + CONTACT_US * self.rounds),
            place,
            deflection: Millimetre::known(deflection_mm * (1.0 + noise.deflection * deflection_noise)),
            strain: Strain::known(
                per_mm * deflection_mm * in_plane * one.gain * (log_noise + warm).exp() + one.baseline_strain,
            ),
            pressure: one.pressure,
            is_test: false,
            angle_is_stated: *states_angle,
            saturated: false,
            temperature_c: Some(*temperature_c),
        }
    }

    /// A whisker as the core sees it.
    pub(crate) fn view(&self, index: usize) -> WhiskerView<'_> {
        self.core.whisker(index).expect("a whisker")
    }

    /// Mean error of a whisker's readings with the published gain, against itself while whole, as a ratio.
    pub(crate) fn reading_error(&self, index: usize) -> f64 {
        let one = &self.whiskers[index];
        let gains = one.published.unwrap_or([1.0; CONTACT_RATIOS.len()]);
        let errors: Vec<f64> = CONTACT_RATIOS
            .into_iter()
            .zip(gains)
            .filter_map(|(a, gain)| {
                let ratio = ContactRatio::known(a);
                let per_mm = |length_mm: f64, pressure: Megapascal| {
                    let morphology = one.model.morphology(pressure);
                    one.model.sensitivity_per_mm(ratio, Millimetre::known(length_mm), &morphology).ok()
                };
                let whole = per_mm(WHOLE_MM, Megapascal::known(0.1))?;
                Some((one.gain * gain * per_mm(one.length_mm, one.pressure)? / whole - 1.0).abs())
            })
            .collect();
        errors.iter().sum::<f64>() / errors.len() as f64
    }

    /// The effects that `pick` selects, each with its round.
    pub(crate) fn picked<T>(&self, pick: impl Fn(&Effect) -> Option<T>) -> Vec<(u64, T)> {
        self.effects.iter().filter_map(|(round, effect)| Some((*round, pick(effect)?))).collect()
    }

    /// All trims, each with its round.
    pub(crate) fn trims(&self) -> Vec<(u64, Trim)> {
        self.picked(|effect| if let Effect::Trim(trim) = effect { Some(*trim) } else { None })
    }

    /// Whiskers that were called anything but healthy or suspected, with the round and the condition.
    pub(crate) fn verdicts(&self) -> Vec<(u64, (usize, Condition))> {
        self.picked(|effect| match effect {
            Effect::Condition { whisker, to, .. } if !matches!(to, Condition::Healthy | Condition::Suspected) => {
                Some((*whisker, *to))
            }
            _ => None,
        })
    }

    /// All conditions that whiskers came to, in order.
    pub(crate) fn conditions(&self) -> Vec<Condition> {
        self.picked(|effect| if let Effect::Condition { to, .. } = effect { Some(*to) } else { None })
            .into_iter()
            .map(|(_, to)| to)
            .collect()
    }

    /// All alarms of a kind, by round and whisker.
    pub(crate) fn alarms(&self, wanted: AlarmKind) -> Vec<(u64, usize)> {
        self.picked(|effect| match effect {
            Effect::Alarm { whisker, kind } if *kind == wanted => Some(*whisker),
            _ => None,
        })
    }
}

impl Rubber {
    fn new(random: &mut ChaCha8Rng) -> Self {
        let built_in = Calibration::nguyen_2021();
        let mut by = |value: f64| value * (1.0 + random.random_range(-0.03..=0.03));
        let calibration = Calibration {
            c: by(built_in.c),
            a: by(built_in.a),
            b_per_mpa: by(built_in.b_per_mpa),
            elongation_gain_mm: by(built_in.elongation_gain_mm),
            ..built_in
        };
        let formulation = if random.random() { Formulation::Published } else { Formulation::Consistent };
        let model = Model::new(Geometry::nguyen_2021(), calibration, formulation).expect("a whisker");
        Self {
            model,
            length_mm: WHOLE_MM,
            gain: 1.0,
            angle_deg: 0.0,
            baseline_strain: 0.0,
            per_k: 0.0,
            pressure: Megapascal::known(0.1),
            published: None,
            read: None,
            every: 1,
            correlated: 0.0,
        }
    }
}
