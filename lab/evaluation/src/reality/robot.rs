//! A robot with true whiskers, connected to the core by events, without messages.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::effect::{Command, CommandKey, Effect, TouchTest};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, ContactPlace, Distance, Factsheet, GaugeState, Link, MissedTouch, SetpointReport,
    Task, TestReport, TouchTests, WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, OperatorAction, Params, Place as At, Robot as Core};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

use super::air::Air;
use super::course::Course;
use super::nuisances::Nuisances;
use super::whisker::{Circumstances, MOUNTED_DEG, NOMINAL_MPA, Touch, Whisker, normal, stream};
use super::{RobotKind, StatedPlace};

/// Number of whiskers of a robot.
pub(super) const WHISKERS: usize = 6;
/// Names of the arrays; robots with one array use the first.
const ARRAYS: [&str; WHISKERS] = ["a", "b", "c", "d", "e", "f"];
const BOOT: &str = "b";
const START_US: u64 = 1_795_248_000_000_000;
/// Longest time that a message takes, s.
const LATE_MAX_S: f64 = 60.0;
const POST_STREAM: u64 = u64::MAX - 30;
/// Standard deviation of the error of a factory length, mm: 0.5 mm at 95 %, as a factsheet without a tolerance has it.
const WHOLE_SD_MM: f64 = 0.255;
const WHOLE_STREAM: u64 = u64::MAX - 40;
/// Time between two scheduled touch tests of a whisker: one hour.
const TESTED_EVERY: Micros = Micros(3_600_000_000);
/// Time between two statuses while the robot touches something, and while it does not, s.
const STATUS_S: (f64, f64) = (2.0, 10.0);
/// The same of a robot with a leak.
const LEAK_STATUS_S: (f64, f64) = (1.0, 1.0);

/// Arrays of a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Layout {
    /// One array, whose whiskers compensate for one another.
    Neighbours,
    /// One array, whose whiskers compensate for themselves.
    Together,
    /// Arrays of one whisker each: no other whisker tells what the array shares.
    Single,
}

impl Layout {
    /// All, in the order in which the robots of a row have them.
    pub(super) const ALL: [Self; 3] = [Self::Neighbours, Self::Together, Self::Single];

    /// Name of the array of a whisker, and its number there.
    fn place(self, number: usize) -> (&'static str, u16) {
        match self {
            Self::Neighbours | Self::Together => (ARRAYS[0], number as u16),
            Self::Single => (ARRAYS[number], 0),
        }
    }

    /// Whiskers that compensate for one another differ in length, and those that compensate for themselves do not.
    fn whole_mm(self, number: u64) -> f64 {
        match self {
            Self::Neighbours if number % 2 == 1 => 66.0,
            Self::Neighbours | Self::Together | Self::Single => 70.0,
        }
    }
}

/// A robot, its truth, and the core's state.
pub(super) struct Robot {
    place: StatedPlace,
    layout: Layout,
    /// The true whiskers.
    pub(super) whiskers: Vec<Whisker>,
    /// Chambers of the whiskers, in the same order.
    pub(super) air: Vec<Air>,
    /// Circumstances that its whiskers share.
    pub(super) course: Course,
    /// State of the robot in the core.
    pub(super) core: Core,
    /// Parameters of the core.
    pub(super) params: Params,
    /// Effects since they were last taken, except contacts and responses, each with its time since the installation, s.
    pub(super) kept_effects: Vec<(f64, Effect)>,
    /// Two whiskers that are connected to each other's amplifier.
    pub(super) exchanged: Option<(usize, usize)>,
    /// Setpoints that are on their way.
    moving: Vec<(usize, CommandKey)>,
    /// Share of the messages that come late, and those on their way: time of arrival, number, contacts.
    late: f64,
    on_way: Vec<(f64, u64, Vec<Contact<'static>>)>,
    post: ChaCha8Rng,
    /// Buffers for effects and for the next message, reused to save allocations.
    effects: Vec<Effect>,
    message: Vec<Contact<'static>>,
    seq: u64,
    /// Time since the installation, s.
    at_s: f64,
    /// Time of the next status, s.
    status_s: f64,
    /// Time between two statuses: short and long.
    every_s: (f64, f64),
}

/// A robot that can do touch tests also does them on a schedule: its habit may leave out the tips for days, and then there is
/// no silence to notice. Where contacts turn, the operator knows how far.
fn params(place: StatedPlace, nuisances: &Nuisances) -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    if nuisances.turn_deg > 0.0 {
        params.detection.contact_angle_deg_max = nuisances.turn_deg + MOUNTED_DEG;
    }
    if place == StatedPlace::DistanceTests {
        params.touch_tests.every = TESTED_EVERY;
    }
    params
}

impl Robot {
    /// A robot with whole whiskers, connected.
    #[must_use]
    pub(super) fn new(nuisances: Nuisances, kind: RobotKind, layout: Layout, seed: u64) -> Self {
        let place = kind.place;
        let numbers = 0..WHISKERS as u64;
        let params = params(place, &nuisances);
        let (_, designed) = &params.models[0];
        let mut robot = Self {
            place,
            layout,
            whiskers: numbers
                .clone()
                .map(|number| {
                    let off_mm = WHOLE_SD_MM * normal(&mut stream(seed, WHOLE_STREAM - number));
                    Whisker::new(designed, nuisances, layout.whole_mm(number) + off_mm, seed, number)
                })
                .collect(),
            air: numbers.map(|number| Air::new(&nuisances, seed, number)).collect(),
            course: Course::new(nuisances, seed),
            core: Core::new(1, Numbers::default()),
            params,
            kept_effects: Vec::new(),
            exchanged: None,
            moving: Vec::new(),
            late: nuisances.late,
            on_way: Vec::new(),
            post: stream(seed, POST_STREAM),
            effects: Vec::new(),
            message: Vec::new(),
            seq: 0,
            at_s: 0.0,
            status_s: 0.0,
            every_s: if nuisances.leak > 0.0 { LEAK_STATUS_S } else { STATUS_S },
        };
        robot.step(&Event::Connection { boot_id: BOOT, link: Link::Online });
        robot.step(&Event::Factsheet { boot_id: BOOT, factsheet: &factsheet(layout, kind) });
        robot
    }

    /// Each whisker makes one contact, and one message tells of all.
    pub(super) fn round(&mut self) {
        self.course.go_on();
        self.pass_until(self.course.now_s);
        let mut message = std::mem::take(&mut self.message);
        message.clear();
        let shared = Circumstances {
            habit: self.course.habit,
            warmer_k: self.course.warmer_k(),
            log_shift: self.course.log_shift,
            ratio_off: self.course.ratio_off,
            heading_deg: self.course.heading_deg,
            pause_s: self.course.pause_s,
            held_s: self.course.held_s,
            pressure_mpa: NOMINAL_MPA,
        };
        for number in 0..WHISKERS {
            let at = Circumstances { pressure_mpa: self.air[number].pressure_mpa(), ..shared };
            let pressure_mpa = self.air[number].reading_mpa();
            let touch = self.whiskers[number].touch_at(&at, self.place);
            message.extend(touch.map(|touch| self.contact(number, &touch, self.place, pressure_mpa)));
        }
        let seq = self.seq;
        self.seq += 1;
        if self.late > 0.0 && self.post.random::<f64>() < self.late {
            let arrives_s = self.at_s + LATE_MAX_S * self.post.random::<f64>();
            self.on_way.push((arrives_s, seq, message.clone()));
        } else {
            self.step(&Event::Contacts { boot_id: BOOT, seq, contacts: &message, missed: &[] });
        }
        self.message = message;
        let now_s = self.at_s;
        let arrived: Vec<_> = self.on_way.extract_if(.., |(at_s, _, _)| *at_s <= now_s).collect();
        for (_, seq, contacts) in arrived {
            self.step(&Event::Contacts { boot_id: BOOT, seq, contacts: &contacts, missed: &[] });
        }
    }

    /// The whisker as which the robot tells a touch.
    fn told_as(&self, number: usize) -> usize {
        match self.exchanged {
            Some((one, other)) if number == one => other,
            Some((one, other)) if number == other => one,
            Some(_) | None => number,
        }
    }

    /// A contact with a place as the robot can know it.
    fn contact(&self, number: usize, touch: &Touch, kind: StatedPlace, pressure_mpa: f64) -> Contact<'static> {
        let place = match kind {
            StatedPlace::Ratio | StatedPlace::RatioTests => {
                ContactPlace::Ratio { ratio: ContactRatio::known(touch.ratio), sd: None }
            }
            StatedPlace::Tip => ContactPlace::Tip(None),
            StatedPlace::Distance | StatedPlace::DistanceTests => {
                let at = Millimetre::known(touch.distance_mm);
                ContactPlace::Distance(Distance { at, sd_mm: self.whiskers[number].distance_sd_mm() })
            }
            StatedPlace::Unknown => ContactPlace::Unknown,
        };
        let (array, whisker) = self.layout.place(self.told_as(number));
        Contact {
            array,
            whisker,
            robot_time: self.now(),
            place,
            deflection: Millimetre::known(touch.deflection_mm),
            strain: Strain::known(touch.strain),
            pressure: Megapascal::known(pressure_mpa),
            is_test: false,
            angle_is_stated: false,
            saturated: false,
            temperature_c: Some(self.course.temperature_c()),
        }
    }

    /// Time passes, with statuses and answers to setpoints.
    fn pass_until(&mut self, until_s: f64) {
        let long = until_s - self.at_s > self.every_s.1;
        while self.status_s <= until_s {
            self.advance_to(self.status_s);
            self.status();
            self.status_s += if long { self.every_s.1 } else { self.every_s.0 };
        }
        self.advance_to(until_s);
    }

    fn advance_to(&mut self, until_s: f64) {
        let seconds = (until_s - self.at_s).max(0.0);
        self.at_s = until_s;
        for air in &mut self.air {
            air.advance(seconds);
        }
        let mut position = 0;
        while let Some(&(number, command)) = self.moving.get(position) {
            if self.air[number].is_settled() {
                self.moving.remove(position);
                let reached = Megapascal::known(self.air[number].reading_mpa());
                self.report(command, SetpointReport::Applied(reached));
            } else {
                position += 1;
            }
        }
    }

    fn status(&mut self) {
        let whiskers: [WhiskerStatus<'_>; WHISKERS] = std::array::from_fn(|number| {
            let (array, whisker) = self.layout.place(number);
            WhiskerStatus {
                array,
                whisker,
                pressure: Megapascal::known(self.air[number].reading_mpa()),
                setpoint: Megapascal::known(self.air[number].target_mpa()),
                regulator: self.air[number].condition(),
                gauge: GaugeState::Ok,
            }
        });
        let robot_time = self.now();
        self.step(&Event::Status { boot_id: BOOT, robot_time, whiskers: &whiskers });
        self.step(&Event::Tick);
    }

    /// An operator has found a whisker to be whole, whatever the supervisor says, and has it learned anew.
    pub(super) fn replaced(&mut self, number: usize) {
        let (array, whisker) = self.layout.place(number);
        let action = OperatorAction::Replaced(At { array, whisker });
        self.step(&Event::Operator(&action));
    }

    fn report(&mut self, command: CommandKey, report: SetpointReport) {
        let robot_time = self.now();
        self.step(&Event::Setpoint { boot_id: BOOT, command, report, robot_time });
    }

    fn now(&self) -> Micros {
        Micros(START_US + (1e6 * self.at_s) as u64)
    }

    /// Steps the core, and obeys its setpoints.
    fn step(&mut self, event: &Event<'_>) {
        let now = self.now();
        let mut effects = std::mem::take(&mut self.effects);
        self.core.step(&self.params, now, event, &mut effects);
        let first = self.kept_effects.len();
        let is_kept = |effect: &Effect| !matches!(effect, Effect::Contact(_) | Effect::Response(_));
        self.kept_effects.extend(effects.drain(..).filter(is_kept).map(|effect| (self.at_s, effect)));
        self.effects = effects;
        let new_effects = || self.kept_effects[first..].iter().map(|(_, effect)| effect);
        let commands: Vec<Command> = new_effects().filter_map(command_of).collect();
        let tests: Vec<TouchTest> = new_effects().filter_map(test_of).collect();
        for command in commands {
            self.obey(&command);
        }
        for test in tests {
            self.test(&test);
        }
    }

    /// Does a touch test at once, and reports it.
    fn test(&mut self, test: &TouchTest) {
        let number = test.whisker;
        let (array, whisker) = self.layout.place(number);
        let at = Circumstances {
            habit: self.course.habit,
            warmer_k: self.course.warmer_k(),
            log_shift: self.course.log_shift,
            ratio_off: self.course.ratio_off,
            heading_deg: self.course.heading_deg,
            pause_s: self.course.pause_s,
            held_s: self.course.held_s,
            pressure_mpa: self.air[number].pressure_mpa(),
        };
        let (mut contacts, mut missed) = (Vec::new(), Vec::new());
        for turn in 0..usize::from(test.contacts) {
            let distance_mm = test.distances_mm[turn % test.distances_mm.len()];
            let deflection_mm = test.deflections_mm[turn % test.deflections_mm.len()];
            if let Some(touch) = self.whiskers[number].touch_on_request(&at, distance_mm, deflection_mm) {
                let pressure_mpa = self.air[number].reading_mpa();
                contacts.push(Contact {
                    is_test: true,
                    ..self.contact(number, &touch, StatedPlace::Distance, pressure_mpa)
                });
            } else {
                let sd_mm = self.whiskers[number].distance_sd_mm();
                let at = Distance { at: Millimetre::known(distance_mm), sd_mm };
                missed.push(MissedTouch { array, whisker, robot_time: self.now(), at });
            }
        }
        let (seq, robot_time) = (self.seq, self.now());
        self.seq += 1;
        self.step(&Event::Contacts { boot_id: BOOT, seq, contacts: &contacts, missed: &missed });
        self.step(&Event::TouchTest { boot_id: BOOT, test: test.key, report: TestReport::Done, robot_time });
    }

    fn obey(&mut self, command: &Command) {
        let number = command.whisker;
        self.moving.retain(|&(other, _)| other != number);
        self.air[number].set(command.pressure.mpa(), command.slew_mpa_per_s);
        self.moving.push((number, command.key));
        self.report(command.key, SetpointReport::Received);
        self.report(command.key, SetpointReport::Applying);
    }
}

/// The touch test of an effect.
fn test_of(effect: &Effect) -> Option<TouchTest> {
    match effect {
        Effect::Test(test) => Some((**test).clone()),
        _ => None,
    }
}

/// The setpoint of an effect.
fn command_of(effect: &Effect) -> Option<Command> {
    match effect {
        Effect::Command(command) => Some((**command).clone()),
        // Each setpoint is answered at once, so none is sent twice.
        _ => None,
    }
}

fn factsheet(layout: Layout, RobotKind { place, applies_gain }: RobotKind) -> Factsheet {
    let sheet = |number: usize| {
        let is_neighbour = |other: &u16| layout != Layout::Single && usize::from(*other).abs_diff(number) == 1;
        WhiskerSheet {
            number: layout.place(number).1,
            x_mm: 25.0 * number as f64,
            y_mm: 0.0,
            model: "nguyen-2021".to_owned(),
            length: Millimetre::known(layout.whole_mm(number as u64)),
            pressure: Megapascal::known(NOMINAL_MPA),
            pressure_max: Megapascal::EXAMINED_MAX,
            length_tolerance_mm: 0.5,
            strain_max: None,
            neighbours: (0..WHISKERS as u16).filter(is_neighbour).collect(),
        }
    };
    let array = |(name, numbers): (&str, std::ops::Range<usize>)| ArraySheet {
        name: name.to_owned(),
        kind: if layout == Layout::Neighbours { ArrayKind::Type1 } else { ArrayKind::Type2 },
        task: if place.is_distance() { Task::Distance } else { Task::Ratio },
        whiskers: numbers.map(sheet).collect(),
    };
    let arrays = match layout {
        Layout::Neighbours | Layout::Together => vec![array((ARRAYS[0], 0..WHISKERS))],
        Layout::Single => (0..WHISKERS).map(|number| array((ARRAYS[number], number..number + 1))).collect(),
    };
    Factsheet {
        arrays,
        touch_tests: TouchTests { tip: false, wall: place.has_tests() },
        applies_gain,
        air_control: Default::default(),
    }
}
