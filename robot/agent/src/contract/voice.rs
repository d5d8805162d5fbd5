//! Messages that a robot sends, numbered by topic and boot.

use vibrissa_protocol::{
    AirControl, ArrayFacts, BootId, Connection, ConnectionState, Contact, Contacts, Factsheet, MissedTouch,
    OnSupervisorLoss, SetpointState, Software, Status, TestState, Timestamp, TouchTestKind, WhiskerStatus,
};

use super::commands::CommandAnswer;
use super::touch_tests::TestAnswer;

/// Properties of a robot that its factsheet states.
#[derive(Debug, Clone, PartialEq)]
pub struct Facts {
    /// Model of the robot.
    pub model: String,
    /// Behaviour of the robot without a supervisor.
    pub on_supervisor_loss: OnSupervisorLoss,
    /// Arrays of the robot, with distinct names.
    pub arrays: Vec<ArrayFacts>,
    /// Touch tests that the robot can do by itself.
    pub touch_tests: Vec<TouchTestKind>,
    /// Whether the robot multiplies its readings by `reading_gain`.
    pub applies_gain: bool,
    /// Ways in which the robot can change the pressure of its chambers.
    pub air_control: Option<AirControl>,
    /// Programs of the robot that are known.
    pub software: Vec<Software>,
}

/// Boot id of a robot, and the next `seq` of each topic in that boot.
#[derive(Debug)]
pub struct Voice {
    boot_id: BootId,
    /// Number of the next birth; the will or farewell of the connection has the number after it.
    connection: u64,
    factsheet: u64,
    contacts: u64,
    status: u64,
    setpoint_state: u64,
    test_state: u64,
}

fn next(counter: &mut u64) -> u64 {
    let seq = *counter;
    *counter += 1;
    seq
}

impl Voice {
    /// The voice of a new boot.
    #[must_use]
    pub fn new(boot_id: BootId) -> Self {
        Self { boot_id, connection: 0, factsheet: 0, contacts: 0, status: 0, setpoint_state: 0, test_state: 0 }
    }

    /// The voice of an earlier boot, which has sent so many births and factsheets, and whose other topics are silent.
    #[must_use]
    pub fn earlier(boot_id: BootId, births: u64, factsheets: u64) -> Self {
        Self { connection: 2 * births, factsheet: factsheets, ..Self::new(boot_id) }
    }

    /// Number of births of this boot.
    #[must_use]
    pub fn births(&self) -> u64 {
        self.connection / 2
    }

    /// Number of factsheets of this boot.
    #[must_use]
    pub fn factsheets(&self) -> u64 {
        self.factsheet
    }

    /// The same numbers in another boot. Only for a robot that shall break the contract on purpose: each boot counts from 0.
    #[must_use]
    pub fn counting_on(self, boot_id: BootId) -> Self {
        Self { boot_id, ..self }
    }

    /// Id of the boot.
    #[must_use]
    pub fn boot_id(&self) -> &BootId {
        &self.boot_id
    }

    /// Number of contacts messages of this boot; the sequence number of the next one.
    #[must_use]
    pub fn contacts_made(&self) -> u64 {
        self.contacts
    }

    fn connection(&self, seq: u64, now_us: u64, state: ConnectionState) -> Connection {
        Connection { boot_id: self.boot_id.clone(), seq, timestamp: Timestamp(now_us), state }
    }

    /// Last will for the next connection, with the same boot id as its birth.
    #[must_use]
    pub fn will(&self, now_us: u64) -> Connection {
        self.connection(self.connection + 1, now_us, ConnectionState::ConnectionBroken)
    }

    /// Birth of a connection, or the answer to a request for births.
    pub fn birth(&mut self, now_us: u64) -> Connection {
        let birth = self.connection(self.connection, now_us, ConnectionState::Online);
        self.connection += 2;
        birth
    }

    /// Last message before a clean disconnect.
    #[must_use]
    pub fn farewell(&self, now_us: u64) -> Connection {
        self.connection(self.connection.saturating_sub(1), now_us, ConnectionState::Offline)
    }

    /// The factsheet.
    pub fn factsheet(&mut self, now_us: u64, facts: &Facts) -> Factsheet {
        Factsheet {
            boot_id: self.boot_id.clone(),
            seq: next(&mut self.factsheet),
            timestamp: Timestamp(now_us),
            model: facts.model.clone(),
            on_supervisor_loss: facts.on_supervisor_loss,
            arrays: facts.arrays.clone(),
            touch_tests: facts.touch_tests.clone(),
            applies_gain: facts.applies_gain,
            air_control: facts.air_control,
            software: facts.software.clone(),
        }
    }

    /// A status; `dropped` counts the contacts messages that were dropped because of a full outbox.
    pub fn status(&mut self, now_us: u64, whiskers: Vec<WhiskerStatus>, dropped: u64) -> Status {
        Status {
            boot_id: self.boot_id.clone(),
            seq: next(&mut self.status),
            t_us: now_us,
            whiskers,
            contacts_dropped: (dropped > 0).then_some(dropped),
        }
    }

    /// A contacts message.
    pub fn contacts(&mut self, contacts: Vec<Contact>, missed: Vec<MissedTouch>) -> Contacts {
        Contacts { boot_id: self.boot_id.clone(), seq: next(&mut self.contacts), contacts, missed }
    }

    /// The answer to a setpoint; `pressure_mpa` is the chamber's measured pressure, if there is such a chamber.
    pub fn setpoint_state(
        &mut self,
        command_id: &str,
        answer: CommandAnswer,
        now_us: u64,
        pressure_mpa: Option<f64>,
    ) -> SetpointState {
        SetpointState {
            boot_id: self.boot_id.clone(),
            seq: next(&mut self.setpoint_state),
            command_id: command_id.to_owned(),
            state: answer.outcome,
            t_us: now_us,
            pressure_mpa,
            error: answer.error,
        }
    }

    /// The answer to a touch test.
    pub fn test_state(&mut self, test_id: &str, answer: TestAnswer, now_us: u64) -> TestState {
        TestState {
            boot_id: self.boot_id.clone(),
            seq: next(&mut self.test_state),
            test_id: test_id.to_owned(),
            state: answer.outcome,
            t_us: now_us,
            error: answer.error,
        }
    }
}
