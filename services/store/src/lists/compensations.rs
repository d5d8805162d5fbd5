//! Decisions and what came of them, with everyone who was asked, the looks at the setpoint, and the errors by ratio.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

readings! {
    /// A decision about a broken whisker, and what came of it.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct CompensationSummary {
        /// Number.
        #[schema(minimum = 0)]
        pub compensation_id: i64,
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// The broken whisker's array.
        pub array: String,
        /// The broken whisker.
        #[schema(minimum = 0)]
        pub target_whisker: i64,
        /// Its whole length.
        pub target_length_mm: f64,
        /// Its nominal pressure.
        pub target_pressure_mpa: f64,
        /// Who serves; null if no one can.
        #[schema(minimum = 0)]
        pub compensator_whisker: Option<i64>,
        /// Who has said that it begins: `AUTOMATIC` (nobody was asked), `PROPOSED` (it waits), `APPROVED` or `REFUSED`.
        pub approval: String,
        /// Case of the paper: `SELF_COMPENSATION`, `SHORTER_FOR_LONGER` or `LONGER_FOR_SHORTER`; null if no one can serve.
        #[serde(rename = "case")]
        pub compensation_case: Option<String>,
        /// The compensator's pressure before.
        pub pressure_before_mpa: Option<f64>,
        /// Setpoint as decided.
        pub pressure_mpa: Option<f64>,
        /// Predicted mean error (Eq. 35), as a ratio.
        pub predicted_error: Option<f64>,
        /// Lower bound of its 95 % interval.
        pub predicted_error_low: Option<f64>,
        /// Upper bound.
        pub predicted_error_high: Option<f64>,
        /// The pressure of its newest setpoint: as decided, or as refined since.
        pub held_pressure_mpa: Option<f64>,
        /// Who was asked.
        #[schema(minimum = 0)]
        pub candidate_count: i64,
        /// How often its setpoint was looked at.
        #[schema(minimum = 0)]
        pub look_count: i64,
        /// Why its pressure is what it is: what came of the newest look.
        pub last_look: Option<String>,
        /// Measured mean error (Eq. 35), newest, as a ratio; null before the first.
        pub measured_error: Option<f64>,
        /// Lower bound of its 95 % interval.
        pub measured_error_low: Option<f64>,
        /// Upper bound.
        pub measured_error_high: Option<f64>,
        /// The pressure at which it is measured.
        pub measured_pressure_mpa: Option<f64>,
        /// Measured mean error with the residual gain applied.
        pub measured_error_with_gain: Option<f64>,
        /// Lower bound of its 95 % interval.
        pub measured_error_with_gain_low: Option<f64>,
        /// Upper bound.
        pub measured_error_with_gain_high: Option<f64>,
        /// Contact-ratio bins in it.
        pub measured_bins: Option<i64>,
        /// Contacts in it.
        pub measured_contacts: Option<i64>,
        /// When it was measured.
        pub measured_at: Option<Time>,
        /// What became of its newest setpoint.
        pub setpoint_state: Option<String>,
        /// When it was decided.
        pub decided_at: Time,
        /// When it ended; null while it holds.
        pub ended_at: Option<Time>,
        /// Why it ended.
        pub end_reason: Option<String>,
    }

    /// Somebody who was asked to serve.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Candidate {
        /// Number in the array.
        #[schema(minimum = 0)]
        pub whisker: i64,
        /// Case of the paper.
        #[serde(rename = "case")]
        pub compensation_case: String,
        /// Estimated length.
        pub length_mm: f64,
        /// Its standard deviation.
        pub length_sd_mm: f64,
        /// Its nominal pressure.
        pub pressure_before_mpa: f64,
        /// Setpoint by Eq. 34, or the clamped one where there is none in range.
        pub pressure_mpa: Option<f64>,
        /// Predicted mean error (Eq. 35), as a ratio.
        pub predicted_error: Option<f64>,
        /// Lower bound of its 95 % interval.
        pub predicted_error_low: Option<f64>,
        /// Upper bound.
        pub predicted_error_high: Option<f64>,
        /// The same at the contact ratios 0.45, 0.50 .. 1.00.
        #[schema(value_type = Option<Vec<f64>>)]
        pub predicted_error_by_ratio: Option<Numbers>,
        /// Whether it would give up its own role.
        pub gives_up_own_role: bool,
        /// Whether it was chosen.
        pub chosen: bool,
        /// Why not; null if it was chosen.
        pub refused: Option<String>,
    }

    /// A look at a compensation's setpoint.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Look {
        /// When.
        pub recorded_at: Time,
        /// Contacts at the pressure.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// What came of it: `REFINED`, or why the pressure stays: `HELD_DITHER`, `HELD_MARGIN`, `HELD_UNCERTAIN`,
        /// `HELD_STEPS` or `HELD_UNPREDICTABLE`.
        pub outcome: String,
        /// The pressure that was held.
        pub pressure_from_mpa: f64,
        /// The best pressure by what was felt.
        pub pressure_best_mpa: Option<f64>,
        /// Mean error as felt, as a ratio.
        pub error: f64,
        /// Lower bound of its 95 % interval.
        pub error_low: f64,
        /// Upper bound.
        pub error_high: f64,
        /// Error to be expected at the best pressure, as a ratio.
        pub error_best: Option<f64>,
        /// Lower bound of its 95 % interval.
        pub error_best_low: Option<f64>,
        /// Upper bound.
        pub error_best_high: Option<f64>,
        /// What the published gain leaves, as a ratio.
        pub error_with_gain: f64,
        /// What a gain from these contacts would leave, as a ratio.
        pub error_with_own_gain: f64,
        /// Whether a new gain was published.
        pub gain_published: bool,
    }

    /// A measured error at one contact ratio.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct RatioError {
        /// Centre of the contact-ratio bin.
        pub ratio: f64,
        /// Contacts in it.
        #[schema(minimum = 0)]
        pub contacts: i64,
        /// Sensitivity of the compensator at its new pressure, strain per mm of deflection.
        pub after_per_mm: f64,
        /// The same at its nominal pressure.
        pub before_per_mm: f64,
        /// Where that comes from: `MEASURED` or `MODEL`.
        pub before_origin: String,
        /// Sensitivity of the target while it was whole.
        pub target_per_mm: f64,
        /// Where that comes from: `MEASURED` or `MODEL`.
        pub target_origin: String,
        /// Eq. 35 as a ratio.
        pub error: f64,
        /// Lower bound of its 95 % interval.
        pub error_low: f64,
        /// Upper bound.
        pub error_high: f64,
    }
}

/// Numbers that the database has as a JSON array.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Numbers(pub Vec<f64>);

impl TryFrom<String> for Numbers {
    type Error = serde_json::Error;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        serde_json::from_str(&text).map(Self)
    }
}

crate::readings::text_columns!(Numbers);

sorts! {
    /// What a list of compensations may be sorted by.
    pub enum CompensationSort {
        /// When they were decided.
        DecidedAt = "decided_at" Whole Down,
        /// Number.
        CompensationId = "compensation_id" Whole Up,
    }
}

/// Decisions.
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
             e.error_with_gain_high AS measured_error_with_gain_high, e.bins AS measured_bins, \
             e.contacts AS measured_contacts, e.recorded_us AS measured_at, \
             (SELECT state FROM setpoints s WHERE s.compensation_id = c.compensation_id \
              ORDER BY epoch DESC, version DESC LIMIT 1) AS setpoint_state, \
             decided_us AS decided_at, ended_us AS ended_at, end_reason \
             FROM compensations c JOIN robots USING (robot_id) JOIN whiskers t ON t.whisker_id = c.target_whisker_id \
             JOIN arrays ON arrays.array_id = t.array_id \
             LEFT JOIN whiskers k ON k.whisker_id = c.compensator_whisker_id \
             LEFT JOIN compensation_errors e ON e.compensation_error_id = (SELECT max(compensation_error_id) \
              FROM compensation_errors n WHERE n.compensation_id = c.compensation_id)",
    sorts: CompensationSort::SORTS,
    id: "compensation_id",
};

/// Everyone who was asked, in the order in which they were.
pub static CANDIDATES: List = List {
    what: "list the candidates",
    select: "SELECT compensation_id, ordinal, w.whisker, compensation_case, k.length_mm, k.length_sd_mm, \
             pressure_before_mpa, k.pressure_mpa, predicted_error, predicted_error_low, predicted_error_high, \
             predicted_error_by_ratio, gives_up_own_role, chosen, refused \
             FROM compensation_candidates k JOIN whiskers w USING (whisker_id)",
    sorts: &[by_order("ordinal")],
    id: "ordinal",
};

/// Looks at setpoints.
pub static LOOKS: List = List {
    what: "list the looks at a setpoint",
    select: "SELECT compensation_refinement_id, compensation_id, recorded_us AS recorded_at, contacts, outcome, \
             pressure_from_mpa, pressure_best_mpa, error, error_low, error_high, error_best, error_best_low, \
             error_best_high, error_with_gain, error_with_own_gain, gain_published FROM compensation_refinements",
    sorts: &[by_order("compensation_refinement_id")],
    id: "compensation_refinement_id",
};

/// The newest measured errors by contact ratio.
pub static RATIO_ERRORS: List = List {
    what: "list the errors by contact ratio",
    select: "SELECT e.compensation_id, row_number() OVER (PARTITION BY e.compensation_id ORDER BY ratio) AS ordinal, \
             b.ratio, b.contacts, after_per_mm, before_per_mm, before_origin, target_per_mm, target_origin, b.error, \
             b.error_low, b.error_high FROM compensation_error_bins b \
             JOIN compensation_errors e ON e.compensation_error_id = b.compensation_error_id \
             WHERE e.compensation_error_id IN (SELECT max(compensation_error_id) FROM compensation_errors \
              GROUP BY compensation_id)",
    sorts: &[by_order("ordinal")],
    id: "ordinal",
};

/// By a whole number, the least first.
const fn by_order(column: &'static str) -> crate::list::Sort {
    crate::list::Sort { column, kind: crate::list::Kind::Whole, descending: false }
}
