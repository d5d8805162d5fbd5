//! How long each table keeps its rows. A test compares the list with both databases.

/// Bound of the rows of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    /// Rows are removed after the days of this setting.
    Days(&'static str),
    /// Rows are removed then.
    Until(&'static str),
    /// Rows are never removed. This bounds their number.
    For(&'static str),
}

use Kept::{Days, For, Until};

const DECISIONS: Kept = For("decisions: trims, and the rate of the policy");
const BY_PEOPLE: Kept = For("people's requests");

/// All tables, by name, each with its retention.
pub const TABLES: &[(&str, Kept)] = &[
    ("actions", For("people's requests: the audit log")),
    ("active_calibrations", For("one for each model and fleet")),
    ("alarm_shelves", Days("records.days")),
    ("alarms", Days("records.days")),
    ("allowed_robots", Until("beyond the newest 20 of each fleet")),
    ("api_tokens", BY_PEOPLE),
    ("archive_horizons", For("one for each fleet")),
    ("archives", For("one for each fleet")),
    ("arrays", Until("a day after all their whiskers, if none was touched")),
    ("black_boxes", Days("black_box.days")),
    ("boots", Until("once no contact and no journal refers to them, except the newest 4 of each robot")),
    ("calibrations", BY_PEOPLE),
    ("compensation_candidates", DECISIONS),
    ("compensation_error_bins", Days("records.days")),
    ("compensation_errors", Days("records.days")),
    ("compensation_refinements", Days("records.days")),
    ("compensation_responses", Days("records.days")),
    ("compensations", DECISIONS),
    ("console_sessions", Until("at the end of the session")),
    ("contact_hours", For("one for each whisker and hour, and removed with it")),
    ("contact_minutes", Days("rollups.minutes_days")),
    ("contacts", Days("contacts.days")),
    ("epochs", For("changes of a fleet's owner")),
    ("event_positions", For("one for each fleet")),
    (
        "events",
        Until("after a day, those for webhooks after a week and beyond 20,000 in fair shares, if Kafka has them"),
    ),
    ("health_changes", Days("records.days")),
    ("journal", Until("after the next checkpoint")),
    ("leases", For("one for each fleet")),
    ("log_positions", For("one for each fleet, topic and partition")),
    ("maintenance", Until("30 days after its end, once another is set; at most 200")),
    ("notes", BY_PEOPLE),
    ("policies", BY_PEOPLE),
    ("quarantine", Until("beyond the newest 1,000 of each fleet")),
    ("refusals", For("one for each robot, topic and reason")),
    ("robots", For("limits.robots_per_fleet")),
    ("rollout_events", BY_PEOPLE),
    ("rollouts", BY_PEOPLE),
    ("setpoint_states", Days("records.days")),
    ("setpoints", Days("records.days")),
    ("supervisors", Until("after a day without a sign of life")),
    ("touch_tests", Days("records.days")),
    ("trims", DECISIONS),
    ("turned_away", Until("beyond the newest 64 of each fleet")),
    ("webhook_dead_letters", Until("with their events, and beyond the newest 1,000 of each webhook")),
    ("webhooks", For("50 of a fleet, 200 of all")),
    ("whiskers", Until("a day after the last layout with them, once no contact, minute or decision names them")),
];
