use serde::{Deserialize, Serialize};

use super::Checked;
use crate::check::{CONTACTS_LEFT, LENGTH_MM, WEAR_MM};
use crate::{ARRAYS_MAX, BootId, Name, Refusal, Timestamp, WHISKERS_MAX, WhiskerCondition, check};

/// `maintenance`: facts for the maintenance of a robot's whiskers. For fleet controls and tools for maintenance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct Maintenance {
    /// Boot id of the supervisor.
    pub boot_id: BootId,
    /// Sequence number, from 0 in each boot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub seq: u64,
    /// Epoch of the supervisor; (`epoch`, `seq`) orders the messages about a robot.
    #[cfg_attr(feature = "documents", schemars(transform = crate::schema::exact_integer))]
    #[serde(deserialize_with = "crate::shape::whole")]
    pub epoch: u64,
    /// Time at which the message was written, by the supervisor's clock.
    pub timestamp: Timestamp,
    /// One entry for each whisker of the factsheet. If the message would become too long, the whiskers with the least
    /// wear are left out.
    #[cfg_attr(feature = "documents", schemars(length(max = ARRAYS_MAX * WHISKERS_MAX)))]
    #[serde(deserialize_with = "crate::shape::objects")]
    pub whiskers: Vec<WhiskerMaintenance>,
}

/// Facts for the maintenance of one whisker. A fact without evidence is null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "documents", derive(schemars::JsonSchema))]
pub struct WhiskerMaintenance {
    /// The whisker's array.
    pub array: Name,
    /// The whisker's number in its array.
    #[serde(deserialize_with = "crate::shape::whole")]
    pub whisker: u16,
    /// Mechanical condition of the whisker.
    pub condition: WhiskerCondition,
    /// Length of the whole whisker by the factsheet, in mm.
    #[cfg_attr(feature = "documents", schemars(transform = LENGTH_MM.in_schema()))]
    pub factory_length_mm: f64,
    /// Length that it has lost by cuts and erosion, in mm. Null before its contacts or a touch test tell its length.
    #[cfg_attr(feature = "documents", schemars(transform = WEAR_MM.in_schema()))]
    pub wear_mm: Option<f64>,
    /// Lower bound of the 95 % interval of `wear_mm`.
    #[cfg_attr(feature = "documents", schemars(transform = WEAR_MM.in_schema()))]
    pub wear_low_mm: Option<f64>,
    /// Upper bound of the 95 % interval of `wear_mm`.
    #[cfg_attr(feature = "documents", schemars(transform = WEAR_MM.in_schema()))]
    pub wear_high_mm: Option<f64>,
    /// End of the last touch test that was done, by the supervisor's clock: when the whisker was last compared with a
    /// known distance. Null before the first test, and after a replacement of the whisker.
    pub last_calibration: Option<Timestamp>,
    /// Contacts until the whisker is too short to compensate for itself, at its present wear per contact. Null unless it
    /// erodes, and until the rate is known.
    #[cfg_attr(feature = "documents", schemars(transform = CONTACTS_LEFT.in_schema()))]
    pub contacts_left: Option<f64>,
    /// Lower bound of the 95 % interval of `contacts_left`.
    #[cfg_attr(feature = "documents", schemars(transform = CONTACTS_LEFT.in_schema()))]
    pub contacts_left_low: Option<f64>,
    /// Upper bound of that interval; null, too, if the whisker may not erode at all.
    #[cfg_attr(feature = "documents", schemars(transform = CONTACTS_LEFT.in_schema()))]
    pub contacts_left_high: Option<f64>,
}

impl WhiskerMaintenance {
    fn check(&self) -> Result<(), Refusal> {
        LENGTH_MM.check("factory_length_mm", self.factory_length_mm)?;
        let numbers = [
            ("wear_mm", self.wear_mm, WEAR_MM),
            ("wear_low_mm", self.wear_low_mm, WEAR_MM),
            ("wear_high_mm", self.wear_high_mm, WEAR_MM),
            ("contacts_left", self.contacts_left, CONTACTS_LEFT),
            ("contacts_left_low", self.contacts_left_low, CONTACTS_LEFT),
            ("contacts_left_high", self.contacts_left_high, CONTACTS_LEFT),
        ];
        numbers.into_iter().try_for_each(|(path, value, range)| value.map_or(Ok(()), |value| range.check(path, value)))
    }
}

impl Checked for Maintenance {
    fn check(&self) -> Result<(), Refusal> {
        check::integer("seq", self.seq)?;
        check::integer("epoch", self.epoch)?;
        check::count("whiskers", self.whiskers.len(), ARRAYS_MAX * WHISKERS_MAX)?;
        check::each("whiskers", &self.whiskers, WhiskerMaintenance::check)
    }
}
