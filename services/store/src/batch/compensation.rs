//! Rows of compensations: decisions with their candidates, measured errors with their bins, and refinements.

use crate::row::{Interval, row};

row! {
    /// A decision with its candidates.
    pub struct DecisionRow {
        /// Number of the compensation: the robot's number in the upper 32 bits, a count in the lower.
        pub compensation_id: i64,
        /// Number of the robot in the database.
        pub robot_id: i64,
        /// Number of the trimmed whisker (the target) in the database.
        pub target_whisker_id: i64,
        /// Length of the target before the trim, mm.
        pub target_length_mm: f64,
        /// Nominal pressure of the target, MPa.
        pub target_pressure_mpa: f64,
        /// Time of the decision, µs since 1970 UTC by the supervisor's clock.
        pub decided_us: i64,
        /// `PROPOSED` if it waits for approval, else `AUTOMATIC`.
        pub approval: &'static str,
        /// All whiskers that were evaluated as compensators, in that order.
        pub candidates: Vec<CandidateRow> = [],
    }
    also {
        compensator_whisker_id: Option<i64> = |row| row.chosen().map(|one| one.whisker_id),
        compensation_case: Option<&'static str> = |row| row.chosen().map(|one| one.case),
        pressure_before_mpa: Option<f64> = |row| row.chosen().map(|one| one.pressure_before_mpa),
        pressure_mpa: Option<f64> = |row| row.chosen().and_then(|one| one.pressure_mpa),
        predicted_error: Option<f64> = |row| row.chosen().and_then(|one| one.predicted_error),
        predicted_error_low: Option<f64> =
            |row| row.chosen().and_then(|one| one.predicted_error_interval).map(|bounds| bounds.0),
        predicted_error_high: Option<f64> =
            |row| row.chosen().and_then(|one| one.predicted_error_interval).map(|bounds| bounds.1),
    }

    /// A whisker that a decision evaluated as compensator.
    pub struct CandidateRow {
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Case of the paper, such as `SELF_COMPENSATION`.
        pub case: &'static str = ["compensation_case"],
        /// Estimated length, mm.
        pub length_mm: f64,
        /// Standard deviation of the estimated length, mm.
        pub length_sd_mm: f64,
        /// Nominal pressure, MPa, whatever pressure the whisker holds for another compensation.
        pub pressure_before_mpa: f64,
        /// Pressure of the setpoint by Eq. 34, MPa; if Eq. 34 has no root within the range, the nearest limit of the
        /// range.
        pub pressure_mpa: Option<f64>,
        /// Predicted mean error (Eq. 35), as a ratio.
        pub predicted_error: Option<f64>,
        /// 95 % interval of `predicted_error`.
        pub predicted_error_interval: Option<(f64, f64)> = ["predicted_error_low", "predicted_error_high"],
        /// Predicted errors by contact ratio, as a JSON array.
        pub predicted_error_by_ratio: Option<String>,
        /// Whether the whisker would give up its own role as a sensor.
        pub gives_up_own_role: bool,
        /// Whether the whisker was chosen.
        pub chosen: bool,
        /// Reason why it was not chosen, such as `COSTS_MORE`.
        pub refused: Option<&'static str>,
    }

    /// A measured compensation error with its contact-ratio bins.
    pub struct ErrorRow {
        /// Number of the compensation.
        pub compensation_id: i64,
        /// Time of the measurement, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
        /// Number of contacts of the compensator in the measurement.
        pub contacts: i64,
        /// Pressure of the compensator during the measurement, MPa.
        pub pressure_mpa: f64,
        /// Mean of Eq. 35 over the bins, as a ratio.
        pub error: Interval = ["error", "error_low", "error_high"],
        /// Mean error with the gain in force applied, as a ratio.
        pub with_gain: Option<Interval> = ["error_with_gain", "error_with_gain_low", "error_with_gain_high"],
        /// Mean error of the air alone, without the reading gain, as a ratio; `None` where the robot applies no gain. Not
        /// among the bytes of the row, but behind those of its batch.
        pub air_error: Option<Interval> = ["air_error", "air_error_low", "air_error_high"],
        /// The error in each contact-ratio bin.
        pub bins: Vec<ErrorBinRow> = [],
    }
    also {
        bins: i64 = |row| row.bins.len() as i64,
    }

    /// One contact-ratio bin of a measured error.
    pub struct ErrorBinRow {
        /// Centre of the bin, as a contact ratio.
        pub ratio: f64,
        /// Number of contacts of the compensator in the bin.
        pub contacts: i64,
        /// Sensitivity of the compensator at its new pressure, strain per mm of deflection.
        pub after_per_mm: f64,
        /// Sensitivity of the compensator at its nominal pressure, strain per mm of deflection.
        pub before_per_mm: f64,
        /// Origin of `before_per_mm`: `MEASURED` or `MODEL`.
        pub before_origin: &'static str,
        /// Sensitivity of the target before the trim, strain per mm of deflection.
        pub target_per_mm: f64,
        /// Origin of `target_per_mm`: `MEASURED` or `MODEL`.
        pub target_origin: &'static str,
        /// Error by Eq. 35 in this bin, as a ratio.
        pub error: Interval = ["error", "error_low", "error_high"],
    }

    /// An evaluation of a setpoint; docs/schema.md documents the columns.
    pub struct RefinementRow {
        /// Number of the compensation.
        pub compensation_id: i64,
        /// Time of the evaluation, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
        /// Number of contacts of the compensator at the evaluated pressure.
        pub contacts: i64,
        /// Outcome: `REFINED`, or why the pressure stays, such as `HELD_MARGIN`.
        pub outcome: &'static str,
        /// Pressure that was evaluated, MPa.
        pub pressure_from_mpa: f64,
        /// Best pressure by the measured responses, MPa; `None` if the model has no solution.
        pub pressure_best_mpa: Option<f64>,
        /// Mean error (Eq. 35) at the evaluated pressure, from smoothed responses, as a ratio.
        pub error: Interval = ["error", "error_low", "error_high"],
        /// Mean error expected at the best pressure, as a ratio.
        pub error_best: Option<Interval> = ["error_best", "error_best_low", "error_best_high"],
        /// Mean error that remains with the published gain applied, as a ratio.
        pub error_with_gain: f64,
        /// Mean error that would remain with a gain computed from these contacts, as a ratio.
        pub error_with_own_gain: f64,
        /// Whether a new gain was published.
        pub gain_published: bool,
    }
}

impl DecisionRow {
    /// The candidate that was chosen as compensator.
    fn chosen(&self) -> Option<&CandidateRow> {
        self.candidates.iter().find(|one| one.chosen)
    }
}
