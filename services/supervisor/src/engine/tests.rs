//! Tests that checkpoints and journal together restore the robots as of the last commit, after a crash at any point.

mod budget;
mod excluded;
mod pressures;
mod robots;
mod silence;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::robot::event::{
    ArrayKind, ArraySheet, Contact, ContactPlace, Factsheet, GaugeState, Link, RegulatorState, Task, TouchTests,
    WhiskerSheet, WhiskerStatus,
};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};
use vibrissa_protocol::{self as protocol, BootId, Name, RobotTopic};

use super::commit::batch::Source;
use super::commit::checkpoint::CheckpointRate;
use super::commit::journal::StoredEntries;
use super::commit::journal::records::LogRecords;
use super::commit::transaction::SealedTransaction;
use super::message::RawMessage;
use super::pipeline::recovery::Replay;
use super::robot::KnownRobot;
use super::robot::limits::{BOOTS_AT_ONCE, Bucket};
use super::robot::retention::ContactRetention;
use super::worker::stepper::Stepper;
use super::worker::workers::Workers;

use super::worker::publication::Receipts;
use super::worker::{Found, Worker};
use crate::inbox::Delayed;
use crate::metrics::Metrics;
use vibrissa_store::batch::Batch;
use vibrissa_store::{JournalReading, Resolution, StoredRobot};

const WHISKERS: u16 = 6;
const PRESSURE_MPA: f64 = 0.1;
const WHOLE_MM: f64 = 70.0;

/// Pseudorandom numbers with a fixed seed.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 ^ (self.0 >> 29)) >> 11) as f64 % 1e6 / 1e6
    }

    fn below(&mut self, end: usize) -> usize {
        (self.unit() * end as f64) as usize
    }

    /// A nearly normal distribution, mean 0, standard deviation 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

/// Contents of the database's tables.
#[derive(Default)]
struct Tables {
    robots: BTreeMap<i64, (i64, Vec<u8>)>,
    whiskers: BTreeMap<i64, Vec<u8>>,
    /// Open minutes and hours, and closed ones.
    rollups: BTreeMap<i64, Vec<u8>>,
    closed: BTreeSet<(i64, Resolution, i64)>,
    journal: BTreeMap<i64, Vec<u8>>,
}

impl Tables {
    fn write(&mut self, rows: Batch) {
        for robot in rows.robots {
            self.robots.insert(robot.robot_id, (robot.journal_number, robot.state));
        }
        for whisker in rows.whiskers {
            self.whiskers.insert(whisker.whisker_id, whisker.state);
            self.rollups.insert(whisker.whisker_id, whisker.rollup);
        }
        for row in rows.rollups {
            assert!(self.closed.insert((row.whisker_id, row.resolution, row.start_us)), "a span is closed only once");
        }
        self.journal.extend(rows.journal.map(|row| (row.number, row.entries)));
        if let Some(done) = rows.journal_done {
            self.journal.retain(|&number, _| number > done);
        }
    }

    fn stored(&self, robot_id: i64) -> StoredRobot {
        let (journal_number, state) = self.robots[&robot_id].clone();
        StoredRobot {
            robot_id,
            robot: format!("r{robot_id}"),
            state: Some(state),
            software: "[]".to_owned(),
            whisker_ids: whisker_ids(robot_id),
            whisker_states: whisker_ids(robot_id).iter().map(|id| self.whiskers[id].clone()).collect(),
            segmenters: vec![None; usize::from(WHISKERS)],
            boots: BTreeMap::from([("b".to_owned(), robot_id)]),
            rollups: whisker_ids(robot_id).iter().map(|id| self.rollups.get(id).cloned()).collect(),
            journal_number,
            held: false,
            numbers: Numbers::default(),
        }
    }
}

fn whisker_ids(robot_id: i64) -> Vec<i64> {
    (0..i64::from(WHISKERS)).map(|index| 100 * robot_id + index).collect()
}

fn factsheet() -> Factsheet {
    let sheet = |number: u16| WhiskerSheet {
        number,
        x_mm: 25.0 * f64::from(number),
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length: Millimetre::known(WHOLE_MM),
        pressure: Megapascal::known(PRESSURE_MPA),
        pressure_max: Megapascal::known(0.2),
        length_tolerance_mm: 0.5,
        strain_max: None,
        neighbours: [number.checked_sub(1), Some(number + 1).filter(|&right| right < WHISKERS)]
            .into_iter()
            .flatten()
            .collect(),
    };
    let whiskers = (0..WHISKERS).map(sheet).collect();
    Factsheet {
        arrays: vec![ArraySheet { name: "a".to_owned(), kind: ArrayKind::Type1, task: Task::Ratio, whiskers }],
        touch_tests: TouchTests::default(),
        applies_gain: false,
        air_control: Default::default(),
    }
}

fn worker(robots: i64) -> Worker {
    let params = Arc::new(Params::nguyen_2021(Formulation::default()));
    let (fleet, boot) = (Name::new("f").unwrap(), BootId::new("s").unwrap());
    let metrics = Metrics::new(false).unwrap().of_fleet(&fleet);
    let mut worker = Worker::new(Stepper::new(fleet, boot, params, metrics), 7, 1);
    let (known_robots, stepper) = worker.parts();
    for robot_id in 1..=robots {
        let name = Name::robot(&format!("r{robot_id}")).unwrap();
        let mut known = KnownRobot::new(
            (Name::new("f").unwrap(), name.clone()),
            robot_id,
            Robot::new(7, Numbers::default()),
            ContactRetention::Decisions,
        );
        known.whisker_ids = whisker_ids(robot_id);
        known.boots.insert("b", robot_id);
        let birth = Event::Connection { boot_id: "b", link: Link::Online };
        stepper.step(&mut known, Micros(1), &birth, None);
        stepper.step(&mut known, Micros(1), &Event::Factsheet { boot_id: "b", factsheet: &factsheet() }, None);
        known_robots.insert(name, known);
    }
    worker
}

/// Robots with contacts, status messages and ticks, some of whose whiskers are cut.
struct World {
    random: Random,
    model: Model,
    lengths_mm: BTreeMap<(i64, u16), f64>,
    seqs: BTreeMap<i64, u64>,
    now: Micros,
}

impl World {
    fn new(seed: u64) -> Self {
        Self {
            random: Random(seed),
            model: Model::nguyen_2021(Formulation::default()),
            lengths_mm: BTreeMap::new(),
            seqs: BTreeMap::new(),
            now: Micros(1_000_000),
        }
    }

    fn happen(&mut self, worker: &mut Worker) {
        self.now = Micros(self.now.0 + 20_000);
        let robot_id = 1 + self.random.below(worker.robots().len()) as i64;
        match self.random.below(40) {
            // At least one whisker per tick: a tick with many effects is continued with the next one.
            0 => drop(worker.tick(self.now, &Delayed::new(), 1)),
            1..=3 => self.status(worker, robot_id),
            // An outage that began two whole spans of silence ago, as far as the robots were not heard.
            5 if self.random.below(20) == 0 => {
                let stale_after = worker.parts().1.params_of(&Name::robot("r1").unwrap()).health.stale_after;
                self.now = self.now.after(stale_after).after(stale_after);
                worker.restart_silence_timers(self.now);
            }
            6 if self.random.below(20) == 0 => {
                worker.restart_silence_timer(&Name::robot(&format!("r{robot_id}")).unwrap(), self.now);
            }
            4 if self.now.0 > 40_000_000 => {
                let whisker = self.random.below(usize::from(WHISKERS)) as u16;
                let cut_mm = 10.0 * self.random.unit();
                let length_mm = self.lengths_mm.entry((robot_id, whisker)).or_insert(WHOLE_MM);
                *length_mm = (*length_mm - cut_mm).max(50.0);
            }
            _ => self.contacts(worker, robot_id),
        }
    }

    fn contacts(&mut self, worker: &mut Worker, robot_id: i64) {
        let (robots, stepper) = worker.parts();
        let known = robots.values_mut().find(|known| known.robot_id == robot_id).unwrap();
        let pressure = known.robot.whisker(0).map_or(PRESSURE_MPA, |view| view.setpoint.mpa());
        let mut contacts: Vec<Contact<'_>> =
            (0..1 + self.random.below(3)).map(|_| self.contact(robot_id, pressure)).collect();
        let seq = self.seqs.entry(robot_id).or_default();
        // Some messages are lost and come later, or come twice.
        let sent = match self.random.below(30) {
            0 => *seq + 1,
            1 => seq.saturating_sub(1),
            _ => *seq,
        };
        *seq = (*seq).max(sent + 1);
        contacts.iter_mut().for_each(|one| one.temperature_c = Some(20.0 + self.random.unit()));
        let event = Event::Contacts { boot_id: "b", seq: sent, contacts: &contacts, missed: &[] };
        let message = protocol::Contacts {
            boot_id: BootId::new("b").unwrap(),
            seq: sent,
            contacts: contacts.iter().map(as_sent).collect(),
            missed: Vec::new(),
        };
        stepper.step(known, self.now, &event, Some(Source { message: &message, boot: robot_id }));
    }

    fn contact(&mut self, robot_id: i64, pressure_mpa: f64) -> Contact<'static> {
        let whisker = self.random.below(usize::from(WHISKERS)) as u16;
        let length = Millimetre::known(self.lengths_mm.get(&(robot_id, whisker)).copied().unwrap_or(WHOLE_MM));
        let (ratio, deflection_mm) = (ContactRatio::known(0.6 + 0.3 * self.random.unit()), 3.0 + self.random.unit());
        let pressure = Megapascal::known(pressure_mpa);
        let morphology = self.model.morphology(pressure);
        let per_mm = self.model.sensitivity_per_mm(ratio, length, &morphology).unwrap();
        let strain = per_mm * deflection_mm * (0.03 * self.random.normal()).exp();
        Contact {
            array: "a",
            whisker,
            robot_time: self.now,
            place: ContactPlace::Ratio { ratio, sd: None },
            deflection: Millimetre::known(deflection_mm),
            strain: Strain::known(strain),
            pressure,
            is_test: false,
            angle_is_stated: false,
            saturated: false,
            temperature_c: None,
        }
    }

    fn status(&mut self, worker: &mut Worker, robot_id: i64) {
        let (robots, stepper) = worker.parts();
        let known = robots.values_mut().find(|known| known.robot_id == robot_id).unwrap();
        let line = |index: usize| {
            let setpoint = known.robot.whisker(index)?.setpoint;
            let (regulator, gauge) = (RegulatorState::Ok, GaugeState::Ok);
            Some(WhiskerStatus { array: "a", whisker: index as u16, pressure: setpoint, setpoint, regulator, gauge })
        };
        let whiskers: Vec<WhiskerStatus<'_>> = (0..usize::from(WHISKERS)).filter_map(line).collect();
        let event = Event::Status { boot_id: "b", robot_time: self.now, whiskers: &whiskers };
        stepper.step(known, self.now, &event, None);
    }
}

/// A contact as its robot sends it.
fn as_sent(contact: &Contact<'_>) -> protocol::Contact {
    let ContactPlace::Ratio { ratio, .. } = contact.place else { unreachable!("these robots know the ratio") };
    protocol::Contact {
        array: Name::new(contact.array).unwrap(),
        whisker: contact.whisker,
        t_us: contact.robot_time.0,
        ratio: Some(ratio.a()),
        ratio_sd: None,
        distance_mm: None,
        distance_sd_mm: None,
        tip: false,
        deflection_mm: contact.deflection.mm(),
        strain: contact.strain.ratio(),
        saturated: false,
        pressure_mpa: contact.pressure.mpa(),
        temperature_c: contact.temperature_c.unwrap(),
        angle_deg: None,
        angle_sd_deg: None,
        test_id: None,
    }
}

/// Seals the open batch as the engine does, and returns its rows.
fn seal(worker: &mut Worker, now: Micros, rate: &mut CheckpointRate) -> Batch {
    let number = worker.batch().number();
    rate.refill(now, 0);
    let mut transaction = SealedTransaction::new(number, Vec::new());
    worker.seal_into(&mut transaction, rate, Some(Receipts { now, robots_max: usize::MAX }));
    worker.batch_mut().set_number(number + 1);
    let mut rows = transaction.into_rows();
    rows.journal_done = Some(worker.oldest_entry().unwrap_or(number + 1) - 1);
    rows
}

/// All stored bytes of a robot: its state, its whiskers, and their open minutes and hours.
fn bytes(known: &KnownRobot) -> Vec<Vec<u8>> {
    let whisker = |index| {
        [known.robot.whisker_to_bytes(index).unwrap(), known.history.stored(index, known.full_name(), Micros(1))]
    };
    let whiskers = (0..known.robot.whisker_count()).flat_map(whisker);
    [known.robot.to_bytes().unwrap()].into_iter().chain(whiskers).collect()
}

fn crash(tables: &Tables, live: &Worker) -> usize {
    let mut workers = Workers::new(vec![worker(0)]);
    let mut replay = Replay::default();
    for known in live.robots().values() {
        replay.load(tables.stored(known.robot_id), known.name.clone(), 7, &mut workers);
    }
    let mut entries = 0;
    for (&number, row) in &tables.journal {
        let row = StoredEntries::new(JournalReading { number, log_partition: 0, entries: row.clone() });
        entries += replay.replay_row(&row, &LogRecords::new(), &mut workers);
    }
    for (name, known) in live.robots() {
        assert_eq!(bytes(workers.robot(name).unwrap()), bytes(known), "{name}");
    }
    entries
}

#[test]
fn property_states_and_journal_are_the_robots_at_each_commit() {
    for seed in 1..=6 {
        let mut worker = worker(3);
        let mut world = World::new(seed);
        let (mut tables, mut rate) = (Tables::default(), CheckpointRate::new(world.now));
        let (mut replayed, mut decided) = (0, 0);
        for round in 0..1500 {
            for _ in 0..world.random.below(8) {
                world.happen(&mut worker);
            }
            let rows = seal(&mut worker, world.now, &mut rate);
            decided += rows.records.len();
            tables.write(rows);
            if round % 50 == 49 {
                replayed += crash(&tables, &worker);
            }
        }
        assert!(replayed > 300, "the journal must have been replayed: {replayed}");
        assert!(decided > 10, "decisions must have been made: {decided}");
        assert!(tables.closed.len() >= 15, "spans must have been closed");
    }
}
