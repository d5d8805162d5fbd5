//! A robot as the engine knows it: the core's state, its rows in the database, and the answers that it may still give.

pub(crate) mod boots;
pub(crate) mod commands;
pub(crate) mod errors;
pub(crate) mod estimates;
pub(crate) mod fingerprints;
pub(crate) mod history;
pub(crate) mod limits;
pub(crate) mod maintenance;
pub(crate) mod refusals;
pub(crate) mod repeats;
pub(crate) mod retention;
pub mod rollup;
pub(crate) mod seqs;
pub(crate) mod told;

use indexmap::IndexMap;
use smallvec::SmallVec;
use tokio::time::Instant;
use tracing::error;
use vibrissa_core::policy::Case;
use vibrissa_core::robot::event::Factsheet;
use vibrissa_core::robot::{Event, OperatorAction, Params, RestoreError, Robot, Scope};
use vibrissa_core::text::ShortText;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{BootId, Name};

use crate::black_box::Recorder;
use crate::engine::ledger::Account;
use crate::outbox::Withdrawal;
use boots::Boots;
use commands::Commands;
use errors::MeasuredErrors;
use estimates::Estimates;
use fingerprints::Fingerprints;
use history::History;
use limits::{BOOTS_AT_ONCE, BOOTS_PER_MINUTE, Bucket};
use maintenance::Maintenance;
use refusals::Refusals;
use repeats::Repeats;
use retention::ContactRetention;
use seqs::Seqs;
use told::Told;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::full_name::FullName;
use vibrissa_store::StoredRobot;
use vibrissa_store::batch::Record;

/// Robots by name, in the order in which they became known. A decommissioned one is removed, which moves the later ones.
pub(crate) type Robots = IndexMap<Name, KnownRobot>;

/// A robot with its row ids in the database.
pub(crate) struct KnownRobot {
    pub(crate) fleet: Name,
    pub(crate) name: Name,
    pub(crate) robot_id: i64,
    pub(crate) robot: Robot,
    pub(crate) whisker_ids: Vec<i64>,
    pub(crate) boots: Boots,
    /// Since when its connection is as it is; `None` if it was so before this supervisor knew it.
    pub(crate) linked: Option<Instant>,
    /// A message of its newest boot was received since this supervisor knows it.
    pub(crate) is_heard: bool,
    /// Limits the rate of new boots.
    pub(crate) new_boots: Bucket,
    /// Limits the rate of new layouts.
    pub(crate) new_layouts: Bucket,
    /// Bytes that its effects may add to the database.
    pub(crate) account: Account,
    /// Until when its messages were shed.
    pub(crate) deaf_until: Micros,
    /// The last boot refused by the rate limit; it is accepted once the limit allows it.
    pub(crate) refused_boot: Option<BootId>,
    /// Next `seq` of each topic to this robot.
    pub(crate) seqs: Seqs,
    /// Estimates published to it.
    pub(crate) estimates: Estimates,
    /// Facts for its maintenance, and when they were published.
    pub(crate) maintenance: Maintenance,
    /// Last measured error of each compensation.
    pub(crate) errors: MeasuredErrors,
    /// History of its contacts on the way to the tables.
    pub(crate) history: History,
    /// Where its state is durable.
    pub(crate) durable: Durable,
    /// Setpoints sent to it.
    pub(crate) commands: Commands,
    /// Hashes of its newest `contacts` messages.
    pub(crate) fingerprints: Fingerprints,
    /// Counts of its refusals.
    pub(crate) refusals: Refusals,
    /// Boots whose contacts are due for a receipt.
    pub(crate) receipts_due: SmallVec<[ShortText; 1]>,
    /// Contacts that it repeats although they were receipted.
    pub(crate) repeats: Repeats,
    /// Since when the factsheet of its boot has been missing.
    pub(crate) factsheet_missing: Option<Instant>,
    /// The allow list excludes it: none of its messages is taken, and it raises no alarms.
    pub(crate) is_excluded: bool,
    /// Withdraws its setpoints and requests of touch tests once the allow list excludes it.
    pub(crate) withdrawal: Withdrawal,
    /// Its programs and segmenters, for people.
    pub(crate) told: Told,
    /// Its row does not say yet that the allow list has begun or ended to exclude it, or which programs it has.
    pub(crate) is_row_due: bool,
    /// The database has repeatedly rejected its rows: it gets no events for a while.
    pub(crate) rests: bool,
    /// Its messages for black boxes; `None` before the first message.
    pub(crate) recorder: Option<Box<Recorder>>,
}

/// Where a robot's durable state is, once the open batch is committed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Durable {
    /// In its checkpoint.
    Checkpoint,
    /// In its checkpoint, and in the journal's entries from this number on.
    Journal(i64),
    /// In a checkpoint that the open batch must write.
    NextCheckpoint,
    /// In a checkpoint older than its takeover here, to which no journal entry may be added.
    BeforeTakeover,
}

impl KnownRobot {
    /// A new robot.
    pub(crate) fn new((fleet, name): (Name, Name), robot_id: i64, robot: Robot, retention: ContactRetention) -> Self {
        Self {
            fleet,
            name,
            robot_id,
            robot,
            whisker_ids: Vec::new(),
            boots: Boots::default(),
            linked: None,
            is_heard: false,
            new_boots: Bucket::new(BOOTS_AT_ONCE, BOOTS_PER_MINUTE),
            new_layouts: Bucket::new(BOOTS_AT_ONCE, BOOTS_PER_MINUTE),
            account: Account::default(),
            deaf_until: Micros::default(),
            refused_boot: None,
            seqs: Seqs::default(),
            estimates: Estimates::default(),
            maintenance: Maintenance::default(),
            errors: MeasuredErrors::default(),
            history: History::new(retention),
            durable: Durable::Checkpoint,
            commands: Commands::default(),
            fingerprints: Fingerprints::default(),
            refusals: Refusals::default(),
            receipts_due: SmallVec::new(),
            repeats: Repeats::default(),
            factsheet_missing: None,
            is_excluded: false,
            withdrawal: Withdrawal::default(),
            told: Told::default(),
            is_row_due: false,
            rests: false,
            recorder: None,
        }
    }

    /// A robot as it was stored, before it is taken over. If its bytes are damaged, or of a version that is not read any more,
    /// the robot starts without learned state and without alarms, as the returned record says, and is held as a whole
    /// if any part of it was. `None` if a newer version of the program has written them: they are for that version.
    pub(crate) fn restored(
        (fleet, name): (Name, Name),
        stored: StoredRobot,
        epoch: u64,
        params: &Params,
        retention: ContactRetention,
    ) -> Option<(Self, Option<Record>)> {
        let restored = stored.state.as_ref().map(|state| Robot::restore(state, &stored.whisker_states));
        let mut forgotten = None;
        let (robot, whisker_ids) = match restored {
            Some(Ok(mut robot)) => {
                robot.share_models(params);
                (robot, stored.whisker_ids)
            }
            Some(Err(RestoreError::Newer)) => return None,
            Some(Err(problem @ (RestoreError::Head | RestoreError::Whisker(_) | RestoreError::Layout))) => {
                let robot = FullName::robot(fleet.as_str(), name.as_str());
                error!(%robot, %problem, "cannot read the checkpoint, its learned state is lost");
                let now = wall_clock();
                forgotten = Some(Record::AlarmsForgotten { robot_id: stored.robot_id, cleared_us: now.0 as i64 });
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
        let history = History::taken_up(retention, rollups, wall_clock());
        let told = Told::restored(stored.software, whisker_ids.iter().copied().zip(&stored.segmenters));
        let new = Self::new((fleet, name), stored.robot_id, robot, retention);
        Some((Self { whisker_ids, boots: stored.boots.into(), history, told, ..new }, forgotten))
    }

    /// Starts supervision under a new epoch.
    pub(crate) fn begin(&mut self, epoch: u64, params: &Params) {
        self.robot.take_up(epoch, wall_clock());
        self.errors = MeasuredErrors::of(&self.robot, params);
        self.durable = Durable::BeforeTakeover;
        self.commands = Commands::taken_up();
    }

    /// Its full name, for logs.
    pub(crate) fn full_name(&self) -> FullName<'_> {
        FullName::robot(self.fleet.as_str(), self.name.as_str())
    }

    /// The full name of a whisker, for logs; that of the robot if there is no such whisker.
    pub(crate) fn full_name_of(&self, index: usize) -> FullName<'_> {
        let whisker = self.robot.whisker(index);
        whisker.map_or(self.full_name(), |view| self.full_name().whisker(view.array, view.sheet.number))
    }

    /// Number of a boot, 0 if it has none.
    pub(crate) fn boot(&self, boot_id: &str) -> i64 {
        self.boots.get(boot_id).unwrap_or_default()
    }

    /// Whether a factsheet contains nothing new, and all its whiskers have row ids.
    pub(crate) fn is_laid_out(&self, factsheet: &Factsheet) -> bool {
        self.robot.is_as_known(factsheet) && self.whisker_ids.len() == self.robot.whisker_count()
    }

    pub(crate) fn whisker_id(&self, index: usize) -> i64 {
        self.whisker_ids.get(index).copied().unwrap_or_default()
    }

    /// Target of a compensation that is in force or proposed.
    pub(crate) fn target_of(&self, compensation: u32) -> Option<usize> {
        self.robot.compensations().iter().find(|one| one.id() == compensation).map(|one| one.target())
    }

    /// Case of a compensation that is in force or proposed.
    pub(crate) fn case_of(&self, compensation: u32) -> Option<Case> {
        self.robot.compensations().iter().find(|one| one.id() == compensation).map(|one| one.case())
    }
}
