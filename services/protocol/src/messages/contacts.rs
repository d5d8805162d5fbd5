use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{
    ANGLE_DEG, ANGLE_SD_DEG, DEFLECTION_MM, DISTANCE_MM, DISTANCE_SD_MM, PRESSURE_MPA, RATIO, RATIO_SD, STRAIN,
    TEMPERATURE_C,
};
use crate::{BootId, CONTACTS_MAX, Name, Refusal, check};

/// `contacts`: a batch of contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Contacts {
    /// Boot id of the robot.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// The contacts in the order of their measurement.
    #[cfg_attr(feature = "documents", schemars(length(max = CONTACTS_MAX)))]
    #[serde(deserialize_with = "crate::shape::objects")]
    pub contacts: Vec<Contact>,
    /// Touches that were expected and did not come, because the whisker no longer reaches that far.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "documents", schemars(length(max = CONTACTS_MAX)))]
    #[serde(deserialize_with = "crate::shape::objects")]
    pub missed: Vec<MissedTouch>,
}

/// Measurements of one contact of one whisker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema), schemars(transform = crate::schema::one_place))]
pub struct Contact {
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// Time of the contact, in microseconds since 1970 UTC by the robot's clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub t_us: u64,
    /// The paper's contact ratio a: contact distance / PRESENT length, both without the chamber's elongation; from 0.01
    /// to 1. Only for robots that know the present length. A robot that would divide by the length of its factsheet sends
    /// `distance_mm` instead: a cut whisker has another length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = RATIO.in_schema()))]
    pub ratio: Option<f64>,
    /// Standard deviation of `ratio`, up to 0.5. Only with `ratio`; without it the supervisor assumes its configured one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = RATIO_SD.in_schema()))]
    pub ratio_sd: Option<f64>,
    /// Distance of the contact from the whisker's base along the whisker, in mm, without the chamber's elongation. Never
    /// with `ratio`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = DISTANCE_MM.in_schema()))]
    pub distance_mm: Option<f64>,
    /// Standard deviation of `distance_mm`, up to 100 mm. Only with `distance_mm`; without it the supervisor assumes 1 mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = DISTANCE_SD_MM.in_schema()))]
    pub distance_sd_mm: Option<f64>,
    /// Whether the contact is known to be at the tip, for instance because it slips off the whisker next. Never with
    /// `ratio`. With `distance_mm` it measures the length.
    #[serde(default, skip_serializing_if = "is_false")]
    pub tip: bool,
    /// Deflection of the whisker at the contact, in mm; at least 0.01.
    #[cfg_attr(feature = "documents", schemars(transform = DEFLECTION_MM.in_schema()))]
    pub deflection_mm: f64,
    /// Mean strain over the gauge grid, in m/m; between -1 and 1. It is 0 or has a magnitude of at least 1e-9. It is the
    /// strain as measured, before any gain: the supervisor measures the gain with it.
    #[cfg_attr(feature = "documents", schemars(transform = STRAIN.in_schema()))]
    pub strain: f64,
    /// Whether the strain was at the end of the gauge's or the converter's range: then it is a lower bound, and the
    /// supervisor does not learn from the contact.
    #[serde(default, skip_serializing_if = "is_false")]
    pub saturated: bool,
    /// The chamber's measured gauge pressure in MPa.
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub pressure_mpa: f64,
    /// The whisker's temperature in degrees Celsius.
    #[cfg_attr(feature = "documents", schemars(transform = TEMPERATURE_C.in_schema()))]
    pub temperature_c: f64,
    /// Angle between the direction of the deflection and the plane in which the gauge measures bending, in degrees; from
    /// -75 to 75. The gauge reads the cosine of it. Without it the supervisor takes the direction for a steady one, so that a
    /// robot whose heading changes looks like one whose whiskers change.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = ANGLE_DEG.in_schema()))]
    pub angle_deg: Option<f64>,
    /// Standard deviation of `angle_deg`, up to 45 degrees. Only with `angle_deg`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = ANGLE_SD_DEG.in_schema()))]
    pub angle_sd_deg: Option<f64>,
    /// Id of the touch test that the contact belongs to; absent for others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::optional_identifier"))]
    pub test_id: Option<String>,
}

/// A touch that was expected at a known distance and did not come.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct MissedTouch {
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// Time at which the touch should have come, in microseconds since 1970 UTC by the robot's clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub t_us: u64,
    /// Distance from the whisker's base along the whisker at which it should have touched, in mm, without the chamber's
    /// elongation.
    #[cfg_attr(feature = "documents", schemars(transform = DISTANCE_MM.in_schema()))]
    pub distance_mm: f64,
    /// Standard deviation of `distance_mm`, up to 100 mm; without it the supervisor assumes 1 mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(transform = DISTANCE_SD_MM.in_schema()))]
    pub distance_sd_mm: Option<f64>,
    /// Id of the touch test that the touch belongs to; absent for others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "documents", schemars(schema_with = "crate::schema::optional_identifier"))]
    pub test_id: Option<String>,
}

/// Place of a contact on the whisker, as far as the robot knows it. Standard deviations are those that the robot states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ContactPlace {
    /// Contact distance / present length.
    Ratio {
        /// Contact ratio, from 0.01 to 1.
        ratio: f64,
        /// Its standard deviation.
        sd: Option<f64>,
    },
    /// Distance from the base, without the chamber's elongation.
    Distance(Distance),
    /// The tip, and its distance from the base if the robot measured it.
    Tip(Option<Distance>),
    /// Somewhere on the whisker.
    Unknown,
}

impl ContactPlace {
    /// Kind of the place, as the word in lists and databases.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Ratio { .. } => "RATIO",
            Self::Distance(_) => "DISTANCE",
            Self::Tip(_) => "TIP",
            Self::Unknown => "UNKNOWN",
        }
    }
}

/// A measured distance from the whisker's base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distance {
    /// Distance in mm.
    pub mm: f64,
    /// Its standard deviation in mm.
    pub sd_mm: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub(super) fn is_false(word: &bool) -> bool {
    !word
}

impl Contact {
    /// Place of the contact.
    #[must_use]
    pub fn place(&self) -> ContactPlace {
        let distance = self.distance_mm.map(|mm| Distance { mm, sd_mm: self.distance_sd_mm });
        match (self.ratio, self.tip, distance) {
            (Some(ratio), _, _) => ContactPlace::Ratio { ratio, sd: self.ratio_sd },
            (None, true, distance) => ContactPlace::Tip(distance),
            (None, false, Some(distance)) => ContactPlace::Distance(distance),
            (None, false, None) => ContactPlace::Unknown,
        }
    }

    /// Share of the bending that the gauge reads, by the direction of the deflection: the mean of the cosine over the angles that
    /// the robot holds possible. 1 without a stated direction.
    #[must_use]
    pub fn share_in_gauge_plane(&self) -> f64 {
        let sd = self.angle_sd_deg.unwrap_or(0.0).to_radians();
        self.angle_deg.map_or(1.0, |angle_deg| angle_deg.to_radians().cos() * (-0.5 * sd * sd).exp())
    }

    fn check_place(&self) -> Result<(), Refusal> {
        let optional =
            |range: &check::Range, path, value: Option<f64>| value.map_or(Ok(()), |one| range.check(path, one));
        optional(&RATIO, "ratio", self.ratio)?;
        optional(&RATIO_SD, "ratio_sd", self.ratio_sd)?;
        optional(&DISTANCE_MM, "distance_mm", self.distance_mm)?;
        optional(&DISTANCE_SD_MM, "distance_sd_mm", self.distance_sd_mm)?;
        optional(&ANGLE_DEG, "angle_deg", self.angle_deg)?;
        optional(&ANGLE_SD_DEG, "angle_sd_deg", self.angle_sd_deg)?;
        let wrong = |path: &str, problem: &str| Err(Refusal::Malformed { path: path.into(), problem: problem.into() });
        match self {
            Self { ratio: Some(_), distance_mm: Some(_), .. } => {
                wrong("distance_mm", "a contact has a ratio or a distance, not both")
            }
            Self { ratio: Some(_), tip: true, .. } => wrong("tip", "a contact at the tip has no ratio: it is 1"),
            Self { ratio: None, ratio_sd: Some(_), .. } => wrong("ratio_sd", "a contact without ratio has no ratio_sd"),
            Self { distance_mm: None, distance_sd_mm: Some(_), .. } => {
                wrong("distance_sd_mm", "a contact without distance_mm has no distance_sd_mm")
            }
            Self { angle_deg: None, angle_sd_deg: Some(_), .. } => {
                wrong("angle_sd_deg", "a contact without angle_deg has no angle_sd_deg")
            }
            _ => Ok(()),
        }
    }
}

impl Checked for Contact {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("t_us", self.t_us)?;
        self.check_place()?;
        DEFLECTION_MM.check("deflection_mm", self.deflection_mm)?;
        STRAIN.check("strain", self.strain)?;
        PRESSURE_MPA.check("pressure_mpa", self.pressure_mpa)?;
        TEMPERATURE_C.check("temperature_c", self.temperature_c)?;
        self.test_id.as_deref().map_or(Ok(()), |id| check::identifier("test_id", id))
    }
}

impl Checked for MissedTouch {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("t_us", self.t_us)?;
        DISTANCE_MM.check("distance_mm", self.distance_mm)?;
        self.distance_sd_mm.map_or(Ok(()), |sd_mm| DISTANCE_SD_MM.check("distance_sd_mm", sd_mm))?;
        self.test_id.as_deref().map_or(Ok(()), |id| check::identifier("test_id", id))
    }
}

impl Contacts {
    /// Checks everything but the entries.
    pub(crate) fn check_frame(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::count("contacts", self.contacts.len(), CONTACTS_MAX)?;
        check::count("missed", self.missed.len(), CONTACTS_MAX)
    }
}

impl Checked for Contacts {
    fn check(&self) -> Result<(), Refusal> {
        self.check_frame()?;
        check::each("contacts", &self.contacts, Contact::check)?;
        check::each("missed", &self.missed, MissedTouch::check)
    }
}
