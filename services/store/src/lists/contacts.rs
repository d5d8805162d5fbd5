//! Each contact of a whisker, page by page.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A contact of a whisker, and its estimated length after it.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Contact {
        /// Time of the contact, by the robot's clock.
        pub at: Time,
        /// Time of its arrival, by the supervisor's clock.
        pub received_at: Time,
        /// Contact ratio: position of the contact along the whisker, 0 at the base, 1 at the tip. It is the robot's, or
        /// its distance divided by the estimated length; null if the robot knew no place.
        pub ratio: Option<f64>,
        /// Distance from the base measured by the robot, mm; null if it measured none.
        pub distance_mm: Option<f64>,
        /// Deflection at the contact, mm.
        pub deflection_mm: f64,
        /// Axial strain of the gauge, m/m.
        pub strain: f64,
        /// Measured pressure, MPa.
        pub pressure_mpa: f64,
        /// Temperature at the gauge, °C; null if none was stored.
        pub temperature_c: Option<f64>,
        /// ln(measured / predicted sensitivity); null if the contact was not used for estimation.
        pub residual: Option<f64>,
        /// Estimated length after the contact, mm.
        pub length_mm: f64,
        /// Standard deviation of the estimated length, mm.
        pub length_sd_mm: f64,
    }
}

sorts! {
    /// Sort keys of contacts.
    pub enum ContactSort {
        /// By time of the contact.
        At = "at" Whole Down,
    }
}

/// The contacts. Filter by one whisker, with the columns of the table. Two contacts of one moment differ in their index in the
/// message, which is below 1000, in the number of the message, or in the boot. `number` has all three, each within a bound.
pub static CONTACTS: List = List {
    what: "list a whisker's contacts",
    select: "SELECT t_us AS at, received_us AS received_at, \
             boot % 1000 * 9000000000000000 + seq % 9000000000000 * 1000 + position AS number, ratio, distance_mm, \
             deflection_mm, strain, pressure_mpa, temperature_c, residual, length_mm, length_sd_mm \
             FROM contacts WHERE true{filters}",
    details: "",
    keys: &[],
    sorts: ContactSort::SORTS,
    id: "number",
};
