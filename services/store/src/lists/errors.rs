//! Measured errors of compensations, one by one and in groups.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::group::Group;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// A measured error of a compensation (Eq. 35), as it was stated.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorStatement {
        /// Number.
        #[schema(minimum = 0)]
        pub compensation_error_id: i64,
        /// The compensation.
        #[schema(minimum = 0)]
        pub compensation_id: i64,
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// The broken whisker.
        #[schema(minimum = 0)]
        pub target_whisker: i64,
        /// Who serves.
        #[schema(minimum = 0)]
        pub compensator_whisker: Option<i64>,
        /// Case of the paper.
        #[serde(rename = "case")]
        pub compensation_case: Option<String>,
        /// When it was stated.
        pub recorded_at: Time,
        /// Contacts in it.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// Contact-ratio bins in it.
        #[schema(minimum = 0)]
        pub bins: i64,
        /// The pressure that it is measured at.
        pub pressure_mpa: Option<f64>,
        /// Mean over the bins, as a ratio.
        pub error: f64,
        /// Lower bound of its 95 % interval.
        pub error_low: f64,
        /// Upper bound.
        pub error_high: f64,
        /// The same with the residual gain applied; null while contacts are too few.
        pub error_with_gain: Option<f64>,
        /// Lower bound of its 95 % interval.
        pub error_with_gain_low: Option<f64>,
        /// Upper bound.
        pub error_with_gain_high: Option<f64>,
    }

    /// Errors of a span of time: of each compensation the newest one in it.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByTime {
        /// Begin of the span.
        pub at: Time,
        /// Compensations in it.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Mean error, as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of their 95 % intervals: the bound of the mean if all err together.
        pub error_low: f64,
        /// Mean of the upper bounds.
        pub error_high: f64,
        /// Mean error with the residual gain applied, of those that state it.
        pub error_with_gain: Option<f64>,
    }

    /// Errors of a case of the paper: of each compensation the newest one.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByCase {
        /// Case of the paper.
        #[serde(rename = "case")]
        pub compensation_case: Option<String>,
        /// Compensations in it.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Mean error, as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of their 95 % intervals: the bound of the mean if all err together.
        pub error_low: f64,
        /// Mean of the upper bounds.
        pub error_high: f64,
        /// Mean error with the residual gain applied, of those that state it.
        pub error_with_gain: Option<f64>,
    }

    /// Errors of a contact ratio: of each compensation the newest one.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByRatio {
        /// Centre of the contact-ratio bin.
        pub ratio: f64,
        /// Compensations in it.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Contacts in it.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// Mean error, as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of their 95 % intervals: the bound of the mean if all err together.
        pub error_low: f64,
        /// Mean of the upper bounds.
        pub error_high: f64,
    }

    /// Errors of compensations for one whisker: of each the newest one.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByWhisker {
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// The broken whisker.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Compensations for it.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Mean error, as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of their 95 % intervals: the bound of the mean if all err together.
        pub error_low: f64,
        /// Mean of the upper bounds.
        pub error_high: f64,
        /// Mean error with the residual gain applied, of those that state it.
        pub error_with_gain: Option<f64>,
    }
}

sorts! {
    /// What a list of errors may be sorted by.
    pub enum ErrorSort {
        /// When they were stated.
        RecordedAt = "recorded_at" Whole Down,
        /// Mean error.
        Error = "error" Real Down,
    }
}

/// Measured errors.
pub static ERRORS: List = List {
    what: "list the errors",
    select: "SELECT e.compensation_error_id, e.compensation_id, fleet, robot, \"array\", t.whisker AS target_whisker, \
             k.whisker AS compensator_whisker, compensation_case, e.recorded_us AS recorded_at, e.contacts, e.bins, \
             e.pressure_mpa, e.error, e.error_low, e.error_high, e.error_with_gain, e.error_with_gain_low, \
             e.error_with_gain_high FROM compensation_errors e \
             JOIN compensations c ON c.compensation_id = e.compensation_id \
             JOIN robots r ON r.robot_id = c.robot_id JOIN whiskers t ON t.whisker_id = c.target_whisker_id \
             JOIN arrays y ON y.array_id = t.array_id LEFT JOIN whiskers k ON k.whisker_id = c.compensator_whisker_id",
    sorts: ErrorSort::SORTS,
    id: "compensation_error_id",
};

/// The means of a group.
macro_rules! means {
    () => {
        "count(*) AS compensations, avg(g.error) AS error, avg(g.error_low) AS error_low, \
         avg(g.error_high) AS error_high, avg(g.error_with_gain) AS error_with_gain"
    };
}

/// By spans of time, the newest first.
pub static BY_TIME: Group = Group {
    of: &ERRORS,
    columns: concat!("bucket * bucket_us AS at, ", means!()),
    from: "",
    by: "bucket, bucket_us",
    order: "bucket DESC",
};

/// By case of the paper.
pub static BY_CASE: Group = Group {
    of: &ERRORS,
    columns: concat!("compensation_case, ", means!()),
    from: "",
    by: "compensation_case",
    order: "compensation_case",
};

/// By contact ratio.
pub static BY_RATIO: Group = Group {
    of: &ERRORS,
    columns: "b.ratio, count(*) AS compensations, CAST(sum(b.contacts) AS BIGINT) AS contacts, avg(b.error) AS error, \
              avg(b.error_low) AS error_low, avg(b.error_high) AS error_high",
    from: " JOIN compensation_error_bins b ON b.compensation_error_id = g.compensation_error_id",
    by: "b.ratio",
    order: "b.ratio",
};

/// By the broken whisker, the greatest error first.
pub static BY_WHISKER: Group = Group {
    of: &ERRORS,
    columns: concat!("fleet, robot, \"array\", target_whisker AS whisker, ", means!()),
    from: "",
    by: "fleet, robot, \"array\", target_whisker",
    order: "error DESC, fleet, robot, \"array\", target_whisker",
};
