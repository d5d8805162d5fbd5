//! Aggregates of each whisker's contacts by minute and by hour.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// Aggregates of a whisker's contacts in a minute or an hour. Means are over the contacts that were used or
    /// learned from, unless the field says otherwise.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Rollup {
        /// Start of the minute or hour, by the supervisor's clock.
        pub start_at: Time,
        /// Number of contacts that were used for estimation and detection.
        #[schema(minimum = 0)]
        pub contacts_used: i64,
        /// Number of contacts of the cold start, which were used for estimation only.
        #[schema(minimum = 0)]
        pub contacts_learning: i64,
        /// Number of contacts that were not used.
        #[schema(minimum = 0)]
        pub contacts_unused: i64,
        /// Mean of ln(measured / predicted sensitivity); null if no contact was used or learned from.
        pub residual_mean: Option<f64>,
        /// Standard deviation of ln(measured / predicted sensitivity) over the contacts; null for fewer than two
        /// contacts.
        pub residual_sd: Option<f64>,
        /// Least ln(measured / predicted sensitivity).
        pub residual_min: Option<f64>,
        /// Greatest ln(measured / predicted sensitivity).
        pub residual_max: Option<f64>,
        /// Mean sensitivity, strain per mm of deflection. It depends on the contact ratio: compare it at equal
        /// `ratio` only.
        pub sensitivity_per_mm: Option<f64>,
        /// Mean contact ratio: position along the whisker, 0 at the base, 1 at the tip.
        pub ratio: Option<f64>,
        /// Estimated length after the last contact, mm; null if there was no contact.
        pub length_mm: Option<f64>,
        /// Standard deviation of the estimated length after the last contact, mm.
        pub length_sd_mm: Option<f64>,
        /// Mean estimated length over all contacts, mm.
        pub length_mean_mm: Option<f64>,
        /// Mean pressure over all contacts, MPa.
        pub pressure_mpa: Option<f64>,
        /// Mean temperature over all contacts, °C.
        pub temperature_c: Option<f64>,
        /// Last error (Eq. 35) of a compensation for this whisker that was measured in this span, as a ratio; null if
        /// there was none.
        pub compensation_error: Option<f64>,
    }
}

sorts! {
    /// Sort keys of minutes and hours.
    pub enum RollupSort {
        /// By start of the span.
        StartAt = "start_at" Whole Down,
    }
}

/// The query of one of the two tables. PostgreSQL stores its numbers in four bytes; the casts make them eight.
macro_rules! select {
    ($table:literal) => {
        concat!(
            "SELECT whisker_id, start_us AS start_at, CAST(contacts_used AS BIGINT) AS contacts_used, \
             CAST(contacts_learning AS BIGINT) AS contacts_learning, CAST(contacts_unused AS BIGINT) AS contacts_unused, \
             CAST(residual_mean AS DOUBLE PRECISION) AS residual_mean, \
             CAST(residual_sd AS DOUBLE PRECISION) AS residual_sd, \
             CAST(residual_min AS DOUBLE PRECISION) AS residual_min, \
             CAST(residual_max AS DOUBLE PRECISION) AS residual_max, \
             CAST(sensitivity_per_mm AS DOUBLE PRECISION) AS sensitivity_per_mm, \
             CAST(ratio AS DOUBLE PRECISION) AS ratio, CAST(length_mm AS DOUBLE PRECISION) AS length_mm, \
             CAST(length_sd_mm AS DOUBLE PRECISION) AS length_sd_mm, \
             CAST(length_mean_mm AS DOUBLE PRECISION) AS length_mean_mm, \
             CAST(pressure_mpa AS DOUBLE PRECISION) AS pressure_mpa, \
             CAST(temperature_c AS DOUBLE PRECISION) AS temperature_c, \
             CAST(compensation_error AS DOUBLE PRECISION) AS compensation_error FROM ",
            $table
        )
    };
}

/// The minutes. Filter by one whisker: `whisker_id` is not unique, but no two minutes of a whisker have the same start.
pub static MINUTES: List = List {
    what: "list a whisker's minutes",
    select: select!("contact_minutes"),
    details: "",
    keys: &[],
    sorts: RollupSort::SORTS,
    id: "whisker_id",
};

/// The hours; filter by one whisker, as for [`MINUTES`].
pub static HOURS: List = List {
    what: "list a whisker's hours",
    select: select!("contact_hours"),
    details: "",
    keys: &[],
    sorts: RollupSort::SORTS,
    id: "whisker_id",
};
