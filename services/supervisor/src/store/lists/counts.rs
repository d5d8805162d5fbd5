//! What robots, arrays and fleets are counted by: parts of statements, so that all count alike.

/// Whiskers that are on a robot, counted by a column of robots or whiskers.
macro_rules! whisker_counts {
    ($key:literal) => {
        concat!(
            "(SELECT ",
            $key,
            ", count(*) AS whiskers, \
             count(*) FILTER (WHERE condition = 'HEALTHY' AND fault IS NULL) AS whiskers_healthy, \
             count(*) FILTER (WHERE condition = 'TRIMMED') AS whiskers_trimmed, \
             count(*) FILTER (WHERE condition = 'TRIMMED' AND served IS NULL) AS whiskers_uncompensated, \
             count(*) FILTER (WHERE fault IS NOT NULL) AS whiskers_faulty \
             FROM whiskers w JOIN robots r ON r.robot_id = w.robot_id \
             LEFT JOIN (SELECT DISTINCT target_whisker_id AS served FROM compensations \
              WHERE ended_us IS NULL AND compensator_whisker_id IS NOT NULL) c ON c.served = w.whisker_id \
             WHERE position IS NOT NULL GROUP BY ",
            $key,
            ")"
        )
    };
}
pub(super) use whisker_counts;

/// Alarms with whether they stand: the newest of its kind about its whisker, whose cause is there still. Shifts of an
/// array and drifts of a baseline are told once, and do not stand.
macro_rules! alarms {
    () => {
        "(SELECT a.alarm_id, a.whisker_id, a.raised_us, a.kind, CASE WHEN position IS NOT NULL \
         AND NOT EXISTS (SELECT 1 FROM alarms n \
          WHERE n.whisker_id = a.whisker_id AND n.kind = a.kind AND n.alarm_id > a.alarm_id) \
         AND (w.fault = a.kind OR w.condition = a.kind \
          OR a.kind = 'UNCOMPENSATED' AND w.condition = 'TRIMMED' AND NOT EXISTS (SELECT 1 FROM compensations c \
           WHERE c.target_whisker_id = a.whisker_id AND c.ended_us IS NULL AND c.compensator_whisker_id IS NOT NULL) \
          OR a.kind = 'SETPOINT_FAILED' AND (SELECT s.state FROM setpoints s WHERE s.whisker_id = a.whisker_id \
           ORDER BY s.issued_us DESC, s.version DESC LIMIT 1) IN ('FAILED', 'REJECTED', 'EXPIRED')) \
         THEN true ELSE false END AS standing FROM alarms a JOIN whiskers w ON w.whisker_id = a.whisker_id)"
    };
}
pub(super) use alarms;

/// Standing alarms, counted by a column of robots or whiskers.
macro_rules! alarm_counts {
    ($key:literal) => {
        concat!(
            "(SELECT ",
            $key,
            ", count(*) AS alarms FROM ",
            $crate::store::lists::counts::alarms!(),
            " s JOIN whiskers w ON w.whisker_id = s.whisker_id JOIN robots r ON r.robot_id = w.robot_id \
             WHERE standing GROUP BY ",
            $key,
            ")"
        )
    };
}
pub(super) use alarm_counts;
