//! What people ask for.

use super::database::on;
use super::readings::{
    CandidateReading, Compensation, CompensationReading, ErrorBinReading, HealthChangeReading, LengthPoint,
    RefinementReading, SetpointStateReading, TrimReading, WhiskerReading,
};
use super::{Store, StoreError, failed};

/// Rows that one request gets at most.
pub const ROWS_MAX: i64 = 10_000;

impl Store {
    /// Every whisker that is on a robot, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn whiskers(&self) -> Result<Vec<WhiskerReading>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT fleet, robot, \"array\", array_type, w.whisker, whole_length_mm, length_mm, length_sd_mm, condition, \
             fault, pressure_mpa, setpoint_mpa, nominal_pressure_mpa, contacts, heard_us, leak_per_s, leak_low_per_s, \
             leak_high_per_s, erosion_mm_per_contact, erosion_low_mm_per_contact, erosion_high_mm_per_contact, \
             contacts_left, contacts_left_low, contacts_left_high, \
             (SELECT max(compensation_id) FROM compensations c WHERE c.target_whisker_id = w.whisker_id \
              AND c.ended_us IS NULL AND c.compensator_whisker_id IS NOT NULL) AS compensated_by, \
             (SELECT max(compensation_id) FROM compensations c WHERE c.compensator_whisker_id = w.whisker_id \
              AND c.ended_us IS NULL) AS serves_in \
             FROM whiskers w JOIN arrays USING (array_id) JOIN robots r ON r.robot_id = w.robot_id \
             WHERE position IS NOT NULL ORDER BY fleet, robot, \"array\", w.whisker LIMIT $1",
        )
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("list the whiskers"))
    }

    /// The newest decisions with their candidates, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn compensations(&self) -> Result<Vec<Compensation>, StoreError> {
        const WHAT: &str = "list the compensations";
        let decisions: Vec<CompensationReading> = on!(&self.pool, |pool| sqlx::query_as(
            "SELECT c.compensation_id, fleet, robot, \"array\", t.whisker AS target_whisker, target_length_mm, \
             target_pressure_mpa, k.whisker AS compensator_whisker, compensation_case, pressure_before_mpa, \
             c.pressure_mpa, predicted_error, predicted_error_low, predicted_error_high, \
             (SELECT s.pressure_mpa FROM setpoints s WHERE s.compensation_id = c.compensation_id \
              ORDER BY epoch DESC, version DESC LIMIT 1) AS held_pressure_mpa, \
             (SELECT count(*) FROM compensation_refinements l WHERE l.compensation_id = c.compensation_id) AS looks, \
             (SELECT outcome FROM compensation_refinements l WHERE l.compensation_id = c.compensation_id \
              ORDER BY compensation_refinement_id DESC LIMIT 1) AS last_look, \
             e.error AS measured_error, e.error_low AS measured_error_low, \
             e.error_high AS measured_error_high, e.pressure_mpa AS measured_pressure_mpa, \
             e.error_with_gain AS measured_error_with_gain, e.error_with_gain_low AS measured_error_with_gain_low, \
             e.error_with_gain_high AS measured_error_with_gain_high, e.bins AS measured_bins, \
             (SELECT state FROM setpoints s WHERE s.compensation_id = c.compensation_id \
              ORDER BY epoch DESC, version DESC LIMIT 1) AS setpoint_state, decided_us, ended_us, end_reason \
             FROM compensations c JOIN robots USING (robot_id) JOIN whiskers t ON t.whisker_id = c.target_whisker_id \
             JOIN arrays ON arrays.array_id = t.array_id \
             LEFT JOIN whiskers k ON k.whisker_id = c.compensator_whisker_id \
             LEFT JOIN compensation_errors e ON e.compensation_error_id = (SELECT max(compensation_error_id) \
              FROM compensation_errors n WHERE n.compensation_id = c.compensation_id) \
             ORDER BY decided_us DESC, c.compensation_id DESC LIMIT $1",
        )
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed(WHAT))?;
        let candidates: Vec<CandidateReading> = on!(&self.pool, |pool| {
            sqlx::query_as(
            "SELECT compensation_id, w.whisker, compensation_case, k.length_mm, k.length_sd_mm, pressure_before_mpa, \
             k.pressure_mpa, predicted_error, predicted_error_low, predicted_error_high, gives_up_own_role, chosen, refused \
             FROM compensation_candidates k JOIN whiskers w USING (whisker_id) WHERE compensation_id IN \
             (SELECT compensation_id FROM compensations ORDER BY decided_us DESC, compensation_id DESC LIMIT $1) \
             ORDER BY compensation_id, ordinal",
        )
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await
        })
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
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT robot, \"array\", w.whisker, detected_us, length_before_mm, length_after_mm, length_after_sd_mm, \
             contacts_to_detect FROM trims t JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = t.robot_id ORDER BY detected_us, trim_id LIMIT $1",
        )
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("list the trims"))
    }

    /// The newest measured error of a compensation by contact ratio.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn error_bins(&self, compensation_id: i64) -> Result<Vec<ErrorBinReading>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT ratio, contacts, error, error_low, error_high FROM compensation_error_bins \
             WHERE compensation_error_id = (SELECT max(compensation_error_id) FROM compensation_errors \
             WHERE compensation_id = $1) ORDER BY ratio",
        )
        .bind(compensation_id)
        .fetch_all(pool)
        .await)
        .map_err(failed("read a compensation error"))
    }

    /// Every look at a compensation's setpoint, in order, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn refinements(&self, compensation_id: i64) -> Result<Vec<RefinementReading>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT contacts, outcome, pressure_from_mpa, pressure_best_mpa, error, error_low, error_high, \
             error_best, error_with_gain, gain_published FROM compensation_refinements \
             WHERE compensation_id = $1 ORDER BY compensation_refinement_id LIMIT $2",
        )
        .bind(compensation_id)
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("list the looks at a setpoint"))
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
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT t_us, c.length_mm, c.length_sd_mm, c.pressure_mpa FROM contacts c \
             JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id \
             WHERE robot = $1 AND \"array\" = $2 AND whisker = $3 AND contact_id % $4 = 0 ORDER BY t_us LIMIT $5",
        )
        .bind(robot)
        .bind(array)
        .bind(whisker)
        .bind(every.max(1))
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("read a whisker's lengths"))
    }

    /// How many contacts are recorded.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn contact_count(&self) -> Result<i64, StoreError> {
        on!(&self.pool, |pool| sqlx::query_scalar("SELECT count(*) FROM contacts").fetch_one(pool).await)
            .map_err(failed("count the contacts"))
    }

    /// How many setpoints are in each state.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn setpoint_states(&self) -> Result<Vec<(String, i64)>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as("SELECT state, count(*) FROM setpoints GROUP BY state ORDER BY state")
            .fetch_all(pool)
            .await)
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
        on!(&self.pool, |pool| sqlx::query_scalar(
            "SELECT count(*) FROM contacts c JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id \
             WHERE robot = $1 AND \"array\" = $2 AND whisker = $3 AND t_us >= $4 AND received_us <= $5",
        )
        .bind(whisker.0)
        .bind(whisker.1)
        .bind(whisker.2)
        .bind(from_us)
        .bind(received_us)
        .fetch_one(pool)
        .await)
        .map_err(failed("count a whisker's contacts"))
    }

    /// Contacts behind the newest error of each compensation in force.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn measured_contacts(&self) -> Result<Vec<i64>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_scalar(
            "SELECT contacts FROM compensation_errors JOIN compensations USING (compensation_id) \
             WHERE ended_us IS NULL AND compensation_error_id IN \
             (SELECT max(compensation_error_id) FROM compensation_errors GROUP BY compensation_id) \
             ORDER BY compensation_id",
        )
        .fetch_all(pool)
        .await)
        .map_err(failed("count the measured contacts"))
    }

    /// Changes of health in order, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn health_changes(&self) -> Result<Vec<HealthChangeReading>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT robot, \"array\", whisker, was, becomes, recorded_us FROM health_changes h \
             JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id ORDER BY health_change_id LIMIT $1",
        )
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("list the changes of health"))
    }

    /// What became of setpoints, in order, at most [`ROWS_MAX`].
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn setpoint_history(&self) -> Result<Vec<SetpointStateReading>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT robot, \"array\", whisker, s.pressure_mpa, reason, h.state, h.recorded_us FROM setpoint_states h \
             JOIN setpoints s USING (command_id) JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id ORDER BY setpoint_state_id LIMIT $1",
        )
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("list what became of setpoints"))
    }

    /// The fleet and robot that a compensation is of; none if there is no such compensation.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn robot_of_compensation(&self, compensation_id: i64) -> Result<Option<(String, String)>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as(
            "SELECT fleet, robot FROM compensations JOIN robots USING (robot_id) WHERE compensation_id = $1",
        )
        .bind(compensation_id)
        .fetch_optional(pool)
        .await)
        .map_err(failed("look a compensation up"))
    }

    /// Whether anything is known of a fleet.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn has_fleet(&self, fleet: &str) -> Result<bool, StoreError> {
        let found: Option<i64> = on!(&self.pool, |pool| sqlx::query_scalar(
            "SELECT CAST(1 AS BIGINT) WHERE EXISTS (SELECT 1 FROM leases WHERE fleet = $1) \
             OR EXISTS (SELECT 1 FROM robots WHERE fleet = $1)",
        )
        .bind(fleet)
        .fetch_optional(pool)
        .await)
        .map_err(failed("look a fleet up"))?;
        Ok(found.is_some())
    }
}
