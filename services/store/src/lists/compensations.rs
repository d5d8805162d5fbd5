//! Compensations: the decisions with their candidates, the refinements of their setpoints, and their measured errors
//! by contact ratio.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::from_row::from_row;
use crate::list::{Keys, List};
use crate::time::Time;

from_row! {
    /// A decision about a trimmed whisker, and the compensation that followed from it.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct CompensationSummary {
        /// Number of the compensation.
        #[schema(minimum = 0)]
        pub compensation_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array of the trimmed whisker (the target).
        pub array: String,
        /// Number of the target in its array.
        #[schema(minimum = 0)]
        pub target_whisker: i64,
        /// Length of the target before the trim, mm.
        pub target_length_mm: f64,
        /// Nominal pressure of the target, MPa.
        pub target_pressure_mpa: f64,
        /// Number of the compensator in the array; null if no whisker can compensate.
        #[schema(minimum = 0)]
        pub compensator_whisker: Option<i64>,
        /// Approval: `AUTOMATIC` (not needed), `PROPOSED` (waits for an operator), `APPROVED` or `REFUSED`.
        pub approval: String,
        /// Case of the paper: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER` or `LONGER_FOR_SHORTER`; null if no whisker
        /// can compensate.
        #[serde(rename = "case")]
        pub compensation_case: Option<String>,
        /// Nominal pressure of the compensator, MPa; null if no whisker can compensate.
        pub pressure_before_mpa: Option<f64>,
        /// Pressure of the setpoint as first decided, MPa; null if no whisker can compensate.
        pub pressure_mpa: Option<f64>,
        /// Predicted mean error (Eq. 35), as a ratio.
        pub predicted_error: Option<f64>,
        /// Lower bound of the 95 % interval of `predicted_error`, as a ratio.
        pub predicted_error_low: Option<f64>,
        /// Upper bound of the 95 % interval of `predicted_error`, as a ratio.
        pub predicted_error_high: Option<f64>,
        /// Pressure of the newest setpoint, as decided or as refined since, MPa.
        pub held_pressure_mpa: Option<f64>,
        /// Number of whiskers that were evaluated as compensators.
        #[schema(minimum = 0)]
        pub candidate_count: i64,
        /// Number of times that the setpoint was evaluated for a refinement.
        #[schema(minimum = 0)]
        pub look_count: i64,
        /// Outcome of the newest evaluation of the setpoint: `REFINED`, or why the pressure was left as it is.
        pub last_look: Option<String>,
        /// Newest measured mean error (Eq. 35), as a ratio; null before the first measurement.
        pub measured_error: Option<f64>,
        /// Lower bound of the 95 % interval of `measured_error`, as a ratio.
        pub measured_error_low: Option<f64>,
        /// Upper bound of the 95 % interval of `measured_error`, as a ratio.
        pub measured_error_high: Option<f64>,
        /// Pressure of the compensator during the measurement, MPa.
        pub measured_pressure_mpa: Option<f64>,
        /// Newest measured mean error with the residual gain applied, as a ratio; null while there are too few
        /// contacts.
        pub measured_error_with_gain: Option<f64>,
        /// Lower bound of the 95 % interval of `measured_error_with_gain`, as a ratio.
        pub measured_error_with_gain_low: Option<f64>,
        /// Upper bound of the 95 % interval of `measured_error_with_gain`, as a ratio.
        pub measured_error_with_gain_high: Option<f64>,
        /// Newest measured mean error of the air alone, without the gain on the readings, as a ratio. Null where the robot
        /// applies none: then `measured_error` is the error of the air alone.
        pub measured_air_error: Option<f64>,
        /// Lower bound of the 95 % interval of `measured_air_error`, as a ratio.
        pub measured_air_error_low: Option<f64>,
        /// Upper bound of the 95 % interval of `measured_air_error`, as a ratio.
        pub measured_air_error_high: Option<f64>,
        /// Number of contact-ratio bins in the newest measurement.
        pub measured_bins: Option<i64>,
        /// Number of contacts in the newest measurement.
        pub measured_contacts: Option<i64>,
        /// Time of the newest measurement, by the supervisor's clock.
        pub measured_at: Option<Time>,
        /// State of the newest setpoint, such as `APPLIED`.
        pub setpoint_state: Option<String>,
        /// Reason that the robot gave for rejecting it; `IN_TASK` says that it waits for the end of the robot's task. Null
        /// unless it was rejected.
        pub setpoint_error: Option<String>,
        /// Time of the decision, by the supervisor's clock.
        pub decided_at: Time,
        /// Time at which the compensation ended, by the supervisor's clock; null while it is in force or proposed.
        pub ended_at: Option<Time>,
        /// Reason for the end, such as `TARGET_TRIMMED_AGAIN` or `REPLACED`; null while it has not ended.
        pub end_reason: Option<String>,
    }

    /// A whisker that a decision evaluated as compensator.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Candidate {
        /// Number of the whisker in its array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Case of the paper: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER` or `LONGER_FOR_SHORTER`.
        #[serde(rename = "case")]
        pub compensation_case: String,
        /// Estimated length, mm.
        pub length_mm: f64,
        /// Standard deviation of the estimated length, mm.
        pub length_sd_mm: f64,
        /// Nominal pressure of the whisker, MPa, whatever pressure it holds for another compensation.
        pub pressure_before_mpa: f64,
        /// Pressure of the setpoint by Eq. 34, MPa; if Eq. 34 has no root within the range, the nearest limit of the
        /// range.
        pub pressure_mpa: Option<f64>,
        /// Predicted mean error (Eq. 35), as a ratio.
        pub predicted_error: Option<f64>,
        /// Lower bound of the 95 % interval of `predicted_error`, as a ratio.
        pub predicted_error_low: Option<f64>,
        /// Upper bound of the 95 % interval of `predicted_error`, as a ratio.
        pub predicted_error_high: Option<f64>,
        /// Predicted errors at the contact ratios 0.45, 0.50 .. 1.00, as ratios.
        #[schema(value_type = Option<Vec<f64>>)]
        pub predicted_error_by_ratio: Option<Numbers>,
        /// Whether the whisker would give up its own role as a sensor.
        pub gives_up_own_role: bool,
        /// Whether the whisker was chosen.
        pub chosen: bool,
        /// Reason why it was not chosen, such as `COSTS_MORE` or `ERROR_ABOVE_LIMIT`; null if it was chosen.
        pub refused: Option<String>,
    }

    /// An evaluation of a compensation's setpoint, which may refine the setpoint.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Look {
        /// Time of the evaluation, by the supervisor's clock.
        pub recorded_at: Time,
        /// Number of contacts of the compensator at the evaluated pressure.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// Outcome: `REFINED`, or why the pressure stays: `HELD_DITHER` (the best pressure is nearer than a
        /// regulator's dither), `HELD_MARGIN` (hardly better), `HELD_UNCERTAIN` (too few contacts to tell),
        /// `HELD_STEPS` (no steps are left) or `HELD_UNPREDICTABLE` (the model has no solution).
        pub outcome: String,
        /// Pressure that was evaluated, MPa.
        pub pressure_from_mpa: f64,
        /// Best pressure by the measured responses, MPa; null if the model has no solution.
        pub pressure_best_mpa: Option<f64>,
        /// Mean error (Eq. 35) at the evaluated pressure, from smoothed responses, as a ratio.
        pub error: f64,
        /// Lower bound of the 95 % interval of `error`, as a ratio.
        pub error_low: f64,
        /// Upper bound of the 95 % interval of `error`, as a ratio.
        pub error_high: f64,
        /// Mean error expected at the best pressure, as a ratio; null if the model has no solution.
        pub error_best: Option<f64>,
        /// Lower bound of the 95 % interval of `error_best`, as a ratio.
        pub error_best_low: Option<f64>,
        /// Upper bound of the 95 % interval of `error_best`, as a ratio.
        pub error_best_high: Option<f64>,
        /// Mean error that remains with the published gain applied, as a ratio.
        pub error_with_gain: f64,
        /// Mean error that would remain with a gain computed from these contacts, as a ratio.
        pub error_with_own_gain: f64,
        /// Whether a new gain was published.
        pub gain_published: bool,
    }

    /// The newest measured error of a compensation in one contact-ratio bin.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct RatioError {
        /// Centre of the contact-ratio bin.
        pub ratio: f64,
        /// Number of contacts of the compensator in the bin.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// Sensitivity of the compensator at its new pressure, strain per mm of deflection.
        pub after_per_mm: f64,
        /// Sensitivity of the compensator at its nominal pressure, strain per mm of deflection.
        pub before_per_mm: f64,
        /// Origin of `before_per_mm`: `MEASURED` or `MODEL`.
        pub before_origin: String,
        /// Sensitivity of the target before the trim, strain per mm of deflection.
        pub target_per_mm: f64,
        /// Origin of `target_per_mm`: `MEASURED` or `MODEL`.
        pub target_origin: String,
        /// Error by Eq. 35 in this bin, as a ratio.
        pub error: f64,
        /// Lower bound of the 95 % interval of `error`, as a ratio.
        pub error_low: f64,
        /// Upper bound of the 95 % interval of `error`, as a ratio.
        pub error_high: f64,
    }
}

/// A list of numbers that the database stores as a JSON array.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Numbers(pub Vec<f64>);

impl TryFrom<String> for Numbers {
    type Error = serde_json::Error;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        serde_json::from_str(&text).map(Self)
    }
}

crate::from_row::text_columns!(Numbers);

sorts! {
    /// Sort keys of the list of compensations.
    pub enum CompensationSort {
        /// By time of the decision.
        DecidedAt = "decided_at" Whole Down,
        /// By name of the robot.
        Robot = "robot" Text Up,
        /// By number of the compensation.
        CompensationId = "compensation_id" Whole Up,
    }
}

/// All decisions, each with the newest state of its compensation.
pub static COMPENSATIONS: List = List {
    what: "list the compensations",
    select: "SELECT c.compensation_id, fleet, robot, \"array\", t.whisker AS target_whisker, target_length_mm, \
             target_pressure_mpa, k.whisker AS compensator_whisker, approval, compensation_case, pressure_before_mpa, \
             c.pressure_mpa, predicted_error, predicted_error_low, predicted_error_high, \
             (SELECT s.pressure_mpa FROM setpoints s WHERE s.compensation_id = c.compensation_id \
              ORDER BY epoch DESC, version DESC LIMIT 1) AS held_pressure_mpa, \
             (SELECT count(*) FROM compensation_candidates a WHERE a.compensation_id = c.compensation_id) \
              AS candidate_count, \
             (SELECT count(*) FROM compensation_refinements l WHERE l.compensation_id = c.compensation_id) \
              AS look_count, \
             (SELECT outcome FROM compensation_refinements l WHERE l.compensation_id = c.compensation_id \
              ORDER BY compensation_refinement_id DESC LIMIT 1) AS last_look, \
             e.error AS measured_error, e.error_low AS measured_error_low, e.error_high AS measured_error_high, \
             e.pressure_mpa AS measured_pressure_mpa, e.error_with_gain AS measured_error_with_gain, \
             e.error_with_gain_low AS measured_error_with_gain_low, \
             e.error_with_gain_high AS measured_error_with_gain_high, e.air_error AS measured_air_error, \
             e.air_error_low AS measured_air_error_low, e.air_error_high AS measured_air_error_high, \
             e.bins AS measured_bins, \
             e.contacts AS measured_contacts, e.recorded_us AS measured_at, \
             (SELECT state FROM setpoints s WHERE s.compensation_id = c.compensation_id \
              ORDER BY epoch DESC, version DESC LIMIT 1) AS setpoint_state, \
             (SELECT s.error FROM setpoints s WHERE s.compensation_id = c.compensation_id \
              ORDER BY epoch DESC, version DESC LIMIT 1) AS setpoint_error, \
             decided_us AS decided_at, ended_us AS ended_at, end_reason \
             FROM compensations c JOIN robots USING (robot_id) JOIN whiskers t ON t.whisker_id = c.target_whisker_id \
             JOIN arrays ON arrays.array_id = t.array_id \
             LEFT JOIN whiskers k ON k.whisker_id = c.compensator_whisker_id \
             LEFT JOIN compensation_errors e ON e.compensation_error_id = (SELECT max(compensation_error_id) \
              FROM compensation_errors n WHERE n.compensation_id = c.compensation_id)",
    details: "",
    keys: &[Keys {
        select: "SELECT compensation_id, fleet, robot, decided_us AS decided_at, ended_us AS ended_at, approval \
                 FROM compensations JOIN robots USING (robot_id)",
        columns: &["compensation_id", "fleet", "robot", "decided_at", "ended_at", "approval"],
    }],
    sorts: CompensationSort::SORTS,
    id: "compensation_id",
};

/// The candidates of decisions, in the order in which they were evaluated.
pub static CANDIDATES: List = List {
    what: "list the candidates",
    select: "SELECT compensation_id, ordinal, w.whisker, compensation_case, k.length_mm, k.length_sd_mm, \
             pressure_before_mpa, k.pressure_mpa, predicted_error, predicted_error_low, predicted_error_high, \
             predicted_error_by_ratio, gives_up_own_role, chosen, refused \
             FROM compensation_candidates k JOIN whiskers w USING (whisker_id)",
    details: "",
    keys: &[],
    sorts: &[by_order("ordinal")],
    id: "ordinal",
};

/// The evaluations of setpoints.
pub static LOOKS: List = List {
    what: "list the evaluations of a setpoint",
    select: "SELECT compensation_refinement_id, compensation_id, recorded_us AS recorded_at, contacts, outcome, \
             pressure_from_mpa, pressure_best_mpa, error, error_low, error_high, error_best, error_best_low, \
             error_best_high, error_with_gain, error_with_own_gain, gain_published FROM compensation_refinements",
    details: "",
    keys: &[],
    sorts: &[by_order("compensation_refinement_id")],
    id: "compensation_refinement_id",
};

/// The newest measured errors of each compensation, by contact ratio.
pub static RATIO_ERRORS: List = List {
    what: "list the errors by contact ratio",
    select: "SELECT e.compensation_id, row_number() OVER (PARTITION BY e.compensation_id ORDER BY ratio) AS ordinal, \
             b.ratio, b.contacts, after_per_mm, before_per_mm, before_origin, target_per_mm, target_origin, b.error, \
             b.error_low, b.error_high FROM compensation_error_bins b \
             JOIN compensation_errors e ON e.compensation_error_id = b.compensation_error_id \
             WHERE e.compensation_error_id IN (SELECT max(compensation_error_id) FROM compensation_errors \
              GROUP BY compensation_id)",
    details: "",
    keys: &[],
    sorts: &[by_order("ordinal")],
    id: "ordinal",
};

/// Sorts by a column of whole numbers, the lowest first.
const fn by_order(column: &'static str) -> crate::list::Sort {
    crate::list::Sort { column, kind: crate::list::ColumnKind::Whole, descending: false }
}
