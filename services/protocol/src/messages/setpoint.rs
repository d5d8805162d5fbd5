use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{PRESSURE_MPA, SLEW_MPA_PER_S};
use crate::{BootId, Name, Refusal, SetpointError, SetpointOutcome, SetpointReason, Timestamp, check};

/// `setpoint`: a pressure for a robot to hold in one chamber.
///
/// The pressure is not checked here: a robot answers a pressure outside its factsheet's range with `OUT_OF_RANGE`,
/// so that the supervisor gets an answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Setpoint {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Identifies the command: a repeated one is answered again and not applied again.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub command_id: String,
    /// Epoch of the supervisor; (`epoch`, `version`) orders the setpoints of a whisker. It rises by leaps with each
    /// owner of the fleet and needs 64 bits: it is the start of ownership in milliseconds since 1970 UTC, or later.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub epoch: u64,
    /// Version of the setpoint; it rises within an epoch.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub version: u64,
    /// Boot id of the robot that the setpoint is for.
    pub robot_boot_id: BootId,
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// The gauge pressure to hold, in MPa.
    pub pressure_mpa: f64,
    /// Highest rate of change of the pressure, in MPa/s; above 0.
    #[cfg_attr(feature = "documents", schemars(transform = SLEW_MPA_PER_S.in_schema()))]
    pub slew_mpa_per_s: f64,
    /// Time at which it was issued, by the supervisor's clock.
    pub issued: Timestamp,
    /// Time at which it expires, in microseconds since 1970 UTC by the robot's own clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub expires_us: u64,
    /// Reason of the setpoint.
    pub reason: SetpointReason,
    /// Remaining correction after the pressure: pairs of contact ratio and factor on the compensator's strain, by
    /// rising ratio, for interpolation.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::gain"))]
    pub gain: Vec<(f64, f64)>,
    /// Factor on each reading of the whisker, the same at every contact ratio; absent = 1. It belongs to `pressure_mpa`: a
    /// robot whose factsheet states `applies_gain` uses it from the moment at which it reports APPLIED, and not before.
    /// Never sent to other robots.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = crate::check::READING_GAIN.in_schema()))]
    pub reading_gain: Option<f64>,
}

/// `setpoint_state`: progress or result of a setpoint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "documents", schemars(transform = crate::schema::error_where_due))]
pub struct SetpointState {
    /// Boot id of the robot.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Id of the answered command.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub command_id: String,
    /// State of the setpoint.
    pub state: SetpointOutcome,
    /// Time of the state, in microseconds since 1970 UTC by the robot's clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub t_us: u64,
    /// Measured gauge pressure of the chamber, in MPa; absent if there is no such chamber.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub pressure_mpa: Option<f64>,
    /// Reason, with `REJECTED` and `FAILED`; absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<SetpointError>,
}

impl Checked for Setpoint {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::identifier("command_id", &self.command_id)?;
        check::integer("epoch", self.epoch)?;
        check::integer("version", self.version)?;
        SLEW_MPA_PER_S.check("slew_mpa_per_s", self.slew_mpa_per_s)?;
        check::integer("expires_us", self.expires_us)?;
        check::gain(&self.gain)?;
        check::reading_gain(self.reading_gain)
    }
}

impl Checked for SetpointState {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::identifier("command_id", &self.command_id)?;
        check::integer("t_us", self.t_us)?;
        if let Some(pressure_mpa) = self.pressure_mpa {
            PRESSURE_MPA.check("pressure_mpa", pressure_mpa)?;
        }
        if self.state.needs_error() && self.error.is_none() {
            let problem = format!("missing, but {} needs a reason", self.state);
            return Err(Refusal::Malformed { path: "error".to_owned(), problem });
        }
        Ok(())
    }
}
