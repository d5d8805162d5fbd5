use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{DEFLECTION_MM, DISTANCE_MM};
use crate::{
    BootId, CONTACTS_MAX, Name, Refusal, TEST_POINTS_MAX, Timestamp, TouchTestError, TouchTestKind, TouchTestOutcome,
    TouchTestReason, check,
};

/// Touches that the supervisor requests, to measure a whisker's length or response. A robot accepts it under the rules of
/// a setpoint: `robot_boot_id` is its own, (`epoch`, `version`) is higher than any seen for that whisker, and `expires_us`
/// is in the future by its own clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema), schemars(transform = crate::schema::points_of_wall))]
pub struct TouchTest {
    /// Identifies the test: a repeated one is answered again and not done again. Its contacts carry it.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub test_id: String,
    /// Epoch of the supervisor; (`epoch`, `version`) orders the tests and setpoints of a whisker.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub epoch: u64,
    /// Version of the test; it rises within an epoch.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub version: u64,
    /// Boot id of the robot that the test is for.
    pub robot_boot_id: BootId,
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// Kind of test, one of the factsheet's `touch_tests`.
    pub kind: TouchTestKind,
    /// Distances from the base at which to touch, in mm, without the chamber's elongation; empty for `TIP`.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::test_distances"))]
    pub distances_mm: Vec<f64>,
    /// Deflections at which to touch, in mm; empty for `TIP`.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::test_deflections"))]
    pub deflections_mm: Vec<f64>,
    /// Number of touches, those that do not come included: the distances in turn, each with the next deflection.
    #[cfg_attr(feature = "documents", schemars(range(min = 1, max = CONTACTS_MAX)))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub contacts: u16,
    /// Time at which it was issued, by the supervisor's clock.
    pub issued: Timestamp,
    /// Time at which it expires, in microseconds since 1970 UTC by the robot's own clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub expires_us: u64,
    /// Reason of the test.
    pub reason: TouchTestReason,
}

/// `test_state`: progress or result of a touch test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "documents", schemars(transform = crate::schema::error_of_rejected))]
pub struct TestState {
    /// Boot id of the robot.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Id of the answered test.
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::identifier_field"))]
    pub test_id: String,
    /// State of the test.
    pub state: TouchTestOutcome,
    /// Time of the state, in microseconds since 1970 UTC by the robot's clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub t_us: u64,
    /// Reason, with `REJECTED`; absent otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<TouchTestError>,
}

impl Checked for TouchTest {
    fn check(&self) -> Result<(), Refusal> {
        check::identifier("test_id", &self.test_id)?;
        check::integer("epoch", self.epoch)?;
        check::integer("version", self.version)?;
        check::integer("expires_us", self.expires_us)?;
        check::count("distances_mm", self.distances_mm.len(), TEST_POINTS_MAX)?;
        check::each("distances_mm", &self.distances_mm, |&mm| DISTANCE_MM.check("", mm))?;
        check::count("deflections_mm", self.deflections_mm.len(), TEST_POINTS_MAX)?;
        check::each("deflections_mm", &self.deflections_mm, |&mm| DEFLECTION_MM.check("", mm))?;
        check::count("contacts", self.contacts.into(), CONTACTS_MAX)?;
        let problem = match self.kind {
            _ if self.contacts == 0 => "0, but a test has at least one contact",
            TouchTestKind::Wall if self.distances_mm.is_empty() || self.deflections_mm.is_empty() => {
                "WALL needs distances_mm and deflections_mm"
            }
            TouchTestKind::Wall | TouchTestKind::Tip => return Ok(()),
        };
        Err(Refusal::Malformed { path: "contacts".to_owned(), problem: problem.to_owned() })
    }
}

impl Checked for TestState {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::identifier("test_id", &self.test_id)?;
        check::integer("t_us", self.t_us)?;
        if self.state == TouchTestOutcome::Rejected && self.error.is_none() {
            let problem = "missing, but REJECTED needs a reason".to_owned();
            return Err(Refusal::Malformed { path: "error".to_owned(), problem });
        }
        Ok(())
    }
}
