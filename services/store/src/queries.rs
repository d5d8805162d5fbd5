//! Queries that are not lists of the REST API.

use sqlx::FromRow;
use sqlx::postgres::PgRow;
use sqlx::sqlite::SqliteRow;

use super::database::on;
use super::from_row::{HealthChangeReading, LengthPoint, SetpointStateReading};
use super::list::{Filter, List, Selection};
use super::{Store, StoreError, failed};

/// Most rows of one query.
pub const ROWS_MAX: i64 = 10_000;

impl Store {
    /// The first [`ROWS_MAX`] rows of a list that pass the filters, in the list's default order.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn all<T>(&self, list: &List, filters: Vec<Filter>) -> Result<Vec<T>, StoreError>
    where
        T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin,
    {
        let selection = Selection { filters, ..Selection::all(list, ROWS_MAX as u32) };
        Ok(self.list(list, &selection).await?.rows)
    }

    /// Estimated length and pressure of a whisker over time: every `every`-th contact, at most [`ROWS_MAX`].
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
            "SELECT t_us, length_mm, length_sd_mm, pressure_mpa FROM (\
             SELECT t_us, c.length_mm, c.length_sd_mm, c.pressure_mpa, \
             row_number() OVER (ORDER BY t_us, boot, seq, c.position) AS number FROM contacts c \
             JOIN whiskers w USING (whisker_id) JOIN arrays USING (array_id) \
             JOIN robots r ON r.robot_id = w.robot_id \
             WHERE robot = $1 AND \"array\" = $2 AND whisker = $3) n WHERE number % $4 = 0 ORDER BY number LIMIT $5",
        )
        .bind(robot)
        .bind(array)
        .bind(whisker)
        .bind(every.max(1))
        .bind(ROWS_MAX)
        .fetch_all(pool)
        .await)
        .map_err(failed("read the lengths of a whisker"))
    }

    /// Number of contacts that are stored as single rows.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn contact_count(&self) -> Result<i64, StoreError> {
        on!(&self.pool, |pool| sqlx::query_scalar("SELECT count(*) FROM contacts").fetch_one(pool).await)
            .map_err(failed("count the contacts"))
    }

    /// Number of setpoints in each state.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn setpoint_states(&self) -> Result<Vec<(String, i64)>, StoreError> {
        on!(&self.pool, |pool| sqlx::query_as("SELECT state, count(*) FROM setpoints GROUP BY state ORDER BY state")
            .fetch_all(pool)
            .await)
        .map_err(failed("count the setpoints"))
    }

    /// Number of contacts of a whisker (robot, array, number) at or after `from_us` by the robot's clock that were
    /// received until `received_us` by the supervisor's clock.
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

    /// Number of contacts in the newest measured error of each compensation in force.
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

    /// The first [`ROWS_MAX`] changes of condition and fault, in order.
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

    /// The first [`ROWS_MAX`] states of setpoints, in order.
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
        .map_err(failed("list the states of setpoints"))
    }

    /// Fleet and robot of a compensation; `None` if there is no such compensation.
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
        .map_err(failed("read a compensation"))
    }

    /// Whether the database has a lease or a robot of this fleet.
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
        .map_err(failed("read a fleet"))?;
        Ok(found.is_some())
    }

    /// Whether the database has a robot of these names.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn has_robot(&self, fleet: &str, robot: &str) -> Result<bool, StoreError> {
        const SQL: &str = "SELECT robot_id FROM robots WHERE fleet = $1 AND robot = $2";
        let found: Option<i64> =
            on!(&self.pool, |pool| sqlx::query_scalar(SQL).bind(fleet).bind(robot).fetch_optional(pool).await)
                .map_err(failed("read a robot"))?;
        Ok(found.is_some())
    }
}
