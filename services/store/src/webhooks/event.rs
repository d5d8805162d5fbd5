//! Events of the outbox, with the names and values that their payloads need.

use sqlx::{AssertSqlSafe, SqlSafeStr};
use vibrissa_edge::webhooks::{EventKind, Interest};
use vibrissa_edge::words::named;

use super::Place;
use crate::from_row::from_row;

from_row! {
    /// An event with what its payload says. The values of other kinds are `None`.
    #[derive(Debug, Clone, PartialEq)]
    pub struct EventRow {
        /// Number of the event.
        pub event_id: i64,
        /// Number of the transaction.
        pub tx: i64,
        /// Place in the transaction.
        pub place: i64,
        /// Time of the event, µs since 1970 UTC by the supervisor's clock.
        pub occurred_us: i64,
        /// Kind of the event.
        pub kind: String,
        /// Kind of the alarm, end reason, state of the setpoint, or new condition.
        pub word: Option<String>,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot.
        pub robot: String,
        /// Name of the array; `None` if the whole robot is concerned.
        pub array: Option<String>,
        /// Number of the whisker in its array; `None` if the whole robot is concerned.
        pub whisker: Option<i64>,
        /// Number of the alarm, trim, compensation or change of health.
        pub number: Option<i64>,
        /// Identifier of the setpoint.
        pub command_id: Option<String>,
        /// Length before the trim, mm.
        pub length_before_mm: Option<f64>,
        /// Length after the trim, mm.
        pub length_after_mm: Option<f64>,
        /// Standard deviation of the length after the trim, mm.
        pub length_after_sd_mm: Option<f64>,
        /// Condition before the change.
        pub was: Option<String>,
        /// Case of the compensation.
        pub compensation_case: Option<String>,
        /// Number of the compensator in the whisker's array.
        pub compensator_whisker: Option<i64>,
        /// Pressure of the compensation or setpoint, MPa.
        pub pressure_mpa: Option<f64>,
        /// Predicted error of the compensation, as a ratio.
        pub predicted_error: Option<f64>,
        /// Reason of the setpoint.
        pub setpoint_reason: Option<String>,
        /// Why the robot rejected the setpoint.
        pub setpoint_error: Option<String>,
    }
}

impl EventRow {
    /// Kind of the event; `None` for a word of a newer version of the program.
    #[must_use]
    pub fn event_kind(&self) -> Option<EventKind> {
        named(&self.kind)
    }

    /// Whether a target wants it.
    pub(super) fn is_in(&self, interest: &Interest) -> bool {
        self.event_kind().is_some_and(|kind| interest.includes(&self.fleet, kind, self.word.as_deref()))
    }

    /// Place of the event in the outbox.
    #[must_use]
    pub fn at(&self) -> Place {
        Place { tx: self.tx, place: self.place, event_id: self.event_id }
    }
}

/// The query of [`EventRow`] with an end that begins with WHERE.
pub(super) fn select(end: &str) -> impl SqlSafeStr + use<> {
    AssertSqlSafe(format!(
        "SELECT e.event_id, e.tx, e.place, e.occurred_us, e.kind, e.word, e.fleet, r.robot, a.\"array\", w.whisker, e.number, \
         e.command_id, t.length_before_mm, t.length_after_mm, t.length_after_sd_mm, h.was, c.compensation_case, \
         v.whisker AS compensator_whisker, coalesce(c.pressure_mpa, s.pressure_mpa) AS pressure_mpa, c.predicted_error, \
         s.reason AS setpoint_reason, s.error AS setpoint_error FROM webhook_events e \
         JOIN robots r ON r.robot_id = e.robot_id LEFT JOIN whiskers w ON w.whisker_id = e.whisker_id \
         LEFT JOIN arrays a ON a.array_id = w.array_id LEFT JOIN trims t ON e.kind = 'TRIM' AND t.trim_id = e.number \
         LEFT JOIN health_changes h ON e.kind = 'CONDITION_CHANGED' AND h.health_change_id = e.number \
         LEFT JOIN compensations c ON e.kind IN ('COMPENSATION_BEGUN', 'COMPENSATION_ENDED') AND c.compensation_id = e.number \
         LEFT JOIN whiskers v ON v.whisker_id = c.compensator_whisker_id \
         LEFT JOIN setpoints s ON s.command_id = e.command_id {end}"
    ))
}
