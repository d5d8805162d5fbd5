//! A part of a fleet's robots. Each robot has one owner, its shard. Shards share nothing, so they work in parallel.

use std::time::{Duration, Instant};

use indexmap::IndexMap;
use smallvec::SmallVec;
use tracing::error;
use vibrissa_core::robot::event::Factsheet;
use vibrissa_core::robot::{Event, OperatorAction, Params, Robot, Scope};
use vibrissa_core::text::ShortText;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{BootId, Name};

use super::announced::Announced;
use super::boots::Boots;
use super::commands::Commands;
use super::commit::batch::Gathering;
use super::fingerprints::Fingerprints;
use super::fleet_metrics;
use super::history::History;
use super::limits::{BOOTS_AT_ONCE, BOOTS_PER_MINUTE, Bucket};
use super::publication;
use super::retention::Keep;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::StoredRobot;
use vibrissa_store::batch::Record;

/// Shortest interval between two restarts of a robot's silence timer after its messages were shed: a third of the time
/// after which the robot counts as silent.
const LISTEN_EVERY: Duration = Duration::from_secs(5);

/// A robot with its row ids in the database.
pub(super) struct Known {
    pub(super) name: Name,
    pub(super) robot_id: i64,
    pub(super) robot: Robot,
    pub(super) whisker_ids: Vec<i64>,
    pub(super) boots: Boots,
    /// Limits the rate of new boots.
    pub(super) new_boots: Bucket,
    /// Limits the rate of new layouts.
    pub(super) new_layouts: Bucket,
    /// Last time that its silence timer was restarted because its messages were shed.
    pub(super) listened_anew: Option<Instant>,
    /// The last boot refused by the rate limit; it is accepted once the limit allows it.
    pub(super) refused_boot: Option<BootId>,
    /// Next `seq` of each topic to this robot.
    pub(super) seqs: publication::Seqs,
    /// Last measured error of each compensation.
    pub(super) stated: fleet_metrics::Stated,
    /// History of its contacts on the way to the tables.
    pub(super) history: History,
    /// Where its state is stored.
    pub(super) stored: Stored,
    /// Setpoints sent to it.
    pub(super) commands: Commands,
    /// Hashes of its newest `contacts` messages.
    pub(super) fingerprints: Fingerprints,
    /// Boots whose contacts are due for a receipt.
    pub(super) receipts_due: SmallVec<[ShortText; 1]>,
    /// The database has repeatedly rejected its rows: it gets no events for a while.
    pub(super) rests: bool,
}

/// Where a robot's durable state is, once the open batch is committed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    /// In its checkpoint.
    State,
    /// In its checkpoint, and in the journal's entries from this number on.
    Journal(i64),
    /// In a checkpoint that the open batch must write.
    Next,
    /// In a checkpoint older than its takeover here, to which no journal entry may be added.
    Before,
}

impl Known {
    /// A new robot.
    pub(super) fn new(name: Name, robot_id: i64, robot: Robot, keep: Keep) -> Self {
        Self {
            name,
            robot_id,
            robot,
            whisker_ids: Vec::new(),
            boots: Boots::default(),
            new_boots: Bucket::new(BOOTS_AT_ONCE, BOOTS_PER_MINUTE),
            new_layouts: Bucket::new(BOOTS_AT_ONCE, BOOTS_PER_MINUTE),
            listened_anew: None,
            refused_boot: None,
            seqs: publication::Seqs::default(),
            stated: fleet_metrics::Stated::default(),
            history: History::new(keep),
            stored: Stored::State,
            commands: Commands::default(),
            fingerprints: Fingerprints::default(),
            receipts_due: SmallVec::new(),
            rests: false,
        }
    }

    /// A robot as it was stored, before it is taken over. Bytes of another version of the program cannot be read: then
    /// the robot starts without learned state and without alarms, and is held as a whole if any part of it was.
    pub(super) fn as_stored(
        name: Name,
        stored: StoredRobot,
        epoch: u64,
        params: &Params,
        gathering: &mut Gathering,
    ) -> Self {
        let restored = stored.state.as_ref().map(|state| Robot::restore(state, &stored.whisker_states));
        let (robot, whisker_ids) = match restored {
            Some(Ok(mut robot)) => {
                robot.share_models(params);
                (robot, stored.whisker_ids)
            }
            Some(Err(problem)) => {
                error!(robot = stored.robot, %problem, "cannot read the checkpoint, its learned state is lost");
                let now = wall_clock();
                let record = Record::AlarmsForgotten { robot_id: stored.robot_id, cleared_us: now.0 as i64 };
                gathering.batch.records.push(record);
                let mut robot = Robot::new(epoch, stored.numbers).taken_up();
                if stored.held {
                    let hold = OperatorAction::Hold(Scope::Robot);
                    robot.step(params, now, &Event::Operator(&hold), &mut Vec::new());
                }
                (robot, Vec::new())
            }
            None => (Robot::new(epoch, stored.numbers), Vec::new()),
        };
        let rollups = if whisker_ids.is_empty() { &[][..] } else { &stored.rollups };
        let keep = gathering.keep;
        let history = History::taken_up(keep, rollups, wall_clock());
        Self { whisker_ids, boots: stored.boots.into(), history, ..Self::new(name, stored.robot_id, robot, keep) }
    }

    /// Starts supervision under a new epoch.
    pub(super) fn begin(&mut self, epoch: u64, params: &Params) {
        self.robot.take_up(epoch, wall_clock());
        self.stated = fleet_metrics::Stated::of(&self.robot, params);
        self.stored = Stored::Before;
        self.commands = Commands::taken_up();
    }

    /// Number of a boot, 0 if it has none.
    pub(super) fn boot(&self, boot_id: &str) -> i64 {
        self.boots.get(boot_id).unwrap_or_default()
    }

    /// Whether a factsheet contains nothing new, and all its whiskers have row ids.
    pub(super) fn is_laid_out(&self, factsheet: &Factsheet) -> bool {
        self.robot.is_as_known(factsheet) && self.whisker_ids.len() == self.robot.whisker_count()
    }

    pub(super) fn whisker_id(&self, index: usize) -> i64 {
        self.whisker_ids.get(index).copied().unwrap_or_default()
    }
}

/// A part of a fleet's robots, and their open batch.
pub(super) struct Shard {
    /// In the order in which they became known. Robots are never removed, so indices stay valid.
    pub(super) robots: IndexMap<Name, Known>,
    /// Robots whose factsheets are missing.
    pub(super) announced: Announced,
    pub(super) gathering: Gathering,
    /// The epoch of the fleet's lease.
    pub(super) epoch: u64,
    /// Number of robots that have got the current tick, if it was interrupted.
    pub(super) told_until: Option<usize>,
}

impl Shard {
    /// Steps a tick through the robots, beginning with the first that has not got it yet, until so many whiskers need a
    /// checkpoint. The limit keeps an event that affects a whole fleet from blocking everything else with one long
    /// transaction. Returns false if the tick is interrupted.
    pub(super) fn tick(&mut self, now: Micros, whiskers_max: usize) -> bool {
        let told = self.told_until.take().unwrap_or_default();
        if told == 0 {
            self.announced.tick(&mut self.gathering, now);
        }
        for (index, known) in self.robots.values_mut().enumerate().skip(told) {
            if known.rests {
                continue;
            }
            self.gathering.take_refused_boot(known, now);
            self.gathering.step(known, now, &Event::Tick, None);
            if self.gathering.waiting.next_whiskers() >= whiskers_max {
                self.told_until = Some(index + 1);
                return false;
            }
        }
        true
    }

    /// Restarts the silence timers of all robots, because this supervisor was deaf.
    pub(super) fn listen_from(&mut self, now: Micros) {
        for known in self.robots.values_mut() {
            known.robot.listen_from(now);
            // A journal entry may be replayed only after a checkpoint that contains this change.
            self.gathering.store_next(known);
        }
    }
}

impl Shard {
    /// Restarts the robot's silence timer after its messages were shed. Each restart needs a checkpoint, so they are
    /// limited.
    pub(super) fn listen_to_one_from(&mut self, name: &Name, now: Micros) {
        let Some(known) = self.robots.get_mut(name) else { return };
        if known.listened_anew.is_none_or(|last| last.elapsed() >= LISTEN_EVERY) {
            known.listened_anew = Some(Instant::now());
            known.robot.listen_from(now);
            self.gathering.store_next(known);
        }
    }
}

/// The shard of a robot. Depends only on its name and the number of shards.
pub(super) fn shard_of(name: &Name, shards: usize) -> usize {
    // FNV-1a, so that the result is the same in every build.
    let hash = name
        .as_str()
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    // The low bits depend on the last letter, the high ones hardly do.
    let mixed = (hash ^ (hash >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 33;
    (mixed % shards.max(1) as u64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_spread_over_all_shards_and_stay_where_they_are() {
        let mut counts = [0; 4];
        for number in 0..1000 {
            let name = Name::robot(&format!("robot-{number:04}")).unwrap();
            let shard = shard_of(&name, counts.len());
            assert_eq!(shard, shard_of(&name, counts.len()));
            counts[shard] += 1;
        }
        assert!(counts.iter().all(|&count| count > 200), "{counts:?}");
    }
}
