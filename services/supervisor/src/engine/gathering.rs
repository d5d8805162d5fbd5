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

use super::allowed::{Allowed, TurnedAway};
use super::intake::Parcel;
use super::journal::Journal;
use super::keep::Keep;
use super::shard::{Known, Stored};
use super::snapshot::Waiting;
use super::survey;
use crate::metrics::FleetMetrics;
use crate::outbox::Publication;
use crate::store::Batch;
use crate::trace::{Lives, Step, Untold, is_told};

/// How often something suspicious of one kind is logged.
const WARNED_EVERY: Duration = Duration::from_secs(60);

/// A contacts message with the number of its boot in the database.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) told: &'a protocol::Contacts,
    pub(super) boot: i64,
}

/// What has come of a shard's robots since the last transaction was closed.
pub(super) struct Gathering {
    pub(super) fleet: Name,
    pub(super) boot_id: BootId,
    pub(super) params: Arc<Params>,
    pub(super) metrics: FleetMetrics,
    /// Which contacts are kept one by one.
    pub(super) keep: Keep,
    /// The allow list of robots.
    pub(super) allowed: Allowed,
    /// Those that were not.
    pub(super) turned_away: TurnedAway,
    /// The number of the transaction in the fleet's journal.
    pub(super) number: i64,
    pub(super) batch: Batch,
    pub(super) journal: Journal,
    pub(super) publications: Vec<Publication>,
    /// A setpoint is among the publications: the transaction is not to wait for more.
    pub(super) is_urgent: bool,
    /// The messages behind the gathered rows, in case the database refuses the rows.
    pub(super) messages: Vec<Parcel>,
    /// The message in hand has changed a robot.
    pub(super) has_stepped: bool,
    /// Times of the contacts messages in the batch.
    pub(super) taken: Vec<survey::Taken>,
    /// Robots whose states are to be written.
    pub(super) waiting: Waiting,
    /// Robots with boots whose contacts are to be receipted.
    pub(super) receipts_due: Vec<Name>,
    /// The setpoint that the message in hand is an answer to.
    pub(super) answering: Option<survey::Answering>,
    pub(super) effects: Vec<Effect>,
    /// Keys of the fingerprints of messages.
    pub(super) hashers: RandomState,
    /// When something suspicious of each kind was logged last.
    warned: BTreeMap<&'static str, Instant>,
    /// The contacts of a message that is done with.
    pub(super) list: Vec<protocol::Contact>,
    /// The traces of setpoints under way, if there is a collector.
    pub(super) lives: Option<Lives>,
}

/// A gathering that is closed, to be committed.
#[derive(Default)]
pub(super) struct Sealed {
    pub(super) batch: Batch,
    pub(super) publications: Vec<Publication>,
    /// Messages that led to it.
    pub(super) messages: Vec<Parcel>,
    pub(super) taken: Vec<survey::Taken>,
    /// By shard.
    pub(super) untold: Vec<Untold>,
    /// Actions whose answers are in the batch.
    pub(super) answered: Vec<i64>,
    /// The number of the transaction in the fleet's journal.
    pub(super) number: i64,
    /// The batch as bytes, while these are to be kept.
    pub(super) bytes: Option<Vec<u8>>,
    /// What waited for it has gone out.
    pub(super) is_out: bool,
}

impl Gathering {
    pub(super) fn new(fleet: Name, boot_id: BootId, params: Arc<Params>, metrics: FleetMetrics) -> Self {
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
    pub(super) fn step(
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
    pub(super) fn suspect(&mut self, reason: &'static str, problem: &str, robot: &Name) {
        self.metrics.refuse(reason, problem, robot.as_str());
        let now = Instant::now();
        if self.warned.get(reason).is_none_or(|&before| now.duration_since(before) >= WARNED_EVERY) {
            self.warned.insert(reason, now);
            warn!(%robot, reason, "{problem}; more of it is only counted for a minute");
        }
    }

    /// The robot's state is written by the next transaction.
    pub(super) fn store_next(&mut self, known: &mut Known) {
        if known.stored != Stored::Next {
            known.stored = Stored::Next;
            self.waiting.push_next(&known.name, known.whisker_ids.len());
        }
    }

    /// Closes it: adds its rows to those of other shards; says how many contacts its journal entries have.
    pub(super) fn seal_into(&mut self, sealed: &mut Sealed, entries: &mut Vec<u8>) -> usize {
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
    pub(super) fn is_empty(&self) -> bool {
        self.batch.is_empty() && self.journal.is_empty() && self.publications.is_empty() && self.waiting.is_next_empty()
    }
}

/// Whether the same effect of the same event can be left out when the event is gone through again: it has become a row or a
/// request, and nothing follows from it.
pub(super) fn is_ordinary(effect: &Effect) -> bool {
    matches!(effect, Effect::Contact(_) | Effect::Response(_) | Effect::AskForFactsheet | Effect::BadTime { .. })
}
