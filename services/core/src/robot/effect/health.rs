//! Effects about the health of whiskers: conditions, faults, trims and alarms.

use borsh::{BorshDeserialize, BorshSerialize};

use super::WhiskerIndex;
use crate::estimation::LengthEstimate;
use crate::robot::event::GaugeState;
use crate::units::Millimetre;

/// Mechanical condition of a whisker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, BorshSerialize, BorshDeserialize)]
pub enum Condition {
    /// Cold start: offset and noise are being learned.
    #[default]
    Learning,
    /// As long and as sensitive as the factsheet says.
    Healthy,
    /// The detector has raised an alarm that is being looked into.
    Suspected,
    /// Shorter than whole, by a cut.
    Trimmed,
    /// Becoming shorter by wear.
    Eroding,
    /// Less sensitive, which no trim explains.
    SensitivityLoss,
}

/// Reason why a whisker cannot be relied on, whatever its length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum Fault {
    /// No contact or status of it was received in time, or the robot is not connected.
    Stale,
    /// Its gauge is faulty: reported by the robot, or found from its contacts.
    Gauge(GaugeState),
    /// Its pressure is not held.
    Leak,
    /// Its regulator is out of order.
    Regulator,
    /// Too little air to fill it.
    SupplyLow,
}

/// A detected trim.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trim {
    /// Number on this robot.
    pub id: u32,
    /// The whisker concerned.
    pub whisker: WhiskerIndex,
    /// Length before the trim.
    pub length_before: Millimetre,
    /// Length estimate after the trim.
    pub length_after: LengthEstimate,
    /// Contacts from the likeliest moment of the cut to the decision.
    pub contacts_to_detect: u32,
}

/// Kind of alarm. An alarm stands until the event that its kind names here, or until the whisker is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, BorshSerialize, BorshDeserialize)]
pub enum AlarmKind {
    /// A trimmed whisker that no one can compensate for: until it is served or proposed to be, is replaced, or is not
    /// trimmed any more.
    Uncompensated,
    /// Setpoints have failed: until the robot takes one, or a new boot, a new whisker or an operator begins anew.
    SetpointFailed,
    /// A whisker has lost sensitivity, which no trim explains: until its condition is another.
    SensitivityLoss,
    /// A whisker erodes: until its condition is another.
    Eroding,
    /// The whole array reads more or less than before: deflection mis-scaled, or temperature. The shift is taken out.
    /// Until the whisker of the alarm has had a thousand contacts without more of it, or is learned anew.
    ArrayShift,
    /// The gauge's baseline drifts. The drift is followed and taken out, but the gauge stays suspect: until an operator
    /// has it learned anew, or replaces the whisker.
    BaselineDrift,
    /// A fault: until it goes or becomes another. A whisker has [`Fault::Stale`] as an alarm only while other whiskers of
    /// its robot are heard.
    Fault(Fault),
    /// A compensation for this whisker waits for approval: until it is approved, refused or over.
    Proposed,
    /// Contacts near the tip have failed to come for so long that chance does not explain it: the whisker is cut and the
    /// robot divides distances by an old length or knows only distances, or the robot has changed its habits. Until such
    /// contacts come again, a touch test decides, or a trim is called.
    ReachLost,
    /// The robot has vented the whisker by itself, and the pressure before is not restored: the whisker is held or faulty, or no
    /// silence explains it. Until it is filled, or about to be.
    Vented,
    /// Two whiskers of the robot have changed at once, each to the response of the other: until they have changed back, or
    /// an operator has each learned anew or replaced.
    CablesExchanged,
    /// A cut whisker reads like a whole one again: until an operator says that it was replaced, or has it learned anew.
    WhiskerReplaced,
    /// Strong contacts give strains below zero: until some give strains above it.
    GaugeReversed,
    /// Readings are off by more than 5 % for a hundred contacts, and nothing explains it: until they fit again.
    ModelMisfit,
    /// No whisker of the robot is heard, or the robot is not connected: one alarm about the robot, until a whisker is
    /// heard again.
    RobotSilent,
    /// The robot sends contacts again and again that were receipted long before: one alarm about the robot, until it stops.
    /// The supervisor raises it, because only it knows when receipts went out.
    ReceiptsUnheard,
    /// Two robots use the name of this one: replaced boots come back. One alarm about the robot, until none has come back
    /// for a minute.
    DuplicateRobot,
}
