//! What people ask for, as JSON in the contract's words.

use serde::Serialize;
use sqlx::sqlite::SqliteRow;
use sqlx::{FromRow, Row};

use super::{Store, StoreError, failed};

/// Defines what a query reads: a struct whose fields are the query's columns, by name.
macro_rules! readings {
    ($($(#[$meta:meta])* pub struct $name:ident { $($(#[$field_meta:meta])* pub $field:ident: $type:ty,)+ })+) => {
        $($(#[$meta])* pub struct $name { $($(#[$field_meta])* pub $field: $type,)+ }

        impl<'r> FromRow<'r, SqliteRow> for $name {
            fn from_row(row: &'r SqliteRow) -> sqlx::Result<Self> {
                Ok(Self { $($field: row.try_get(stringify!($field))?,)+ })
            }
        })+
    };
}

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
        /// Measured mean error, newest, as a ratio.
        pub measured_error: Option<f64>,
        /// Lower end of its 95 % interval.
        pub measured_error_low: Option<f64>,
        /// Upper end of its 95 % interval.
        pub measured_error_high: Option<f64>,
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
        /// Whether it would give up its own role.
        pub gives_up_own_role: bool,
        /// Whether it was chosen.
        pub chosen: bool,
        /// Why not.
        pub refused: Option<String>,
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

/// Rows that one request gets at most.
pub const ROWS_MAX: i64 = 10_000;

impl Store {
    /// Every whisker that is on a robot, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn whiskers(&self) -> Result<Vec<WhiskerReading>, StoreError> {
        sqlx::query_as(
            "SELECT fleet, robot, array, array_type, w.whisker, whole_length_mm, length_mm, length_sd_mm, condition, \
             fault, pressure_mpa, setpoint_mpa, nominal_pressure_mpa, contacts, heard_us, \
             (SELECT max(compensation_id) FROM compensations c WHERE c.target_whisker_id = w.whisker_id \
              AND c.ended_us IS NULL AND c.compensator_whisker_id IS NOT NULL) AS compensated_by, \
             (SELECT max(compensation_id) FROM compensations c WHERE c.compensator_whisker_id = w.whisker_id \
              AND c.ended_us IS NULL) AS serves_in \
             FROM whiskers w JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id \
             WHERE position IS NOT NULL ORDER BY fleet, robot, array, w.whisker LIMIT ?",
        )
        .bind(ROWS_MAX)
        .fetch_all(&self.pool)
        .await
        .map_err(failed("list the whiskers"))
    }

    /// The newest decisions with their candidates, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn compensations(&self) -> Result<Vec<Compensation>, StoreError> {
        const WHAT: &str = "list the compensations";
        let decisions: Vec<CompensationReading> = sqlx::query_as(
            "SELECT c.compensation_id, fleet, robot, array, t.whisker AS target_whisker, target_length_mm, \
             target_pressure_mpa, k.whisker AS compensator_whisker, compensation_case, pressure_before_mpa, \
             c.pressure_mpa, predicted_error, e.error AS measured_error, e.error_low AS measured_error_low, \
             e.error_high AS measured_error_high, e.bins AS measured_bins, \
             (SELECT state FROM setpoints s WHERE s.compensation_id = c.compensation_id \
              ORDER BY epoch DESC, version DESC LIMIT 1) AS setpoint_state, decided_us, ended_us, end_reason \
             FROM compensations c JOIN robots USING (robot_id) JOIN whiskers t ON t.whisker_id = c.target_whisker_id \
             JOIN arrays ON arrays.array_id = t.array_id \
             LEFT JOIN whiskers k ON k.whisker_id = c.compensator_whisker_id \
             LEFT JOIN compensation_errors e ON e.compensation_error_id = (SELECT max(compensation_error_id) \
              FROM compensation_errors n WHERE n.compensation_id = c.compensation_id) \
             ORDER BY decided_us DESC, c.compensation_id DESC LIMIT ?",
        )
        .bind(ROWS_MAX)
        .fetch_all(&self.pool)
        .await
        .map_err(failed(WHAT))?;
        let candidates: Vec<CandidateReading> = sqlx::query_as(
            "SELECT compensation_id, w.whisker, compensation_case, k.length_mm, k.length_sd_mm, pressure_before_mpa, \
             k.pressure_mpa, predicted_error, gives_up_own_role, chosen, refused \
             FROM compensation_candidates k JOIN whiskers w USING (whisker_id) WHERE compensation_id IN \
             (SELECT compensation_id FROM compensations ORDER BY decided_us DESC, compensation_id DESC LIMIT ?) \
             ORDER BY compensation_id, ordinal",
        )
        .bind(ROWS_MAX)
        .fetch_all(&self.pool)
        .await
        .map_err(failed(WHAT))?;
        let with_candidates = decisions.into_iter().map(|decision| {
            let id = decision.compensation_id;
            let from = candidates.partition_point(|candidate| candidate.compensation_id < id);
            let to = candidates.partition_point(|candidate| candidate.compensation_id <= id);
            Compensation { decision, candidates: candidates[from..to].to_vec() }
        });
        Ok(with_candidates.collect())
    }

    /// Trims in the order in which they were found, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn trims(&self) -> Result<Vec<TrimReading>, StoreError> {
        sqlx::query_as(
            "SELECT robot, array, w.whisker, detected_us, length_before_mm, length_after_mm, length_after_sd_mm, \
             contacts_to_detect FROM trims t JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = t.robot_id ORDER BY detected_us, trim_id LIMIT ?",
        )
        .bind(ROWS_MAX)
        .fetch_all(&self.pool)
        .await
        .map_err(failed("list the trims"))
    }

    /// The newest measured error of a compensation by contact ratio.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn error_bins(&self, compensation_id: i64) -> Result<Vec<ErrorBinReading>, StoreError> {
        sqlx::query_as(
            "SELECT ratio, contacts, error, error_low, error_high FROM compensation_error_bins \
             WHERE compensation_error_id = (SELECT max(compensation_error_id) FROM compensation_errors \
             WHERE compensation_id = ?) ORDER BY ratio",
        )
        .bind(compensation_id)
        .fetch_all(&self.pool)
        .await
        .map_err(failed("read a compensation error"))
    }

    /// Estimated length and pressure of a whisker over time, every `every`-th contact, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn lengths(
        &self,
        robot: &str,
        array: &str,
        whisker: i64,
        every: i64,
    ) -> Result<Vec<LengthPoint>, StoreError> {
        sqlx::query_as(
            "SELECT t_us, c.length_mm, c.length_sd_mm, c.pressure_mpa FROM contacts c \
             JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id \
             WHERE robot = ? AND array = ? AND whisker = ? AND contact_id % ? = 0 ORDER BY t_us LIMIT ?",
        )
        .bind(robot)
        .bind(array)
        .bind(whisker)
        .bind(every.max(1))
        .bind(ROWS_MAX)
        .fetch_all(&self.pool)
        .await
        .map_err(failed("read a whisker's lengths"))
    }

    /// How many contacts are recorded.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn contact_count(&self) -> Result<i64, StoreError> {
        sqlx::query_scalar("SELECT count(*) FROM contacts")
            .fetch_one(&self.pool)
            .await
            .map_err(failed("count the contacts"))
    }

    /// How many setpoints are in each state.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn setpoint_states(&self) -> Result<Vec<(String, i64)>, StoreError> {
        sqlx::query_as("SELECT state, count(*) FROM setpoints GROUP BY state ORDER BY state")
            .fetch_all(&self.pool)
            .await
            .map_err(failed("count the setpoints"))
    }

    /// Contacts of a whisker (robot, array, number) from a moment by the robot's clock on, until they were
    /// received at another by the supervisor's.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn contacts_between(
        &self,
        whisker: (&str, &str, i64),
        from_us: i64,
        received_us: i64,
    ) -> Result<i64, StoreError> {
        sqlx::query_scalar(
            "SELECT count(*) FROM contacts c JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id \
             WHERE robot = ? AND array = ? AND whisker = ? AND t_us >= ? AND received_us <= ?",
        )
        .bind(whisker.0)
        .bind(whisker.1)
        .bind(whisker.2)
        .bind(from_us)
        .bind(received_us)
        .fetch_one(&self.pool)
        .await
        .map_err(failed("count a whisker's contacts"))
    }

    /// Contacts behind the newest error of each compensation in force.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn measured_contacts(&self) -> Result<Vec<i64>, StoreError> {
        sqlx::query_scalar(
            "SELECT max(e.contacts) FROM compensation_errors e JOIN compensations USING (compensation_id) \
             WHERE ended_us IS NULL GROUP BY compensation_id",
        )
        .fetch_all(&self.pool)
        .await
        .map_err(failed("count the measured contacts"))
    }

    /// Changes of health in order, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn health_changes(&self) -> Result<Vec<HealthChangeReading>, StoreError> {
        sqlx::query_as(
            "SELECT robot, array, whisker, was, becomes, recorded_us FROM health_changes h \
             JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id ORDER BY health_change_id LIMIT ?",
        )
        .bind(ROWS_MAX)
        .fetch_all(&self.pool)
        .await
        .map_err(failed("list the changes of health"))
    }

    /// What became of setpoints, in order, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn setpoint_history(&self) -> Result<Vec<SetpointStateReading>, StoreError> {
        sqlx::query_as(
            "SELECT robot, array, whisker, s.pressure_mpa, reason, h.state, h.recorded_us FROM setpoint_states h \
             JOIN setpoints s USING (command_id) JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id ORDER BY setpoint_state_id LIMIT ?",
        )
        .bind(ROWS_MAX)
        .fetch_all(&self.pool)
        .await
        .map_err(failed("list what became of setpoints"))
    }
}
