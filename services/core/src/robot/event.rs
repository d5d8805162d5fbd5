//! The inputs of a step: a closed set of events, already parsed and checked for range.

use borsh::{BorshDeserialize, BorshSerialize};

use super::action::OperatorAction;
use super::command_key::CommandKey;
use crate::units::{ContactRatio, Megapascal, Micros, Millimetre, Strain};

/// One input of [`super::Robot::step`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event<'a> {
    /// A birth, an orderly end, or a last will.
    Connection {
        /// Boot whose connection changed.
        boot_id: &'a str,
        /// New state of the connection.
        link: Link,
    },
    /// Arrays and whiskers of the robot.
    Factsheet {
        /// Boot that sent the message.
        boot_id: &'a str,
        /// Content of the factsheet.
        factsheet: &'a Factsheet,
    },
    /// A batch of contacts.
    Contacts {
        /// Boot that sent the message.
        boot_id: &'a str,
        /// Number of the message in this boot.
        seq: u64,
        /// The contacts; empty for a message that was refused as a whole: its number is accounted for all the same.
        contacts: &'a [Contact<'a>],
        /// Touches that were expected and did not come.
        missed: &'a [MissedTouch<'a>],
    },
    /// Condition of chambers and gauges.
    Status {
        /// Boot that sent the message.
        boot_id: &'a str,
        /// Time of sending by the robot's clock.
        robot_time: Micros,
        /// One entry for each whisker.
        whiskers: &'a [WhiskerStatus<'a>],
    },
    /// A robot's report on a setpoint.
    Setpoint {
        /// Boot that sent the message.
        boot_id: &'a str,
        /// Key of the setpoint.
        command: CommandKey,
        /// Report of the robot.
        report: SetpointReport,
        /// Time of sending by the robot's clock; 0 if it is unknown.
        robot_time: Micros,
    },
    /// A robot's report on a touch test.
    TouchTest {
        /// Boot that sent the message.
        boot_id: &'a str,
        /// Key of the test.
        test: CommandKey,
        /// Report of the robot.
        report: TestReport,
        /// Time of sending by the robot's clock; 0 if it is unknown.
        robot_time: Micros,
    },
    /// An operator requests an action.
    Operator(&'a OperatorAction<'a>),
    /// The parameters differ from those of the last event. Decisions are taken anew, and refused compensators may be
    /// proposed again. Compensations in force follow the rules for changing an assignment, and proposed ones go on
    /// waiting for approval, also if the new policy would not ask for it.
    PolicyChanged,
    /// Time has passed.
    Tick,
}

/// State of a robot's connection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Link {
    /// The robot is connected.
    Online,
    /// The robot ended the connection in order.
    Offline,
    /// The connection broke: the broker published the last will.
    Broken,
}

/// Arrays and whiskers of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Factsheet {
    /// Its arrays; names are unique.
    pub arrays: Vec<ArraySheet>,
    /// Touch tests that it can do by itself.
    pub touch_tests: TouchTests,
    /// It multiplies its readings by the reading gain of the setpoint applied last.
    pub applies_gain: bool,
    /// Ways in which it can change the pressure of its chambers.
    pub air_control: AirControl,
}

/// Ways in which a robot can change the pressure of its chambers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum AirControl {
    /// It has a supply, and vents.
    #[default]
    FillAndVent,
    /// It can only vent: no pressure above the one at which the whisker is used.
    VentOnly,
    /// It cannot change the pressure.
    None,
}

/// Touch tests that a robot can do by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub struct TouchTests {
    /// It sweeps an object so that the contact leaves over the tip.
    pub tip: bool,
    /// It presses the whisker against a known surface at given distances.
    pub wall: bool,
}

/// An array and its whiskers.
#[derive(Debug, Clone, PartialEq)]
pub struct ArraySheet {
    /// Name, unique on the robot.
    pub name: String,
    /// Kind of array.
    pub kind: ArrayKind,
    /// Use of its readings.
    pub task: Task,
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

/// Use of an array's readings. It decides which loss a cut means.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum Task {
    /// Readings are compared at equal contact ratio, as in the paper: a cut changes the sensitivity there, and a change of
    /// pressure restores it.
    #[default]
    Ratio,
    /// Readings are compared at equal distance from the base: a cut whisker reads there as before, and has lost reach.
    Distance,
}

/// Data of a whisker in the factsheet.
#[derive(Debug, Clone, PartialEq)]
pub struct WhiskerSheet {
    /// Number, unique in its array.
    pub number: u16,
    /// Position on the array along x, mm.
    pub x_mm: f64,
    /// Position on the array along y, mm.
    pub y_mm: f64,
    /// Name of its model.
    pub model: String,
    /// Length of the whole whisker.
    pub length: Millimetre,
    /// Error of the length, mm: it is within this with 95 % probability.
    pub length_tolerance_mm: f64,
    /// Pressure at which the whole whisker is used.
    pub pressure: Megapascal,
    /// Highest pressure that the robot allows.
    pub pressure_max: Megapascal,
    /// Largest strain that the gauge reads, m/m; `None` if the factsheet does not state it.
    pub strain_max: Option<f64>,
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
    /// Time of the contact by the robot's clock.
    pub robot_time: Micros,
    /// Place of the contact on the whisker, as far as the robot knows it.
    pub place: ContactPlace,
    /// Deflection at the contact, above 0.
    pub deflection: Millimetre,
    /// Mean strain over the gauge.
    pub strain: Strain,
    /// Whether the strain was at the end of the gauge's range: a lower bound.
    pub saturated: bool,
    /// Pressure in the chamber.
    pub pressure: Megapascal,
    /// Whether the robot touched on request: then its place says nothing about the robot's habits.
    pub is_test: bool,
    /// Whether the robot states the angle of the deflection to the plane of the gauge: the strain is without it then.
    pub angle_is_stated: bool,
    /// Temperature, degrees Celsius, if the robot measures it.
    pub temperature_c: Option<f64>,
}

/// Place of a contact on the whisker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactPlace {
    /// Contact ratio a of the paper, with respect to the present length.
    Ratio {
        /// Contact ratio, above 0 and at most 1.
        ratio: ContactRatio,
        /// Its standard deviation; the configured one if the robot states none.
        sd: Option<f64>,
    },
    /// Distance from the base. What lies beyond the contact carries no load: sensitivity at a distance does not depend on
    /// the length.
    Distance(Distance),
    /// The tip, and its distance from the base if the robot measured it.
    Tip(Option<Distance>),
    /// The robot does not know the place.
    Unknown,
}

/// Distance from a whisker's base, without the chamber's elongation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Measured distance, above 0.
    pub at: Millimetre,
    /// Its standard deviation, mm.
    pub sd_mm: f64,
}

/// A touch that was expected at a place and did not come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MissedTouch<'a> {
    /// Name of the array.
    pub array: &'a str,
    /// Number of the whisker.
    pub whisker: u16,
    /// Time by the robot's clock.
    pub robot_time: Micros,
    /// Distance from the base at which the whisker would have touched.
    pub at: Distance,
}

/// Condition of one chamber and gauge, as the robot sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WhiskerStatus<'a> {
    /// Name of the array.
    pub array: &'a str,
    /// Number of the whisker.
    pub whisker: u16,
    /// Measured pressure in the chamber.
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
    /// The setpoint is held.
    #[default]
    Ok,
    /// The pressure is rising to the setpoint.
    Filling,
    /// The pressure is falling to the setpoint.
    Venting,
    /// The supply pressure is too low to fill.
    SupplyLow,
    /// The robot has found a leak.
    Leak,
    /// The regulator is out of order.
    Fault,
}

/// Condition of a strain gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum GaugeState {
    /// The gauge works.
    #[default]
    Ok,
    /// The reading is at the end of its range.
    Saturated,
    /// The circuit is open: no current.
    Open,
    /// The circuit is shorted: no resistance.
    Short,
}

/// Report of a robot on a setpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SetpointReport {
    /// The robot has received it.
    Received,
    /// The pressure is moving there.
    Applying,
    /// The whisker holds it, at this measured pressure.
    Applied(Megapascal),
    /// The robot refuses it.
    Rejected(Rejection),
    /// The robot could not reach the pressure.
    Failed,
    /// A newer one took its place.
    Superseded,
}

/// Reason of a robot for rejecting a setpoint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Rejection {
    /// The robot has seen a higher (epoch, version).
    Stale,
    /// The robot's clock is past the expiry.
    Expired,
    /// The pressure is outside the factsheet's range.
    OutOfRange,
    /// The robot has no such whisker.
    UnknownWhisker,
    /// The setpoint is for another boot.
    WrongBoot,
    /// The robot cannot take it at the moment.
    NotReady,
    /// The robot is in a task, and takes it after its end.
    InTask,
}

/// Report of a robot on a touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TestReport {
    /// The robot will do it.
    Accepted,
    /// The robot is at it.
    Running,
    /// All contacts are sent.
    Done,
    /// The robot refuses it.
    Rejected(Rejection),
    /// The robot could not do it.
    Failed,
}
