//! Rows from which a new owner of a fleet publishes facts for the maintenance of its whiskers.

use super::database::on;
use super::from_row::from_row;
use super::set_aside::Tried;
use super::{Store, StoreError, failed};

from_row! {
    /// The last touch test of a whisker that was done since the whisker is there.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub struct LastTest {
        /// Row of the whisker.
        pub whisker_id: i64,
        /// End of the test, µs since 1970 UTC by the supervisor's clock.
        pub ended_us: i64,
    }
}

/// `$1` is the fleet. A whisker that was replaced is learned anew.
const LAST: &str = "SELECT w.whisker_id, t.ended_us FROM whiskers w JOIN robots r ON r.robot_id = w.robot_id \
     JOIN touch_tests t ON t.touch_test_id = (SELECT l.touch_test_id FROM touch_tests l \
       WHERE l.whisker_id = w.whisker_id AND l.state = 'DONE' ORDER BY l.requested_us DESC LIMIT 1) \
     WHERE r.fleet = $1 AND w.position IS NOT NULL AND t.ended_us IS NOT NULL AND NOT EXISTS (SELECT 1 FROM health_changes h \
       WHERE h.whisker_id = w.whisker_id AND h.recorded_us > t.ended_us AND h.kind = 'CONDITION' AND h.becomes = 'LEARNING') \
     ORDER BY w.whisker_id";

impl Store {
    /// The last touch tests of a fleet's whiskers.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn last_tests(&self, fleet: &str) -> Result<Vec<LastTest>, StoreError> {
        let rows: Vec<Tried<LastTest>> = on!(&self.pool, |pool| sqlx::query_as(LAST).bind(fleet).fetch_all(pool).await)
            .map_err(failed("read the last touch tests"))?;
        Ok(self.set_aside.readable("touch_tests", rows))
    }
}
