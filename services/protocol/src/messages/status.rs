use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::PRESSURE_MPA;
use crate::{ARRAYS_MAX, BootId, Gauge, Name, Refusal, Regulator, Segmenter, WHISKERS_MAX, check};

/// `status`: condition of a robot's chambers and gauges.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Status {
    /// Boot id of the robot.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Time of the status, in microseconds since 1970 UTC by the robot's clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub t_us: u64,
    /// One entry for each whisker.
    #[cfg_attr(feature = "documents", schemars(length(max = ARRAYS_MAX * WHISKERS_MAX)))]
    #[serde(deserialize_with = "crate::shape::objects")]
    pub whiskers: Vec<WhiskerStatus>,
    /// Contacts messages that the robot dropped in this boot because its store was full, or lost in the restart
    /// before; absent for zero or for a robot that does not count them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole_if_any")]
    pub contacts_dropped: Option<u64>,
}

/// Condition of one whisker's chamber and gauge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct WhiskerStatus {
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// Measured gauge pressure of the chamber, in MPa.
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub pressure_mpa: f64,
    /// Pressure that the regulator shall hold, in MPa.
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub setpoint_mpa: f64,
    /// Condition of the regulator.
    pub regulator: Regulator,
    /// Condition of the gauge.
    pub gauge: Gauge,
    /// How far the whisker's contacts can be relied on; absent if the robot finds them in another way than from samples
    /// of strain, or does not know.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub segmenter: Option<Segmenter>,
}

impl Status {
    /// Checks everything but the entries.
    pub(crate) fn check_frame(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::integer("t_us", self.t_us)?;
        check::integer("contacts_dropped", self.contacts_dropped.unwrap_or(0))?;
        check::count("whiskers", self.whiskers.len(), ARRAYS_MAX * WHISKERS_MAX)
    }
}

impl Checked for Status {
    fn check(&self) -> Result<(), Refusal> {
        self.check_frame()?;
        check::each("whiskers", &self.whiskers, WhiskerStatus::check)
    }
}

impl Checked for WhiskerStatus {
    fn check(&self) -> Result<(), Refusal> {
        PRESSURE_MPA.check("pressure_mpa", self.pressure_mpa)?;
        PRESSURE_MPA.check("setpoint_mpa", self.setpoint_mpa)
    }
}
