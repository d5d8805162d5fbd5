//! What can happen to a robot: the closed set of inputs, already parsed and in range.

use borsh::{BorshDeserialize, BorshSerialize};

use super::action::OperatorAction;
use super::effect::CommandKey;
use crate::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

/// One input of [`super::Robot::step`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'a> {
    /// A birth, a good-bye or a will.
    Connection {
        /// Who was born.
        boot_id: &'a str,
        /// What became of the connection.
        link: Link,
    },
    /// What is on the robot.
    Factsheet {
        /// The boot that says so.
        boot_id: &'a str,
        /// Its content.
        factsheet: &'a Factsheet,
    },
    /// A batch of contacts.
    Contacts {
        /// The boot that felt them.
        boot_id: &'a str,
        /// Number of the message in this boot.
        seq: u64,
        /// The contacts; none for a message that was refused as a whole and is only accounted for.
        contacts: &'a [Contact<'a>],
    },
    /// Condition of chambers and gauges.
    Status {
        /// The boot that says so.
        boot_id: &'a str,
        /// By the robot's clock.
        robot_time: Micros,
        /// One entry a whisker.
        whiskers: &'a [WhiskerStatus<'a>],
    },
    /// What became of a setpoint.
    Setpoint {
        /// The boot that says so.
        boot_id: &'a str,
        /// Which setpoint.
        command: CommandKey,
        /// What became of it.
        report: SetpointReport,
        /// By the robot's clock; 0 if that is not known.
        robot_time: Micros,
    },
    /// An operator asks for something.
    Operator(&'a OperatorAction<'a>),
    /// The parameters are others than at the last event: decisions are taken anew, and what operators refused may be
    /// proposed again. What is in force stays in force by the rules for changing an assignment, and what waits for
    /// approval goes on waiting, also if the new policy would not ask.
    PolicyChanged,
    /// Time has passed.
    Tick,
}

/// State of a robot's connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Link {
    /// Connected.
    Online,
    /// It said good-bye.
    Offline,
    /// The broker said its will.
    Broken,
}

/// What is on a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Factsheet {
    /// Its arrays; names are unique.
    pub arrays: Vec<ArraySheet>,
}

/// What is on an array.
#[derive(Debug, Clone, PartialEq)]
pub struct ArraySheet {
    /// Name, unique on the robot.
    pub name: String,
    /// Kind of array.
    pub kind: ArrayKind,
    /// Its whiskers; numbers are unique and neighbours exist.
    pub whiskers: Vec<WhiskerSheet>,
}

/// The paper's types of configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum ArrayKind {
    /// An array of whiskers, which compensate for one another.
    Type1,
    /// Single whiskers, which compensate for themselves.
    Type2,
}

/// What a factsheet says of a whisker.
#[derive(Debug, Clone, PartialEq)]
pub struct WhiskerSheet {
    /// Number, unique in its array.
    pub number: u16,
    /// Position on the array.
    pub x_mm: f64,
    /// Position on the array.
    pub y_mm: f64,
    /// Name of its model.
    pub model: String,
    /// Whole length.
    pub length: Millimetre,
    /// Nominal pressure.
    pub pressure: Megapascal,
    /// Highest pressure that the robot allows.
    pub pressure_max: Megapascal,
    /// Numbers of its neighbours in the array.
    pub neighbours: Vec<u16>,
}

/// One contact of one whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact<'a> {
    /// Name of the array.
    pub array: &'a str,
    /// Number of the whisker.
    pub whisker: u16,
    /// By the robot's clock.
    pub robot_time: Micros,
    /// The paper's a, with respect to the present length.
    pub ratio: ContactRatio,
    /// Deflection at the contact, above 0.
    pub deflection: Millimetre,
    /// Mean strain over the gauge.
    pub strain: Strain,
    /// Pressure in the chamber.
    pub pressure: Megapascal,
}

/// Condition of one chamber and gauge, as the robot sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiskerStatus<'a> {
    /// Name of the array.
    pub array: &'a str,
    /// Number of the whisker.
    pub whisker: u16,
    /// Measured pressure.
    pub pressure: Megapascal,
    /// The pressure that the robot is holding or moving to.
    pub setpoint: Megapascal,
    /// Condition of the regulator.
    pub regulator: RegulatorState,
    /// Condition of the gauge.
    pub gauge: GaugeState,
}

/// Condition of a pressure regulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum RegulatorState {
    /// Holding.
    #[default]
    Ok,
    /// Moving up.
    Filling,
    /// Moving down.
    Venting,
    /// Not enough air.
    SupplyLow,
    /// The robot has found a leak.
    Leak,
    /// Out of order.
    Fault,
}

/// Condition of a strain gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum GaugeState {
    /// In order.
    #[default]
    Ok,
    /// At the end of its range.
    Saturated,
    /// No current.
    Open,
    /// No resistance.
    Short,
}

/// What a robot says of a setpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SetpointReport {
    /// It has it.
    Received,
    /// It is moving there.
    Applying,
    /// It is there, at this pressure.
    Applied(Megapascal),
    /// It will not take it.
    Rejected(Rejection),
    /// It could not reach it.
    Failed,
    /// A newer one took its place.
    Superseded,
}

/// Why a robot will not take a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Rejection {
    /// It has seen a higher (epoch, version).
    Stale,
    /// Its clock is past the expiry.
    Expired,
    /// Not within the factsheet's range.
    OutOfRange,
    /// No such whisker.
    UnknownWhisker,
    /// The setpoint is for another boot.
    WrongBoot,
    /// Not now.
    NotReady,
}
