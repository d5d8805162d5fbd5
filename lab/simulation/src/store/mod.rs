//! A database in memory: the same operations as PostgreSQL has for supervisors, on plain maps, with a clock of its own.
//!
//! A clone is a snapshot. A failover that loses confirmed commits puts one in the place of the present state. Rows that
//! nothing loads are kept as [`Fact`]s until [`ModelStore::take_facts`]. What remains grows with decisions, actions and
//! events, and not with contacts. `tests/integration/databases/reference` compares its answers with those of both databases.

mod at_hand;
mod fleets;
mod leases;
mod programs;
mod records;
mod robots;
mod rows;
mod table;
mod webhooks;

use vibrissa_protocol::Name;
use vibrissa_store::actions::Action;
use vibrissa_store::allowed::{AllowedReading, TurnedAwayReading};
use vibrissa_store::batch::{ContactRow, EventRow, Record, ResponseRow, RollupRow};
use vibrissa_store::black_boxes::NewBlackBox;
use vibrissa_store::calibrations::ActiveCalibration;
use vibrissa_store::model::{Model, Violation};
use vibrissa_store::policies::PolicyReading;
use vibrissa_store::refusals::RefusalRow;
use vibrissa_store::rollouts::RolloutRow;
use vibrissa_store::{JournalReading, Lease, LeaseRow, MemberRow};

#[cfg(test)]
mod tests;

pub use at_hand::AtHand;
pub use leases::Epoch;
pub use programs::Program;

use table::{Table, Undo};

/// The name of a fleet, and another part of a key.
type Of<K> = (String, K);

/// The data.
#[derive(Debug, Clone, Default)]
pub struct ModelStore {
    /// The database's clock, µs since 1970 UTC.
    clock_us: i64,
    /// No room is left on its disk for rows.
    is_full: bool,
    /// The program that asks now.
    program: Program,
    /// Robots whose state an earlier program than theirs has changed.
    overwritten: Vec<i64>,
    /// The last number that was given, in whatever table. It never returns.
    last_number: i64,
    leases: Table<String, LeaseRow>,
    /// Numbers of transactions under each fleet's lease that assigned numbers.
    numbers: Table<String, i64>,
    epochs: Table<Of<i64>, Epoch>,
    members: Table<String, MemberRow>,
    robots: Table<i64, robots::Robot>,
    whiskers: Table<i64, robots::Whisker>,
    boots: Table<(i64, String), i64>,
    journal: Table<Of<i64>, JournalReading>,
    log_positions: Table<Of<(String, u32)>, i64>,
    horizons: Table<String, i64>,
    actions: Table<i64, Action>,
    policies: Table<Of<i64>, PolicyReading>,
    calibrations: Table<i64, String>,
    active_calibrations: Table<Of<String>, ActiveCalibration>,
    allowed: Table<Of<i64>, AllowedReading>,
    rollouts: Table<i64, RolloutRow>,
    trims: Table<i64, i64>,
    compensations: Table<i64, records::Compensation>,
    /// The robot of each setpoint.
    setpoints: Table<String, i64>,
    /// Robot, epoch and version of each setpoint.
    versions: Table<(i64, i64, i64), ()>,
    /// Alarms that stand.
    alarms: Table<i64, records::Alarm>,
    touch_tests: Table<String, ()>,
    webhooks: Table<i64, webhooks::Webhook>,
    /// Those that webhooks may get.
    events: Table<i64, webhooks::LogEvent>,
    /// By the number of the target and that of the event.
    dead_letters: Table<(i64, i64), webhooks::Letter>,
    facts: Facts,
}

/// A row that nothing loads, with the lease under which it was written.
#[derive(Debug, Clone)]
pub struct Fact {
    /// Name of the fleet.
    pub fleet: Name,
    /// Epoch of the lease.
    pub epoch: u64,
    /// The row.
    pub row: FactRow,
}

/// A row of a [`Fact`].
#[derive(Debug, Clone)]
pub enum FactRow {
    /// A contact.
    Contact(ContactRow),
    /// An event of the log.
    Event(EventRow),
    /// Aggregates of a minute or hour.
    Rollup(RollupRow),
    /// A response of a compensator.
    Response(ResponseRow),
    /// One of the rarer rows.
    Record(Record),
    /// A count of refused messages that is added.
    Refusal(RefusalRow),
    /// All robots of the fleet that were turned away.
    TurnedAway(Vec<TurnedAwayReading>),
    /// A black box.
    BlackBox(NewBlackBox),
}

/// Facts in the order of their commits.
#[derive(Debug, Clone, Default)]
struct Facts {
    rows: Vec<Fact>,
    /// Numbers of facts at the begins of the open transactions.
    begins: Vec<usize>,
}

impl Undo for Facts {
    fn begin(&mut self) {
        self.begins.push(self.rows.len());
    }

    fn end(&mut self, is_kept: bool) {
        let begin = self.begins.pop().unwrap_or_default();
        if !is_kept {
            self.rows.truncate(begin);
        }
    }
}

impl ModelStore {
    /// Sets the database's clock, µs since 1970 UTC.
    pub fn set_clock(&mut self, clock_us: i64) {
        self.clock_us = clock_us;
    }

    /// Sets whether its disk is full: then it answers queries, and refuses rows.
    pub fn set_full(&mut self, is_full: bool) {
        self.is_full = is_full;
    }

    /// Fails as PostgreSQL does when it cannot extend a table.
    fn need_room(&self) -> Result<(), Violation> {
        check(!self.is_full, "53100", || {
            "could not extend file \"base/16384/16412\": No space left on device".to_owned()
        })
    }

    /// The facts since the last time, in the order of their commits.
    pub fn take_facts(&mut self) -> Vec<Fact> {
        std::mem::take(&mut self.facts.rows)
    }

    /// The owners that each fleet has had, in the order of their epochs.
    pub fn epochs(&self) -> impl Iterator<Item = (&str, i64, &Epoch)> {
        self.epochs.iter().map(|((fleet, epoch), row)| (fleet.as_str(), *epoch, row))
    }

    fn next_number(&mut self) -> i64 {
        self.last_number += 1;
        self.last_number
    }

    fn note(&mut self, lease: &Lease, row: FactRow) {
        self.facts.rows.push(Fact { fleet: lease.fleet().clone(), epoch: lease.epoch(), row });
    }

    fn parts(&mut self) -> [&mut dyn Undo; 26] {
        [
            &mut self.leases,
            &mut self.numbers,
            &mut self.epochs,
            &mut self.members,
            &mut self.robots,
            &mut self.whiskers,
            &mut self.boots,
            &mut self.journal,
            &mut self.log_positions,
            &mut self.horizons,
            &mut self.actions,
            &mut self.policies,
            &mut self.calibrations,
            &mut self.active_calibrations,
            &mut self.allowed,
            &mut self.rollouts,
            &mut self.trims,
            &mut self.compensations,
            &mut self.setpoints,
            &mut self.versions,
            &mut self.alarms,
            &mut self.touch_tests,
            &mut self.webhooks,
            &mut self.events,
            &mut self.dead_letters,
            &mut self.facts,
        ]
    }
}

impl Model for ModelStore {
    fn begin(&mut self) {
        self.parts().into_iter().for_each(Undo::begin);
    }

    fn end(&mut self, is_kept: bool) {
        self.parts().into_iter().for_each(|part| part.end(is_kept));
    }
}

/// Fails if a row with the same key exists.
fn unique(exists: bool, table: &str) -> Result<(), Violation> {
    check(!exists, "23505", || format!("{table}: a row with this key exists"))
}

/// Fails if the row that another one refers to does not exist.
fn known(exists: bool, table: &str) -> Result<(), Violation> {
    check(exists, "23503", || format!("a row refers to a row of {table} that does not exist"))
}

fn check(is_met: bool, code: &'static str, text: impl FnOnce() -> String) -> Result<(), Violation> {
    if is_met { Ok(()) } else { Err(Violation { code, text: text() }) }
}
