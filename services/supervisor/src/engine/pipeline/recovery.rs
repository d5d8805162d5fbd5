//! Recovery of a fleet: checkpoints are loaded, and the journal is replayed.

use std::collections::BTreeMap;

use tokio::time::Instant;
use tracing::{error, info};
use vibrissa_core::robot::event::{Contact, WhiskerStatus};
use vibrissa_core::robot::{Event, Outcome};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Message, Name, Received, RobotTopic};

use crate::engine::commit::journal::records::{LogRecords, records_of};
use crate::engine::commit::journal::{Entry, JournalEvent, ROWS_AT_A_TIME, StoredEntries};
use crate::engine::part::Part;
use crate::engine::robot::KnownRobot;
use crate::engine::worker::Worker;
use crate::engine::worker::stepper::Stepper;
use crate::engine::worker::workers::Workers;
use crate::log_inbox::{LogRange, LogSource};
use crate::set_aside::Reader;
use vibrissa_edge::full_name::FullName;
use vibrissa_store::StoredRobot;
use vibrissa_store::{Lease, StoreError, Writer};

/// Robots that are loaded by one query: the memory for their stored states, at most some 60 KB each, serves the next ones.
const ROBOTS_AT_A_TIME: i64 = 100;

/// Facts about a robot that the replay needs.
struct ReplayedRobot {
    name: Name,
    /// Entries up to this number are contained in its checkpoint.
    journal_number: i64,
    arrays: Vec<String>,
    boots: BTreeMap<i64, String>,
    is_replayed: bool,
}

/// Loads the robots of a fleet into their workers. Returns the number of the last journal entry.
///
/// The journal may refer to the log. The recovery waits for the log then: what it has must not be left out.
pub(crate) async fn recover(
    writer: &mut Writer,
    lease: &Lease,
    workers: &mut Workers,
    log: Option<&LogSource>,
) -> Result<i64, StoreError> {
    let (mut replay, mut last) = (Replay::default(), 0);
    let mut after = -1;
    loop {
        let some = writer.robots(lease, after, ROBOTS_AT_A_TIME).await?;
        let Some(newest) = some.last else { break };
        after = newest;
        for stored in some.robots {
            last = last.max(stored.journal_number);
            match Name::robot(&stored.robot) {
                Ok(name) => replay.load(stored, name, lease.epoch(), workers),
                Err(_) => {
                    let robot = FullName::robot(lease.fleet().as_str(), &stored.robot);
                    error!(%robot, "a stored robot has no valid name and is left out");
                    workers.count_set_aside(Reader::Checkpoint);
                }
            }
        }
    }
    let (begun, mut entries) = (Instant::now(), 0);
    let mut after = -1;
    loop {
        let rows = writer.journal(lease, after, ROWS_AT_A_TIME).await?;
        let Some(newest) = rows.last() else { break };
        after = newest.number;
        last = last.max(after);
        for row in rows.into_iter().map(StoredEntries::new) {
            let records = records_of(&row, log, lease).await?;
            entries += replay.replay_row(&row, &records, workers);
        }
    }
    if let Some(log) = log {
        log.records_are_read().await;
    }
    replay.finish(lease.epoch(), workers);
    if entries > 0 {
        let seconds = begun.elapsed().as_secs_f64();
        info!(fleet = %lease.fleet(), entries, seconds, "journal replayed");
    }
    Ok(last)
}

/// Replay of the journal, from the checkpoints to the last commit.
#[derive(Default)]
pub(crate) struct Replay {
    robots: BTreeMap<i64, ReplayedRobot>,
}

impl Replay {
    /// Puts a robot into its worker. The journal is replayed for robots that have whiskers.
    pub(crate) fn load(&mut self, stored: StoredRobot, name: Name, epoch: u64, workers: &mut Workers) {
        // It has only announced itself, to an earlier version of the program: see `announced`.
        if stored.boots.is_empty() && stored.whisker_ids.is_empty() && !stored.held {
            return;
        }
        let (robot_id, journal_number) = (stored.robot_id, stored.journal_number);
        let (robots, stepper) = workers.of(&name).parts();
        let (params, retention) = (stepper.params_of(&name), stepper.retention());
        let restored = KnownRobot::restored((stepper.fleet().clone(), name.clone()), stored, epoch, params, retention);
        let Some((known, forgotten)) = restored else {
            let robot = FullName::robot(stepper.fleet().as_str(), name.as_str());
            error!(
                %robot,
                "a newer vibrissa has written the robot's state: it is kept, and the robot is not supervised. Start the newer \
                 program, or restore the back-up from before the upgrade (docs/operations.md, Upgrade and downgrade)"
            );
            stepper.count_set_aside(Reader::Checkpoint, 1);
            return workers.of(&name).leave_to_newer_program(name.clone(), robot_id);
        };
        stepper.count_set_aside(Reader::Checkpoint, forgotten.iter().count() as u64);
        stepper.batch_mut().rows_mut().records.extend(forgotten);
        if !known.whisker_ids.is_empty() {
            let replayed = ReplayedRobot {
                name: name.clone(),
                journal_number,
                arrays: known.robot.arrays().map(str::to_owned).collect(),
                boots: known.boots.by_number(),
                is_replayed: false,
            };
            self.robots.insert(robot_id, replayed);
        }
        robots.insert(name, known);
    }

    /// Replays one row of the journal. Returns the number of its entries that were replayed.
    pub(crate) fn replay_row(&mut self, row: &StoredEntries, records: &LogRecords, workers: &mut Workers) -> usize {
        let (number, mut count) = (row.number, 0);
        for entry in row.entries() {
            let entry = match entry {
                Ok(entry) => entry,
                Err(problem) => {
                    error!(number, %problem, "cannot read the journal, the rest of its row is lost");
                    workers.count_set_aside(Reader::Journal);
                    break;
                }
            };
            match &entry.event {
                JournalEvent::Log { range, part, except } => {
                    count += self.replay_records((number, entry.now), (*range, *part, except), records, workers);
                    continue;
                }
                JournalEvent::TickAll { part } => {
                    let tick = |robot_id| Entry { robot_id, now: entry.now, event: JournalEvent::Tick };
                    for (&robot_id, one) in &mut self.robots {
                        // The checkpoint has the ticks of others.
                        if one.journal_number < number && one.is_replayed && part.has(&one.name) {
                            one.replay(&tick(robot_id), workers.of(&one.name));
                        }
                    }
                    continue;
                }
                JournalEvent::Tick | JournalEvent::Contacts { .. } | JournalEvent::Status { .. } => {}
            }
            let replayed = self.robots.get_mut(&entry.robot_id);
            let Some(replayed) = replayed.filter(|one| one.journal_number < number) else { continue };
            count += 1;
            replayed.replay(&entry, workers.of(&replayed.name));
        }
        count
    }

    /// Replays records of the log. Returns their number.
    fn replay_records(
        &mut self,
        (number, begin): (i64, Micros),
        (range, part, except): (LogRange, Part, &[i64]),
        records: &LogRecords,
        workers: &mut Workers,
    ) -> usize {
        let mut count = 0;
        for record in records.get(&range).into_iter().flatten().filter(|record| part.has(&record.robot)) {
            let worker = workers.of(&record.robot);
            let Some(known) = worker.robots().get(&record.robot) else { continue };
            let Some(one) = self.robots.get_mut(&known.robot_id) else { continue };
            if one.journal_number >= number || except.contains(&known.robot_id) {
                continue;
            }
            let now = Micros(begin.0 + record.offset.abs_diff(range.from));
            let entry = if record.kind == RobotTopic::Contacts {
                let received = protocol::receive_contacts(&record.payload, Vec::new()).ok();
                received.map(|received| Entry::of_contacts(known, now, &received.message))
            } else if let Ok(Received { message: Message::Status(message), .. }) =
                protocol::receive(&record.topic, &record.payload)
            {
                Entry::of_status(known, now, &message)
            } else {
                None
            };
            if let Some(entry) = entry {
                count += 1;
                one.replay(&entry, worker);
            }
        }
        count
    }

    /// Starts the new epoch for all robots, which are now as of the last commit, and schedules checkpoints of those
    /// that were replayed.
    fn finish(&self, epoch: u64, workers: &mut Workers) {
        for worker in workers.iter_mut() {
            let (robots, stepper) = worker.parts();
            for known in robots.values_mut() {
                self.finish_robot(known, epoch, stepper);
            }
        }
    }

    /// Does the same for one robot.
    pub(crate) fn finish_robot(&self, known: &mut KnownRobot, epoch: u64, stepper: &mut Stepper) {
        known.begin(epoch, stepper.params_of(&known.name));
        if self.robots.get(&known.robot_id).is_some_and(|replayed| replayed.is_replayed) {
            stepper.batch_mut().checkpoint(known);
        }
    }
}

impl ReplayedRobot {
    fn replay(&mut self, entry: &Entry, worker: &mut Worker) {
        let (robots, stepper) = worker.parts();
        let Some(known) = robots.get_mut(&self.name) else { return };
        let boot_of = |boot: &i64| self.boots.get(boot).map_or("", String::as_str);
        // A range of the log has also the records that changed nothing. A new owner that has had no others of a robot has
        // journalled nothing of it, and its ticks do not count: the owner had excused the silence before.
        self.is_replayed |= match &entry.event {
            JournalEvent::Tick => {
                stepper.replay(known, entry, &Event::Tick);
                true
            }
            // Not of one robot.
            JournalEvent::Log { .. } | JournalEvent::TickAll { .. } => false,
            JournalEvent::Contacts { boot, seq, contacts } => {
                let contacts: Vec<Contact<'_>> = contacts.iter().filter_map(|one| one.contact(&self.arrays)).collect();
                let boot_id = boot_of(boot);
                let event = Event::Contacts { boot_id, seq: *seq, contacts: &contacts, missed: &[] };
                let outcome = stepper.replay(known, entry, &event);
                has_changed(outcome) || known.robot.has_gap(boot_id)
            }
            JournalEvent::Status { boot, robot_time, whiskers } => {
                let whiskers: Vec<WhiskerStatus<'_>> =
                    whiskers.iter().filter_map(|one| one.status(&self.arrays)).collect();
                let event = Event::Status { boot_id: boot_of(boot), robot_time: *robot_time, whiskers: &whiskers };
                has_changed(stepper.replay(known, entry, &event))
            }
        };
    }
}

/// Whether a step is journalled, or writes a checkpoint.
fn has_changed(outcome: Outcome) -> bool {
    matches!(outcome, Outcome::Taken | Outcome::BadTime)
}
