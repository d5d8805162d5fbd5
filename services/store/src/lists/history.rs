//! What whiskers felt in each minute and hour.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// What a whisker felt in a minute or an hour: of the contacts that were used or learned from unless it is said otherwise.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Rollup {
        /// Its begin, by the supervisor's clock.
        pub start_at: Time,
        /// Contacts that were used for estimation and detection.
        #[schema(minimum = 0)]
        pub contacts_used: i64,
        /// Contacts of the cold start, which were learned from.
        #[schema(minimum = 0)]
        pub contacts_learning: i64,
        /// Contacts that were not used.
        #[schema(minimum = 0)]
        pub contacts_unused: i64,
        /// Mean of ln(measured / predicted sensitivity); null without such contacts.
        pub residual_mean: Option<f64>,
        /// Its standard deviation over the contacts; null for fewer than two.
        pub residual_sd: Option<f64>,
        /// The least.
        pub residual_min: Option<f64>,
        /// The greatest.
        pub residual_max: Option<f64>,
        /// Mean of strain by deflection: compare it at equal contact ratios only.
        pub sensitivity_per_mm: Option<f64>,
        /// Mean contact ratio.
        pub ratio: Option<f64>,
        /// Estimated length after the last contact; null without any contact.
        pub length_mm: Option<f64>,
        /// Its standard deviation.
        pub length_sd_mm: Option<f64>,
        /// Mean estimated length, of all contacts.
        pub length_mean_mm: Option<f64>,
        /// Mean pressure, of all contacts.
        pub pressure_mpa: Option<f64>,
        /// Mean temperature, of all contacts.
        pub temperature_c: Option<f64>,
        /// The error (Eq. 35, a ratio) that was stated last of a compensation for this whisker; null if none was.
        pub compensation_error: Option<f64>,
    }
}

sorts! {
    /// What minutes and hours may be sorted by.
    pub enum RollupSort {
        /// Their begin.
        StartAt = "start_at" Whole Down,
    }
}

/// The query of either table. What PostgreSQL has in four bytes is read as eight.
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

/// Minutes. To be asked for one whisker: then no two have the same begin.
pub static MINUTES: List = List {
    what: "list a whisker's minutes",
    select: select!("contact_minutes"),
    sorts: RollupSort::SORTS,
    id: "whisker_id",
};

/// Hours, likewise.
pub static HOURS: List = List {
    what: "list a whisker's hours",
    select: select!("contact_hours"),
    sorts: RollupSort::SORTS,
    id: "whisker_id",
};
