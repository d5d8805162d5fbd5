//! Measured errors of compensations, one by one and as means over groups.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::aggregates::Group;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

from_row! {
    /// A measured error of a compensation (Eq. 35), as recorded.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorStatement {
        /// Number of the measurement.
        #[schema(minimum = 0)]
        pub compensation_error_id: i64,
        /// Number of the compensation.
        #[schema(minimum = 0)]
        pub compensation_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the trimmed whisker (the target) in its array.
        #[schema(minimum = 0)]
        pub target_whisker: i64,
        /// Number of the compensator in the array.
        #[schema(minimum = 0)]
        pub compensator_whisker: Option<i64>,
        /// Case of the paper: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER` or `LONGER_FOR_SHORTER`.
        #[serde(rename = "case")]
        pub compensation_case: Option<String>,
        /// Time of the measurement, by the supervisor's clock.
        pub recorded_at: Time,
        /// Number of contacts of the compensator in the measurement.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// Number of contact-ratio bins in the measurement.
        #[schema(minimum = 0)]
        pub bins: i64,
        /// Pressure of the compensator during the measurement, MPa.
        pub pressure_mpa: Option<f64>,
        /// Mean of Eq. 35 over the contact-ratio bins, as a ratio.
        pub error: f64,
        /// Lower bound of the 95 % interval of `error`, as a ratio.
        pub error_low: f64,
        /// Upper bound of the 95 % interval of `error`, as a ratio.
        pub error_high: f64,
        /// Mean error with the residual gain applied, as a ratio; null while there are too few contacts.
        pub error_with_gain: Option<f64>,
        /// Lower bound of the 95 % interval of `error_with_gain`, as a ratio.
        pub error_with_gain_low: Option<f64>,
        /// Upper bound of the 95 % interval of `error_with_gain`, as a ratio.
        pub error_with_gain_high: Option<f64>,
        /// Mean error of the air alone, without the gain on the readings, as a ratio. Null where the robot applies none: then
        /// `error` is the error of the air alone.
        pub air_error: Option<f64>,
        /// Lower bound of the 95 % interval of `air_error`, as a ratio.
        pub air_error_low: Option<f64>,
        /// Upper bound of the 95 % interval of `air_error`, as a ratio.
        pub air_error_high: Option<f64>,
    }

    /// Mean errors in a span of time, over the newest measurement of each compensation in that span.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByTime {
        /// Start of the span, by the supervisor's clock.
        pub at: Time,
        /// Number of compensations that were measured in the span.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Mean error (Eq. 35), as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of the 95 % intervals, as a ratio: a bound of the mean if all errors are fully
        /// correlated.
        pub error_low: f64,
        /// Mean of the upper bounds of the 95 % intervals, as a ratio.
        pub error_high: f64,
        /// Mean error with the residual gain applied, over the compensations that have one, as a ratio.
        pub error_with_gain: Option<f64>,
        /// Mean error of the air alone, over the compensations whose robots apply a gain, as a ratio.
        pub air_error: Option<f64>,
    }

    /// Mean errors of one case of the paper, over the newest measurement of each compensation.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByCase {
        /// Case of the paper: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER` or `LONGER_FOR_SHORTER`.
        #[serde(rename = "case")]
        pub compensation_case: Option<String>,
        /// Number of compensations of this case.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Mean error (Eq. 35), as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of the 95 % intervals, as a ratio: a bound of the mean if all errors are fully
        /// correlated.
        pub error_low: f64,
        /// Mean of the upper bounds of the 95 % intervals, as a ratio.
        pub error_high: f64,
        /// Mean error with the residual gain applied, over the compensations that have one, as a ratio.
        pub error_with_gain: Option<f64>,
        /// Mean error of the air alone, over the compensations whose robots apply a gain, as a ratio.
        pub air_error: Option<f64>,
    }

    /// Mean errors in one contact-ratio bin, over the newest measurement of each compensation.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByRatio {
        /// Centre of the contact-ratio bin.
        pub ratio: f64,
        /// Number of compensations with contacts in the bin.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Number of contacts in the bin, over all these compensations.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// Mean error (Eq. 35), as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of the 95 % intervals, as a ratio: a bound of the mean if all errors are fully
        /// correlated.
        pub error_low: f64,
        /// Mean of the upper bounds of the 95 % intervals, as a ratio.
        pub error_high: f64,
    }

    /// Mean errors of the compensations for one whisker, over the newest measurement of each compensation.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct ErrorByWhisker {
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the trimmed whisker (the target) in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Number of compensations for this whisker.
        #[schema(minimum = 0)]
        pub compensations: i64,
        /// Mean error (Eq. 35), as a ratio.
        pub error: f64,
        /// Mean of the lower bounds of the 95 % intervals, as a ratio: a bound of the mean if all errors are fully
        /// correlated.
        pub error_low: f64,
        /// Mean of the upper bounds of the 95 % intervals, as a ratio.
        pub error_high: f64,
        /// Mean error with the residual gain applied, over the compensations that have one, as a ratio.
        pub error_with_gain: Option<f64>,
        /// Mean error of the air alone, over the compensations whose robots apply a gain, as a ratio.
        pub air_error: Option<f64>,
    }
}

sorts! {
    /// Sort keys of the list of measured errors.
    pub enum ErrorSort {
        /// By time of the measurement.
        RecordedAt = "recorded_at" Whole Down,
        /// By mean error.
        Error = "error" Real Down,
    }
}

/// All measured errors.
pub static ERRORS: List = List {
    what: "list the errors",
    select: "SELECT e.compensation_error_id, e.compensation_id, fleet, robot, \"array\", t.whisker AS target_whisker, \
             k.whisker AS compensator_whisker, compensation_case, e.recorded_us AS recorded_at, e.contacts, e.bins, \
             e.pressure_mpa, e.error, e.error_low, e.error_high, e.error_with_gain, e.error_with_gain_low, \
             e.error_with_gain_high, e.air_error, e.air_error_low, e.air_error_high FROM compensation_errors e \
             JOIN compensations c ON c.compensation_id = e.compensation_id \
             JOIN robots r ON r.robot_id = c.robot_id JOIN whiskers t ON t.whisker_id = c.target_whisker_id \
             JOIN arrays y ON y.array_id = t.array_id LEFT JOIN whiskers k ON k.whisker_id = c.compensator_whisker_id",
    details: "",
    keys: &[],
    sorts: ErrorSort::SORTS,
    id: "compensation_error_id",
};

/// Columns with the number and the means of a group.
macro_rules! means {
    () => {
        "count(*) AS compensations, avg(g.error) AS error, avg(g.error_low) AS error_low, \
         avg(g.error_high) AS error_high, avg(g.error_with_gain) AS error_with_gain, avg(g.air_error) AS air_error"
    };
}

/// Groups by span of time, the newest first.
pub static BY_TIME: Group = Group {
    of: &ERRORS,
    columns: concat!("bucket * bucket_us AS at, ", means!()),
    from: "",
    by: "bucket, bucket_us",
    order: "bucket DESC",
};

/// Groups by case of the paper.
pub static BY_CASE: Group = Group {
    of: &ERRORS,
    columns: concat!("compensation_case, ", means!()),
    from: "",
    by: "compensation_case",
    order: "compensation_case",
};

/// Groups by contact ratio.
pub static BY_RATIO: Group = Group {
    of: &ERRORS,
    columns: "b.ratio, count(*) AS compensations, CAST(sum(b.contacts) AS BIGINT) AS contacts, avg(b.error) AS error, \
              avg(b.error_low) AS error_low, avg(b.error_high) AS error_high",
    from: " JOIN compensation_error_bins b ON b.compensation_error_id = g.compensation_error_id",
    by: "b.ratio",
    order: "b.ratio",
};

/// Groups by trimmed whisker, the greatest error first.
pub static BY_WHISKER: Group = Group {
    of: &ERRORS,
    columns: concat!("fleet, robot, \"array\", target_whisker AS whisker, ", means!()),
    from: "",
    by: "fleet, robot, \"array\", target_whisker",
    order: "error DESC, fleet, robot, \"array\", target_whisker",
};
