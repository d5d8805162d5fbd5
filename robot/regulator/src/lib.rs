//! Regulates the pressure of a chamber with two on/off valves (fill and vent) and a coarse pressure sensor.
//!
//! Pure: [`Regulator::step`] takes the time and a reading and returns at most one [`Command`], a pulse of one valve
//! with its length. [`Valves`] turns commands into the two outputs and closes each valve at the end of its pulse,
//! whatever else happens. There is no clock, no allocation, and no function of `libm`: the crate also runs on a
//! microcontroller.
//!
//! `robot/boards/arduino/vibrissa/src/regulator.h` is the same algorithm in C++. A test runs both on the same readings and
//! compares every command and condition.
//!
//! docs/regulator.md has the state diagram, the reasons for the numbers, and the measurements.

#![no_std]

mod diagnosis;
mod learning;
mod params;
mod regulator;
mod valves;

pub use params::Params;
pub use regulator::Regulator;
pub use valves::Valves;

/// Order to the valves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Leave the valves as they are.
    None,
    /// Open the fill valve for so many microseconds; the vent valve stays closed.
    Fill(u32),
    /// Open the vent valve for so many microseconds; the fill valve stays closed.
    Vent(u32),
    /// Close both valves now.
    Close,
}

/// Condition of the chamber, in the words of the contract's `regulator`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Condition {
    /// The pressure is at the setpoint, or no setpoint was given yet.
    Ok,
    /// On the way up.
    Filling,
    /// On the way down.
    Venting,
    /// The supply cannot reach the setpoint.
    SupplyLow,
    /// Held, but the chamber loses air, or is not reached for that reason.
    Leak,
    /// The regulator has stopped: [`Regulator::fault`] says why.
    Fault,
}

impl Condition {
    /// The word of the contract.
    pub fn word(self) -> &'static str {
        match self {
            Condition::Ok => "OK",
            Condition::Filling => "FILLING",
            Condition::Venting => "VENTING",
            Condition::SupplyLow => "SUPPLY_LOW",
            Condition::Leak => "LEAK",
            Condition::Fault => "FAULT",
        }
    }
}

/// Reason for which the regulator has stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// Readings are missing, not numbers, or beyond the sensor's range. Ends by itself with good readings.
    Sensor,
    /// Pulses do not change the reading: the sensor is frozen, or a valve fails.
    NoResponse,
    /// The fill valve does nothing although the supply is good, or it lets air in while it should be closed.
    FillValve,
    /// The chamber loses more air than the fill valve may replace.
    Burst,
}

/// Direction of a pulse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    Fill,
    Vent,
}
