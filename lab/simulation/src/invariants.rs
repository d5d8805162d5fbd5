//! What always holds, and what holds in the end: each invariant once, with a check of observed facts.

use std::fmt;

/// An invariant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Invariant {
    /// A receipt covers only contacts that are committed.
    ReceiptAfterCommit,
    /// A contact that a receipt covers is in the database for good, and in the end every contact is.
    ContactRecorded,
    /// No contact is recorded twice.
    ContactOnce,
    /// A recorded contact has the values that the robot felt.
    ContactAsFelt,
    /// No epoch of a fleet is given twice, and epochs rise.
    EpochOnce,
    /// A robot applies only setpoints that are in the database with the same values.
    SetpointCommitted,
    /// No robot applies a setpoint twice.
    SetpointOnce,
    /// No robot applies a setpoint that is expired, outdated, or for another boot.
    SetpointFresh,
    /// A setpoint lives for its time to live at most, by the robot's clock.
    SetpointExpires,
    /// A decision has one setpoint, unless that came to nothing.
    SetpointForDecision,
    /// The pressure of a setpoint is from 0 to the limit of the whisker.
    PressureInRange,
    /// A trim is reported only of a whisker that was cut.
    TrimIsTrue,
    /// A fault is reported only of a whisker that has it.
    FaultIsTrue,
    /// In the end each fleet has one owner, which hears its robots.
    FleetOwned,
    /// In the end each setpoint has an end: applied, refused, superseded or expired.
    SetpointEnds,
    /// In the end each cut of a whisker is found.
    TrimFound,
    /// No part of the program panics.
    NoPanic,
}

impl Invariant {
    /// All invariants.
    pub const ALL: [Self; 17] = [
        Self::ReceiptAfterCommit,
        Self::ContactRecorded,
        Self::ContactOnce,
        Self::ContactAsFelt,
        Self::EpochOnce,
        Self::SetpointCommitted,
        Self::SetpointOnce,
        Self::SetpointFresh,
        Self::SetpointExpires,
        Self::SetpointForDecision,
        Self::PressureInRange,
        Self::TrimIsTrue,
        Self::FaultIsTrue,
        Self::FleetOwned,
        Self::SetpointEnds,
        Self::TrimFound,
        Self::NoPanic,
    ];

    /// The invariant as a sentence.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::ReceiptAfterCommit => "a receipt covers only contacts that are committed",
            Self::ContactRecorded => "each receipted contact is recorded, and in the end every contact",
            Self::ContactOnce => "no contact is recorded twice",
            Self::ContactAsFelt => "a recorded contact has the values that the robot felt",
            Self::EpochOnce => "no epoch of a fleet is given twice, and epochs rise",
            Self::SetpointCommitted => "a robot applies only setpoints that are committed",
            Self::SetpointOnce => "no robot applies a setpoint twice",
            Self::SetpointFresh => "no robot applies a setpoint that is expired, outdated, or for another boot",
            Self::SetpointExpires => "a setpoint lives for its time to live at most, by the robot's clock",
            Self::SetpointForDecision => "a decision has one setpoint, unless that came to nothing",
            Self::PressureInRange => "the pressure of a setpoint is within the whisker's range",
            Self::TrimIsTrue => "a trim is reported only of a whisker that was cut",
            Self::FaultIsTrue => "a fault is reported only of a whisker that has it",
            Self::FleetOwned => "in the end each fleet has one owner, which hears its robots",
            Self::SetpointEnds => "in the end each setpoint has an end",
            Self::TrimFound => "in the end each cut of a whisker is found",
            Self::NoPanic => "no part of the program panics",
        }
    }
}

impl fmt::Display for Invariant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

/// An invariant that does not hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// Which one.
    pub invariant: Invariant,
    /// The facts.
    pub what: String,
}

impl fmt::Display for Violation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.invariant, self.what)
    }
}
