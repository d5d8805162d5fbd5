//! Recovery of a fleet: intents become rows, checkpoints are loaded, and the journal is replayed.

use std::collections::BTreeMap;
use std::time::Instant;

use tracing::{error, info};
use vibrissa_core::robot::Event;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::{Contact, WhiskerStatus};
use vibrissa_protocol::Name;

use crate::engine::commit::batch::{Gathering, is_ordinary};
use crate::engine::commit::journal::{Entry, Told, by_robot, read};
use crate::engine::shard::{Known, Shard, shard_of};
use vibrissa_store::StoredRobot;
use vibrissa_store::batch::Batch;
use vibrissa_store::{Lease, Refused, StoreError, Writer};

/// Number of journal rows read at a time.
pub(in crate::engine) const ROWS_AT_A_TIME: i64 = 256;

/// Facts about a robot that the replay needs.
struct Follower {
    name: Name,
    shard: usize,
    /// Entries up to this number are contained in its checkpoint.
    journal_number: i64,
    arrays: Vec<String>,
    boots: BTreeMap<i64, String>,
    has_gone_on: bool,
}

/// Writes the rows of the transactions in the intent log. An unreadable one is logged and dropped.
async fn write_kept(writer: &mut Writer, lease: &Lease) -> Result<(), StoreError> {
    while let Some((number, bytes)) = writer.pending_intent(lease).await? {
        let batch = Batch::from_bytes(&bytes).unwrap_or_else(|problem| {
            let (fleet, bytes) = (lease.fleet(), bytes.len());
            error!(%fleet, number, bytes, %problem, "cannot read a transaction of the intent log, its rows are lost");
            Batch::default()
        });
        write_rows(writer, lease, Batch { redo_done: Some(number), ..batch }).await?;
        info!(fleet = %lease.fleet(), number, "wrote the rows of a transaction of the intent log");
    }
    Ok(())
}

/// Writes a batch. Rows that the database rejects permanently are logged and dropped, so that the recovery continues.
async fn write_rows(writer: &mut Writer, lease: &Lease, mut batch: Batch) -> Result<(), StoreError> {
    match writer.commit(lease, &batch).await {
        Err(problem) if problem.rejection().is_some() => {}
        written => return written,
    }
    let mut refused = Vec::new();
    writer.commit_apart(lease, &mut batch, by_robot, &mut refused).await?;
    for Refused { owner, rejection } in refused {
        let (code, text) = (rejection.code, rejection.text);
        error!(fleet = %lease.fleet(), ?owner, code, text, "database rejects rows of the intent log, they are lost");
    }
    Ok(())
}

/// Loads the robots of a fleet into their shards. Returns the number of the last journal entry.
pub(in crate::engine) async fn take_up(
    writer: &mut Writer,
    lease: &Lease,
    shards: &mut [Shard],
) -> Result<i64, StoreError> {
    write_kept(writer, lease).await?;
    let (mut journey, mut last) = (Journey::default(), 0);
    for stored in writer.robots(lease).await? {
        last = last.max(stored.journal_number);
        if let Ok(name) = Name::robot(&stored.robot) {
            journey.place(stored, name, lease.epoch(), shards);
        }
    }
    let (begun, mut entries) = (Instant::now(), 0);
    let mut after = -1;
    loop {
        let rows = writer.journal(lease, after, ROWS_AT_A_TIME).await?;
        let Some((newest, _)) = rows.last() else { break };
        after = *newest;
        last = last.max(after);
        for (number, bytes) in &rows {
            entries += journey.go_through(*number, bytes, shards);
        }
    }
    journey.arrive(lease.epoch(), shards);
    if entries > 0 {
        let seconds = begun.elapsed().as_secs_f64();
        info!(fleet = %lease.fleet(), entries, seconds, "journal replayed");
    }
    Ok(last)
}

/// Replay of the journal, from the checkpoints to the last commit.
#[derive(Default)]
pub(in crate::engine) struct Journey {
    followers: BTreeMap<i64, Follower>,
}

impl Journey {
    /// Puts a robot into its shard. The journal is replayed for robots that have whiskers.
    pub(in crate::engine) fn place(&mut self, stored: StoredRobot, name: Name, epoch: u64, shards: &mut [Shard]) {
        // It has only announced itself, to an earlier version of the program: see `announced`.
        if stored.boots.is_empty() && stored.whisker_ids.is_empty() && !stored.held {
            return;
        }
        let at = shard_of(&name, shards.len());
        let shard = &mut shards[at];
        let (robot_id, journal_number) = (stored.robot_id, stored.journal_number);
        let params = shard.gathering.params.clone();
        let known = Known::as_stored(name.clone(), stored, epoch, &params, &mut shard.gathering);
        if !known.whisker_ids.is_empty() {
            let follower = Follower {
                name: name.clone(),
                shard: at,
                journal_number,
                arrays: known.robot.arrays().map(str::to_owned).collect(),
                boots: known.boots.by_number(),
                has_gone_on: false,
            };
            self.followers.insert(robot_id, follower);
        }
        shard.robots.insert(name, known);
    }

    /// Replays one row of the journal. Returns the number of its entries that were replayed.
    pub(in crate::engine) fn go_through(&mut self, number: i64, bytes: &[u8], shards: &mut [Shard]) -> usize {
        let mut count = 0;
        for entry in read(bytes) {
            let entry = match entry {
                Ok(entry) => entry,
                Err(problem) => {
                    error!(number, %problem, "cannot read the journal, the rest of its row is lost");
                    break;
                }
            };
            let follower = self.followers.get_mut(&entry.robot_id);
            let Some(follower) = follower.filter(|one| one.journal_number < number) else { continue };
            count += 1;
            follower.go_on(&entry, &mut shards[follower.shard]);
        }
        count
    }

    /// Starts the new epoch for all robots, which are now as of the last commit, and schedules checkpoints of those
    /// that were replayed.
    fn arrive(&self, epoch: u64, shards: &mut [Shard]) {
        for Shard { robots, gathering, .. } in shards {
            for known in robots.values_mut() {
                self.arrive_at(known, epoch, gathering);
            }
        }
    }

    /// Does the same for one robot.
    pub(in crate::engine) fn arrive_at(&self, known: &mut Known, epoch: u64, gathering: &mut Gathering) {
        known.begin(epoch, &gathering.params);
        if self.followers.get(&known.robot_id).is_some_and(|follower| follower.has_gone_on) {
            gathering.store_next(known);
        }
    }
}

impl Follower {
    fn go_on(&mut self, entry: &Entry, shard: &mut Shard) {
        self.has_gone_on = true;
        let Some(known) = shard.robots.get_mut(&self.name) else { return };
        let boot_of = |boot: &i64| self.boots.get(boot).map_or("", String::as_str);
        match &entry.told {
            Told::Tick => shard.gathering.go_again(known, entry, &Event::Tick),
            Told::Contacts { boot, seq, contacts } => {
                let contacts: Vec<Contact<'_>> = contacts.iter().filter_map(|one| one.contact(&self.arrays)).collect();
                let event = Event::Contacts { boot_id: boot_of(boot), seq: *seq, contacts: &contacts };
                shard.gathering.go_again(known, entry, &event);
            }
            Told::Status { boot, robot_time, whiskers } => {
                let whiskers: Vec<WhiskerStatus<'_>> =
                    whiskers.iter().filter_map(|one| one.status(&self.arrays)).collect();
                let event = Event::Status { boot_id: boot_of(boot), robot_time: *robot_time, whiskers: &whiskers };
                shard.gathering.go_again(known, entry, &event);
            }
        }
    }
}

impl Gathering {
    /// Replays an event. Its rows are already written, so only the open minutes and hours need its effects. Effects
    /// other than ordinary ones are new, because parameters have changed, and are recorded.
    fn go_again(&mut self, known: &mut Known, entry: &Entry, event: &Event<'_>) {
        let mut effects = Vec::new();
        known.robot.step(&self.params, entry.now, event, &mut effects);
        let mut written = Batch::default();
        for effect in effects {
            if !is_ordinary(&effect) {
                self.record(known, entry.now, effect, None);
            } else if let (Effect::Contact(record), Told::Contacts { boot, seq, contacts }) = (&effect, &entry.told) {
                let Some(kept) = contacts.get(record.position) else { continue };
                let row = kept.row(record, known.whisker_id(record.whisker), (*boot, *seq), entry.now);
                known.history.felt(record.whisker, record.used, row, &mut written);
            } else if let Effect::Response(_) = effect {
                known.history.serves(&mut written);
            }
        }
    }
}
