//! Counts of whiskers, alarms and proposals as parts of statements, so that robots, arrays and fleets count alike.

/// Subquery that counts the whiskers on robots that are not sound, grouped by a column of `whiskers`. They
/// are few, and the index `whiskers_in_need` has all that is counted: a row of `whiskers` is long. Each of them is in exactly
/// one of the counts `learning`, `worn`, `compensated`, `faulty` and `uncompensated`; `trimmed` is a count beside them.
macro_rules! need_counts {
    ($key:literal) => {
        concat!(
            "(SELECT ",
            $key,
            ", count(*) AS whiskers_unsound, \
             count(*) FILTER (WHERE condition = 'TRIMMED') AS whiskers_trimmed, \
             count(*) FILTER (WHERE condition = 'LEARNING' AND fault IS NULL) AS whiskers_learning, \
             count(*) FILTER (WHERE condition IN ('SUSPECTED', 'ERODING', 'SENSITIVITY_LOSS') AND fault IS NULL) \
              AS whiskers_worn, \
             count(*) FILTER (WHERE condition = 'TRIMMED' AND served IS NOT NULL AND fault IS NULL) \
              AS whiskers_compensated, \
             count(*) FILTER (WHERE condition = 'TRIMMED' AND served IS NULL) AS whiskers_uncompensated, \
             count(*) FILTER (WHERE fault IS NOT NULL AND NOT (condition = 'TRIMMED' AND served IS NULL)) \
              AS whiskers_faulty \
             FROM whiskers w LEFT JOIN (SELECT DISTINCT target_whisker_id AS served FROM compensations \
              WHERE ended_us IS NULL AND compensator_whisker_id IS NOT NULL AND approval <> 'PROPOSED') c \
              ON c.served = w.whisker_id \
             WHERE position IS NOT NULL AND (condition <> 'HEALTHY' OR fault IS NOT NULL) GROUP BY ",
            $key,
            ")"
        )
    };
}
pub(super) use need_counts;

/// Subquery of the robots in maintenance, each with the window that ends last. `MaintenanceRow::at` computes the same.
macro_rules! in_maintenance {
    () => {
        "(SELECT robot_id, maintenance_id, set_by, reason, until_us FROM (\
          SELECT u.*, row_number() OVER (PARTITION BY robot_id ORDER BY until_us DESC, maintenance_id) AS place FROM (\
           SELECT robot_id, maintenance_id, set_by, reason, \
            CASE WHEN ended_us < ends_us THEN ended_us ELSE ends_us END AS until_us FROM (\
            SELECT r.robot_id, v.maintenance_id, v.set_by, v.reason, v.ended_us, {now_us} + v.lasts_us \
             - ({now_us} - v.begins_us) % coalesce(v.repeat_us, 9223372036854775807) AS ends_us \
            FROM maintenance v JOIN robots r ON r.fleet = v.fleet AND (v.robot_id IS NULL OR v.robot_id = r.robot_id) \
            WHERE v.begins_us <= {now_us}) e) u WHERE until_us > {now_us}) k WHERE place = 1)"
    };
}
pub(super) use in_maintenance;

/// Subquery of the alarms that meet a condition, each with whether it is standing, and until when it is shelved: by a person,
/// with the others of its kind about its whisker or robot, or by a window of maintenance, whichever ends later.
macro_rules! alarms {
    ($condition:literal) => {
        concat!(
            "(SELECT a.alarm_id, a.whisker_id, a.robot_id, a.raised_us, a.kind, a.cleared_us, a.acknowledged_us, \
             a.acknowledged_by, a.acknowledged_reason, \
             CASE WHEN a.cleared_us IS NULL THEN true ELSE false END AS standing, \
             CASE WHEN m.until_us >= h.until_us OR h.until_us IS NULL THEN m.until_us ELSE h.until_us END AS shelved_until_us, \
             CASE WHEN m.until_us >= h.until_us OR h.until_us IS NULL THEN m.set_by ELSE h.shelved_by END AS shelved_by, \
             CASE WHEN m.until_us >= h.until_us OR h.until_us IS NULL THEN m.reason ELSE h.reason END AS shelved_reason, \
             CASE WHEN m.until_us >= h.until_us OR h.until_us IS NULL THEN m.maintenance_id END AS maintenance_id \
             FROM alarms a LEFT JOIN alarm_shelves h ON h.alarm_shelf_id = coalesce(\
              (SELECT max(alarm_shelf_id) FROM alarm_shelves n WHERE n.whisker_id = a.whisker_id AND n.kind = a.kind), \
              (SELECT max(alarm_shelf_id) FROM alarm_shelves n WHERE n.robot_id = a.robot_id AND n.kind = a.kind)) \
             AND h.until_us > {now_us} \
             LEFT JOIN ",
            $crate::lists::counts::in_maintenance!(),
            " m ON m.robot_id = coalesce(a.robot_id, (SELECT mw.robot_id FROM whiskers mw WHERE mw.whisker_id = a.whisker_id)) \
             WHERE ",
            $condition,
            ")"
        )
    };
}
pub(super) use alarms;

/// Expression for the connection state of the robot with this alias: `SILENT` if it is connected and the alarm about its silence
/// stands, shelved or not.
macro_rules! presence {
    ($robots:literal) => {
        concat!(
            "CASE WHEN ",
            $robots,
            ".connection = 'ONLINE' AND EXISTS (SELECT 1 FROM alarms z WHERE z.robot_id = ",
            $robots,
            ".robot_id AND z.kind = 'ROBOT_SILENT' AND z.cleared_us IS NULL) THEN 'SILENT' ELSE ",
            $robots,
            ".connection END"
        )
    };
}
pub(super) use presence;

/// Subquery that counts the standing alarms, shelved and others, grouped by a column of `robots` or `whiskers`.
macro_rules! alarm_counts {
    ($key:literal) => {
        concat!(
            "(SELECT ",
            $key,
            ", count(*) FILTER (WHERE shelved_until_us IS NULL) AS alarms, \
             count(*) FILTER (WHERE shelved_until_us IS NOT NULL) AS alarms_shelved FROM ",
            $crate::lists::counts::alarms!("a.cleared_us IS NULL"),
            " s LEFT JOIN whiskers w ON w.whisker_id = s.whisker_id \
             JOIN robots r ON r.robot_id = coalesce(s.robot_id, w.robot_id) GROUP BY ",
            $key,
            ")"
        )
    };
}
pub(super) use alarm_counts;

/// Subquery that counts the compensations that wait for approval, grouped by a column of `robots`.
macro_rules! proposal_counts {
    ($key:literal) => {
        concat!(
            "(SELECT ",
            $key,
            ", count(*) AS proposals FROM compensations c JOIN robots r ON r.robot_id = c.robot_id \
             WHERE approval = 'PROPOSED' AND ended_us IS NULL GROUP BY ",
            $key,
            ")"
        )
    };
}
pub(super) use proposal_counts;
