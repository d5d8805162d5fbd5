//! What a store keeps of a robot is enough: every change is marked, and what happened since can be gone through again.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::robot::effect::{Command, Effect};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, Factsheet, GaugeState, Link, RegulatorState, SetpointReport, WhiskerSheet,
    WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, OperatorAction, Params, Place, Robot, Scope};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

const ARRAY: &str = "left";
const WHISKERS: u16 = 4;
/// A boot that others have followed does not come back.
const BOOTS: [&str; 16] =
    ["b0", "b1", "b2", "b3", "b4", "b5", "b6", "b7", "b8", "b9", "b10", "b11", "b12", "b13", "b14", "b15"];
const YEAR_US: u64 = 365 * 86_400 * 1_000_000;

/// What happens, to be told as often as needed.
#[derive(Debug, Clone)]
enum Said {
    Connection(usize, Link),
    Factsheet(usize),
    Contacts(usize, u64, Vec<Contact<'static>>),
    Status(usize, Micros, Vec<WhiskerStatus<'static>>),
    Setpoint(usize, Command, SetpointReport, Micros),
    Hold(bool, u16),
    Tick,
}

/// A robot with its whiskers in truth, which does not always keep to what robots should.
struct Plant {
    random: ChaCha8Rng,
    model: Model,
    lengths_mm: [f64; WHISKERS as usize],
    pressures: [Megapascal; WHISKERS as usize],
    dead_gauge: Option<u16>,
    boot: usize,
    next: [u64; BOOTS.len()],
    now: Micros,
    under_way: Vec<Command>,
}

impl Plant {
    fn new(seed: u64) -> Self {
        Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            model: Model::nguyen_2021(Formulation::Published),
            lengths_mm: [70.0, 68.0, 66.0, 70.0],
            pressures: [Megapascal::known(0.1); WHISKERS as usize],
            dead_gauge: None,
            boot: 0,
            next: [0; BOOTS.len()],
            now: Micros(1_795_248_000_000_000),
            under_way: Vec::new(),
        }
    }

    fn passes(&mut self, us: u64) {
        self.now = Micros(self.now.0 + us);
    }

    fn next(&mut self) -> Said {
        self.passes(20_000);
        match self.random.random_range(0..1000) {
            0..700 => self.contacts(),
            700..850 => self.status(),
            850..960 => {
                self.passes(250_000);
                Said::Tick
            }
            960..975 => self.answer(),
            975..978 => {
                let whisker = self.random.random_range(0..usize::from(WHISKERS));
                self.lengths_mm[whisker] = (self.lengths_mm[whisker] - 6.0).max(40.0);
                self.contacts()
            }
            978..982 => {
                self.dead_gauge = (self.dead_gauge.is_none()).then(|| self.random.random_range(0..WHISKERS));
                self.contacts()
            }
            982..986 => {
                self.passes(20_000_000);
                Said::Tick
            }
            // Longer than a gap may stay open while a robot is heard.
            986..988 => {
                self.passes(400_000_000);
                self.contacts()
            }
            988..992 => Said::Hold(self.random.random(), self.random.random_range(0..WHISKERS)),
            992..995 => {
                self.boot = (self.boot + 1).min(BOOTS.len() - 1);
                Said::Connection(self.boot, Link::Online)
            }
            995..996 => Said::Connection(self.boot, Link::Broken),
            996..998 => Said::Connection(self.boot, Link::Online),
            _ => Said::Factsheet(self.boot),
        }
    }

    fn contacts(&mut self) -> Said {
        let count = self.random.random_range(1..8);
        let contacts = (0..count).map(|_| self.contact()).collect();
        // Now and then of an older boot, again, or with a gap.
        let is_another = self.random.random_bool(0.02);
        let boot = if is_another { self.random.random_range(0..=self.boot + 1) % BOOTS.len() } else { self.boot };
        let seq = match self.random.random_range(0..40) {
            0 => self.next[boot].saturating_sub(self.random.random_range(1..6)),
            1 => self.next[boot] + 2,
            _ => self.next[boot],
        };
        self.next[boot] = self.next[boot].max(seq + 1);
        Said::Contacts(boot, seq, contacts)
    }

    fn contact(&mut self) -> Contact<'static> {
        self.passes(2_000);
        let whisker = self.random.random_range(0..WHISKERS);
        let at = usize::from(whisker);
        let ratio = ContactRatio::known(self.random.random_range(0.5..=1.0));
        let deflection_mm: f64 = self.random.random_range(0.5..5.0);
        let pressure = self.pressures[at];
        let length = Millimetre::known(self.lengths_mm[at]);
        let per_mm = self.model.sensitivity_per_mm(ratio, length, &self.model.morphology(pressure)).unwrap();
        let noise: f64 = 1.0 + self.random.random_range(-0.05..0.05);
        let strain = if self.dead_gauge == Some(whisker) { 0.0 } else { per_mm * deflection_mm * noise };
        Contact {
            array: ARRAY,
            whisker: if self.random.random_bool(0.002) { 99 } else { whisker },
            robot_time: self.time(),
            ratio,
            deflection: Millimetre::known(deflection_mm),
            strain: Strain::known(strain),
            pressure,
        }
    }

    fn status(&mut self) -> Said {
        self.passes(500_000);
        let strange = self.random.random_range(0..200);
        let whiskers = (0..WHISKERS).map(|whisker| {
            let setpoint = self.pressures[usize::from(whisker)];
            let is_strange = strange == u32::from(whisker);
            WhiskerStatus {
                array: ARRAY,
                whisker,
                pressure: if strange == 10 { Megapascal::known(0.07) } else { setpoint },
                setpoint: if is_strange { Megapascal::known(0.13) } else { setpoint },
                regulator: if strange == 11 { RegulatorState::Leak } else { RegulatorState::Ok },
                gauge: GaugeState::Ok,
            }
        });
        let whiskers = whiskers.collect();
        Said::Status(self.boot, self.time(), whiskers)
    }

    /// Now and then a wrong one.
    fn time(&mut self) -> Micros {
        match self.random.random_range(0..200) {
            0 => Micros(self.now.0 + YEAR_US),
            1 => Micros(self.now.0 - YEAR_US),
            2 => Micros(self.now.0 + 23_000_000),
            _ => self.now,
        }
    }

    fn answer(&mut self) -> Said {
        if self.under_way.is_empty() {
            return Said::Tick;
        }
        let command = self.under_way.remove(0);
        let report = match self.random.random_range(0..8) {
            0 => SetpointReport::Failed,
            1 => SetpointReport::Received,
            _ => {
                self.pressures[command.whisker] = command.pressure;
                SetpointReport::Applied(command.pressure)
            }
        };
        Said::Setpoint(self.boot, command, report, self.now)
    }
}

fn params() -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    params
}

fn factsheet() -> Factsheet {
    let whisker = |number: u16| WhiskerSheet {
        number,
        x_mm: 25.0 * f64::from(number),
        y_mm: 0.0,
        model: "nguyen-2021".into(),
        length: Millimetre::known([70.0, 68.0, 66.0, 70.0][usize::from(number)]),
        pressure: Megapascal::known(0.1),
        pressure_max: Megapascal::EXAMINED_MAX,
        neighbours: (0..WHISKERS).filter(|other| other.abs_diff(number) == 1).collect(),
    };
    let whiskers = (0..WHISKERS).map(whisker).collect();
    Factsheet { arrays: vec![ArraySheet { name: ARRAY.to_owned(), kind: ArrayKind::Type1, whiskers }] }
}

/// Steps a robot; what came of it, but for what is not stored: when the factsheet was asked for.
fn step(robot: &mut Robot, params: &Params, now: Micros, said: &Said) -> Vec<Effect> {
    let mut effects = Vec::new();
    let mut tell = |event: &Event<'_>| robot.step(params, now, event, &mut effects);
    match said {
        Said::Connection(boot, link) => tell(&Event::Connection { boot_id: BOOTS[*boot], link: *link }),
        Said::Factsheet(boot) => tell(&Event::Factsheet { boot_id: BOOTS[*boot], factsheet: &factsheet() }),
        Said::Contacts(boot, seq, contacts) => tell(&Event::Contacts { boot_id: BOOTS[*boot], seq: *seq, contacts }),
        Said::Status(boot, robot_time, whiskers) => {
            tell(&Event::Status { boot_id: BOOTS[*boot], robot_time: *robot_time, whiskers })
        }
        Said::Setpoint(boot, command, report, robot_time) => {
            let (boot_id, report, robot_time) = (BOOTS[*boot], *report, *robot_time);
            tell(&Event::Setpoint { boot_id, command: command.key, report, robot_time })
        }
        Said::Hold(holds, whisker) => {
            let scope = Scope::Whisker(Place { array: ARRAY, whisker: *whisker });
            let action = if *holds { OperatorAction::Hold(scope) } else { OperatorAction::Release(scope) };
            tell(&Event::Operator(&action))
        }
        Said::Tick => tell(&Event::Tick),
    };
    effects.retain(|effect| *effect != Effect::AskForFactsheet);
    effects
}

/// As a store would: what is marked is written.
#[derive(Debug, Clone, PartialEq, Default)]
struct Store {
    head: Vec<u8>,
    whiskers: Vec<Vec<u8>>,
}

impl Store {
    fn write(&mut self, robot: &mut Robot) {
        let changed = robot.has_changed();
        let (mut indices, head) = (Vec::new(), robot.take_changed());
        robot.take_changed_whiskers(|index| indices.push(index));
        assert_eq!(changed, head || !indices.is_empty());
        assert!(!robot.has_changed());
        if head {
            self.head = robot.to_bytes().unwrap();
        }
        self.whiskers.resize(robot.whisker_count(), Vec::new());
        for index in indices {
            self.whiskers[index] = robot.whisker_to_bytes(index).unwrap();
        }
    }

    fn all_of(robot: &Robot) -> Self {
        let whiskers = (0..robot.whisker_count()).map(|index| robot.whisker_to_bytes(index).unwrap()).collect();
        Self { head: robot.to_bytes().unwrap(), whiskers }
    }

    /// Where it differs from another: the whisker, or none for the head, and the byte.
    fn first_difference(&self, other: &Self) -> Option<(Option<usize>, usize)> {
        let byte = |one: &[u8], other: &[u8]| {
            let differs = one.iter().zip(other).position(|(one, other)| one != other);
            differs.or((one.len() != other.len()).then_some(one.len().min(other.len())))
        };
        let whiskers = self.whiskers.iter().zip(&other.whiskers).enumerate();
        let of_head = byte(&self.head, &other.head).map(|at| (None, at));
        of_head.or(whiskers.filter_map(|(index, (one, other))| Some((Some(index), byte(one, other)?))).next())
    }
}

/// One life of a robot, with every step written as a store would.
struct Life {
    params: Params,
    told: Vec<(Micros, Said)>,
    effects: Vec<Vec<Effect>>,
    /// After each event.
    stored: Vec<Store>,
}

impl Life {
    fn new(seed: u64, events: usize) -> Self {
        let (mut plant, params) = (Plant::new(seed), params());
        let mut robot = Robot::new(1, Numbers::default());
        let mut life = Self { params, told: Vec::new(), effects: Vec::new(), stored: Vec::new() };
        let mut store = Store::default();
        let born = [Said::Connection(0, Link::Online), Said::Factsheet(0)];
        for at in 0..events {
            let said = born.get(at).cloned().unwrap_or_else(|| plant.next());
            let effects = step(&mut robot, &life.params, plant.now, &said);
            plant.under_way.extend(effects.iter().filter_map(|effect| match effect {
                Effect::Command(command) => Some((**command).clone()),
                _ => None,
            }));
            store.write(&mut robot);
            let unmarked = store.first_difference(&Store::all_of(&robot));
            assert_eq!(unmarked, None, "seed {seed}: a change by event {at} is not marked: {said:?}");
            life.told.push((plant.now, said));
            life.effects.push(effects);
            life.stored.push(store.clone());
        }
        life
    }

    /// From what was stored after event `from`, everything since once more.
    fn again_from(&self, from: usize) {
        let Store { head, whiskers } = &self.stored[from];
        let mut robot = Robot::restore(head, whiskers).unwrap();
        assert_eq!(Store::all_of(&robot), self.stored[from]);
        for at in from + 1..self.told.len() {
            let (now, said) = &self.told[at];
            assert_eq!(
                step(&mut robot, &self.params, *now, said),
                self.effects[at],
                "from {from}, event {at}: {said:?}"
            );
            let differs = Store::all_of(&robot).first_difference(&self.stored[at]);
            assert_eq!(differs, None, "from {from}, event {at}: {said:?}");
        }
    }
}

/// Lives in which whiskers are cut and served, gauges fail, messages are missed and come again, and robots start anew.
#[test]
fn property_every_change_is_marked_and_what_was_stored_goes_on_as_it_did() {
    let mut kinds = [0_usize; 5];
    for seed in 0..12 {
        let life = Life::new(seed, 1500);
        for effect in life.effects.iter().flatten() {
            let kind = match effect {
                Effect::Trim(_) => 0,
                Effect::Command(_) => 1,
                Effect::Fault { .. } => 2,
                Effect::Ended { .. } => 3,
                Effect::Alarm { .. } => 4,
                _ => continue,
            };
            kinds[kind] += 1;
        }
        for from in [1, 200 + 37 * seed as usize, 1200] {
            life.again_from(from);
        }
    }
    assert!(kinds.iter().all(|&count| count > 5), "lives are eventful: {kinds:?}");
}

/// Time alone tells silence, also after contacts: a robot that looks at its whiskers only when something can have
/// come about says the same as one that was just restored, which looks at all of them.
#[test]
fn property_a_tick_with_nothing_to_do_says_what_a_full_look_says() {
    for seed in 100..106 {
        let life = Life::new(seed, 600);
        for at in (1..life.told.len()).filter(|&at| matches!(life.told[at].1, Said::Tick)) {
            let Store { head, whiskers } = &life.stored[at - 1];
            let mut robot = Robot::restore(head, whiskers).unwrap();
            let (now, said) = &life.told[at];
            assert_eq!(step(&mut robot, &life.params, *now, said), life.effects[at], "seed {seed}, event {at}");
        }
    }
}

/// The parts of robots that version 4 of the state stored; they were written by the program of then.
fn parts_of(mut bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut parts = Vec::new();
    while let Some((length, rest)) = bytes.split_first_chunk() {
        let (part, rest) = rest.split_at(u32::from_le_bytes(*length) as usize);
        parts.push(part.to_vec());
        bytes = rest;
    }
    parts
}

/// Two robots of then, each with its parts.
fn of_version_4() -> Vec<Vec<Vec<u8>>> {
    let parts = parts_of(include_bytes!("../../data/state-4/robots.bin"));
    parts.chunks(1 + usize::from(WHISKERS)).map(<[_]>::to_vec).collect()
}

/// Describes the parts of a robot's state that existed in that version.
fn told_of(robot: &Robot) -> String {
    let mut told = format!("{:?}\n", robot.connection_state());
    BOOTS[..3].iter().for_each(|boot| told += &format!("{:?}\n", robot.sequence(boot)));
    told += &format!("{:?}\n{:#?}\n", robot.arrays().collect::<Vec<_>>(), robot.compensations());
    told += &format!("{:#?}\n", robot.commands_under_way().collect::<Vec<_>>());
    (0..robot.whisker_count()).for_each(|index| told += &format!("{:#?}\n", robot.whisker(index).unwrap()));
    told
}

#[test]
fn golden_robots_of_version_4_lose_nothing_that_was_learned() {
    let mut told = String::new();
    for parts in of_version_4() {
        let (head, whiskers) = (&parts[0], &parts[1..]);
        let robot = Robot::restore(head, whiskers).unwrap();
        told += &told_of(&robot);
        let Store { head: now, whiskers: same } = Store::all_of(&robot);
        let is_only_marked = same.iter().zip(whiskers).all(|(now, then)| now[2..] == then[..]);
        assert!(is_only_marked, "whiskers are stored as they were, with the version in two bytes before them");
        assert_eq!((head[0], now[0]), (4, 5));
        assert_eq!(Robot::restore(&now, &same).unwrap(), robot);
    }
    let expected = include_str!("../../data/state-4/robots.txt");
    let differs = told.lines().zip(expected.lines()).find(|(told, expected)| told != expected);
    assert_eq!((differs, told.len()), (None, expected.len()));
}

#[test]
fn a_robot_of_version_4_goes_on_once_it_has_said_its_time_again() {
    let parts = &of_version_4()[0];
    let mut robot = Robot::from_bytes(&parts[0], &parts[1..], 2, Micros(1_795_260_000_000_000)).unwrap();
    let (boot_id, now) = (robot.connection_state().0.unwrap().to_owned(), Micros(1_795_260_001_000_000));
    let mut effects = Vec::new();
    let mut step = |event: &Event<'_>| robot.step(&params(), now, event, &mut effects);
    step(&Event::Connection { boot_id: &boot_id, link: Link::Online });
    let whisker = Place { array: ARRAY, whisker: 3 };
    let by_hand = Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.05 });
    assert!(matches!(step(&by_hand), vibrissa_core::robot::Outcome::Refused(_)), "its clock is not known");
    step(&Event::Status { boot_id: &boot_id, robot_time: now, whiskers: &[] });
    step(&by_hand);
    step(&Event::Tick);
    let sent = effects.iter().find_map(|effect| match effect {
        Effect::Command(command) if command.whisker == 3 => Some(command),
        _ => None,
    });
    let left_s = Micros(sent.expect("a setpoint").expires.0 - now.0).as_s();
    assert!((10.0..15.0).contains(&left_s), "{left_s} s");
}

/// An earlier version could learn such a length from contacts. A stored NaN cannot occur.
#[test]
fn regress_a_whisker_whose_stored_length_is_infinite_is_learned_anew() {
    let mut parts = of_version_4().swap_remove(0);
    let whole = Robot::restore(&parts[0], &parts[1..]).unwrap();
    let view = whole.whisker(0).unwrap();
    assert!(view.contacts > 0);
    let log_length = (view.length.length.mm() / view.sheet.length.mm()).ln() as f32;
    let places: Vec<usize> =
        (0..parts[1].len() - 4).filter(|&at| parts[1][at..at + 4] == log_length.to_le_bytes()).collect();
    let [at] = places[..] else { panic!("the filter's log length {log_length} is at {places:?}") };
    parts[1][at..at + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    let mut robot = Robot::restore(&parts[0], &parts[1..]).unwrap();
    let view = robot.whisker(0).unwrap();
    assert_eq!((view.length.length.mm(), view.contacts), (view.sheet.length.mm(), 0));
    assert!(view.length.sd_mm.is_finite() && !format!("{robot:?}").contains("inf,"));
    let mut changed = Vec::new();
    robot.take_changed_whiskers(|index| changed.push(index));
    assert_eq!(changed, [0], "what is stored is written anew");
    assert_eq!(robot.whisker(1).unwrap(), whole.whisker(1).unwrap());
}
