//! The suspects of a fleet: a robot whose rows the database has rejected is restored to its last committed state, and
//! becomes one.

use std::collections::BTreeMap;

use tokio::time::Instant;
use tracing::{error, info, warn};
use vibrissa_core::robot::Event;
use vibrissa_protocol::Name;

use crate::engine::commit::committer::Offender;
use crate::engine::commit::transaction::{RobotShare, SealedTransaction};
use crate::engine::message::RawMessage;
use crate::engine::pipeline::Pipeline;
use crate::engine::pipeline::recovery::Replay;
use crate::engine::quarantine::suspect::{Suspect, Turn, Verdict};
use crate::engine::worker::workers::Workers;
use crate::events::{Parts, QuarantinePart, event};
use crate::metrics::FleetMetrics;
use crate::readiness::Readiness;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::full_name::FullName;
use vibrissa_store::Lease;
use vibrissa_store::batch::{QuarantineRow, Record};

/// If there are more suspects than this, and more than a quarter of the robots, the database is at fault rather than
/// messages.
const SUSPECTS_FEW: usize = 8;
/// Name of this part in the service's readiness.
const PART: &str = "quarantine";

/// Robots whose rows the database has rejected.
pub(crate) struct Suspects {
    lease: Lease,
    metrics: FleetMetrics,
    readiness: Readiness,
    robots: BTreeMap<Name, Suspect>,
}

impl Suspects {
    pub(crate) fn new(lease: Lease, metrics: FleetMetrics, readiness: Readiness) -> Self {
        Self { lease, metrics, readiness, robots: BTreeMap::new() }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.robots.is_empty()
    }

    /// Whether a robot is a suspect.
    pub(crate) fn has(&self, robot: &Name) -> bool {
        self.robots.contains_key(robot)
    }

    pub(crate) fn names(&self) -> Vec<Name> {
        self.robots.keys().cloned().collect()
    }

    /// Handles robots whose rows were left out of a transaction.
    pub(crate) fn reject(
        &mut self,
        offenders: Vec<Offender>,
        transaction: &mut SealedTransaction,
        workers: &mut Workers,
        pipeline: &mut Pipeline,
    ) {
        for offender in offenders {
            let found = workers.robots().find(|known| known.robot_id == offender.robot_id);
            let Some(name) = found.map(|known| known.name.clone()) else { continue };
            let mut messages = self.remove(&name, offender.robot_id, transaction, workers, pipeline);
            let now = Instant::now();
            let widespread = self.is_widespread(workers);
            let suspect = self.robots.entry(name.clone()).or_insert_with(|| Suspect::new(now));
            messages.retain(|raw| raw.robot == name);
            let verdict = suspect.refused(now, messages, &offender.rejection, widespread);
            let rests = suspect.rests(now);
            warn!(
                robot = %self.full_name(&name), code = offender.rejection.code, rests,
                "restoring the robot's last committed state"
            );
            self.restore(&name, offender, rests, workers);
            if let Verdict::Quarantine(row) = verdict {
                self.quarantine(*row, workers, pipeline);
            }
        }
        self.metrics.robots_suspect.set(self.robots.len() as i64);
        pipeline.stepped(0, workers);
    }

    fn full_name<'a>(&'a self, name: &'a Name) -> FullName<'a> {
        FullName::robot(self.lease.fleet().as_str(), name.as_str())
    }

    fn is_widespread(&self, workers: &Workers) -> bool {
        let (suspects, robots) = (self.robots.len(), workers.robot_count());
        let is = suspects > SUSPECTS_FEW && suspects > robots / 4;
        let problem = || format!("the database rejects rows of {suspects} of {robots} robots: see the log");
        self.readiness.set_of(self.lease.fleet(), PART, is.then(problem));
        is
    }

    /// Removes the effects of a robot's messages since the last commit, and returns these messages in order.
    fn remove(
        &self,
        name: &Name,
        robot_id: i64,
        transaction: &mut SealedTransaction,
        workers: &mut Workers,
        pipeline: &mut Pipeline,
    ) -> Vec<RawMessage> {
        let whisker_ids = workers.robot(name).map_or(&[][..], |known| &known.whisker_ids);
        let share = RobotShare::of(name, robot_id, whisker_ids);
        let mut messages = transaction.remove_rejected(&share);
        for worker in workers.iter_mut() {
            worker.batch_mut().remove_rows(&share);
        }
        messages.extend(workers.of(name).batch_mut().remove_messages(&share));
        pipeline.retain_answers(workers);
        messages
    }

    /// Restores a robot's last committed state. Numbers already used are not used again.
    fn restore(&self, name: &Name, offender: Offender, rests: bool, workers: &mut Workers) {
        let epoch = self.lease.epoch();
        let Some(before) = workers.of(name).robots_mut().get_mut(name) else { return };
        let (seqs, later) = (std::mem::take(&mut before.seqs), before.robot.clone());
        let (refusals, repeats) = (std::mem::take(&mut before.refusals), std::mem::take(&mut before.repeats));
        let (maintenance, recorder) = (std::mem::take(&mut before.maintenance), before.recorder.take());
        let (is_excluded, withdrawal) = (before.is_excluded, before.withdrawal.clone());
        let mut replay = Replay::default();
        match offender.stored {
            Some(stored) => {
                replay.load(stored, name.clone(), epoch, workers);
                for (row, records) in offender.journal.iter().zip(&offender.records) {
                    replay.replay_row(row, records, workers);
                }
            }
            None => error!(robot = %self.full_name(name), "robot no longer in the database"),
        }
        let (robots, stepper) = workers.of(name).parts();
        let Some(known) = robots.get_mut(name) else { return };
        replay.finish_robot(known, epoch, stepper);
        known.robot.go_on_numbering_after(&later);
        (known.seqs, known.rests, known.refusals, known.repeats) = (seqs, rests, refusals, repeats);
        (known.maintenance, known.recorder) = (maintenance, recorder);
        (known.is_excluded, known.withdrawal) = (is_excluded, withdrawal);
        if let ((None, _), (Some(boot_id), link)) = (known.robot.connection_state(), later.connection_state()) {
            // Nothing of it was ever committed. Its birth came before it became known, and must be repeated.
            let birth = Event::Connection { boot_id, link };
            stepper.step(known, wall_clock(), &birth, None);
        }
    }

    /// Writes a message that the database rejects into the quarantine table, for inspection by people.
    pub(crate) fn quarantine(&self, row: QuarantineRow, workers: &mut Workers, pipeline: &mut Pipeline) {
        self.metrics.messages_quarantined.count([row.cause]);
        let robot = FullName::robot(self.lease.fleet().as_str(), &row.robot);
        let (topic, seq, cause, code) = (row.topic, row.seq, row.cause, &row.code);
        error!(%robot, topic, seq, cause, code, "message put into quarantine");
        let part = QuarantinePart { robot: row.robot.clone(), topic, cause };
        let parts = Parts { quarantine: Some(part), ..Parts::default() };
        let entry = event(EventKind::Quarantined, row.quarantined_us, &parts);
        workers.record(Record::Quarantined(Box::new(row)), Some(entry));
        pipeline.commit_now();
    }

    /// Returns the message, unless it must wait because its robot is a suspect.
    pub(crate) fn pass(&mut self, raw: RawMessage) -> Option<RawMessage> {
        if self.robots.is_empty() {
            return Some(raw);
        }
        let Some(suspect) = self.robots.get_mut(&raw.robot) else { return Some(raw) };
        let robot = raw.robot.clone();
        if !suspect.wait(raw) {
            let problem = "the database has rejected this robot's rows, and too many of its messages wait";
            self.metrics.refuse("suspect", problem, robot.as_str());
        }
        None
    }

    /// Begins the next turns of all suspects that do not rest.
    pub(crate) fn begin(&mut self, now: Instant, workers: &mut Workers) -> Vec<(Name, Vec<Turn>)> {
        let mut next: Vec<(Name, Vec<Turn>)> = Vec::new();
        for (name, suspect) in &mut self.robots {
            let rests = suspect.rests(now);
            if let Some(known) = workers.of(name).robots_mut().get_mut(name) {
                known.rests = rests;
            }
            let turns = suspect.begin(now);
            if !turns.is_empty() {
                next.push((name.clone(), turns));
            }
        }
        next
    }

    /// Whether the turns of a robot that were begun have not been rejected.
    pub(crate) fn is_under_way(&self, robot: &Name) -> bool {
        self.robots.get(robot).is_some_and(Suspect::is_under_way)
    }

    /// Notes that the turns of a robot are stepped, and belong to the transaction of this number.
    pub(crate) fn stepped(&mut self, robot: &Name, number: i64) {
        if let Some(suspect) = self.robots.get_mut(robot) {
            suspect.stepped(number);
        }
    }

    /// Confirms the suspects' messages that were stepped before a transaction was sealed, after its rows are written.
    pub(crate) fn committed(&mut self, number: i64) {
        for suspect in self.robots.values_mut() {
            suspect.committed(number);
        }
    }

    /// Forgets suspects that are ordinary robots again.
    pub(crate) fn clear(&mut self, now: Instant, workers: &Workers) {
        let before = self.robots.len();
        self.robots.retain(|_, suspect| !suspect.is_cleared(now));
        if self.robots.len() < before {
            info!(fleet = %self.lease.fleet(), suspects = self.robots.len(), "robot no longer a suspect");
            self.metrics.robots_suspect.set(self.robots.len() as i64);
            self.is_widespread(workers);
        }
    }
}
