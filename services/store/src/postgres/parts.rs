//! The parts of the statement that writes a whole transaction, and their combination into one.

use std::sync::LazyLock;

use super::rows::{CONTACTS, HOURS, MINUTES, RESPONSES, ROBOTS, WHISKERS};

/// Advances the commit counter of the lease and renews it; also used as a statement on its own.
pub(in super::super) const COUNTED: &str = "UPDATE leases SET commits = $4 + 1, expires_us = clock_us() + $5 \
    WHERE fleet = $1 AND epoch = $2 AND owner = $3 AND commits = $4 RETURNING fleet";

const JOURNAL: &str = "INSERT INTO journal (fleet, number, entries) \
    SELECT $1, n.* FROM unnest($2::bigint[], $3::bytea[]) AS n WHERE OWNED";

const JOURNAL_DONE: &str = "DELETE FROM journal WHERE fleet = $1 AND number <= $2 AND OWNED";

const REDO: &str = "INSERT INTO redo (fleet, number, rows) SELECT $1::text, $2::bigint, $3::bytea WHERE OWNED";

const REDO_DONE: &str = "DELETE FROM redo WHERE fleet = $1 AND number = $2 AND OWNED";

const HEALTH: &str = "INSERT INTO health_changes (whisker_id, recorded_us, kind, was, becomes) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::text[], $4::text[], $5::text[]) WHERE OWNED";

const TRIMS: &str = "INSERT INTO trims (trim_id, robot_id, whisker_id, detected_us, length_before_mm, length_after_mm, \
    length_after_sd_mm, contacts_to_detect) SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::bigint[], \
    $5::float8[], $6::float8[], $7::float8[], $8::bigint[]) WHERE OWNED";

const DECISIONS: &str = "INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, \
    target_pressure_mpa, compensator_whisker_id, compensation_case, pressure_before_mpa, pressure_mpa, \
    predicted_error, predicted_error_low, predicted_error_high, decided_us, approval) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::float8[], $5::float8[], $6::bigint[], $7::text[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::float8[], $13::bigint[], $14::text[]) WHERE OWNED";

const CANDIDATES: &str = "INSERT INTO compensation_candidates (compensation_id, ordinal, whisker_id, compensation_case, \
    length_mm, length_sd_mm, pressure_before_mpa, pressure_mpa, predicted_error, predicted_error_low, \
    predicted_error_high, predicted_error_by_ratio, gives_up_own_role, chosen, refused) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::text[], $5::float8[], $6::float8[], $7::float8[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::text[], $13::boolean[], $14::boolean[], $15::text[]) \
    WHERE OWNED";

const ENDED: &str = "UPDATE compensations c SET ended_us = n.ended_us, end_reason = n.end_reason, \
    approval = CASE WHEN n.end_reason = 'REFUSED' THEN 'REFUSED' ELSE approval END \
    FROM unnest($1::bigint[], $2::bigint[], $3::text[]) AS n (compensation_id, ended_us, end_reason) \
    WHERE c.compensation_id = n.compensation_id AND OWNED";

const SETPOINTS: &str = "INSERT INTO setpoints (command_id, robot_id, whisker_id, compensation_id, epoch, version, \
    robot_boot_id, pressure_mpa, slew_mpa_per_s, issued_us, expires_us, reason, gain, state) \
    SELECT *, 'PENDING' FROM unnest($1::text[], $2::bigint[], $3::bigint[], $4::bigint[], $5::bigint[], $6::bigint[], \
    $7::text[], $8::float8[], $9::float8[], $10::bigint[], $11::bigint[], $12::text[], $13::text[]) WHERE OWNED \
    RETURNING command_id, issued_us";

const FIRST_STATES: &str = "INSERT INTO setpoint_states (command_id, recorded_us, state) \
    SELECT command_id, issued_us, 'PENDING' FROM setpoints_new WHERE OWNED";

const ANSWERED: &str = "UPDATE setpoints s SET state = n.state, error = n.error, \
    reached_mpa = COALESCE(n.pressure_mpa, reached_mpa) \
    FROM unnest($1::text[], $2::text[], $3::text[], $4::float8[]) AS n (command_id, state, error, pressure_mpa) \
    WHERE s.command_id = n.command_id AND OWNED";

const STATES: &str = "INSERT INTO setpoint_states (command_id, recorded_us, state, error, pressure_mpa) \
    SELECT * FROM unnest($1::text[], $2::bigint[], $3::text[], $4::text[], $5::float8[]) WHERE OWNED";

const ERRORS: &str = "INSERT INTO compensation_errors (compensation_id, recorded_us, contacts, bins, error, error_low, \
    error_high, pressure_mpa, error_with_gain, error_with_gain_low, error_with_gain_high) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::bigint[], $5::float8[], $6::float8[], $7::float8[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[]) WHERE OWNED \
    RETURNING compensation_error_id, compensation_id, recorded_us";

const BINS: &str = "INSERT INTO compensation_error_bins (compensation_error_id, ratio, contacts, after_per_mm, \
    before_per_mm, before_origin, target_per_mm, target_origin, error, error_low, error_high) \
    SELECT e.compensation_error_id, n.ratio, n.contacts, n.after_per_mm, n.before_per_mm, n.before_origin, \
    n.target_per_mm, n.target_origin, n.error, n.error_low, n.error_high \
    FROM unnest($1::bigint[], $2::bigint[], $3::float8[], $4::bigint[], $5::float8[], $6::float8[], $7::text[], \
    $8::float8[], $9::text[], $10::float8[], $11::float8[], $12::float8[]) \
    AS n (compensation_id, recorded_us, ratio, contacts, after_per_mm, before_per_mm, before_origin, target_per_mm, \
    target_origin, error, error_low, error_high) \
    JOIN errors_new e USING (compensation_id, recorded_us) WHERE OWNED";

const REFINEMENTS: &str = "INSERT INTO compensation_refinements (compensation_id, recorded_us, contacts, outcome, \
    pressure_from_mpa, pressure_best_mpa, error, error_low, error_high, error_best, error_best_low, error_best_high, \
    error_with_gain, error_with_own_gain, gain_published) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::bigint[], $4::text[], $5::float8[], $6::float8[], $7::float8[], \
    $8::float8[], $9::float8[], $10::float8[], $11::float8[], $12::float8[], $13::float8[], $14::float8[], \
    $15::boolean[]) WHERE OWNED";

const ALARMS: &str = "INSERT INTO alarms (whisker_id, raised_us, kind) \
    SELECT * FROM unnest($1::bigint[], $2::bigint[], $3::text[]) WHERE OWNED";

/// Each alarm is looked up with its own subquery. The server's estimate of the number of standing alarms can be wrong
/// by a factor of a thousand when a fleet goes offline, and a join planned with it would compare every alarm with
/// every other.
const CLEARED: &str = "UPDATE alarms a SET cleared_us = n.cleared_us \
    FROM (SELECT u.cleared_us, (SELECT s.alarm_id FROM alarms s \
    WHERE s.whisker_id = u.whisker_id AND s.kind = u.kind AND s.cleared_us IS NULL LIMIT 1) AS alarm_id \
    FROM unnest($1::bigint[], $2::bigint[], $3::text[]) AS u (whisker_id, cleared_us, kind)) AS n \
    WHERE a.alarm_id = n.alarm_id AND OWNED";

const CHANGES: &str = "INSERT INTO changes (fleet, recorded_us, kind, robot_id, whisker_id, number, command_id) \
    SELECT $1, n.* FROM unnest($2::bigint[], $3::text[], $4::bigint[], $5::bigint[], $6::bigint[], $7::text[]) AS n \
    WHERE OWNED";

/// Statement of a transaction that writes only an intent.
static KEPT: LazyLock<String> = LazyLock::new(|| of_parts(&[("counted", COUNTED), ("kept", REDO)]));

/// The statement that writes an intent; its parameters are those of the lease, then fleet, number and bytes.
pub(in super::super) fn kept() -> &'static str {
    &KEPT
}

/// Statement of a transaction that contains only contacts and journal entries.
pub(super) static ORDINARY: LazyLock<String> = LazyLock::new(|| {
    of_parts(&[
        ("counted", COUNTED),
        ("journal_new", JOURNAL),
        ("journal_done", JOURNAL_DONE),
        ("contacts_new", CONTACTS),
    ])
});

/// Statement of a transaction with all kinds of rows; most of its parts usually write nothing.
pub(super) static WHOLE: LazyLock<String> = LazyLock::new(|| {
    of_parts(&[
        ("counted", COUNTED),
        ("journal_new", JOURNAL),
        ("journal_done", JOURNAL_DONE),
        ("contacts_new", CONTACTS),
        ("redo_done", REDO_DONE),
        ("robots_now", ROBOTS),
        ("whiskers_now", WHISKERS),
        ("health_new", HEALTH),
        ("trims_new", TRIMS),
        ("compensations_new", DECISIONS),
        ("candidates_new", CANDIDATES),
        ("compensations_ended", ENDED),
        ("setpoints_new", SETPOINTS),
        ("setpoint_states_first", FIRST_STATES),
        ("setpoints_answered", ANSWERED),
        ("setpoint_states_next", STATES),
        ("errors_new", ERRORS),
        ("bins_new", BINS),
        ("refinements_new", REFINEMENTS),
        ("alarms_new", ALARMS),
        ("alarms_cleared", CLEARED),
        ("responses_new", RESPONSES),
        ("changes_new", CHANGES),
        ("minutes_new", MINUTES),
        ("hours_new", HOURS),
    ])
});

/// Combines named parts into one statement, and renumbers the parameters of each part.
fn of_parts(parts: &[(&str, &str)]) -> String {
    let mut first = 0;
    let parts: Vec<String> = parts
        .iter()
        .map(|(name, sql)| {
            let mut pieces = sql.split('$');
            let mut whole = pieces.next().unwrap_or_default().to_owned();
            let before = first;
            for piece in pieces {
                let digits = piece.find(|c: char| !c.is_ascii_digit()).unwrap_or(piece.len());
                let number = before + piece[..digits].parse::<usize>().unwrap_or_default();
                first = first.max(number);
                whole += &format!("${number}{}", &piece[digits..]);
            }
            format!("{name} AS ({})", whole.replace("OWNED", "EXISTS (SELECT FROM counted)"))
        })
        .collect();
    let written = |name| if parts.iter().any(|part| part.starts_with(name)) { name } else { "counted" };
    format!(
        "WITH {} SELECT (SELECT count(*) FROM counted), (SELECT count(*) FROM {}), (SELECT count(*) FROM {})",
        parts.join(", "),
        written("minutes_new"),
        written("hours_new")
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_statement_have_parameters_of_their_own() {
        let parts = [
            ("counted", "UPDATE a SET b = $2 WHERE c = $1 RETURNING c"),
            ("next", "DELETE FROM d WHERE e = $1 AND OWNED"),
        ];
        assert_eq!(
            of_parts(&parts),
            "WITH counted AS (UPDATE a SET b = $2 WHERE c = $1 RETURNING c), \
             next AS (DELETE FROM d WHERE e = $3 AND EXISTS (SELECT FROM counted)) SELECT (SELECT count(*) FROM counted), \
             (SELECT count(*) FROM counted), (SELECT count(*) FROM counted)"
        );
    }

    #[test]
    fn no_part_is_written_without_the_lease() {
        for sql in [&*KEPT, &*ORDINARY, &*WHOLE] {
            let (parts, gates) = (
                sql.matches(" AS (INSERT").count()
                    + sql.matches(" AS (UPDATE").count()
                    + sql.matches(" AS (DELETE").count(),
                sql.matches("EXISTS (SELECT FROM counted)").count(),
            );
            assert!(parts > 1 && gates == parts - 1, "{parts} parts, {gates} conditions");
        }
    }
}
