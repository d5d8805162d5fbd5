//! The words of the interface.

use std::borrow::Cow;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use vibrissa_protocol::{Gauge, Name, Regulator, TouchTestKind, WhiskerCondition, plain};

/// Largest number of samples in one `strain` line.
pub const SAMPLES_MAX: usize = 1000;

/// A line from the driver.
#[derive(Debug, Clone, PartialEq)]
pub enum FromDriver {
    /// First line after the driver's start.
    Hello(Hello),
    /// One contact, or a touch that did not come.
    Contact(Contact),
    /// Samples of a strain gauge.
    Strain(Strain),
    /// The motion of a whisker, for the strain that another driver reads.
    Motion(Motion),
    /// A reading of a chamber.
    Pressure(Pressure),
    /// The condition of a gauge or a regulator has changed.
    Fault(Fault),
    /// Progress of a touch test.
    TestState(TestState),
    /// Whether the robot moves.
    Driving(Driving),
}

/// `hello`: the driver introduces itself.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct Hello {
    /// Version of the interface.
    pub version: u32,
    /// Name of the driver, for logs and for the factsheet.
    #[serde(default)]
    pub name: String,
    /// Version of the driver's program on a computer.
    #[serde(default)]
    pub software_version: Option<String>,
    /// Version of the program on the board.
    #[serde(default)]
    pub firmware_version: Option<String>,
}

/// The whisker and the time of a line.
#[derive(Debug, Clone, PartialEq)]
pub struct Origin {
    /// Array of the whisker; may be absent if the robot has one array.
    pub array: Option<Name>,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Time by the system's clock, in microseconds since 1970 UTC.
    pub t_us: Option<u64>,
    /// Time since the board's start, in milliseconds.
    pub t_ms: Option<u64>,
    /// Time from that of the line to its newest value, in microseconds: a line is sent after all its values.
    pub span_us: u64,
}

/// Defines lines of whiskers. The fields of [`Origin`] are in each, because serde flattens slowly.
macro_rules! lines {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $kind:ty,)+ })+) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, PartialEq, Deserialize)]
            pub struct $name {
                /// Array of the whisker.
                pub array: Option<Name>,
                /// Number of the whisker in its array.
                pub whisker: u16,
                /// Time by the system's clock, in microseconds since 1970 UTC.
                pub t_us: Option<u64>,
                /// Time since the board's start, in milliseconds.
                pub t_ms: Option<u64>,
                $($(#[$field_doc])* pub $field: $kind,)+
            }

            impl $name {
                /// Time and whisker.
                #[must_use]
                pub fn origin(&self) -> Origin {
                    let (array, whisker) = (self.array.clone(), self.whisker);
                    Origin { array, whisker, t_us: self.t_us, t_ms: self.t_ms, span_us: 0 }
                }
            }
        )+
    };
}

lines! {
    /// `contact`.
    Contact {
        /// Deflection at the contact, in mm; absent with `touched: false`.
        deflection_mm: Option<f64>,
        /// Mean strain over the gauge, in m/m; absent with `touched: false`.
        strain: Option<f64>,
        /// Whether the strain was at the end of the gauge's range.
        #[serde(default)]
        saturated: bool,
        /// Contact ratio.
        ratio: Option<f64>,
        /// Its standard deviation.
        ratio_sd: Option<f64>,
        /// Distance from the base, in mm.
        distance_mm: Option<f64>,
        /// Its standard deviation, in mm.
        distance_sd_mm: Option<f64>,
        /// Whether the contact is at the tip.
        #[serde(default)]
        tip: bool,
        /// Pressure of the chamber, in MPa; otherwise the newest reading.
        pressure_mpa: Option<f64>,
        /// Temperature, in degrees Celsius; otherwise the newest reading.
        temperature_c: Option<f64>,
        /// Touch test that the contact belongs to.
        test_id: Option<String>,
        /// False for a touch that was expected and did not come.
        touched: Option<bool>,
    }
    /// `strain`: samples for the segmenter.
    Strain {
        /// Strain in m/m.
        strain: Samples,
        /// Strain of the second gauge, in m/m.
        strain_2: Option<Samples>,
        /// Time between samples, in microseconds.
        every_us: Option<u64>,
        /// Deflection, if the motion is known, in mm.
        deflection_mm: Option<Samples>,
        /// Distance from the base, if the motion is known, in mm.
        distance_mm: Option<Samples>,
        /// Touch test that the samples belong to.
        test_id: Option<String>,
    }
    /// `motion`: where the whisker is, for the strain of another driver.
    Motion {
        /// Deflection, with any offset, in mm.
        deflection_mm: Option<Samples>,
        /// Distance from the base, in mm.
        distance_mm: Option<Samples>,
        /// Contact ratio.
        ratio: Option<Samples>,
        /// Time between values, in microseconds.
        every_us: Option<u64>,
        /// Touch test that the motion belongs to.
        test_id: Option<String>,
    }
    /// `pressure`: a reading of a chamber.
    Pressure {
        /// Gauge pressure, in MPa.
        pressure_mpa: f64,
        /// Condition of the regulator, if the driver regulates.
        regulator: Option<Regulator>,
        /// Temperature, in degrees Celsius.
        temperature_c: Option<f64>,
        /// Pressure of the supply, in MPa.
        supply_mpa: Option<f64>,
    }
    /// `fault`: a change of condition.
    Fault {
        /// Condition of the gauge.
        gauge: Option<Gauge>,
        /// Condition of the regulator.
        regulator: Option<Regulator>,
    }
}

/// One sample, or consecutive ones.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(untagged)]
pub enum Samples {
    /// One sample.
    One(f64),
    /// Consecutive samples, the oldest first.
    Many(Vec<f64>),
}

impl Samples {
    /// The samples.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Many(many) => many,
        }
    }
}

/// `driving`: the robot moves from now on, or stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub struct Driving {
    /// Whether it moves.
    pub driving: bool,
}

/// `test_state`: progress of a touch test.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct TestState {
    /// The test.
    pub test_id: String,
    /// Its state.
    pub state: Progress,
}

/// State of a touch test, as a driver knows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Progress {
    /// The driver has begun.
    Running,
    /// All touches are done.
    Done,
    /// The driver cannot finish.
    Failed,
}

/// A line that the agent refuses.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadLine {
    /// Description of the error.
    pub problem: String,
    /// Remedy for the author of the driver.
    pub remedy: &'static str,
    /// Whether a driver speaks, although its values are refused. Noise of a serial line is no JSON object with a
    /// `type`.
    pub is_spoken: bool,
}

impl BadLine {
    /// A refusal of values.
    pub fn new(problem: impl Into<String>, remedy: &'static str) -> Self {
        Self { problem: problem.into(), remedy, is_spoken: true }
    }

    /// A refusal of what may be noise.
    pub fn noise(problem: impl Into<String>, remedy: &'static str) -> Self {
        Self { is_spoken: false, ..Self::new(problem, remedy) }
    }
}

#[derive(Deserialize)]
struct Head<'a> {
    #[serde(rename = "type", borrow)]
    kind: Cow<'a, str>,
}

/// The words of drivers, in an error.
const WORDS: &str = "send one of hello, contact, strain, motion, pressure, fault, test_state, driving";

impl FromDriver {
    /// Reads a line.
    ///
    /// # Errors
    /// The line is no object of the interface.
    pub fn read(line: &[u8]) -> Result<Self, BadLine> {
        let text = std::str::from_utf8(line)
            .map_err(|_| BadLine::noise("the line is not UTF-8", "check the device and its baud rate"))?;
        let Head { kind } = serde_json::from_str(text).map_err(|why| {
            BadLine::noise(cut(&plain::data(&why.to_string())), "send one JSON object in each line, with a text `type`")
        })?;
        match &*kind {
            "hello" => read(text, Self::Hello),
            "contact" => read(text, Self::Contact),
            "strain" => read(text, Self::Strain),
            "motion" => read(text, Self::Motion),
            "pressure" => read(text, Self::Pressure),
            "fault" => read(text, Self::Fault),
            "test_state" => read(text, Self::TestState),
            "driving" => read(text, Self::Driving),
            other => Err(BadLine::new(format!("{:?} is no word of a driver", cut(other)), WORDS)),
        }
    }
}

fn read<T: DeserializeOwned>(text: &str, word: impl Fn(T) -> FromDriver) -> Result<FromDriver, BadLine> {
    let read = serde_json::from_str(text).map(word);
    read.map_err(|why| {
        BadLine::new(cut(&plain::data(&why.to_string())), "compare the line with docs/driver-interface.md")
    })
}

/// Texts of a driver are cut, so that an answer is short.
pub(crate) fn cut(text: &str) -> String {
    text.chars().filter(|one| !one.is_control()).take(160).collect()
}

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
        br#"{"type":"error","#,
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
