//! The words of the driver interface, version 1: JSON, one object per line, on standard input and output.

use serde::{Deserialize, Serialize};

/// Version of the interface.
pub const VERSION: u32 = 1;
/// Longest line, in bytes.
pub const LINE_MAX: usize = 64 * 1024;

/// A whisker in the agent's `hello`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Named {
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Highest pressure, MPa.
    pub pressure_max_mpa: f64,
}

/// The supervisor's newest estimate of a whisker.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Estimate {
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Estimated length, mm.
    pub length_mm: f64,
    /// Lower bound of the 95 % interval, mm.
    pub length_low_mm: f64,
    /// Upper bound of the 95 % interval, mm.
    pub length_high_mm: f64,
    /// Condition, such as HEALTHY.
    pub condition: String,
    /// Pairs of contact ratio and factor on the strain.
    #[serde(default)]
    pub gain: Vec<(f64, f64)>,
}

/// An order for a touch test.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct TestOrder {
    /// Identifier of the test.
    pub test_id: String,
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// WALL or TIP.
    pub kind: String,
    /// Distances from the base, mm.
    pub distances_mm: Vec<f64>,
    /// Deflections, mm.
    pub deflections_mm: Vec<f64>,
    /// Number of touches.
    pub contacts: u16,
}

/// A line from the agent.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum FromAgent {
    /// The first line, and the answer to ours.
    Hello {
        /// Version of the interface.
        version: u32,
        /// All whiskers of the robot.
        whiskers: Vec<Named>,
    },
    /// Hold this pressure.
    SetPressure {
        /// Name of the array.
        array: String,
        /// Number of the whisker in its array.
        whisker: u16,
        /// Gauge pressure, MPa.
        pressure_mpa: f64,
        /// Greatest change of pressure, MPa/s.
        slew_mpa_per_s: f64,
    },
    /// Multiply the readings by this factor. Only for robots that apply gains.
    ReadingGain {
        /// Name of the array.
        array: String,
        /// Number of the whisker in its array.
        whisker: u16,
        /// The factor.
        reading_gain: f64,
    },
    /// A pulse of a valve: only for boards without a regulator.
    Valve {},
    /// Do a touch test.
    Test(TestOrder),
    /// The newest estimate of a whisker.
    Estimate(Estimate),
    /// The agent refused a line of ours.
    Error {
        /// The error in the line.
        problem: String,
    },
    /// A word of a later version.
    #[serde(other)]
    Other,
}

/// A line to the agent.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum ToAgent {
    /// The first line.
    Hello {
        /// Version of the interface.
        version: u32,
        /// Name of the driver.
        name: String,
        /// Version of this program.
        software_version: &'static str,
    },
    /// A contact.
    Contact(ContactLine),
    /// Samples of strain.
    Strain(StrainLine),
    /// Whether the robot moves.
    Driving {
        /// It moves from now on, or stands.
        driving: bool,
    },
    /// Whether the robot is in a task, and takes neither setpoints nor touch tests.
    Task {
        /// It is from now on, or not any more.
        task: bool,
    },
    /// Where a whisker is, for its strain.
    Motion {
        /// Name of the array.
        array: String,
        /// Number of the whisker in its array.
        whisker: u16,
        /// Time since 1970 UTC, us; without it the time of receipt counts.
        #[serde(skip_serializing_if = "Option::is_none")]
        t_us: Option<u64>,
        /// Way of the whisker's base, mm.
        #[serde(skip_serializing_if = "Option::is_none")]
        deflection_mm: Option<f64>,
        /// Distance of the contact from the base, mm.
        #[serde(skip_serializing_if = "Option::is_none")]
        distance_mm: Option<f64>,
        /// Contact ratio.
        #[serde(skip_serializing_if = "Option::is_none")]
        ratio: Option<f64>,
    },
    /// A reading of a chamber.
    Pressure {
        /// Name of the array.
        array: String,
        /// Number of the whisker in its array.
        whisker: u16,
        /// Time since 1970 UTC, us; without it the time of receipt counts.
        #[serde(skip_serializing_if = "Option::is_none")]
        t_us: Option<u64>,
        /// Gauge pressure, MPa.
        pressure_mpa: f64,
        /// State of the regulator as a node reports it, and `OK` when readings return.
        #[serde(skip_serializing_if = "Option::is_none")]
        regulator: Option<&'static str>,
    },
    /// A change of condition.
    Fault {
        /// Name of the array.
        array: String,
        /// Number of the whisker in its array.
        whisker: u16,
        /// State of the gauge.
        #[serde(skip_serializing_if = "Option::is_none")]
        gauge: Option<&'static str>,
        /// State of the regulator.
        #[serde(skip_serializing_if = "Option::is_none")]
        regulator: Option<&'static str>,
    },
    /// Progress of a touch test.
    TestState {
        /// Identifier of the test.
        test_id: String,
        /// `RUNNING`, `DONE` or `FAILED`.
        state: &'static str,
    },
}

/// A contact, as a line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContactLine {
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Time since 1970 UTC, us; without it the time of receipt counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub t_us: Option<u64>,
    /// Deflection, mm.
    pub deflection_mm: f64,
    /// Strain of the gauge.
    pub strain: f64,
    /// True if the strain was at an end of the gauge's range.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub saturated: Option<bool>,
    /// Distance from the base, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
    /// Standard deviation of the distance, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_sd_mm: Option<f64>,
    /// Contact ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
    /// Standard deviation of the ratio.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ratio_sd: Option<f64>,
    /// Whether the tip touched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tip: Option<bool>,
    /// Identifier of the touch test to which the contact belongs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test_id: Option<String>,
    /// False for a touch that did not come.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub touched: Option<bool>,
}

/// One sample, or consecutive ones.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Samples {
    /// One sample, or one value for all samples.
    One(f64),
    /// Consecutive samples, the oldest first.
    Many(Vec<f64>),
}

/// Samples of a strain gauge, as a line.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StrainLine {
    /// Name of the array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Time of the first sample since 1970 UTC, us.
    pub t_us: u64,
    /// Strain, m/m.
    pub strain: Samples,
    /// Strain of the second gauge, m/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strain_2: Option<Samples>,
    /// Time between samples, us.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every_us: Option<u32>,
    /// Way of the whisker's base, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deflection_mm: Option<Samples>,
    /// Distance from the base, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<Samples>,
    /// Identifier of the touch test to which the samples belong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub test_id: Option<String>,
}
