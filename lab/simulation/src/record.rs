//! What is observed in a run: at the robots, at the broker, and in the store. Each observation is compared with the invariants.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use tokio::time::Instant;
use vibrissa_edge::invariants::is_pressure_in_range;
use vibrissa_protocol::{Message, Name, Topic, decode};
use vibrissa_simulator::JournalEntry;
use vibrissa_store::batch::{ContactRow, Record as Row, SetpointRow};

use crate::invariants::{Invariant, Violation};
use crate::oracle::ledger::{Content, Ledger, Recorded};
use crate::oracle::obedience::{self, Decided, LOST, Obedience};
use crate::robots::SimulatedRobot;
use crate::scenario::{self, WhiskerName};
use crate::store::{Fact, FactRow, ModelStore};

/// Most violations that are kept.
const VIOLATIONS: usize = 20;
/// Longest life of a setpoint, µs: the time to live of ten seconds, and ten seconds for the longest way of the pressure. A
/// supervisor knows the robot's clock to a second.
const LIVES_US: u64 = 21_000_000;
/// Highest pressure of the whiskers of a run by their factsheets, MPa.
const WHISKER_LIMIT_MPA: f64 = 0.2;
/// A robot whose messages are not further apart talks all the time.
const TALKS_WITHIN: Duration = Duration::from_secs(4);
/// A whisker or robot may be called silent after this time.
const SILENT_AFTER: Duration = Duration::from_secs(15);
/// Alarms that the faults of a run can cause.
const TRUE_FAULTS: [&str; 11] = [
    "STALE",
    "ROBOT_SILENT",
    "UNCOMPENSATED",
    "SETPOINT_FAILED",
    "REACH_LOST",
    "DUPLICATE_ROBOT",
    "RECEIPTS_UNHEARD",
    "REGULATOR",
    "VENTED",
    "PROPOSED",
    "SUPPLY_LOW",
];

/// What the store has said.
#[derive(Debug, Default, Clone)]
struct Committed {
    ledger: Ledger,
    decided: BTreeMap<String, Decided>,
    trims: u64,
    alarms: BTreeMap<String, u64>,
}

/// What was committed at a time.
#[derive(Debug)]
pub struct Snapshot(Committed);

/// The observations of a run.
#[derive(Debug, Default)]
pub struct Record {
    committed: Committed,
    obedience: Obedience,
    /// Robot and identifier of each boot, by number.
    boots: BTreeMap<i64, (String, String)>,
    /// Messages below this number are receipted, by robot and boot.
    receipted: BTreeMap<(String, String), u64>,
    /// The supervisor's boot of each epoch of a fleet.
    owners: BTreeMap<(String, u64), String>,
    /// Whiskers that were cut.
    pub cut: BTreeSet<WhiskerName>,
    /// Since when each robot talks without a pause, and its newest message.
    talking: BTreeMap<String, (Instant, Instant)>,
    /// Times at which the last two commits of each fleet were seen, the newest one last.
    commits: BTreeMap<Name, [Option<Instant>; 2]>,
    violations: Vec<Violation>,
    /// Surplus and wrong rows at the last look.
    seen: (u64, u64),
}

impl Record {
    /// The violations so far.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        &self.violations
    }

    /// Number of contacts that robots made, of setpoints that were decided, and of trims that were found.
    #[must_use]
    pub fn counts(&self) -> [u64; 3] {
        [self.committed.ledger.count(), self.committed.decided.len() as u64, self.committed.trims]
    }

    /// Raised alarms by kind.
    #[must_use]
    pub fn alarms(&self) -> &BTreeMap<String, u64> {
        &self.committed.alarms
    }

    /// Notes a violation.
    pub fn violated(&mut self, invariant: Invariant, what: String) {
        if self.violations.len() < VIOLATIONS {
            self.violations.push(Violation { invariant, what });
        }
    }

    /// Takes in what robots have felt, heard and applied, and then what was committed.
    pub fn drain(&mut self, robots: &[SimulatedRobot], store: &mut ModelStore) {
        for robot in robots {
            let (name, entries) = robot.with(|robot| (robot.name().to_string(), robot.take_journal()));
            for entry in entries {
                match entry {
                    JournalEntry::Felt(message) => self.committed.ledger.felt(&name, &message),
                    JournalEntry::Heard(setpoint) => {
                        let left_us = setpoint.setpoint.expires_us.saturating_sub(setpoint.at_us);
                        if left_us > LIVES_US {
                            let what = format!("{name}: {left_us} us until {:?} expires", setpoint.setpoint);
                            self.violated(Invariant::SetpointExpires, what);
                        }
                        self.obedience.heard(&name, &setpoint);
                    }
                    JournalEntry::Applied(setpoint) => {
                        if !is_pressure_in_range(setpoint.setpoint.pressure_mpa, WHISKER_LIMIT_MPA) {
                            self.violated(Invariant::PressureInRange, format!("{name}: {:?}", setpoint.setpoint));
                        }
                        self.obedience.applied(&name, &setpoint);
                    }
                }
            }
        }
        let facts = store.take_facts();
        for fact in &facts {
            self.fact(fact, store);
        }
        let now = Instant::now();
        for fact in facts {
            let commits = self.commits.entry(fact.fleet).or_default();
            if commits[1] != Some(now) {
                *commits = [commits[1], Some(now)];
            }
        }
        let (duplicate, wrong) = self.committed.ledger.surplus();
        let before = std::mem::replace(&mut self.seen, (duplicate, wrong));
        if duplicate > before.0 {
            self.violated(Invariant::ContactOnce, format!("{duplicate} contacts twice"));
        }
        if wrong > before.1 {
            self.violated(Invariant::ContactAsFelt, format!("{wrong} contacts that nobody felt"));
        }
    }

    fn fact(&mut self, fact: &Fact, store: &ModelStore) {
        match &fact.row {
            FactRow::Contact(row) => self.contact(row, store),
            FactRow::Record(Row::Setpoint(row)) => self.setpoint(row, store),
            FactRow::Record(Row::SetpointState(row)) => {
                if let Some(decided) = self.committed.decided.get_mut(&row.command_id) {
                    row.state.clone_into(&mut decided.state);
                }
            }
            FactRow::Record(Row::Trim(row)) => {
                self.committed.trims += 1;
                let Some(name) = name(store, row.whisker_id).filter(|name| is_honest(&name.0)) else { return };
                if !self.cut.contains(&name) {
                    self.violated(Invariant::TrimIsTrue, format!("{name:?} was not cut: {row:?}"));
                }
            }
            FactRow::Record(Row::Alarm(row)) => {
                let whisker = name(store, row.whisker_id);
                // Loss of sensitivity and cut are told apart in the end only.
                let is_cut = whisker.as_ref().is_some_and(|whisker| self.cut.contains(whisker));
                self.alarm(&fact.fleet, row.kind, whisker.map(|whisker| whisker.0), is_cut);
            }
            FactRow::Record(Row::RobotAlarm(row)) => {
                let robot = store.name_of_robot(row.robot_id).map(ToOwned::to_owned);
                self.alarm(&fact.fleet, row.kind, robot, false);
            }
            FactRow::Record(_)
            | FactRow::Event(_)
            | FactRow::Rollup(_)
            | FactRow::Response(_)
            | FactRow::Refusal(_)
            | FactRow::TurnedAway(_)
            | FactRow::BlackBox(_) => {}
        }
    }

    /// An alarm about a robot, or about one of its whiskers.
    ///
    /// It may be committed long after it was raised, if the store is away. While one transaction is written, the next one
    /// is filled: so the alarm was raised after the last commit but one.
    fn alarm(&mut self, fleet: &Name, kind: &str, robot: Option<String>, is_cut: bool) {
        let Some(robot) = robot.filter(|robot| is_honest(robot)) else { return };
        *self.committed.alarms.entry(kind.to_owned()).or_default() += 1;
        let now = Instant::now();
        let raised_from = self.commits.get(fleet).and_then(|commits| commits[0]);
        let is_talking = self.talking.get(&robot).zip(raised_from).is_some_and(|((since, last), raised_from)| {
            now.duration_since(*last) < TALKS_WITHIN
                && raised_from.saturating_duration_since(*since) > SILENT_AFTER + TALKS_WITHIN
        });
        if matches!(kind, "STALE" | "ROBOT_SILENT") && is_talking {
            self.violated(Invariant::FaultIsTrue, format!("{kind} of {robot}, which talks all the time"));
        }
        if !TRUE_FAULTS.contains(&kind) && !is_cut {
            self.violated(Invariant::FaultIsTrue, format!("{kind} of {robot}"));
        }
    }

    /// Notes that the broker has accepted a message of a robot. A last will or a farewell interrupts its talk.
    pub fn talked(&mut self, robot: &str, is_end: bool) {
        let now = Instant::now();
        let (since, last) = self.talking.entry(robot.to_owned()).or_insert((now, now));
        if now.duration_since(*last) > TALKS_WITHIN || is_end {
            *since = now;
        }
        *last = now;
    }

    fn contact(&mut self, row: &ContactRow, store: &ModelStore) {
        if !self.boots.contains_key(&row.boot) {
            let all = store.boots().map(|(boot, robot, boot_id)| (boot, (robot.to_owned(), boot_id.to_owned())));
            self.boots.extend(all);
        }
        let (Some((robot, boot_id)), Some(whisker)) =
            (self.boots.get(&row.boot).cloned(), store.name_of_whisker(row.whisker_id))
        else {
            return self.violated(Invariant::ContactAsFelt, format!("unknown boot or whisker: {row:?}"));
        };
        if !is_honest(&robot) {
            return;
        }
        self.committed.ledger.recorded(Recorded {
            robot,
            boot_id,
            seq: row.seq as u64,
            position: row.position as usize,
            content: Content {
                array: whisker.1.to_owned(),
                whisker: whisker.2,
                t_us: row.t_us,
                values: [
                    row.ratio.unwrap_or(f64::NAN),
                    row.deflection_mm,
                    row.strain,
                    row.pressure_mpa,
                    row.temperature_c,
                ],
            },
        });
    }

    fn setpoint(&mut self, row: &SetpointRow, store: &ModelStore) {
        let Some(whisker) = name(store, row.whisker_id) else { return };
        let decided = Decided {
            command_id: row.command_id.clone(),
            whisker,
            robot_boot_id: row.robot_boot_id.clone(),
            compensation_id: row.compensation_id,
            order: (row.epoch, row.version),
            pressure_mpa: row.pressure_mpa,
            gain: row.gain.as_deref().and_then(|gain| serde_json::from_str(gain).ok()).unwrap_or_default(),
            reason: row.reason.to_owned(),
            state: "PENDING".to_owned(),
        };
        self.committed.decided.insert(row.command_id.clone(), decided);
    }

    /// Compares a message that a supervisor has published with what is committed by now.
    pub fn published(&mut self, topic: &str, payload: &[u8]) {
        let Ok(topic) = Topic::parse(topic) else { return };
        match decode(&topic, payload) {
            Ok(Message::Receipt(receipt)) => {
                let Topic::Robot { robot, .. } = &topic else { return };
                if !is_honest(robot.as_str()) {
                    return;
                }
                let boot = (robot.to_string(), receipt.robot_boot_id.to_string());
                let from = self.receipted.get(&boot).copied().unwrap_or_default();
                let held: Vec<_> = receipt.held.iter().map(|&(first, last)| (first, last + 1)).collect();
                let ledger = &self.committed.ledger;
                let new = [(from, receipt.next)];
                let missing = new.iter().chain(&held).find_map(|range| ledger.first_missing(&boot.0, &boot.1, *range));
                if let Some(seq) = missing {
                    let what = format!("{}: message {seq} of boot {} is receipted", boot.0, boot.1);
                    self.violated(Invariant::ReceiptAfterCommit, what);
                }
                self.receipted.insert(boot, from.max(receipt.next));
            }
            Ok(Message::SupervisorState(state)) => {
                let Topic::SupervisorState { fleet } = &topic else { return };
                let boot_id = state.boot_id.to_string();
                let owner = self.owners.entry((fleet.to_string(), state.epoch)).or_insert_with(|| boot_id.clone());
                if *owner != boot_id {
                    let what = format!("{fleet}: epoch {} of {owner} and of {boot_id}", state.epoch);
                    self.violated(Invariant::EpochOnce, what);
                }
            }
            Ok(_) | Err(_) => {}
        }
    }

    /// Compares the setpoints that robots applied with those in the database.
    pub fn check_setpoints(&mut self) {
        let decided: Vec<Decided> = self.committed.decided.values().cloned().collect();
        let verdict = self.obedience.verdict(&decided);
        for (invariant, count) in [
            (Invariant::SetpointOnce, verdict.twice),
            (Invariant::SetpointFresh, verdict.stale),
            (Invariant::SetpointCommitted, verdict.uncommitted),
        ] {
            if count > 0 && !self.violations.iter().any(|one| one.invariant == invariant) {
                let example = self.obedience.uncommitted(&decided).next().unwrap_or_default();
                self.violated(invariant, format!("{count} setpoints {example}"));
            }
        }
        self.check_decisions(verdict.two_for_one);
    }

    fn check_decisions(&mut self, two_for_one: u64) {
        if two_for_one > 0 {
            self.violated(Invariant::SetpointForDecision, format!("{two_for_one} setpoints"));
        }
    }

    /// Setpoints that have no end yet.
    #[must_use]
    pub fn pending(&self) -> Vec<String> {
        let is_open = |state: &str| matches!(state, "PENDING" | "RECEIVED" | "APPLYING");
        let open = self.committed.decided.values().filter(|one| is_open(&one.state));
        open.map(|one| format!("{} {} of {:?}", one.command_id, one.state, one.whisker)).collect()
    }

    /// The first message that is not recorded, of those of the present boots and of those that are receipted: a robot that
    /// restarts loses its others.
    #[must_use]
    pub fn first_missing(&self, present: &[String]) -> Option<String> {
        let mut boots = self.committed.ledger.boots();
        boots.find_map(|(robot, boot_id)| {
            let receipted = self.receipted.get(&(robot.to_owned(), boot_id.to_owned())).copied().unwrap_or_default();
            let until = if present.iter().any(|present| present == boot_id) { u64::MAX } else { receipted };
            let seq = self.committed.ledger.first_missing(robot, boot_id, (0, until))?;
            Some(format!("{robot}: message {seq} of boot {boot_id}"))
        })
    }

    /// Remembers what is committed, before a failover that loses what follows.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot(self.committed.clone())
    }

    /// Goes back to a snapshot: what was committed since then is lost, which is nobody's fault.
    pub fn lose_since(&mut self, Snapshot(mut before): Snapshot) {
        let decided: Vec<Decided> = self.committed.decided.values().cloned().collect();
        self.check_decisions(obedience::two_for_one(&decided));
        // Numbers of lost boots are given again.
        self.boots.clear();
        self.committed.ledger.lose_since(&before.ledger);
        before.ledger = std::mem::take(&mut self.committed.ledger);
        for (name, decided) in &self.committed.decided {
            let lost = || Decided { state: LOST.to_owned(), ..decided.clone() };
            before.decided.entry(name.clone()).or_insert_with(lost);
        }
        self.committed = before;
    }
}

/// Whether a robot's messages are its own.
fn is_honest(robot: &str) -> bool {
    robot.starts_with(scenario::ROBOTS)
}

fn name(store: &ModelStore, whisker_id: i64) -> Option<WhiskerName> {
    store.name_of_whisker(whisker_id).map(|(robot, array, whisker)| (robot.to_owned(), array.to_owned(), whisker))
}
