//! A supervised robot without the service: bytes are decoded, converted to the core's events, and applied to the robot.

use vibrissa_core::mechanics::CONTACT_RATIOS;
use vibrissa_core::robot::effect::{Command, CommandKey, Effect};
use vibrissa_core::robot::event::{Contact, MissedTouch};
use vibrissa_core::robot::{Event, Numbers, Outcome, Params, Robot};
use vibrissa_core::units::Micros;
use vibrissa_edge as edge;
use vibrissa_edge::contract::setpoint_reason;
use vibrissa_protocol::{
    self as protocol, BootId, Message, Name, RobotTopic, Timestamp, Topic, decode, encode, envelope,
};
use vibrissa_tests::extremes::{FROM_ROBOTS, not_finite};

const EPOCH: u64 = 1;

/// An input for the robot.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Input {
    /// A tick of the clock.
    Tick,
    /// A message on a topic.
    Message(RobotTopic, Vec<u8>),
}

/// The result of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fate {
    /// The core accepted it.
    Taken,
    /// The message was refused with this label.
    Refused(&'static str),
}

/// A supervised robot.
pub(crate) struct Subject<'a> {
    pub(crate) robot: Robot,
    params: &'a Params,
    models: Vec<&'a str>,
    topics: [Topic; FROM_ROBOTS.len()],
    effects: Vec<Effect>,
}

/// Command id of a setpoint in this test.
pub(crate) fn name_of(key: CommandKey) -> String {
    format!("{}-{}", key.epoch, key.version)
}

impl<'a> Subject<'a> {
    pub(crate) fn new(params: &'a Params) -> Self {
        let name = |text| Name::new(text).unwrap();
        Self {
            robot: Robot::new(EPOCH, Numbers::default()),
            params,
            models: params.models.iter().map(|(name, _)| name.as_str()).collect(),
            topics: FROM_ROBOTS.map(|kind| kind.of(&name("f"), &name("r"))),
            effects: Vec::new(),
        }
    }

    /// Applies an input as the service would.
    ///
    /// # Errors
    /// A violation of an invariant: an effect with a number that is not finite, a message without a receipt, or a
    /// setpoint that violates the contract.
    pub(crate) fn take(&mut self, now: Micros, input: &Input) -> Result<Fate, String> {
        let (kind, payload) = match input {
            Input::Tick => {
                self.step(now, &Event::Tick)?;
                return Ok(Fate::Taken);
            }
            Input::Message(kind, payload) => (*kind, payload),
        };
        let topic = FROM_ROBOTS.iter().position(|&one| one == kind).expect("a topic of robots");
        match decode(&self.topics[topic], payload) {
            Ok(message) => self.message(now, &message),
            Err(refusal) => {
                if kind == RobotTopic::Contacts
                    && let Some(envelope) = envelope(payload)
                {
                    self.contacts(now, &envelope.boot_id, envelope.seq, (&[], &[]))?;
                }
                Ok(Fate::Refused(refusal.label()))
            }
        }
    }

    fn message(&mut self, now: Micros, message: &Message) -> Result<Fate, String> {
        match message {
            Message::Connection(message) => {
                let event = Event::Connection { boot_id: message.boot_id.as_str(), link: edge::link(message.state) };
                self.step(now, &event)?;
            }
            Message::Factsheet(message) => match edge::factsheet(message, &self.models) {
                Ok(factsheet) => {
                    let boot_id = message.boot_id.as_str();
                    self.step(now, &Event::Factsheet { boot_id, factsheet: &factsheet })?;
                }
                Err(problem) => return Ok(Fate::Refused(problem.label())),
            },
            Message::Contacts(message) => {
                let contacts: Vec<_> = message.contacts.iter().filter_map(|one| edge::contact(one).ok()).collect();
                let missed: Vec<_> = message.missed.iter().filter_map(|one| edge::missed(one).ok()).collect();
                self.contacts(now, &message.boot_id, message.seq, (&contacts, &missed))?;
            }
            Message::Status(message) => {
                let whiskers: Result<Vec<_>, _> = message.whiskers.iter().map(edge::status).collect();
                match whiskers {
                    Ok(whiskers) => {
                        let (boot_id, robot_time) = (message.boot_id.as_str(), Micros(message.t_us));
                        self.step(now, &Event::Status { boot_id, robot_time, whiskers: &whiskers })?;
                    }
                    Err(problem) => return Ok(Fate::Refused(problem.label())),
                }
            }
            Message::SetpointState(message) => return self.setpoint_state(now, message),
            Message::TestState(message) => {
                // Whatever the id says, it is taken for an answer to the first test under way.
                let test = self.robot.tests_under_way().next().map(|(test, _)| test);
                if let Some(test) = test {
                    let report = edge::touch_tests::report(message);
                    let (boot_id, robot_time) = (message.boot_id.as_str(), Micros(message.t_us));
                    self.step(now, &Event::TouchTest { boot_id, test, report, robot_time })?;
                }
            }
            Message::Receipt(_)
            | Message::Setpoint(_)
            | Message::Request(_)
            | Message::Estimate(_)
            | Message::Maintenance(_)
            | Message::SupervisorState(_)
            | Message::SupervisorRequest(_) => {
                unreachable!("robots do not say this")
            }
        }
        Ok(Fate::Taken)
    }

    fn contacts(
        &mut self,
        now: Micros,
        boot_id: &protocol::BootId,
        seq: u64,
        (contacts, missed): (&[Contact<'_>], &[MissedTouch<'_>]),
    ) -> Result<(), String> {
        let outcome = self.step(now, &Event::Contacts { boot_id: boot_id.as_str(), seq, contacts, missed })?;
        let is_covered = || {
            self.robot.sequence(boot_id.as_str()).is_some_and(|sequence| {
                seq < sequence.next() || sequence.held().iter().any(|&(first, last)| (first..=last).contains(&seq))
            })
        };
        // Without a receipt the robot would send an accepted message again endlessly.
        if matches!(outcome, Outcome::Taken | Outcome::Duplicate) && !is_covered() {
            return Err(format!("contacts {seq} of boot {boot_id} are {outcome:?} and no receipt covers them"));
        }
        Ok(())
    }

    fn setpoint_state(&mut self, now: Micros, message: &protocol::SetpointState) -> Result<Fate, String> {
        let found = self.robot.commands_under_way().find(|command| name_of(command.key) == message.command_id);
        let Some((command, pressure)) = found.map(|command| (command.key, command.pressure)) else {
            return Ok(Fate::Taken);
        };
        match edge::setpoint_report(message, pressure) {
            Ok(report) => {
                let (boot_id, robot_time) = (message.boot_id.as_str(), Micros(message.t_us));
                self.step(now, &Event::Setpoint { boot_id, command, report, robot_time })?;
                Ok(Fate::Taken)
            }
            Err(problem) => Ok(Fate::Refused(problem.label())),
        }
    }

    fn step(&mut self, now: Micros, event: &Event<'_>) -> Result<Outcome, String> {
        self.effects.clear();
        let outcome = self.robot.step(self.params, now, event, &mut self.effects);
        if let Some(place) = not_finite(&self.effects) {
            return Err(format!("an effect is not finite: ..{place}"));
        }
        for effect in &self.effects {
            if let Effect::Command(command) | Effect::Resend(command) = effect {
                self.keeps_the_contract(command)?;
            }
        }
        Ok(outcome)
    }

    /// Checks that a robot that validates setpoints accepts this one.
    fn keeps_the_contract(&self, command: &Command) -> Result<(), String> {
        let view = self.robot.whisker(command.whisker).ok_or("a setpoint for an unknown whisker")?;
        let setpoint = protocol::Setpoint {
            boot_id: BootId::new("s").unwrap(),
            seq: 0,
            command_id: name_of(command.key),
            epoch: command.key.epoch,
            version: command.key.version,
            robot_boot_id: BootId::new(&command.robot_boot_id).unwrap(),
            array: Name::new(view.array).unwrap(),
            whisker: view.sheet.number,
            pressure_mpa: command.pressure.mpa(),
            slew_mpa_per_s: command.slew_mpa_per_s,
            issued: Timestamp(command.issued.0),
            expires_us: command.expires.0,
            reason: setpoint_reason(command.reason),
            gain: command.gain.map(|gain| CONTACT_RATIOS.into_iter().zip(gain).collect()).unwrap_or_default(),
            reading_gain: None,
        };
        let topic = RobotTopic::Setpoint.of(&Name::new("f").unwrap(), &Name::new("r").unwrap());
        let read = decode(&topic, &encode(&setpoint));
        read.map(drop).map_err(|refusal| format!("a setpoint breaks the contract: {refusal}"))
    }

    /// Checks the whole state of the robot, its views, and that the stored state can be restored.
    ///
    /// # Errors
    /// A number is not finite, or the stored state cannot be restored.
    pub(crate) fn check_state(&self) -> Result<(), String> {
        if let Some(place) = not_finite(&self.robot) {
            return Err(format!("the state is not finite: ..{place}"));
        }
        for index in 0..self.robot.whisker_count() {
            if let Some(place) = not_finite(&self.robot.whisker(index)) {
                return Err(format!("a view is not finite: ..{place}"));
            }
        }
        let head = self.robot.to_bytes().ok_or("the robot cannot be stored")?;
        let whiskers: Option<Vec<_>> =
            (0..self.robot.whisker_count()).map(|index| self.robot.whisker_to_bytes(index)).collect();
        let whiskers = whiskers.ok_or("a whisker cannot be stored")?;
        let restored = Robot::restore(&head, &whiskers)
            .map_err(|problem| format!("the stored state cannot be restored: {problem}"))?;
        let again: Option<Vec<_>> = (0..whiskers.len()).map(|index| restored.whisker_to_bytes(index)).collect();
        if restored.to_bytes().as_ref() == Some(&head) && again.as_ref() == Some(&whiskers) {
            return Ok(());
        }
        Err("the restored state differs from the stored one".to_owned())
    }
}
