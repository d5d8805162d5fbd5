use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{DEFLECTION_MM, PRESSURE_MPA, RATIO, STRAIN, TEMPERATURE_C};
use crate::{BootId, CONTACTS_MAX, Name, Refusal, check};

/// `contacts`: a batch of contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Contacts {
    /// Boot id of the robot.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    pub seq: u64,
    /// The contacts in the order of their measurement.
    #[cfg_attr(feature = "documents", schemars(length(max = CONTACTS_MAX)))]
    pub contacts: Vec<Contact>,
}

/// Measurements of one contact of one whisker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Contact {
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    pub whisker: u16,
    /// Time of the contact, in microseconds since 1970 UTC by the robot's clock.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    pub t_us: u64,
    /// The paper's contact ratio a: contact distance / present length, both without the chamber's
    /// elongation; from 0.01 to 1.
    #[cfg_attr(feature = "documents", schemars(transform = RATIO.in_schema()))]
    pub ratio: f64,
    /// Deflection of the whisker at the contact, in mm; at least 0.01.
    #[cfg_attr(feature = "documents", schemars(transform = DEFLECTION_MM.in_schema()))]
    pub deflection_mm: f64,
    /// Mean strain over the gauge grid, in m/m; between -1 and 1. It is 0 or has a magnitude of at least 1e-9.
    #[cfg_attr(feature = "documents", schemars(transform = STRAIN.in_schema()))]
    pub strain: f64,
    /// The chamber's measured gauge pressure in MPa.
    #[cfg_attr(feature = "documents", schemars(transform = PRESSURE_MPA.in_schema()))]
    pub pressure_mpa: f64,
    /// The whisker's temperature in degrees Celsius.
    #[cfg_attr(feature = "documents", schemars(transform = TEMPERATURE_C.in_schema()))]
    pub temperature_c: f64,
}

impl Contact {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("t_us", self.t_us)?;
        RATIO.check("ratio", self.ratio)?;
        DEFLECTION_MM.check("deflection_mm", self.deflection_mm)?;
        STRAIN.check("strain", self.strain)?;
        PRESSURE_MPA.check("pressure_mpa", self.pressure_mpa)?;
        TEMPERATURE_C.check("temperature_c", self.temperature_c)
    }
}

impl Checked for Contacts {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::count("contacts", self.contacts.len(), CONTACTS_MAX)?;
        check::each("contacts", &self.contacts, Contact::check)
    }
}
