//! The words of drivers.

mod states;

use std::borrow::Cow;

use serde::Deserialize;
use serde::de::DeserializeOwned;
use vibrissa_protocol::{Gauge, Name, Regulator, plain};

pub use states::{Changes, Configuration, Configured, Driving, Hello, Problem, Progress, Source, Task, TestState};

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
    /// Whether the robot is in a task.
    Task(Task),
    /// Where was this touch?
    Locate(Locate),
    /// A board's answer to a person who configures it.
    Configured(Configured),
    /// A part of a board's configuration.
    Configuration(Configuration),
    /// A board has refused a line.
    Error(Problem),
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
    /// `locate`: a question for the place of a touch.
    Locate {
        /// Strain as measured, without its value at rest, in m/m.
        strain: f64,
        /// Deflection, in mm.
        deflection_mm: f64,
        /// Text that the answer repeats, up to 160 characters.
        id: Option<String>,
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
const WORDS: &str = "send one of hello, contact, strain, motion, pressure, fault, test_state, driving, task, locate";

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
            "task" => read(text, Self::Task),
            "locate" => read(text, Self::Locate),
            "configured" => read(text, Self::Configured),
            "configuration" => read(text, Self::Configuration),
            "error" => read(text, Self::Error),
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
