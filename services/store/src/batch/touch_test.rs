//! Rows of touch tests, and their progress.

use crate::row::row;

row! {
    /// A touch test that was requested or proposed; docs/schema.md documents the columns.
    pub struct TouchTestRow {
        /// Identifier of the test, a UUID.
        pub test_id: String,
        /// Number of the robot in the database.
        pub robot_id: i64,
        /// Number of the whisker in the database.
        pub whisker_id: i64,
        /// Kind of test: `TIP` or `WALL`.
        pub kind: &'static str,
        /// Reason, such as `SUSPICION`.
        pub reason: &'static str,
        /// Number of requested touches.
        pub contacts: i64,
        /// First state: `PENDING` or `PROPOSED`.
        pub state: &'static str,
        /// Time of the request or proposal, µs since 1970 UTC by the supervisor's clock.
        pub requested_us: i64,
    }
    also {
        updated_us: i64 = |row| row.requested_us,
    }

    /// Progress of a touch test: a new state, or touches.
    pub struct TouchTestProgressRow {
        /// Identifier of the test, a UUID.
        pub test_id: String,
        /// Number of the robot in the database; a test of another robot is not changed.
        pub robot_id: i64,
        /// Time of the progress, µs since 1970 UTC by the supervisor's clock.
        pub updated_us: i64,
        /// The new state, such as `RUNNING`; `None` if it is as before.
        pub state: Option<&'static str>,
        /// Reason that the robot gave for rejecting the test.
        pub error: Option<&'static str>,
        /// Time of the end, µs since 1970 UTC by the supervisor's clock; `None` while the test goes on.
        pub ended_us: Option<i64>,
        /// Touches that came since the last progress.
        pub touches: i64,
        /// Touches that did not come since the last progress.
        pub missed: i64,
        /// Estimated length after the test, mm.
        pub length_mm: Option<f64>,
        /// Standard deviation of the estimated length, mm.
        pub length_sd_mm: Option<f64>,
    }
}

impl TouchTestProgressRow {
    /// Adds later progress of the same test.
    pub(crate) fn add(&mut self, later: &Self) {
        self.updated_us = later.updated_us;
        self.state = later.state.or(self.state);
        self.error = later.error.or(self.error);
        self.ended_us = later.ended_us.or(self.ended_us);
        self.touches += later.touches;
        self.missed += later.missed;
        self.length_mm = later.length_mm.or(self.length_mm);
        self.length_sd_mm = later.length_sd_mm.or(self.length_sd_mm);
    }
}
