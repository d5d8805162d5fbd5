//! The ROS messages, with their fields in the order of their `.msg` files: CDR has no names.

use ros2_client::builtin_interfaces::Time;
use serde::{Deserialize, Serialize};

/// `std_msgs/msg/Header`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// Time of the data.
    pub stamp: Time,
    /// Frame of the sensor.
    pub frame_id: String,
}

/// `vibrissa_msgs/msg/Contact`: `robot/ros2/vibrissa_msgs/msg/Contact.msg` explains the fields.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the file explains them")]
pub struct Contact {
    pub header: Header,
    pub array: String,
    pub whisker: u16,
    pub deflection_m: f64,
    pub strain: f64,
    pub place: u8,
    pub distance_m: f64,
    pub distance_sd_m: f64,
    pub ratio: f64,
    pub ratio_sd: f64,
    pub test_id: String,
    pub missed: bool,
    pub saturated: bool,
}

/// `vibrissa_msgs/msg/Strain`: its file explains the fields.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the file explains them")]
pub struct Strain {
    pub header: Header,
    pub strain: Vec<f64>,
    pub strain_2: Vec<f64>,
    pub every_us: u32,
    pub deflection_m: Vec<f64>,
    pub distance_m: Vec<f64>,
    pub test_id: String,
}

/// `vibrissa_msgs/msg/Fault`: its file explains the fields.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the file explains them")]
pub struct Fault {
    pub header: Header,
    pub array: String,
    pub whisker: u16,
    pub gauge: String,
    pub regulator: String,
}

/// `vibrissa_msgs/msg/Estimate`: its file explains the fields.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the file explains them")]
pub struct Estimate {
    pub header: Header,
    pub array: String,
    pub whisker: u16,
    pub length_m: f64,
    pub length_low_m: f64,
    pub length_high_m: f64,
    pub condition: String,
    pub gain_ratio: Vec<f64>,
    pub gain: Vec<f64>,
}

/// Goal of `vibrissa_msgs/action/TouchTest`: its file explains the fields.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the file explains them")]
pub struct TouchTestGoal {
    pub test_id: String,
    pub array: String,
    pub whisker: u16,
    pub kind: u8,
    pub distances_m: Vec<f64>,
    pub deflections_m: Vec<f64>,
    pub contacts: u16,
}

/// Result of `vibrissa_msgs/action/TouchTest`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the file explains them")]
pub struct TouchTestResult {
    pub contacts: Vec<Contact>,
    pub problem: String,
}

/// Feedback of `vibrissa_msgs/action/TouchTest`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the file explains them")]
pub struct TouchTestFeedback {
    pub contacts: u16,
}

impl ros2_client::Message for TouchTestGoal {}
impl ros2_client::Message for TouchTestResult {}
impl ros2_client::Message for TouchTestFeedback {}

/// `sensor_msgs/msg/FluidPressure`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FluidPressure {
    /// Time, and the whisker as array/number.
    pub header: Header,
    /// Pressure, Pa.
    pub fluid_pressure: f64,
    /// Variance, Pa²; 0 if unknown.
    pub variance: f64,
}

/// `std_msgs/msg/Float64`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Float64 {
    /// The number.
    pub data: f64,
}

/// `std_msgs/msg/Float32`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Float32 {
    /// The number.
    pub data: f32,
}

/// `diagnostic_msgs/msg/KeyValue`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct KeyValue {
    /// Name, with its unit.
    pub key: String,
    /// Value as text.
    pub value: String,
}

/// Levels of `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Level {
    /// All is well.
    Ok = 0,
    /// Somebody should look at it.
    Warn = 1,
    /// It does not work.
    Error = 2,
    /// Nothing is known of it now.
    Stale = 3,
}

/// `diagnostic_msgs/msg/DiagnosticStatus`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// A [`Level`].
    pub level: u8,
    /// Component.
    pub name: String,
    /// Summary.
    pub message: String,
    /// Name of the robot.
    pub hardware_id: String,
    /// Details.
    pub values: Vec<KeyValue>,
}

/// `diagnostic_msgs/msg/DiagnosticArray`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// Time of the report.
    pub header: Header,
    /// A status for each whisker, and one for the bridge.
    pub status: Vec<DiagnosticStatus>,
}
