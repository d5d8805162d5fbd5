//! The words of the agent to its drivers.

use serde::Serialize;
use vibrissa_protocol::{Name, TouchTestKind, WhiskerCondition};

/// A line to the driver.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ToDriver {
    /// The first line to a driver, and the answer to its `hello`.
    Hello {
        /// Version of the interface.
        version: u32,
        /// Whiskers with their limits.
        whiskers: Vec<HelloWhisker>,
    },
    /// Hold this pressure.
    SetPressure {
        /// Array of the whisker.
        array: Name,
        /// Its number.
        whisker: u16,
        /// Pressure, in MPa.
        pressure_mpa: f64,
        /// Highest rate of change, in MPa/s.
        slew_mpa_per_s: f64,
    },
    /// Multiply each reading of the whisker by this factor. Only to drivers of robots that apply gains.
    ReadingGain {
        /// Array of the whisker.
        array: Name,
        /// Its number.
        whisker: u16,
        /// The factor.
        reading_gain: f64,
    },
    /// Open a valve for a pulse; close both valves afterwards.
    Valve {
        /// Array of the whisker.
        array: Name,
        /// Its number.
        whisker: u16,
        /// The valve.
        open: Opening,
        /// Length of the pulse, in milliseconds, at most 1000; 0 with `CLOSE`.
        for_ms: f64,
    },
    /// Do a touch test.
    Test {
        /// Identifies the test.
        test_id: String,
        /// Array of the whisker.
        array: Name,
        /// Its number.
        whisker: u16,
        /// Kind of the test.
        kind: TouchTestKind,
        /// Distances from the base, in mm.
        distances_mm: Vec<f64>,
        /// Deflections, in mm.
        deflections_mm: Vec<f64>,
        /// Number of touches.
        contacts: u16,
    },
    /// The supervisor's estimate of a whisker.
    Estimate {
        /// Array of the whisker.
        array: Name,
        /// Its number.
        whisker: u16,
        /// Present length, in mm.
        length_mm: f64,
        /// Lower bound of its 95 % interval, in mm.
        length_low_mm: f64,
        /// Upper bound, in mm.
        length_high_mm: f64,
        /// Mechanical condition.
        condition: WhiskerCondition,
        /// Pairs of contact ratio and factor on the strain.
        gain: Vec<(f64, f64)>,
    },
    /// The place of a touch, or why it has none.
    Place {
        /// The text of the question.
        #[serde(skip_serializing_if = "Option::is_none")]
        id: Option<String>,
        /// Array of the whisker, as in the question.
        #[serde(skip_serializing_if = "Option::is_none")]
        array: Option<Name>,
        /// Its number.
        whisker: u16,
        /// Distance from the base, in mm.
        #[serde(skip_serializing_if = "Option::is_none")]
        distance_mm: Option<f64>,
        /// Lower bound of its 95 % interval, in mm.
        #[serde(skip_serializing_if = "Option::is_none")]
        distance_low_mm: Option<f64>,
        /// Upper bound, in mm.
        #[serde(skip_serializing_if = "Option::is_none")]
        distance_high_mm: Option<f64>,
        /// Why the touch has no place.
        #[serde(skip_serializing_if = "Option::is_none")]
        problem: Option<String>,
    },
    /// A line that the agent refused.
    Error {
        /// Number of the line since the driver's start, from 1.
        line: u64,
        /// Description of the error.
        problem: String,
        /// Remedy for the author of the driver.
        #[serde(rename = "do")]
        remedy: &'static str,
    },
}

/// A valve to open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Opening {
    /// The fill valve.
    Fill,
    /// The vent valve.
    Vent,
    /// None: both are closed now.
    Close,
}

/// A whisker in `hello`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HelloWhisker {
    /// Array of the whisker.
    pub array: Name,
    /// Its number.
    pub whisker: u16,
    /// Pressure to hold now, in MPa.
    pub pressure_mpa: f64,
    /// Highest pressure, in MPa.
    pub pressure_max_mpa: f64,
}

/// Whether a line is one to a driver, and none from it: a device that echoes sends it back. A driver has `hello`, too,
/// but never with whiskers.
pub(crate) fn is_own(line: &[u8]) -> bool {
    let starts = [
        &br#"{"type":"set_pressure","#[..],
        br#"{"type":"reading_gain","#,
        br#"{"type":"valve","#,
        br#"{"type":"test","#,
        br#"{"type":"estimate","#,
        br#"{"type":"place","#,
        br#"{"type":"error","line":"#,
    ];
    starts.iter().any(|start| line.starts_with(start))
        || line.strip_prefix(br#"{"type":"hello","version":"#).is_some_and(|rest| {
            let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            rest[digits..].starts_with(br#","whiskers":["#)
        })
}

impl ToDriver {
    /// The line, with its end.
    #[must_use]
    pub fn line(&self) -> Vec<u8> {
        let mut line = vibrissa_protocol::encode(self);
        line.push(b'\n');
        line
    }
}
