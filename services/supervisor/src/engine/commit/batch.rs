//! What one transaction will write, and what goes out after it: rows, journal entries, states, setpoints and receipts.

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

/// How often something suspicious of one kind is logged.
const WARNED_EVERY: Duration = Duration::from_secs(60);

/// A contacts message with the number of its boot in the database.
#[derive(Clone, Copy)]
pub(in crate::engine) struct Source<'a> {
    pub(in crate::engine) told: &'a protocol::Contacts,
    pub(in crate::engine) boot: i64,
}

/// What has come of a shard's robots since the last transaction was closed.
pub(in crate::engine) struct Gathering {
    pub(in crate::engine) fleet: Name,
    pub(in crate::engine) boot_id: BootId,
    pub(in crate::engine) params: Arc<Params>,
    pub(in crate::engine) metrics: FleetMetrics,
    /// Which contacts are kept one by one.
    pub(in crate::engine) keep: Keep,
    /// The allow list of robots.
    pub(in crate::engine) allowed: Allowed,
    /// Those that were not.
    pub(in crate::engine) turned_away: TurnedAway,
    /// The number of the transaction in the fleet's journal.
    pub(in crate::engine) number: i64,
    pub(in crate::engine) batch: Batch,
    pub(in crate::engine) journal: Journal,
    pub(in crate::engine) publications: Vec<Publication>,
    /// A setpoint is among the publications: the transaction is not to wait for more.
    pub(in crate::engine) is_urgent: bool,
    /// The messages behind the gathered rows, in case the database refuses the rows.
    pub(in crate::engine) messages: Vec<Parcel>,
    /// The message in hand has changed a robot.
    pub(in crate::engine) has_stepped: bool,
    /// Times of the contacts messages in the batch.
    pub(in crate::engine) taken: Vec<fleet_metrics::Taken>,
    /// Robots whose states are to be written.
    pub(in crate::engine) waiting: Waiting,
    /// Robots with boots whose contacts are to be receipted.
    pub(in crate::engine) receipts_due: Vec<Name>,
    /// The setpoint that the message in hand is an answer to.
    pub(in crate::engine) answering: Option<fleet_metrics::Answering>,
    pub(in crate::engine) effects: Vec<Effect>,
    /// Keys of the fingerprints of messages.
    pub(in crate::engine) hashers: RandomState,
    /// When something suspicious of each kind was logged last.
    warned: BTreeMap<&'static str, Instant>,
    /// The contacts of a message that is done with.
    pub(in crate::engine) list: Vec<protocol::Contact>,
    /// The traces of setpoints under way, if there is a collector.
    pub(in crate::engine) lives: Option<Lives>,
}

/// A gathering that is closed, to be committed.
#[derive(Default)]
pub(in crate::engine) struct Sealed {
    pub(in crate::engine) batch: Batch,
    pub(in crate::engine) publications: Vec<Publication>,
    /// Messages that led to it.
    pub(in crate::engine) messages: Vec<Parcel>,
    pub(in crate::engine) taken: Vec<fleet_metrics::Taken>,
    /// By shard.
    pub(in crate::engine) untold: Vec<Untold>,
    /// Actions whose answers are in the batch.
    pub(in crate::engine) answered: Vec<i64>,
    /// The number of the transaction in the fleet's journal.
    pub(in crate::engine) number: i64,
    /// The batch as bytes, while these are to be kept.
    pub(in crate::engine) bytes: Option<Vec<u8>>,
    /// What waited for it has gone out.
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

    /// The core's step, and what comes of it.
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

    /// Has the step outlast us: as an entry of the journal where the same event leads to the same state and to nothing
    /// else, or by writing the state.
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
        // Also a message whose time cannot be right is one that the clock's estimate has heard.
        let is_taken = matches!(outcome, Outcome::Taken | Outcome::BadTime);
        let is_kept = is_ordinary
            && known.stored != Stored::Before
            && match event {
                // Also what is not taken can give up a gap.
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
                // Nothing has changed.
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

    /// Counts what no robot that keeps the contract would send, and warns of it once a minute.
    pub(in crate::engine) fn suspect(&mut self, reason: &'static str, problem: &str, robot: &Name) {
        self.metrics.refuse(reason, problem, robot.as_str());
        let now = Instant::now();
        if self.warned.get(reason).is_none_or(|&before| now.duration_since(before) >= WARNED_EVERY) {
            self.warned.insert(reason, now);
            warn!(%robot, reason, "{problem}; more of it is only counted for a minute");
        }
    }

    /// The robot's state is written by the next transaction.
    pub(in crate::engine) fn store_next(&mut self, known: &mut Known) {
        if known.stored != Stored::Next {
            known.stored = Stored::Next;
            self.waiting.push_next(&known.name, known.whisker_ids.len());
        }
    }

    /// Closes it: adds its rows to those of other shards; says how many contacts its journal entries have.
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

    /// Whether there is anything to commit or to publish.
    pub(in crate::engine) fn is_empty(&self) -> bool {
        self.batch.is_empty() && self.journal.is_empty() && self.publications.is_empty() && self.waiting.is_next_empty()
    }
}

/// Whether the same effect of the same event can be left out when the event is gone through again: it has become a row or a
/// request, and nothing follows from it.
pub(in crate::engine) fn is_ordinary(effect: &Effect) -> bool {
    matches!(effect, Effect::Contact(_) | Effect::Response(_) | Effect::AskForFactsheet | Effect::BadTime { .. })
}
