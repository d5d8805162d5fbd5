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

/// Subquery of the alarms that meet a condition, each with whether it is standing, and until when alarms of its kind about
/// its whisker or robot are shelved.
macro_rules! alarms {
    ($condition:literal) => {
        concat!(
            "(SELECT a.alarm_id, a.whisker_id, a.robot_id, a.raised_us, a.kind, a.cleared_us, a.acknowledged_us, \
             a.acknowledged_by, a.acknowledged_reason, \
             CASE WHEN a.cleared_us IS NULL THEN true ELSE false END AS standing, \
             CASE WHEN h.until_us > {now_us} THEN h.until_us END AS shelved_until_us, \
             CASE WHEN h.until_us > {now_us} THEN h.shelved_by END AS shelved_by, \
             CASE WHEN h.until_us > {now_us} THEN h.reason END AS shelved_reason \
             FROM alarms a LEFT JOIN alarm_shelves h ON h.alarm_shelf_id = coalesce(\
              (SELECT max(alarm_shelf_id) FROM alarm_shelves n WHERE n.whisker_id = a.whisker_id AND n.kind = a.kind), \
              (SELECT max(alarm_shelf_id) FROM alarm_shelves n WHERE n.robot_id = a.robot_id AND n.kind = a.kind)) \
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
