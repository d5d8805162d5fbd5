//! Steps events through the core, and adds the effects to the open batch.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::time::Instant;
use tracing::warn;
use vibrissa_core::robot::effect::{Command, CommandKey, Effect, Reason};
use vibrissa_core::robot::event::Link;
use vibrissa_core::robot::{Event, Outcome, Params};
use vibrissa_core::units::Micros;
use vibrissa_edge::words::Word;
use vibrissa_protocol::{BootId, Name, RobotTopic};

use super::contact_events::ContactEvents;
use super::log;
use crate::black_box::FleetBoxes;
use crate::black_box::recorder::Whose;
use crate::engine::commit::batch::{OpenBatch, Source, is_ordinary};
use crate::engine::commit::journal::{Entry, JournalEvent};
use crate::engine::ledger::{self, Account};
use crate::engine::robot::KnownRobot;
use crate::engine::robot::retention::ContactRetention;
use crate::engine::rollout::trial::TrialParams;
use crate::metrics::FleetMetrics;
use crate::outbox::Withdrawal;
use crate::set_aside::Reader;
use crate::trace::{OpenTraces, PendingSpans, Step, is_traced};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::full_name::FullName;
use vibrissa_store::Batch;
use vibrissa_store::batch::Record;

/// Shortest interval between two warnings with the same reason.
const WARNING_INTERVAL: Duration = Duration::from_secs(60);

/// The setpoint to which a message is an answer.
#[derive(Debug, Clone, Copy)]
pub(super) struct AnsweredSetpoint {
    pub(super) command: CommandKey,
    /// Receipt time of the message that led to the setpoint.
    since: Micros,
    reason: Reason,
}

impl AnsweredSetpoint {
    pub(super) fn of(command: &Command) -> Self {
        Self { command: command.key, since: command.issued, reason: command.reason }
    }
}

/// Steps the robots of a worker, and collects the effects in its open batch.
pub(crate) struct Stepper {
    pub(super) fleet: Name,
    pub(super) boot_id: BootId,
    pub(super) params: Arc<Params>,
    /// Parameters of robots that a roll-out has changed.
    trial: Option<TrialParams>,
    pub(super) metrics: FleetMetrics,
    /// Which contacts get a row of their own.
    pub(super) retention: ContactRetention,
    /// Whether facts for the maintenance of robots are published.
    pub(super) publishes_maintenance: bool,
    pub(super) batch: OpenBatch,
    /// A message has come of a robot whose birth was not received.
    pub(crate) has_unannounced: bool,
    /// The current message has changed a robot.
    pub(super) has_stepped: bool,
    /// Robots with boots whose contacts are due for a receipt.
    pub(super) receipts_due: Vec<Name>,
    /// The setpoint to which the current message is an answer.
    pub(super) answered: Option<AnsweredSetpoint>,
    /// Traces of setpoints under way, if there is a collector.
    pub(super) traces: Option<OpenTraces>,
    /// Events of contacts, if they are wanted.
    pub(super) contact_events: Option<ContactEvents>,
    /// Black boxes, if they are wanted.
    boxes: Option<FleetBoxes>,
    /// Bytes that the effects of all robots may add to the database.
    pub(super) account: Account,
    /// Until when nothing could be received, by the last outage.
    deaf_until: Micros,
    /// Number of stored items that could not be read.
    set_aside: u64,
    /// Effects of the current step; the allocation is reused.
    effects: Vec<Effect>,
    /// Time of the last warning of each reason.
    warned: BTreeMap<&'static str, Instant>,
}

impl Stepper {
    pub(crate) fn new(fleet: Name, boot_id: BootId, params: Arc<Params>, metrics: FleetMetrics) -> Self {
        Self {
            fleet,
            boot_id,
            params,
            trial: None,
            metrics,
            retention: ContactRetention::default(),
            publishes_maintenance: false,
            batch: OpenBatch::default(),
            has_unannounced: false,
            has_stepped: false,
            receipts_due: Vec::new(),
            answered: None,
            traces: None,
            contact_events: None,
            boxes: None,
            account: Account::default(),
            deaf_until: Micros::default(),
            set_aside: 0,
            effects: Vec::new(),
            warned: BTreeMap::new(),
        }
    }

    /// The parameters of a robot.
    pub(crate) fn params_of(&self, robot: &Name) -> &Params {
        match &self.trial {
            Some(trial) if trial.has(robot) => &trial.params,
            Some(_) | None => &self.params,
        }
    }

    /// The fleet of its robots.
    pub(crate) fn fleet(&self) -> &Name {
        &self.fleet
    }

    /// Sets the parameters of the robots that a roll-out has changed; `None` without one.
    pub(crate) fn set_trial(&mut self, trial: Option<TrialParams>) {
        self.trial = trial;
    }

    pub(crate) fn set_params(&mut self, params: Arc<Params>) {
        self.params = params;
    }

    pub(super) fn set_retention(&mut self, retention: ContactRetention) {
        self.retention = retention;
    }

    /// Sets whether facts for the maintenance of robots are published.
    pub(crate) fn set_publishes_maintenance(&mut self, publishes: bool) {
        self.publishes_maintenance = publishes;
    }

    /// Which contacts get a row of their own.
    pub(crate) fn retention(&self) -> ContactRetention {
        self.retention
    }

    /// Adds traces.
    pub(crate) fn set_traces(&mut self, traces: OpenTraces) {
        self.traces = Some(traces);
    }

    /// Adds events of contacts.
    pub(crate) fn set_contact_events(&mut self, events: ContactEvents) {
        self.contact_events = Some(events);
    }

    /// Adds black boxes.
    pub(crate) fn set_boxes(&mut self, boxes: FleetBoxes) {
        self.boxes = Some(boxes);
    }

    /// Whether the messages of a robot are recorded for black boxes. The recorder begins with the first message.
    pub(super) fn has_box(&self, known: &mut KnownRobot, at: Micros) -> bool {
        if known.recorder.is_none() {
            known.recorder = self.boxes.as_ref().and_then(|boxes| boxes.recorder(known.robot_id, at));
        }
        known.recorder.is_some()
    }

    /// Records a message from or to a robot for its black boxes, before the robot's state contains it.
    pub(super) fn keep_message(&self, known: &mut KnownRobot, topic: RobotTopic, at: Micros, payload: &[u8]) {
        if self.has_box(known, at)
            && let Some(recorder) = &mut known.recorder
        {
            recorder.message(&known.robot, topic, at, payload);
        }
    }

    /// Opens a black box, or extends the open one.
    pub(super) fn keep_event(known: &mut KnownRobot, cause: &'static str, whisker: usize, now: Micros) {
        let whisker_id = known.whisker_id(whisker);
        let whose = Whose { robot_id: known.robot_id, name: &known.name };
        if let Some(recorder) = &mut known.recorder {
            recorder.event(cause, whisker_id, now, whose);
        }
    }

    pub(crate) fn traces_mut(&mut self) -> Option<&mut OpenTraces> {
        self.traces.as_mut()
    }

    /// Takes the spans of the steps since the last transaction was sealed.
    pub(super) fn seal_spans(&mut self) -> PendingSpans {
        self.traces.as_mut().map(OpenTraces::seal).unwrap_or_default()
    }

    pub(crate) fn batch_mut(&mut self) -> &mut OpenBatch {
        &mut self.batch
    }

    /// Excuses the silence of all robots until `time`, because nothing could be received.
    pub(super) fn excuse_silence_until(&mut self, time: Micros) {
        self.deaf_until = self.deaf_until.max(time);
    }

    /// Steps the core, and adds the effects to the batch. `source` is the message of a contacts event.
    pub(crate) fn step(
        &mut self,
        known: &mut KnownRobot,
        now: Micros,
        event: &Event<'_>,
        source: Option<Source<'_>>,
    ) -> Outcome {
        let deaf_until = self.deaf_until.max(known.deaf_until);
        if known.robot.excuse_silence(self.params_of(&known.name), now, deaf_until) {
            self.batch.checkpoint(known);
        }
        if known.is_excluded {
            // Its alarms were withdrawn after the step before.
            known.robot.review_alarms(now);
        }
        let mut effects = std::mem::take(&mut self.effects);
        let outcome = known.robot.step(self.params_of(&known.name), now, event, &mut effects);
        if known.is_excluded {
            known.robot.withdraw_alarms();
            effects.retain(|effect| !matches!(effect, Effect::Alarm { .. } | Effect::RobotAlarm { .. }));
            self.batch.checkpoint(known);
        }
        known.is_heard |= is_of_newest_boot(event, outcome);
        self.has_stepped |= outcome == Outcome::Taken || !effects.is_empty();
        if let Some(traces) = &mut self.traces
            && is_traced(&effects)
        {
            let (fleet, name, robot_id, robot) = (&self.fleet, &known.name, known.robot_id, &known.robot);
            traces.stepped(&Step { fleet, name, robot_id, robot, now, event, effects: &effects });
        }
        let is_ordinary = effects.iter().all(is_ordinary);
        if !is_ordinary || !matches!(event, Event::Contacts { .. } | Event::Tick) {
            known.estimates.compare();
        }
        self.batch.make_durable(known, now, event, source, outcome, is_ordinary);
        for effect in effects.drain(..) {
            self.record(known, now, effect, source);
        }
        self.tell_contacts(known, now, source);
        self.effects = effects;
        outcome
    }

    /// Steps a birth or a farewell, and logs a connection that is lost or found.
    pub(super) fn step_connection(&mut self, known: &mut KnownRobot, now: Micros, event: &Event<'_>) -> Outcome {
        let before = log::connection_of(known);
        let outcome = self.step(known, now, event, None);
        log::connection(known, &before);
        outcome
    }

    /// Replays an event of the journal. Its rows are already written, so only the open minutes and hours need its
    /// effects. Effects other than ordinary ones are new, because parameters have changed, and are recorded.
    pub(crate) fn replay(&mut self, known: &mut KnownRobot, entry: &Entry, event: &Event<'_>) -> Outcome {
        let mut effects = Vec::new();
        let outcome = known.robot.step(self.params_of(&known.name), entry.now, event, &mut effects);
        let mut written = Batch::default();
        for effect in effects {
            if !is_ordinary(&effect) {
                self.record(known, entry.now, effect, None);
            } else if let (Effect::Contact(record), JournalEvent::Contacts { boot, seq, contacts }) =
                (&effect, &entry.event)
            {
                let Some(contact) = contacts.get(record.position) else { continue };
                let row = contact.row(record, known.whisker_id(record.whisker), (*boot, *seq), entry.now);
                known.history.add_contact(record.whisker, record.used, row, &mut written);
            } else if let Effect::Response(_) = effect {
                known.history.keep_last(&mut written);
            }
        }
        outcome
    }

    /// Accepts the last refused boot, once the limit allows it.
    pub(super) fn accept_refused_boot(&mut self, known: &mut KnownRobot, now: Micros) {
        let Some(boot_id) = known.refused_boot.clone() else { return };
        let is_new = known.robot.connection_state().0 != Some(boot_id.as_str());
        let is_allowed =
            if is_new { known.new_boots.take(Instant::now()) } else { known.account.affords(ledger::ROBOT, now, 0) };
        if is_allowed {
            known.refused_boot = None;
            self.step_connection(known, now, &Event::Connection { boot_id: boot_id.as_str(), link: Link::Online });
        }
    }

    /// Number of stored items that could not be read.
    pub(crate) fn set_aside(&self) -> u64 {
        self.set_aside
    }

    /// Counts stored items that cannot be read.
    pub(crate) fn count_set_aside(&mut self, reader: Reader, count: u64) {
        self.set_aside += count;
        self.metrics.set_aside(reader, count);
    }

    /// Begins or ends the time in which the allow list excludes a robot. Nobody is responsible for it meanwhile, so its alarms
    /// are over; those that are still due are raised again at the end.
    pub(super) fn exclude(&mut self, known: &mut KnownRobot, is_excluded: bool) {
        (known.is_excluded, known.is_row_due) = (is_excluded, true);
        self.batch.checkpoint(known);
        if !is_excluded {
            known.withdrawal = Withdrawal::default();
            return known.robot.review_alarms(wall_clock());
        }
        known.withdrawal.withdraw();
        let has_unheard = std::mem::take(&mut known.repeats).stands();
        if known.robot.withdraw_alarms() || has_unheard {
            let cleared_us = wall_clock().0 as i64;
            self.batch.rows_mut().records.push(Record::AlarmsForgotten { robot_id: known.robot_id, cleared_us });
        }
    }

    /// Charges an effect to the accounts of its robot and fleet. Returns false for one that is not recorded.
    pub(crate) fn admit(&mut self, known: &mut KnownRobot, now: Micros, effect: &Effect) -> bool {
        let is_admitted = ledger::admit(&mut known.account, &mut self.account, now, effect);
        if !is_admitted {
            let problem = "its faults change too often: a change beyond the budget is not recorded";
            self.violation_of(known, (RobotTopic::Status, "over_budget"), problem, now);
        }
        is_admitted
    }

    /// Counts a message that violates the contract, and warns at most once a minute per reason.
    pub(super) fn violation(&mut self, reason: &'static str, problem: &str, robot: &Name) {
        self.metrics.refuse(reason, problem, robot.as_str());
        self.warn_seldom(reason, problem, robot);
    }

    /// As [`Self::violation`], shown on the robot's page, too.
    pub(super) fn violation_of(
        &mut self,
        known: &mut KnownRobot,
        (topic, reason): (RobotTopic, &'static str),
        problem: &'static str,
        now: Micros,
    ) {
        self.violation(reason, problem, &known.name);
        known.refusals.count((topic, reason), &problem, now);
    }

    /// Warns at most once a minute per reason.
    pub(super) fn warn_seldom(&mut self, reason: &'static str, problem: &str, robot: &Name) {
        let now = Instant::now();
        if self.warned.get(reason).is_none_or(|&before| now.duration_since(before) >= WARNING_INTERVAL) {
            self.warned.insert(reason, now);
            let robot = FullName::robot(self.fleet.as_str(), robot.as_str());
            warn!(%robot, reason, "{problem} (further ones are only counted for a minute)");
        }
    }

    /// Observes the time until a setpoint was applied.
    pub(super) fn observe_application(&self, command: CommandKey) {
        if let Some(answered) = self.answered.filter(|answered| answered.command == command) {
            let seconds = wall_clock().since(answered.since).as_s();
            self.metrics.setpoint_application_seconds.of(answered.reason.word()).observe(seconds);
        }
    }
}

/// Whether an event is a message of the robot's newest boot.
fn is_of_newest_boot(event: &Event<'_>, outcome: Outcome) -> bool {
    let is_message = match event {
        Event::Connection { .. }
        | Event::Factsheet { .. }
        | Event::Contacts { .. }
        | Event::Status { .. }
        | Event::Setpoint { .. }
        | Event::TouchTest { .. } => true,
        Event::Operator(_) | Event::PolicyChanged | Event::Tick => false,
    };
    is_message
        && match outcome {
            Outcome::Taken | Outcome::Duplicate | Outcome::BadTime => true,
            Outcome::NotYet(_) | Outcome::OldBoot | Outcome::Refused(_) => false,
        }
}
