//! The stored parts of a robot are complete: every change of them is marked, and a restored robot goes on alike.
//!
//! The robots of these tests live through every kind of event that [`KINDS`] lists. The list is closed: a new variant
//! of an event, an action or a report does not compile before it is listed, and a listed one must be played.

use std::collections::BTreeMap;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::policy::Mode;
use vibrissa_core::robot::effect::{Command, Effect};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, Factsheet, GaugeState, Link, RegulatorState, Rejection, SetpointReport,
    WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, OperatorAction, Outcome, Params, Place, Robot, Scope};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

const ARRAY: &str = "left";
const WHISKERS: u16 = 4;
/// A boot that others have followed does not come back.
const BOOTS: [&str; 16] =
    ["b0", "b1", "b2", "b3", "b4", "b5", "b6", "b7", "b8", "b9", "b10", "b11", "b12", "b13", "b14", "b15"];
const YEAR_US: u64 = 365 * 86_400 * 1_000_000;

/// Lists patterns that cover a type, each with a name: a pattern that is missing does not compile.
macro_rules! closed_list {
    ($all:ident, $name_of:ident($type:ty): $($pattern:pat => $name:literal,)*) => {
        const $all: &[&str] = &[$($name),*];

        fn $name_of(one: &$type) -> &'static str {
            match one {
                $($pattern => $name,)*
            }
        }
    };
}

closed_list! {
    KINDS, kind_of(Event<'_>):
    Event::Connection { link: Link::Online, .. } => "online",
    Event::Connection { link: Link::Offline, .. } => "offline",
    Event::Connection { link: Link::Broken, .. } => "broken",
    Event::Factsheet { .. } => "factsheet",
    Event::Contacts { .. } => "contacts",
    Event::Status { .. } => "status",
    Event::Setpoint { report: SetpointReport::Received, .. } => "received",
    Event::Setpoint { report: SetpointReport::Applying, .. } => "applying",
    Event::Setpoint { report: SetpointReport::Applied(_), .. } => "applied",
    Event::Setpoint { report: SetpointReport::Failed, .. } => "failed",
    Event::Setpoint { report: SetpointReport::Superseded, .. } => "superseded",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::Stale), .. } => "rejected: stale",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::Expired), .. } => "rejected: expired",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::OutOfRange), .. } => "rejected: out of range",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::UnknownWhisker), .. } => "rejected: unknown whisker",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::WrongBoot), .. } => "rejected: wrong boot",
    Event::Setpoint { report: SetpointReport::Rejected(Rejection::NotReady), .. } => "rejected: not ready",
    Event::Operator(OperatorAction::Approve { .. }) => "approve",
    Event::Operator(OperatorAction::Refuse { .. }) => "refuse",
    Event::Operator(OperatorAction::Setpoint { .. }) => "setpoint by hand",
    Event::Operator(OperatorAction::Hold(Scope::Robot)) => "hold robot",
    Event::Operator(OperatorAction::Hold(Scope::Whisker(_))) => "hold whisker",
    Event::Operator(OperatorAction::Release(Scope::Robot)) => "release robot",
    Event::Operator(OperatorAction::Release(Scope::Whisker(_))) => "release whisker",
    Event::Operator(OperatorAction::Replaced(_)) => "replaced",
    Event::Operator(OperatorAction::Rebaseline(_)) => "rebaseline",
    Event::PolicyChanged => "policy changed",
    Event::Tick => "tick",
}

closed_list! {
    EFFECTS, effect_of(Effect):
    Effect::Contact(_) => "contact",
    Effect::UnknownWhisker { .. } => "unknown whisker",
    Effect::BadTime { .. } => "bad time",
    Effect::Condition { .. } => "condition",
    Effect::Fault { .. } => "fault",
    Effect::Trim(_) => "trim",
    Effect::Decided(_) => "decided",
    Effect::Ended { .. } => "ended",
    Effect::Command(_) => "command",
    Effect::Resend(_) => "resend",
    Effect::CommandState { .. } => "command state",
    Effect::Response(_) => "response",
    Effect::Error(_) => "error",
    Effect::Refined(_) => "refined",
    Effect::Approved { .. } => "approved",
    Effect::Alarm { .. } => "alarm",
    Effect::AlarmCleared { .. } => "alarm cleared",
    Effect::Gone { .. } => "gone",
    Effect::AskForFactsheet => "ask for factsheet",
}

/// An event that owns its content, to be played as often as needed.
#[derive(Debug, Clone)]
enum Said {
    Connection(usize, Link),
    /// With the layout of this number.
    Factsheet(usize, usize),
    Contacts(usize, u64, Vec<Contact<'static>>),
    Status(usize, Micros, Vec<WhiskerStatus<'static>>),
    Setpoint(usize, Command, SetpointReport, Micros),
    Operator(OperatorAction<'static>),
    PolicyChanged(Mode),
    Tick,
}

/// A simulated robot, which does not always keep the contract.
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

    fn next(&mut self, robot: &Robot) -> Said {
        self.passes(20_000);
        // Mostly a factsheet follows a birth at once.
        let is_known = robot.sequence(BOOTS[self.boot]).is_some();
        if !is_known && self.random.random_bool(0.5) {
            return Said::Factsheet(self.boot, 0);
        }
        match self.random.random_range(0..1000) {
            0..700 => self.contacts(),
            700..850 => self.status(),
            850..952 => {
                self.passes(250_000);
                Said::Tick
            }
            952..970 => self.answer(),
            970..976 => {
                let whisker = self.random.random_range(0..usize::from(WHISKERS));
                self.lengths_mm[whisker] = (self.lengths_mm[whisker] - 6.0).max(40.0);
                self.contacts()
            }
            976..979 => {
                self.dead_gauge = (self.dead_gauge.is_none()).then(|| self.random.random_range(0..WHISKERS));
                self.contacts()
            }
            979..981 => {
                self.passes(20_000_000);
                Said::Tick
            }
            // Longer than a gap may stay open while a robot is heard.
            981..982 => {
                self.passes(400_000_000);
                self.contacts()
            }
            982..994 => Said::Operator(self.action(robot)),
            994..995 => {
                self.boot = (self.boot + 1).min(BOOTS.len() - 1);
                Said::Connection(self.boot, Link::Online)
            }
            995..996 => Said::Connection(self.boot, if self.random.random() { Link::Broken } else { Link::Offline }),
            996..998 => Said::Connection(self.boot, Link::Online),
            998..999 => {
                let mode = if self.random.random() { Mode::Advise } else { Mode::Automatic };
                Said::PolicyChanged(mode)
            }
            _ => Said::Factsheet(
                self.boot,
                if self.random.random_bool(0.3) { self.random.random_range(0..LAYOUTS) } else { 0 },
            ),
        }
    }

    fn action(&mut self, robot: &Robot) -> OperatorAction<'static> {
        let whisker = Place { array: ARRAY, whisker: self.random.random_range(0..WHISKERS) };
        let proposed = robot.compensations().iter().find(|one| one.is_proposed()).map(|one| one.id());
        match (proposed, self.random.random_range(0..16)) {
            (Some(compensation), 0..8) => OperatorAction::Approve { compensation },
            (Some(compensation), 8..12) => OperatorAction::Refuse { compensation },
            (_, 0) => OperatorAction::Hold(Scope::Robot),
            (_, 1..4) => OperatorAction::Release(Scope::Robot),
            (_, 4..6) => OperatorAction::Hold(Scope::Whisker(whisker)),
            (_, 6..10) => OperatorAction::Release(Scope::Whisker(whisker)),
            (_, 10..12) => OperatorAction::Setpoint { whisker, pressure_mpa: self.random.random_range(0.0..0.2) },
            (_, 12..14) => OperatorAction::Replaced(whisker),
            (_, _) => OperatorAction::Rebaseline(whisker),
        }
    }

    fn contacts(&mut self) -> Said {
        let count = self.random.random_range(1..8);
        let contacts = (0..count).map(|_| self.contact()).collect();
        // Sometimes of an older boot, a duplicate, or with a gap.
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
                regulator: match strange {
                    11 => RegulatorState::Leak,
                    12 => RegulatorState::Filling,
                    13 => RegulatorState::Venting,
                    14 => RegulatorState::SupplyLow,
                    15 => RegulatorState::Fault,
                    _ => RegulatorState::Ok,
                },
                gauge: if strange == 16 { GaugeState::Saturated } else { GaugeState::Ok },
            }
        });
        let whiskers = whiskers.collect();
        Said::Status(self.boot, self.time(), whiskers)
    }

    /// Time of the robot; sometimes a wrong one.
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
        let report = match self.random.random_range(0..24) {
            0 => SetpointReport::Failed,
            1 => SetpointReport::Superseded,
            2 => SetpointReport::Rejected(Rejection::Stale),
            3 => SetpointReport::Rejected(Rejection::Expired),
            4 => SetpointReport::Rejected(Rejection::OutOfRange),
            5 => SetpointReport::Rejected(Rejection::UnknownWhisker),
            6 => SetpointReport::Rejected(Rejection::WrongBoot),
            7 => SetpointReport::Rejected(Rejection::NotReady),
            // These are followed by another report.
            8..10 => return Said::Setpoint(self.boot, self.under_way[0].clone(), SetpointReport::Received, self.now),
            10..12 => return Said::Setpoint(self.boot, self.under_way[0].clone(), SetpointReport::Applying, self.now),
            _ => {
                let command = &self.under_way[0];
                self.pressures[command.whisker] = command.pressure;
                SetpointReport::Applied(command.pressure)
            }
        };
        Said::Setpoint(self.boot, self.under_way.remove(0), report, self.now)
    }
}

fn params(mode: Mode) -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    params.refinement.first_look_contacts = 60;
    params.policy.mode = mode;
    params
}

const LAYOUTS: usize = 4;

/// Layout 0; with other neighbours; with another whisker in the place of one; and without the last whisker.
fn factsheet(layout: usize) -> Factsheet {
    let whiskers = if layout == 3 { WHISKERS - 1 } else { WHISKERS };
    let whisker = |number: u16| WhiskerSheet {
        number,
        x_mm: 25.0 * f64::from(number),
        y_mm: 0.0,
        model: "nguyen-2021".into(),
        length: Millimetre::known(if layout == 2 { 69.0 } else { [70.0, 68.0, 66.0, 70.0][usize::from(number)] }),
        pressure: Megapascal::known(0.1),
        pressure_max: Megapascal::EXAMINED_MAX,
        neighbours: (0..whiskers)
            .filter(|other| other.abs_diff(number) == 1 || (layout == 1 && other.abs_diff(number) == 3))
            .collect(),
    };
    let whiskers = (0..whiskers).map(whisker).collect();
    Factsheet { arrays: vec![ArraySheet { name: ARRAY.to_owned(), kind: ArrayKind::Type1, whiskers }] }
}

/// The result of a step.
#[derive(Debug, Clone, PartialEq)]
struct Step {
    outcome: Outcome,
    /// Without requests for the factsheet: when the last one was made is not stored.
    effects: Vec<Effect>,
}

/// Steps a robot; `kind` is called with the name of the event's kind.
fn step(robot: &mut Robot, params: &Params, now: Micros, said: &Said, kind: &mut impl FnMut(&'static str)) -> Step {
    let mut effects = Vec::new();
    let mut tell = |event: &Event<'_>| {
        let outcome = robot.step(params, now, event, &mut effects);
        if outcome == Outcome::Taken {
            kind(kind_of(event));
        }
        outcome
    };
    let outcome = match said {
        Said::Connection(boot, link) => tell(&Event::Connection { boot_id: BOOTS[*boot], link: *link }),
        Said::Factsheet(boot, layout) => {
            tell(&Event::Factsheet { boot_id: BOOTS[*boot], factsheet: &factsheet(*layout) })
        }
        Said::Contacts(boot, seq, contacts) => tell(&Event::Contacts { boot_id: BOOTS[*boot], seq: *seq, contacts }),
        Said::Status(boot, robot_time, whiskers) => {
            tell(&Event::Status { boot_id: BOOTS[*boot], robot_time: *robot_time, whiskers })
        }
        Said::Setpoint(boot, command, report, robot_time) => {
            let (boot_id, report, robot_time) = (BOOTS[*boot], *report, *robot_time);
            tell(&Event::Setpoint { boot_id, command: command.key, report, robot_time })
        }
        Said::Operator(action) => tell(&Event::Operator(action)),
        Said::PolicyChanged(_) => tell(&Event::PolicyChanged),
        Said::Tick => tell(&Event::Tick),
    };
    effects.retain(|effect| *effect != Effect::AskForFactsheet);
    Step { outcome, effects }
}

/// The parts that a store has: it writes the marked ones.
#[derive(Debug, Clone, PartialEq, Default)]
struct Store {
    head: Vec<u8>,
    whiskers: Vec<Vec<u8>>,
}

impl Store {
    /// Returns how many parts were written.
    fn write(&mut self, robot: &mut Robot) -> usize {
        let changed = robot.has_changed();
        let (mut indices, head) = (Vec::new(), robot.take_changed());
        robot.take_changed_whiskers(|index| indices.push(index));
        assert_eq!(changed, head || !indices.is_empty());
        assert!(!robot.has_changed());
        if head {
            self.head = robot.to_bytes().unwrap();
        }
        self.whiskers.resize(robot.whisker_count(), Vec::new());
        for &index in &indices {
            self.whiskers[index] = robot.whisker_to_bytes(index).unwrap();
        }
        usize::from(head) + indices.len()
    }

    fn parts_other_than(&self, before: &Self) -> usize {
        let is_other = |&index: &usize| before.whiskers.get(index) != Some(&self.whiskers[index]);
        usize::from(self.head != before.head) + (0..self.whiskers.len()).filter(is_other).count()
    }

    fn all_of(robot: &Robot) -> Self {
        let whiskers = (0..robot.whisker_count()).map(|index| robot.whisker_to_bytes(index).unwrap()).collect();
        Self { head: robot.to_bytes().unwrap(), whiskers }
    }

    /// The first difference from another: the whisker, or none for the head, and the byte.
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

/// One life of a robot, with a checkpoint after every step.
struct Life {
    /// For [`Mode::Automatic`] and [`Mode::Advise`].
    params: [Params; 2],
    /// Events, each with its time and the mode from then on.
    told: Vec<(Micros, Mode, Said)>,
    steps: Vec<Step>,
    /// After each event.
    stored: Vec<Store>,
    /// How often each kind of event was taken.
    kinds: BTreeMap<&'static str, usize>,
    /// Parts that were written, and those of them that had not changed.
    written: [usize; 2],
}

impl Life {
    fn new(seed: u64, events: usize) -> Self {
        let mut plant = Plant::new(seed);
        let mut robot = Robot::new(1, Numbers::default());
        let mut life = Self {
            params: [Mode::Automatic, Mode::Advise].map(params),
            told: Vec::new(),
            steps: Vec::new(),
            stored: Vec::new(),
            kinds: BTreeMap::new(),
            written: [0; 2],
        };
        let mut store = Store::default();
        let mut mode = if seed.is_multiple_of(2) { Mode::Automatic } else { Mode::Advise };
        let born = [Said::Connection(0, Link::Online), Said::Factsheet(0, 0)];
        for at in 0..events {
            let said = born.get(at).cloned().unwrap_or_else(|| plant.next(&robot));
            if let Said::PolicyChanged(next) = said {
                mode = next;
            }
            let mut kind = |name| *life.kinds.entry(name).or_default() += 1;
            let step = step(&mut robot, &life.params[usize::from(mode == Mode::Advise)], plant.now, &said, &mut kind);
            plant.under_way.extend(step.effects.iter().filter_map(|effect| match effect {
                Effect::Command(command) => Some((**command).clone()),
                _ => None,
            }));
            let before = store.clone();
            let written = store.write(&mut robot);
            let unmarked = store.first_difference(&Store::all_of(&robot));
            assert_eq!(unmarked, None, "seed {seed}: a change by event {at} is not marked: {said:?}");
            life.written[0] += written;
            life.written[1] += written - store.parts_other_than(&before);
            life.told.push((plant.now, mode, said));
            life.steps.push(step);
            life.stored.push(store.clone());
        }
        life
    }

    /// Plays event `at` to a robot.
    fn play(&self, robot: &mut Robot, at: usize) -> Step {
        let (now, mode, said) = &self.told[at];
        step(robot, &self.params[usize::from(*mode == Mode::Advise)], *now, said, &mut |_| ())
    }

    /// Restores the robot after event `from`, and plays all later events again.
    fn again_from(&self, from: usize) {
        let Store { head, whiskers } = &self.stored[from];
        let mut robot = Robot::restore(head, whiskers).unwrap();
        assert_eq!(Store::all_of(&robot), self.stored[from]);
        for at in from + 1..self.told.len() {
            let said = &self.told[at].2;
            assert_eq!(self.play(&mut robot, at), self.steps[at], "from {from}, event {at}: {said:?}");
            let differs = Store::all_of(&robot).first_difference(&self.stored[at]);
            assert_eq!(differs, None, "from {from}, event {at}: {said:?}");
        }
    }
}

/// Lives in which whiskers are cut and served, gauges fail, messages are missed and come again, robots start anew,
/// operators act and policies change.
#[test]
fn property_every_change_is_marked_and_what_was_stored_goes_on_as_it_did() {
    let (mut kinds, mut effects, mut written) = (BTreeMap::new(), BTreeMap::new(), [0; 2]);
    for seed in 0..16 {
        let life = Life::new(seed, 2500);
        life.kinds.iter().for_each(|(kind, count)| *kinds.entry(*kind).or_insert(0) += count);
        life.steps
            .iter()
            .flat_map(|step| &step.effects)
            .for_each(|one| *effects.entry(effect_of(one)).or_insert(0) += 1);
        written = [written[0] + life.written[0], written[1] + life.written[1]];
        for from in [1, 200 + 37 * seed as usize, 2200] {
            life.again_from(from);
        }
    }
    for kind in KINDS {
        assert!(kinds.contains_key(kind), "no life has an event {kind:?} that is taken: {kinds:?}");
    }
    for effect in EFFECTS.iter().filter(|effect| **effect != effect_of(&Effect::AskForFactsheet)) {
        assert!(effects.contains_key(effect), "no life has an effect {effect:?}: {effects:?}");
    }
    let [all, unchanged] = written;
    assert!(50 * unchanged < all, "{unchanged} of {all} parts were written although they had not changed");
}

/// A robot that evaluates its whiskers only when a deadline has passed has the same effects as a restored one, which
/// evaluates all of them at its first tick.
#[test]
fn property_a_tick_with_nothing_to_do_says_what_a_full_look_says() {
    for seed in 100..106 {
        let life = Life::new(seed, 600);
        for at in (1..life.told.len()).filter(|&at| matches!(life.told[at].2, Said::Tick)) {
            let Store { head, whiskers } = &life.stored[at - 1];
            let mut robot = Robot::restore(head, whiskers).unwrap();
            assert_eq!(life.play(&mut robot, at), life.steps[at], "seed {seed}, event {at}");
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
    let mut step = |event: &Event<'_>| robot.step(&params(Mode::Automatic), now, event, &mut effects);
    step(&Event::Connection { boot_id: &boot_id, link: Link::Online });
    let whisker = Place { array: ARRAY, whisker: 3 };
    let by_hand = Event::Operator(&OperatorAction::Setpoint { whisker, pressure_mpa: 0.05 });
    assert!(matches!(step(&by_hand), Outcome::Refused(_)), "its clock is not known");
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
