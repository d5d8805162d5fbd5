//! Handling of a robot whose rows the database has rejected: it is restored to its last committed state, and becomes a
//! suspect.

use std::collections::{BTreeSet, HashMap};

use tokio::time::Instant;
use tracing::{error, info, warn};
use vibrissa_core::robot::Event;
use vibrissa_protocol::{Name, RobotTopic};

use crate::engine::Engine;
use crate::engine::commit::batch::Sealed;
use crate::engine::commit::committer::{LeaseLost, Offender};
use crate::engine::commit::recovery::Journey;
use crate::engine::intake::Parcel;
use crate::engine::quarantine::suspects::{Suspect, Turn, Verdict};
use crate::engine::shard::shard_of;
use crate::outbox::Publication;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::batch::{Owner, Owners, QuarantineRow, Record};

/// If there are more suspects than this, and more than a quarter of the robots, the database is at fault rather than
/// messages.
const SUSPECTS_FEW: usize = 8;
/// Name of this part in the service's readiness.
const PART: &str = "quarantine";

impl Engine {
    /// Handles robots whose rows were left out of a transaction.
    pub(in crate::engine) fn convict(&mut self, offenders: Vec<Offender>, sealed: &mut Sealed) {
        for offender in offenders {
            let found = self.shards.iter().flat_map(|shard| shard.robots.values());
            let known = found.filter(|known| known.robot_id == offender.robot_id);
            let Some(name) = known.map(|known| known.name.clone()).next() else { continue };
            let mut messages = self.disown(&name, offender.robot_id, sealed);
            let now = Instant::now();
            let widespread = self.is_widespread();
            let suspect = self.suspects.entry(name.clone()).or_insert_with(|| Suspect::new(now));
            messages.retain(|parcel| parcel.robot == name);
            let verdict = suspect.refused(now, messages, &offender.rejection, widespread);
            let rests = suspect.rests(now);
            warn!(
                fleet = %self.fleet, robot = %name, code = offender.rejection.code, rests,
                "restoring the robot's last committed state"
            );
            self.restore(&name, offender, rests);
            if let Verdict::Quarantine(row) = verdict {
                self.quarantine(*row);
            }
        }
        self.metrics.robots_suspect.set(self.suspects.len() as i64);
        self.gathered(0);
    }

    fn is_widespread(&self) -> bool {
        let robots: usize = self.shards.iter().map(|shard| shard.robots.len()).sum();
        let suspects = self.suspects.len();
        let is = suspects > SUSPECTS_FEW && suspects > robots / 4;
        let problem = || format!("the database rejects rows of {suspects} of {robots} robots: see the log");
        self.readiness.set_of(&self.fleet, PART, is.then(problem));
        is
    }

    /// Removes the effects of a robot's messages since the last commit, and returns these messages in order.
    fn disown(&mut self, name: &Name, robot_id: i64, sealed: &mut Sealed) -> Vec<Parcel> {
        let at = shard_of(name, self.shards.len());
        let whiskers: HashMap<i64, i64> = self.shards[at]
            .robots
            .get(name)
            .map(|known| known.whisker_ids.iter().map(|&whisker_id| (whisker_id, robot_id)).collect())
            .unwrap_or_default();
        let owners = Owners { whiskers, ..Owners::default() };
        let stays = |owner: Owner| owner != Owner::Robot(robot_id);
        let level = level_of(name, &self.fleet);
        let is_other = |publication: &Publication| !publication.topic.starts_with(&level);
        sealed.publications.retain(is_other);
        let mut messages = take_of(&mut sealed.messages, name);
        for kept in &mut self.kept {
            kept.batch.retain(&owners, stays);
            if let Some(journal) = &mut kept.batch.journal {
                let others = crate::engine::commit::journal::by_robot(&journal.entries)
                    .into_iter()
                    .filter(|(other, _)| *other != robot_id);
                journal.entries = others.flat_map(|(_, entries)| entries).collect();
            }
            // The robot's earlier entries may be needed again.
            kept.batch.journal_done = None;
            kept.publications.retain(is_other);
            messages.extend(take_of(&mut kept.messages, name));
        }
        for shard in &mut self.shards {
            let gathering = &mut shard.gathering;
            gathering.batch.retain(&owners, stays);
            gathering.publications.retain(is_other);
        }
        let gathering = &mut self.shards[at].gathering;
        gathering.journal.remove(robot_id);
        messages.extend(take_of(&mut gathering.messages, name));
        // An action whose answer was left out is pending again.
        let answers = |records: &[Record]| {
            let mut ids = BTreeSet::new();
            for record in records {
                if let Record::Answer { action_id, .. } = record {
                    ids.insert(*action_id);
                }
            }
            ids
        };
        let committed = answers(&sealed.batch.records);
        sealed.answered.retain(|action_id| committed.contains(action_id));
        let open: BTreeSet<i64> =
            self.shards.iter().flat_map(|shard| answers(&shard.gathering.batch.records)).collect();
        self.answered.retain(|action_id| open.contains(action_id));
        messages
    }

    /// Restores a robot's last committed state. Numbers already used are not used again.
    fn restore(&mut self, name: &Name, offender: Offender, rests: bool) {
        let at = shard_of(name, self.shards.len());
        let epoch = self.lease.epoch();
        let Some(before) = self.shards[at].robots.get_mut(name) else { return };
        let (seqs, later) = (std::mem::take(&mut before.seqs), before.robot.clone());
        let mut journey = Journey::default();
        match offender.stored {
            Some(stored) => {
                journey.place(stored, name.clone(), epoch, &mut self.shards);
                for (number, entries) in &offender.journal {
                    journey.go_through(*number, entries, &mut self.shards);
                }
            }
            None => error!(fleet = %self.fleet, robot = %name, "robot no longer in the database"),
        }
        let shard = &mut self.shards[at];
        let Some(known) = shard.robots.get_mut(name) else { return };
        journey.arrive_at(known, epoch, &mut shard.gathering);
        known.robot.go_on_numbering_after(&later);
        (known.seqs, known.rests) = (seqs, rests);
        if let ((None, _), (Some(boot_id), link)) = (known.robot.connection_state(), later.connection_state()) {
            // Nothing of it was ever committed. Its birth came before it became known, and must be repeated.
            let birth = Event::Connection { boot_id, link };
            shard.gathering.step(known, wall_clock(), &birth, None);
        }
    }

    /// Writes a message that the database rejects into the quarantine table, for inspection by people.
    pub(in crate::engine) fn quarantine(&mut self, row: QuarantineRow) {
        self.metrics.messages_quarantined.count([row.cause]);
        let (robot, topic, seq, cause, code) = (&row.robot, row.topic, row.seq, row.cause, &row.code);
        error!(fleet = %self.fleet, robot, topic, seq, cause, code, "message put into quarantine");
        self.record(Record::Quarantined(Box::new(row)));
        self.rounds.due_by(Instant::now());
    }

    /// Returns the message, unless it must wait because its robot is a suspect.
    pub(in crate::engine) fn unless_suspect(&mut self, parcel: Parcel) -> Option<Parcel> {
        if self.suspects.is_empty() {
            return Some(parcel);
        }
        let Some(suspect) = self.suspects.get_mut(&parcel.robot) else { return Some(parcel) };
        let robot = parcel.robot.clone();
        if !suspect.wait(parcel) {
            let problem = "the database has rejected this robot's rows, and too many of its messages wait";
            self.metrics.refuse("suspect", problem, robot.as_str());
        }
        None
    }

    /// Steps the next messages of suspects.
    pub(in crate::engine) async fn go_on_with_suspects(&mut self) -> Result<(), LeaseLost> {
        let now = Instant::now();
        let mut next: Vec<(Name, Vec<Turn>)> = Vec::new();
        for (name, suspect) in &mut self.suspects {
            let rests = suspect.rests(now);
            let shard = shard_of(name, self.shards.len());
            if let Some(known) = self.shards[shard].robots.get_mut(name) {
                known.rests = rests;
            }
            let turns = suspect.begin(now);
            if !turns.is_empty() {
                next.push((name.clone(), turns));
            }
        }
        for (name, turns) in next {
            self.step_turns(&name, turns).await?;
        }
        let before = self.suspects.len();
        self.suspects.retain(|_, suspect| !suspect.is_cleared(now));
        if self.suspects.len() < before {
            info!(fleet = %self.fleet, suspects = self.suspects.len(), "robot no longer a suspect");
            self.metrics.robots_suspect.set(self.suspects.len() as i64);
            self.is_widespread();
        }
        Ok(())
    }

    async fn step_turns(&mut self, name: &Name, turns: Vec<Turn>) -> Result<(), LeaseLost> {
        let shard = shard_of(name, self.shards.len());
        let count = turns.len();
        for turn in turns {
            // A transaction sealed meanwhile may have been rejected: then all turns wait again.
            if !self.suspects.get(name).is_some_and(Suspect::is_under_way) {
                return Ok(());
            }
            match turn {
                Turn::Receipt(parcel) => self.shards[shard].receipt_alone(&parcel),
                Turn::Message(parcel) if parcel.kind == RobotTopic::Factsheet => {
                    self.take_factsheet(shard, parcel).await?;
                }
                Turn::Message(parcel) => self.shards[shard].handle(&parcel),
            }
        }
        // The suspect keeps these messages, not the transaction.
        self.shards[shard].gathering.messages.retain(|parcel| parcel.robot != *name);
        let number = self.number + 1;
        if let Some(suspect) = self.suspects.get_mut(name) {
            suspect.stepped(number);
        }
        self.gathered(count);
        self.rounds.due_by(Instant::now());
        if self.shards.iter().all(|shard| shard.gathering.is_empty()) && self.committing.is_none() {
            // The messages had no effects.
            self.suspects_committed(number);
        }
        Ok(())
    }

    /// Confirms the suspects' messages that were stepped before a transaction was sealed, after its rows are written.
    pub(in crate::engine) fn suspects_committed(&mut self, number: i64) {
        for suspect in self.suspects.values_mut() {
            suspect.committed(number);
        }
    }
}

fn level_of(robot: &Name, fleet: &Name) -> String {
    let topic = RobotTopic::Receipt.of(fleet, robot).to_string();
    topic.strip_suffix(RobotTopic::Receipt.as_str()).unwrap_or(&topic).to_owned()
}

/// Takes one robot's messages out of a list.
fn take_of(messages: &mut Vec<Parcel>, name: &Name) -> Vec<Parcel> {
    messages.extract_if(.., |parcel| parcel.robot == *name).collect()
}
