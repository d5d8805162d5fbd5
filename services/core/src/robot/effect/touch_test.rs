//! Effects about touch tests: requests, proposals and states.

use borsh::{BorshDeserialize, BorshSerialize};

use super::{CommandKey, WhiskerIndex};
use crate::units::Micros;

/// A request for touches that measure a whisker's length or response.
#[derive(Debug, Clone, PartialEq, BorshSerialize, BorshDeserialize)]
pub struct TouchTest {
    /// Epoch and version, which identify the test; the version is of the same series as those of setpoints.
    pub key: CommandKey,
    /// Whisker to be touched.
    pub whisker: WhiskerIndex,
    /// The only boot that may take it.
    pub robot_boot_id: String,
    /// Kind of test.
    pub kind: TestKind,
    /// Distances from the base at which to touch, mm, for [`TestKind::Wall`].
    pub distances_mm: Vec<f64>,
    /// Deflections at which to touch, mm, for [`TestKind::Wall`].
    pub deflections_mm: Vec<f64>,
    /// Number of contacts.
    pub contacts: u16,
    /// Time of issue by the supervisor's clock.
    pub issued: Micros,
    /// Time by the robot's clock after which the robot rejects the test.
    pub expires: Micros,
    /// Reason for the test.
    pub reason: TestReason,
}

/// A touch test that an operator can start, in mode ADVISE.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProposedTest {
    /// Identifies the proposal. The version is of the series of setpoints; the test itself gets the next one.
    pub key: CommandKey,
    /// Whisker to be touched.
    pub whisker: WhiskerIndex,
    /// Kind of test.
    pub kind: TestKind,
    /// Number of contacts.
    pub contacts: u16,
    /// Reason for the test.
    pub reason: TestReason,
}

/// Kind of touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum TestKind {
    /// Sweeps an object so that the contact leaves over the tip.
    Tip,
    /// Presses against a known surface at given distances and deflections.
    Wall,
}

/// Reason for a touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum TestReason {
    /// The reach of the whisker has changed.
    Suspicion,
    /// A setpoint of a compensation was applied: its error is to be measured.
    Setpoint,
    /// An operator asked for it.
    Operator,
    /// The whisker was not touched for long, or the robot has started anew: it may have been cut meanwhile.
    Pause,
    /// The interval since the last test is over.
    Schedule,
    /// Its sensitivity rose, and its contacts left open whether it was cut or its gain wanders.
    Change,
}

/// State of a touch test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum TestState {
    /// Requested; not answered yet.
    Pending,
    /// The robot will do it.
    Accepted,
    /// The robot is at it.
    Running,
    /// All contacts are sent.
    Done,
    /// The robot will not do it.
    Rejected,
    /// The robot could not do it.
    Failed,
    /// No answer or no end in time.
    Expired,
    /// The robot started anew before the end, or the whisker is not on it any more.
    Abandoned,
    /// It waits for an operator, in mode ADVISE; nothing was sent.
    Proposed,
    /// It was proposed, and is requested now or not needed any more.
    Withdrawn,
    /// It was proposed, and an operator refused it.
    Refused,
}
