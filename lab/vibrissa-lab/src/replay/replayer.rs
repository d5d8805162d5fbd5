//! Passes recorded messages, and the time between them, to the core as the service would.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::sync::Arc;

use vibrissa_core::robot::effect::Effect;
use vibrissa_core::robot::event::SetpointReport;
use vibrissa_core::robot::{Admission, Event, Numbers, Outcome, Params, Robot};
use vibrissa_core::units::Micros;
use vibrissa_edge as edge;
use vibrissa_edge::black_box::Special;
use vibrissa_protocol::{self as protocol, Message, Name, RobotTopic, Topic};

use super::answers::{Answers, ReplayAnswer};
use super::recorded_tests::RecordedTests;
use super::refusals::Refusals;
use super::status;
use vibrissa_edge::recording::Recorded;

/// Interval of the core's ticks, as in the service.
const TICK: Micros = Micros(250_000);
/// Maximum number of ticks in a silence: its first minute; then follows its end.
const TICKS_MAX: u32 = 240;
/// Epoch of the replay.
const EPOCH: u64 = 1;

/// Something that followed from the traffic.
#[derive(Debug)]
pub struct Happened<'a> {
    /// Time by the recorder's clock.
    pub at: Micros,
    /// Fleet, name and present state of the robot; `None` for a message of no known robot.
    pub robot: Option<(&'a Name, &'a Name, &'a Robot)>,
    /// The event itself.
    pub what: What<'a>,
}

/// Kind of an event of the replay.
#[derive(Debug)]
pub enum What<'a> {
    /// An effect that the core requests.
    Effect {
        /// The effect requested by the core.
        effect: &'a Effect,
        /// The message with the contacts that the effect is about.
        source: Option<&'a protocol::Contacts>,
        /// Whether it depends on a setpoint that is assumed to be applied.
        assumed: bool,
    },
    /// A message, or a part of it, was refused.
    Refused {
        /// Label of the reason, as in the metrics.
        reason: &'static str,
        /// Description of the problem.
        problem: String,
        /// Topic of the message.
        topic: &'a str,
    },
}

/// Receiver of all events of the replay.
pub type Sink<'a> = dyn FnMut(&Happened<'_>) -> io::Result<()> + 'a;

/// Supervises the fleets of a recording, without a broker or a database.
pub struct Replayer {
    params: Arc<Params>,
    fleets: Option<BTreeSet<Name>>,
    robots: BTreeMap<(Name, Name), Known>,
    next_tick: Option<Micros>,
    refusals: Refusals,
}

struct Known {
    robot: Robot,
    answers: Answers,
    tests: RecordedTests,
    /// The newest factsheet of a boot whose birth has not come yet: brokers send retained messages in any order.
    early: Option<protocol::Factsheet>,
}

/// A message that is being processed.
struct Step<'a> {
    at: Micros,
    fleet: &'a Name,
    name: &'a Name,
    topic: &'a str,
}

impl Replayer {
    /// Starts without known robots. Only `fleets` are replayed; all of them if `None`.
    #[must_use]
    pub fn new(params: Arc<Params>, fleets: Option<BTreeSet<Name>>) -> Self {
        Self { params, fleets, robots: BTreeMap::new(), next_tick: None, refusals: Refusals::default() }
    }

    /// All robots that appeared so far.
    pub fn robots(&self) -> impl Iterator<Item = (&Name, &Name, &Robot)> {
        self.robots.iter().map(|((fleet, name), known)| (fleet, name, &known.robot))
    }

    /// Refused messages so far, by robot.
    #[must_use]
    pub fn refusals(&self) -> &Refusals {
        &self.refusals
    }

    /// Lets time pass until a message, and processes it.
    ///
    /// # Errors
    /// Errors of `sink`.
    pub fn take(&mut self, recorded: &Recorded, sink: &mut Sink<'_>) -> io::Result<()> {
        if let Some(special) = Special::of(recorded) {
            return self.special(special, recorded, sink);
        }
        let topic = match Topic::parse(&recorded.topic) {
            Ok(topic) => topic,
            Err(refusal) => {
                self.advance(recorded.received, sink)?;
                self.refusals.count(None, refusal.label());
                let what =
                    What::Refused { reason: refusal.label(), problem: refusal.to_string(), topic: &recorded.topic };
                return sink(&Happened { at: recorded.received, robot: None, what });
            }
        };
        if self.fleets.as_ref().is_some_and(|fleets| !fleets.contains(topic.fleet())) {
            return Ok(());
        }
        self.advance(recorded.received, sink)?;
        let Topic::Robot { fleet, robot: name, kind } = &topic else { return Ok(()) };
        let step = Step { at: recorded.received, fleet, name, topic: &recorded.topic };
        match protocol::receive(&topic, &recorded.payload) {
            Ok(received) => {
                for refusal in &received.refused {
                    self.refuse(&step, refusal.label(), refusal, sink)?;
                }
                self.message(&step, &received.message, sink)
            }
            // The supervisor's own messages are not an input.
            Err(_) if !kind.is_from_robot() => Ok(()),
            Err(refusal) => {
                self.refuse(&step, refusal.label(), &refusal, sink)?;
                if *kind == RobotTopic::Contacts
                    && let Some(envelope) = protocol::envelope(&recorded.payload)
                {
                    // As in the service, the number is accounted for; otherwise the robot would send the message again
                    // without end.
                    let (boot_id, seq) = (envelope.boot_id, envelope.seq);
                    let contacts = protocol::Contacts { boot_id, seq, contacts: Vec::new(), missed: Vec::new() };
                    return self.message(&step, &Message::Contacts(contacts), sink);
                }
                Ok(())
            }
        }
    }

    /// A line of a black box that is no message: the robot's state at the beginning of the box.
    fn special(&mut self, special: Special, recorded: &Recorded, sink: &mut Sink<'_>) -> io::Result<()> {
        let Special::State { fleet, robot: name, state } = special else { return Ok(()) };
        let is_wanted = self.fleets.as_ref().is_none_or(|fleets| fleets.contains(&fleet));
        // In several boxes one after the other, a robot keeps the state of the replay.
        if !is_wanted || self.robots.contains_key(&(fleet.clone(), name.clone())) {
            return Ok(());
        }
        self.advance(recorded.received, sink)?;
        match state {
            Ok(mut robot) => {
                robot.share_models(&self.params);
                let known = Known::restored((&fleet, &name), *robot);
                self.robots.insert((fleet, name), known);
                Ok(())
            }
            Err(problem) => {
                let step = Step { at: recorded.received, fleet: &fleet, name: &name, topic: &recorded.topic };
                self.refuse(&step, "robot_state", &problem, sink)
            }
        }
    }

    /// Advances the time in the service's steps.
    fn advance(&mut self, to: Micros, sink: &mut Sink<'_>) -> io::Result<()> {
        // At the start, and after the recorder's clock was set back.
        let Some(mut due) = self.next_tick.filter(|next| *next <= to.after(TICK)) else {
            self.next_tick = Some(to.after(TICK));
            return Ok(());
        };
        let mut ticks = 0;
        while due <= to {
            if ticks == TICKS_MAX {
                due = due.after(Micros(to.since(due).0 / TICK.0 * TICK.0));
            }
            self.tick(due, sink)?;
            ticks += 1;
            due = due.after(TICK);
        }
        self.next_tick = Some(due);
        Ok(())
    }

    fn tick(&mut self, at: Micros, sink: &mut Sink<'_>) -> io::Result<()> {
        for ((fleet, name), known) in &mut self.robots {
            let step = Step { at, fleet, name, topic: "" };
            for (command, pressure) in known.answers.due(at, &known.robot) {
                let Some(boot_id) = known.robot.connection_state().0.map(str::to_owned) else { continue };
                let report = SetpointReport::Applied(pressure);
                // The robot did not report this, so its time is unknown.
                let event = Event::Setpoint { boot_id: &boot_id, command, report, robot_time: Micros::default() };
                known.step(&self.params, &step, &event, (None, true), sink)?;
            }
            known.step(&self.params, &step, &Event::Tick, (None, false), sink)?;
        }
        Ok(())
    }

    fn refuse(
        &mut self,
        step: &Step<'_>,
        reason: &'static str,
        problem: &dyn std::fmt::Display,
        sink: &mut Sink<'_>,
    ) -> io::Result<()> {
        self.refusals.count(Some((step.fleet, step.name)), reason);
        let known = self.robots.get(&(step.fleet.clone(), step.name.clone()));
        let robot = known.map(|known| (step.fleet, step.name, &known.robot));
        sink(&Happened {
            at: step.at,
            robot,
            what: What::Refused { reason, problem: problem.to_string(), topic: step.topic },
        })
    }

    fn message(&mut self, step: &Step<'_>, message: &Message, sink: &mut Sink<'_>) -> io::Result<()> {
        let key = (step.fleet.clone(), step.name.clone());
        if !self.robots.contains_key(&key) {
            match message {
                Message::Connection(_) | Message::Factsheet(_) => {}
                Message::Setpoint(_)
                | Message::Receipt(_)
                | Message::Request(_)
                | Message::Estimate(_)
                | Message::Maintenance(_)
                | Message::SupervisorState(_)
                | Message::SupervisorRequest(_) => return Ok(()),
                Message::Contacts(_) | Message::Status(_) | Message::SetpointState(_) | Message::TestState(_) => {
                    let problem = "the recording has neither a birth nor a factsheet of this robot";
                    return self.refuse(step, "unknown_robot", &problem, sink);
                }
            }
        }
        let params = self.params.clone();
        let known = self.robots.entry(key).or_insert_with(Known::new);
        let refused = known.message(&params, step, message, sink)?;
        for (reason, problem) in refused {
            self.refuse(step, reason, &problem, sink)?;
        }
        Ok(())
    }
}

/// Label and description of a refusal.
type Refused = (&'static str, String);

impl Known {
    fn new() -> Self {
        let robot = Robot::new(EPOCH, Numbers::default());
        Self { robot, answers: Answers::default(), tests: RecordedTests::default(), early: None }
    }

    /// A robot as it was at the beginning of a black box.
    fn restored(of: (&Name, &Name), robot: Robot) -> Self {
        let mut answers = Answers::default();
        answers.restored(of, &robot);
        Self { robot, answers, ..Self::new() }
    }

    /// Passes a message to the core; returns the refused parts.
    fn message(
        &mut self,
        params: &Params,
        step: &Step<'_>,
        message: &Message,
        sink: &mut Sink<'_>,
    ) -> io::Result<Vec<Refused>> {
        match message {
            Message::Connection(connection) => {
                if self.robot.connection_state().0 != Some(connection.boot_id.as_str())
                    && connection.state == protocol::ConnectionState::Online
                {
                    self.answers.forget();
                }
                let event =
                    Event::Connection { boot_id: connection.boot_id.as_str(), link: edge::link(connection.state) };
                self.step(params, step, &event, (None, false), sink)?;
                let is_its = |early: &mut protocol::Factsheet| early.boot_id == connection.boot_id;
                if connection.state == protocol::ConnectionState::Online
                    && let Some(early) = self.early.take_if(is_its)
                {
                    return self.factsheet(params, step, &early, sink);
                }
            }
            Message::Factsheet(sheet) => return self.factsheet(params, step, sheet, sink),
            Message::Contacts(contacts) => return self.contacts(params, step, contacts, sink),
            Message::Status(status) => {
                let whiskers: Result<Vec<_>, _> = status.whiskers.iter().map(edge::status).collect();
                let mut whiskers = match whiskers {
                    Ok(whiskers) => whiskers,
                    Err(problem) => return Ok(vec![(problem.label(), problem.to_string())]),
                };
                for entry in &mut whiskers {
                    status::correct(entry, &self.robot, &self.answers);
                }
                let (boot_id, robot_time) = (status.boot_id.as_str(), Micros(status.t_us));
                let event = Event::Status { boot_id, robot_time, whiskers: &whiskers };
                if self.step(params, step, &event, (None, false), sink)? == Outcome::BadTime {
                    return Ok(vec![("bad_time", "a status with an implausible time".to_owned())]);
                }
            }
            Message::SetpointState(state) => return self.setpoint_state(params, step, state, sink),
            Message::Setpoint(setpoint) => self.answers.recorded(setpoint, &self.robot),
            Message::Request(protocol::Request { touch_test: Some(test), .. }) => self.tests.recorded(test),
            Message::TestState(state) => {
                if let Some(test) = self.tests.answered(state, &self.robot) {
                    let (report, robot_time) = (edge::touch_tests::report(state), Micros(state.t_us));
                    let event = Event::TouchTest { boot_id: state.boot_id.as_str(), test, report, robot_time };
                    self.step(params, step, &event, (None, false), sink)?;
                }
            }
            Message::Receipt(_)
            | Message::Request(_)
            | Message::Estimate(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => {}
        }
        Ok(Vec::new())
    }

    fn factsheet(
        &mut self,
        params: &Params,
        step: &Step<'_>,
        sheet: &protocol::Factsheet,
        sink: &mut Sink<'_>,
    ) -> io::Result<Vec<Refused>> {
        let models: Vec<&str> = params.models.iter().map(|(name, _)| name.as_str()).collect();
        let factsheet = match edge::factsheet(sheet, &models) {
            Ok(factsheet) => factsheet,
            Err(problem) => return Ok(vec![(problem.label(), problem.to_string())]),
        };
        let boot_id = sheet.boot_id.as_str();
        let event = Event::Factsheet { boot_id, factsheet: &factsheet };
        let outcome = self.step(params, step, &event, (None, false), sink)?;
        if outcome == Outcome::OldBoot && self.robot.sequence(boot_id).is_none() {
            self.early = Some(sheet.clone());
        }
        Ok(Vec::new())
    }

    fn contacts(
        &mut self,
        params: &Params,
        step: &Step<'_>,
        message: &protocol::Contacts,
        sink: &mut Sink<'_>,
    ) -> io::Result<Vec<Refused>> {
        let mut refused = Vec::new();
        let mut contacts = Vec::with_capacity(message.contacts.len());
        for contact in &message.contacts {
            match edge::contact(contact) {
                Ok(contact) => contacts.push(contact),
                Err(problem) => refused.push((problem.label(), problem.to_string())),
            }
        }
        let mut missed = Vec::with_capacity(message.missed.len());
        for one in &message.missed {
            match edge::missed(one) {
                Ok(one) => missed.push(one),
                Err(problem) => refused.push((problem.label(), problem.to_string())),
            }
        }
        let (boot_id, seq) = (message.boot_id.as_str(), message.seq);
        let event = Event::Contacts { boot_id, seq, contacts: &contacts, missed: &missed };
        match self.step(params, step, &event, (Some(message), false), sink)? {
            Outcome::NotYet(Admission::TooManyGaps) => {
                refused.push(("too_many_gaps", "contacts cannot be accepted yet".to_owned()));
            }
            Outcome::NotYet(Admission::UnknownBoot | Admission::New | Admission::Duplicate | Admission::TwoRobots) => {
                refused.push(("unknown_boot", "contacts cannot be accepted yet".to_owned()));
            }
            Outcome::Duplicate => refused.push(("duplicate", "contacts were accepted already".to_owned())),
            // Only operators' actions are refused here, and they are not recorded.
            Outcome::Taken | Outcome::OldBoot | Outcome::BadTime | Outcome::Refused(_) => {}
        }
        Ok(refused)
    }

    fn setpoint_state(
        &mut self,
        params: &Params,
        step: &Step<'_>,
        state: &protocol::SetpointState,
        sink: &mut Sink<'_>,
    ) -> io::Result<Vec<Refused>> {
        let Some(ReplayAnswer { key, instead }) = self.answers.answer(state, &self.robot) else {
            return Ok(Vec::new());
        };
        let commanded = self.robot.commands_under_way().find(|command| command.key == key);
        let Some(pressure) = commanded.map(|command| command.pressure) else { return Ok(Vec::new()) };
        let report = match (edge::setpoint_report(state, pressure), instead) {
            (Ok(SetpointReport::Applied(_)), Some(pressure)) => SetpointReport::Applied(pressure),
            (Ok(report), _) => report,
            (Err(problem), _) => return Ok(vec![(problem.label(), problem.to_string())]),
        };
        let robot_time = Micros(state.t_us);
        let event = Event::Setpoint { boot_id: state.boot_id.as_str(), command: key, report, robot_time };
        self.step(params, step, &event, (None, instead.is_some()), sink)?;
        Ok(Vec::new())
    }

    /// Steps the core and passes its effects to `sink`.
    fn step(
        &mut self,
        params: &Params,
        step: &Step<'_>,
        event: &Event<'_>,
        (source, assumed): (Option<&protocol::Contacts>, bool),
        sink: &mut Sink<'_>,
    ) -> io::Result<Outcome> {
        let mut effects = Vec::new();
        let outcome = self.robot.step(params, step.at, event, &mut effects);
        for effect in &effects {
            if let Effect::Command(command) = effect
                && let Some(view) = self.robot.whisker(command.whisker)
            {
                let place = (view.array.to_owned(), view.sheet.number);
                self.answers.commanded(place, command, view.setpoint, params.command.resend_after);
            }
            let robot = Some((step.fleet, step.name, &self.robot));
            sink(&Happened { at: step.at, robot, what: What::Effect { effect, source, assumed } })?;
        }
        Ok(outcome)
    }
}
