//! What queries read, as JSON in the contract's words: a struct for each, its fields the query's columns.

use serde::Serialize;

/// Defines what a query reads: a struct whose fields are the query's columns, by name.
macro_rules! readings {
    ($($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $type:ty,)+ })+) => {
        $($(#[$meta])* pub struct $name { $($(#[$field_meta])* pub $field: $type,)+ }

        impl<'r> sqlx::FromRow<'r, sqlx::sqlite::SqliteRow> for $name {
            fn from_row(row: &'r sqlx::sqlite::SqliteRow) -> sqlx::Result<Self> {
                Ok(Self { $($field: sqlx::Row::try_get(row, stringify!($field))?,)+ })
            }
        }

        impl<'r> sqlx::FromRow<'r, sqlx::postgres::PgRow> for $name {
            fn from_row(row: &'r sqlx::postgres::PgRow) -> sqlx::Result<Self> {
                Ok(Self { $($field: sqlx::Row::try_get(row, stringify!($field))?,)+ })
            }
        })+
    };
}
pub(super) use readings;

readings! {
    /// A whisker with its estimate; `GET /v1/whiskers`.
    #[derive(Debug, Clone, Serialize)]
    pub struct WhiskerReading {
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// `TYPE_1` or `TYPE_2`.
        pub array_type: String,
        /// Number in the array.
        pub whisker: i64,
        /// Length of the factsheet.
        pub whole_length_mm: f64,
        /// Estimated length.
        pub length_mm: f64,
        /// Its standard deviation.
        pub length_sd_mm: f64,
        /// Mechanical condition.
        pub condition: String,
        /// Fault, if any.
        pub fault: Option<String>,
        /// Measured pressure.
        pub pressure_mpa: Option<f64>,
        /// Pressure that the robot holds or moves to.
        pub setpoint_mpa: f64,
        /// Pressure of the factsheet.
        pub nominal_pressure_mpa: f64,
        /// Contacts that were used.
        pub contacts: i64,
        /// When it was last heard of, by the supervisor's clock.
        pub heard_us: Option<i64>,
        /// Loss of gauge pressure while it is held, per second of itself; null until it can be told.
        pub leak_per_s: Option<f64>,
        /// Lower bound of the 95 % interval.
        pub leak_low_per_s: Option<f64>,
        /// Upper bound.
        pub leak_high_per_s: Option<f64>,
        /// Loss of length with each contact; null unless it erodes.
        pub erosion_mm_per_contact: Option<f64>,
        /// Lower bound of the 95 % interval.
        pub erosion_low_mm_per_contact: Option<f64>,
        /// Upper bound.
        pub erosion_high_mm_per_contact: Option<f64>,
        /// Contacts until it is too short to compensate for itself; null unless it erodes.
        pub contacts_left: Option<f64>,
        /// Lower bound of the 95 % interval.
        pub contacts_left_low: Option<f64>,
        /// Upper bound; null if it may not erode at all.
        pub contacts_left_high: Option<f64>,
        /// The compensation in force for it, if any.
        pub compensated_by: Option<i64>,
        /// The compensation in force that it serves in, if any.
        pub serves_in: Option<i64>,
    }

    /// A decision and what came of it.
    #[derive(Debug, Clone, Serialize)]
    pub struct CompensationReading {
        /// Number.
        pub compensation_id: i64,
        /// Fleet.
        pub fleet: String,
        /// Robot.
        pub robot: String,
        /// The broken whisker's array.
        pub array: String,
        /// The broken whisker.
        pub target_whisker: i64,
        /// Its whole length.
        pub target_length_mm: f64,
        /// Its nominal pressure.
        pub target_pressure_mpa: f64,
        /// Who serves; null if no one can.
        pub compensator_whisker: Option<i64>,
        /// Case of the paper.
        #[serde(rename = "case")]
        pub compensation_case: Option<String>,
        /// Pressure before.
        pub pressure_before_mpa: Option<f64>,
        /// Setpoint.
        pub pressure_mpa: Option<f64>,
        /// Predicted mean error (Eq. 35), as a ratio.
        pub predicted_error: Option<f64>,
        /// Lower end of its 95 % interval.
        pub predicted_error_low: Option<f64>,
        /// Upper end of its 95 % interval.
        pub predicted_error_high: Option<f64>,
        /// The pressure of its newest setpoint: as decided, or as refined since.
        pub held_pressure_mpa: Option<f64>,
        /// How often its setpoint was looked at.
        pub looks: i64,
        /// Why its pressure is what it is: what came of the newest look.
        pub last_look: Option<String>,
        /// Measured mean error, newest, as a ratio.
        pub measured_error: Option<f64>,
        /// Lower end of its 95 % interval.
        pub measured_error_low: Option<f64>,
        /// Upper end of its 95 % interval.
        pub measured_error_high: Option<f64>,
        /// The pressure at which it is measured.
        pub measured_pressure_mpa: Option<f64>,
        /// Measured mean error with the residual gain applied.
        pub measured_error_with_gain: Option<f64>,
        /// Lower end of its 95 % interval.
        pub measured_error_with_gain_low: Option<f64>,
        /// Upper end of its 95 % interval.
        pub measured_error_with_gain_high: Option<f64>,
        /// Contact-ratio bins in it.
        pub measured_bins: Option<i64>,
        /// What became of its newest setpoint.
        pub setpoint_state: Option<String>,
        /// When it was decided.
        pub decided_us: i64,
        /// When it ended, if it has.
        pub ended_us: Option<i64>,
        /// Why it ended.
        pub end_reason: Option<String>,
    }

    /// A candidate of a decision.
    #[derive(Debug, Clone, Serialize)]
    pub struct CandidateReading {
        /// The decision.
        #[serde(skip)]
        pub compensation_id: i64,
        /// Number in the array.
        pub whisker: i64,
        /// Case of the paper.
        #[serde(rename = "case")]
        pub compensation_case: String,
        /// Length.
        pub length_mm: f64,
        /// Its standard deviation.
        pub length_sd_mm: f64,
        /// Pressure before.
        pub pressure_before_mpa: f64,
        /// Setpoint, or the clamped one where there is none in range.
        pub pressure_mpa: Option<f64>,
        /// Predicted mean error, as a ratio.
        pub predicted_error: Option<f64>,
        /// Lower end of its 95 % interval.
        pub predicted_error_low: Option<f64>,
        /// Upper end of its 95 % interval.
        pub predicted_error_high: Option<f64>,
        /// Whether it would give up its own role.
        pub gives_up_own_role: bool,
        /// Whether it was chosen.
        pub chosen: bool,
        /// Why not.
        pub refused: Option<String>,
    }

    /// A look at a setpoint.
    #[derive(Debug, Clone, Serialize)]
    pub struct RefinementReading {
        /// Contacts at the pressure.
        pub contacts: i64,
        /// What came of it.
        pub outcome: String,
        /// The pressure that was held.
        pub pressure_from_mpa: f64,
        /// The best pressure.
        pub pressure_best_mpa: Option<f64>,
        /// Mean error as felt, as a ratio.
        pub error: f64,
        /// Lower end of its 95 % interval.
        pub error_low: f64,
        /// Upper end of its 95 % interval.
        pub error_high: f64,
        /// Error to be expected at the best pressure.
        pub error_best: Option<f64>,
        /// What the published gain leaves.
        pub error_with_gain: f64,
        /// Whether a new gain went out.
        pub gain_published: bool,
    }

    /// A trim that was found.
    #[derive(Debug, Clone, Serialize)]
    pub struct TrimReading {
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        pub whisker: i64,
        /// When it was found.
        pub detected_us: i64,
        /// Length before.
        pub length_before_mm: f64,
        /// Length after.
        pub length_after_mm: f64,
        /// Its standard deviation.
        pub length_after_sd_mm: f64,
        /// Contacts since the likeliest moment of the cut.
        pub contacts_to_detect: i64,
    }

    /// One contact-ratio bin of a measured error.
    #[derive(Debug, Clone, Serialize)]
    pub struct ErrorBinReading {
        /// Centre of the bin.
        pub ratio: f64,
        /// Contacts in it.
        pub contacts: i64,
        /// Eq. 35 as a ratio.
        pub error: f64,
        /// Lower end of its 95 % interval.
        pub error_low: f64,
        /// Upper end of its 95 % interval.
        pub error_high: f64,
    }

    /// The estimated length after a contact.
    #[derive(Debug, Clone)]
    pub struct LengthPoint {
        /// Robot's clock.
        pub t_us: i64,
        /// Length.
        pub length_mm: f64,
        /// Its standard deviation.
        pub length_sd_mm: f64,
        /// Pressure.
        pub pressure_mpa: f64,
    }

    /// A change of condition or fault.
    #[derive(Debug, Clone, Serialize)]
    pub struct HealthChangeReading {
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        pub whisker: i64,
        /// Before.
        pub was: Option<String>,
        /// Now.
        pub becomes: Option<String>,
        /// When.
        pub recorded_us: i64,
    }

    /// A state that a setpoint came into.
    #[derive(Debug, Clone, Serialize)]
    pub struct SetpointStateReading {
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        pub whisker: i64,
        /// Its pressure.
        pub pressure_mpa: f64,
        /// Why it was sent.
        pub reason: String,
        /// The state.
        pub state: String,
        /// When.
        pub recorded_us: i64,
    }
}

/// A decision with everyone who was asked; `GET /v1/compensations`.
#[derive(Debug, Clone, Serialize)]
pub struct Compensation {
    /// The decision and what came of it.
    #[serde(flatten)]
    pub decision: CompensationReading,
    /// Everyone who was asked.
    pub candidates: Vec<CandidateReading>,
}
