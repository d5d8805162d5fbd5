use serde::{Deserialize, Serialize};

use super::Checked;
use crate::{BootId, CONTACTS_MAX, Name, Refusal, check};

/// `contacts`: a batch of contacts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    /// The robot's boot.
    pub boot_id: BootId,
    /// From 0 in each boot.
    pub seq: u64,
    /// At most [`CONTACTS_MAX`].
    pub contacts: Vec<Contact>,
}

/// What one touch of one whisker read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    pub whisker: u16,
    /// When, in microseconds since 1970 UTC by the robot's clock.
    pub t_us: u64,
    /// The paper's contact ratio a: contact distance / present length, both without the chamber's
    /// elongation; above 0, at most 1.
    pub ratio: f64,
    /// How far the contact bent the whisker, in mm; above 0.
    pub deflection_mm: f64,
    /// Mean strain over the gauge grid, in m/m; between -1 and 1.
    pub strain: f64,
    /// The chamber's measured gauge pressure in MPa.
    pub pressure_mpa: f64,
    /// The whisker's temperature in degrees Celsius.
    pub temperature_c: f64,
}

impl Contact {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("t_us", self.t_us)?;
        check::ratio("ratio", self.ratio)?;
        check::positive_mm("deflection_mm", self.deflection_mm)?;
        check::strain("strain", self.strain)?;
        check::pressure_mpa("pressure_mpa", self.pressure_mpa)?;
        check::temperature_c("temperature_c", self.temperature_c)
    }
}

impl Checked for Contacts {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::count("contacts", self.contacts.len(), CONTACTS_MAX)?;
        check::each("contacts", &self.contacts, Contact::check)
    }
}
