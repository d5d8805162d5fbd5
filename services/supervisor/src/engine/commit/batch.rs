//! The open batch of a shard: rows, journal entries and checkpoints of the next transaction, and the publications after
//! it.

use std::collections::BTreeMap;
use std::hash::RandomState;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tracing::warn;
use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::{Event, Outcome, Params};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, BootId, Name};

use crate::engine::allowed::{Allowed, TurnedAway};
use crate::engine::commit::checkpoint::Waiting;
use crate::engine::commit::journal::Journal;
use crate::engine::fleet_metrics;
use crate::engine::intake::Parcel;
use crate::engine::retention::Keep;
use crate::engine::shard::{Known, Stored};
use crate::metrics::FleetMetrics;
use crate::outbox::Publication;
use crate::trace::{Lives, Step, Untold, is_told};
use vibrissa_store::Batch;

/// Shortest interval between two warnings with the same reason.
const WARNED_EVERY: Duration = Duration::from_secs(60);

/// A contacts message with the number of its boot in the database.
#[derive(Clone, Copy)]
pub(in crate::engine) struct Source<'a> {
    pub(in crate::engine) told: &'a protocol::Contacts,
    pub(in crate::engine) boot: i64,
}

/// Open batch of a shard: the effects of its steps since the last transaction was sealed.
pub(in crate::engine) struct Gathering {
    pub(in crate::engine) fleet: Name,
    pub(in crate::engine) boot_id: BootId,
    pub(in crate::engine) params: Arc<Params>,
    pub(in crate::engine) metrics: FleetMetrics,
    /// Which contacts get a row of their own.
    pub(in crate::engine) keep: Keep,
    /// The allow list of robots.
    pub(in crate::engine) allowed: Allowed,
    /// Robots that are not on the allow list.
    pub(in crate::engine) turned_away: TurnedAway,
    /// Number of the open transaction in the fleet's journal.
    pub(in crate::engine) number: i64,
    pub(in crate::engine) batch: Batch,
    pub(in crate::engine) journal: Journal,
    pub(in crate::engine) publications: Vec<Publication>,
    /// A setpoint is among the publications, so the transaction must not wait.
    pub(in crate::engine) is_urgent: bool,
    /// The messages behind the rows, in case the database rejects the rows.
    pub(in crate::engine) messages: Vec<Parcel>,
    /// The current message has changed a robot.
    pub(in crate::engine) has_stepped: bool,
    /// Times of the `contacts` messages in the batch.
    pub(in crate::engine) taken: Vec<fleet_metrics::Taken>,
    /// Robots that need a checkpoint.
    pub(in crate::engine) waiting: Waiting,
    /// Robots with boots whose contacts are due for a receipt.
    pub(in crate::engine) receipts_due: Vec<Name>,
    /// The setpoint to which the current message is an answer.
    pub(in crate::engine) answering: Option<fleet_metrics::Answering>,
    pub(in crate::engine) effects: Vec<Effect>,
    /// Keys of the hashes of messages.
    pub(in crate::engine) hashers: RandomState,
    /// Time of the last warning of each reason.
    warned: BTreeMap<&'static str, Instant>,
    /// Contacts of a handled message; the allocation is reused.
    pub(in crate::engine) list: Vec<protocol::Contact>,
    /// Traces of setpoints under way, if there is a collector.
    pub(in crate::engine) lives: Option<Lives>,
}

/// A sealed transaction, ready to be committed.
#[derive(Default)]
pub(in crate::engine) struct Sealed {
    pub(in crate::engine) batch: Batch,
    pub(in crate::engine) publications: Vec<Publication>,
    /// The messages behind the rows.
    pub(in crate::engine) messages: Vec<Parcel>,
    pub(in crate::engine) taken: Vec<fleet_metrics::Taken>,
    /// Spans of the transaction, by shard.
    pub(in crate::engine) untold: Vec<Untold>,
    /// Actions whose answers are in the batch.
    pub(in crate::engine) answered: Vec<i64>,
    /// Number of the transaction in the fleet's journal.
    pub(in crate::engine) number: i64,
    /// The batch as bytes for the intent log; `None` if its rows are to be written.
    pub(in crate::engine) bytes: Option<Vec<u8>>,
    /// Its publications have gone out.
    pub(in crate::engine) is_out: bool,
}

impl Gathering {
    pub(in crate::engine) fn new(fleet: Name, boot_id: BootId, params: Arc<Params>, metrics: FleetMetrics) -> Self {
        Self {
            fleet,
            boot_id,
            params,
            metrics,
            keep: Keep::default(),
            allowed: Allowed::default(),
            turned_away: TurnedAway::default(),
            number: 0,
            batch: Batch::default(),
            journal: Journal::default(),
            publications: Vec::new(),
            messages: Vec::new(),
            has_stepped: false,
            is_urgent: false,
            taken: Vec::new(),
            waiting: Waiting::default(),
            receipts_due: Vec::new(),
            answering: None,
            effects: Vec::new(),
            hashers: RandomState::new(),
            warned: BTreeMap::new(),
            list: Vec::new(),
            lives: None,
        }
    }

    /// Steps the core, and adds the effects to the batch.
    pub(in crate::engine) fn step(
        &mut self,
        known: &mut Known,
        now: Micros,
        event: &Event<'_>,
        source: Option<Source<'_>>,
    ) -> Outcome {
        let mut effects = std::mem::take(&mut self.effects);
        let outcome = known.robot.step(&self.params, now, event, &mut effects);
        self.has_stepped |= outcome == Outcome::Taken || !effects.is_empty();
        if let Some(lives) = &mut self.lives
            && is_told(&effects)
        {
            let (fleet, name, robot_id, robot) = (&self.fleet, &known.name, known.robot_id, &known.robot);
            lives.stepped(&Step { fleet, name, robot_id, robot, now, event, effects: &effects });
        }
        let is_ordinary = effects.iter().all(is_ordinary);
        self.outlast(known, now, event, source, outcome, is_ordinary);
        for effect in effects.drain(..) {
            self.record(known, now, effect, source);
        }
        self.effects = effects;
        outcome
    }

    /// Makes the step durable: by a journal entry, if a replay of the event leads to the same state without any
    /// decision, or else by a checkpoint.
    fn outlast(
        &mut self,
        known: &mut Known,
        now: Micros,
        event: &Event<'_>,
        source: Option<Source<'_>>,
        outcome: Outcome,
        is_ordinary: bool,
    ) {
        if known.stored == Stored::Next {
            return;
        }
        // A message with an implausible time has changed the estimate of the robot's clock, too.
        let is_taken = matches!(outcome, Outcome::Taken | Outcome::BadTime);
        let is_kept = is_ordinary
            && known.stored != Stored::Before
            && match event {
                // A contacts message that is not accepted can also give up a gap.
                Event::Contacts { boot_id, .. } if is_taken || known.robot.has_gap(boot_id) => {
                    self.journal.contacts(known, now, event, source.filter(|_| is_taken));
                    true
                }
                Event::Status { .. } if is_taken && known.robot.is_settled() => {
                    self.journal.status(known, now, event);
                    true
                }
                Event::Tick if matches!(known.stored, Stored::Journal(_)) => {
                    self.journal.tick(known, now);
                    true
                }
                // The state has not changed.
                _ if !is_taken => return,
                Event::Contacts { .. }
                | Event::Status { .. }
                | Event::Tick
                | Event::Connection { .. }
                | Event::Factsheet { .. }
                | Event::Setpoint { .. }
                | Event::Operator(_)
                | Event::PolicyChanged => false,
            };
        if !is_kept {
            if known.robot.has_changed() {
                self.store_next(known);
            }
        } else if known.stored == Stored::State {
            known.stored = Stored::Journal(self.number);
            self.waiting.push(self.number, now, &known.name);
        }
    }

    /// Counts a message that violates the contract, and warns at most once a minute per reason.
    pub(in crate::engine) fn suspect(&mut self, reason: &'static str, problem: &str, robot: &Name) {
        self.metrics.refuse(reason, problem, robot.as_str());
        let now = Instant::now();
        if self.warned.get(reason).is_none_or(|&before| now.duration_since(before) >= WARNED_EVERY) {
            self.warned.insert(reason, now);
            warn!(%robot, reason, "{problem} (further ones are only counted for a minute)");
        }
    }

    /// Makes the open batch write a checkpoint of the robot.
    pub(in crate::engine) fn store_next(&mut self, known: &mut Known) {
        if known.stored != Stored::Next {
            known.stored = Stored::Next;
            self.waiting.push_next(&known.name, known.whisker_ids.len());
        }
    }

    /// Seals the open batch by appending it to those of other shards. Returns the number of contacts in its journal
    /// entries.
    pub(in crate::engine) fn seal_into(&mut self, sealed: &mut Sealed, entries: &mut Vec<u8>) -> usize {
        sealed.batch.append(&mut self.batch);
        sealed.publications.append(&mut self.publications);
        sealed.messages.append(&mut self.messages);
        sealed.taken.append(&mut self.taken);
        sealed.untold.push(self.lives.as_mut().map(Lives::seal).unwrap_or_default());
        self.is_urgent = false;
        let (bytes, contacts) = self.journal.take();
        if entries.is_empty() {
            *entries = bytes
        } else {
            entries.extend_from_slice(&bytes)
        }
        contacts
    }

    /// Whether there is nothing to commit or to publish.
    pub(in crate::engine) fn is_empty(&self) -> bool {
        self.batch.is_empty() && self.journal.is_empty() && self.publications.is_empty() && self.waiting.is_next_empty()
    }
}

/// Whether an effect can be skipped when the event is replayed: its row or request is done, and it changes no state of
/// other parts.
pub(in crate::engine) fn is_ordinary(effect: &Effect) -> bool {
    matches!(effect, Effect::Contact(_) | Effect::Response(_) | Effect::AskForFactsheet | Effect::BadTime { .. })
}
