//! Removal of finished records, and of whiskers that were never used.

use sqlx::{AssertSqlSafe, SqlSafeStr as _};

use super::partitions::DAY_US;
use super::{Done, ROWS};
use crate::Store;
use crate::database::{Either, on};

/// The oldest rows of tables whose causes are over: `$1` is the time before which they are too old, `$2` the most rows, and
/// ROW the database's name of a row. The alarm with the highest number stays: SQLite would give the number to another one, and
/// events and links name it. An index finds them by their time: the first numbers may be of a time at which the clock
/// was ahead. CROSS JOIN makes SQLite begin with the few compensations.
pub(super) const RECORDS: [(&str, &str); 10] = [
    (
        "alarms",
        "alarm_id IN (SELECT alarm_id FROM alarms WHERE raised_us < $1 AND cleared_us < $1 \
         AND alarm_id < (SELECT max(alarm_id) FROM alarms) ORDER BY raised_us, alarm_id LIMIT $2)",
    ),
    (
        "health_changes",
        "health_change_id IN (SELECT health_change_id FROM health_changes WHERE recorded_us < $1 \
         ORDER BY recorded_us LIMIT $2)",
    ),
    (
        "touch_tests",
        "touch_test_id IN (SELECT touch_test_id FROM touch_tests WHERE ended_us < $1 ORDER BY ended_us LIMIT $2)",
    ),
    (
        "alarm_shelves",
        "alarm_shelf_id IN (SELECT alarm_shelf_id FROM alarm_shelves WHERE until_us < $1 ORDER BY until_us LIMIT $2)",
    ),
    // All of ended compensations, and old ones of those in force, by the robot's clock: a day more.
    (
        "compensation_responses",
        "ROW IN (SELECT r.ROW FROM compensations c CROSS JOIN compensation_responses r \
         WHERE r.compensation_id = c.compensation_id \
         AND r.t_us < CASE WHEN c.ended_us < $1 THEN 9223372036854775807 ELSE $1 - 86400000000 END LIMIT $2)",
    ),
    // The newest measurement and evaluation of each compensation stay, whose pages show them. The index of each compensation is in
    // the order of time. Those of a time at which the clock was ahead are not newer. Bins go before their measurements, which the
    // database demands.
    (
        "compensation_error_bins",
        "compensation_error_id IN (SELECT e.compensation_error_id FROM compensations c CROSS JOIN compensation_errors e \
         WHERE e.compensation_id = c.compensation_id AND e.recorded_us < $1 AND EXISTS (SELECT 1 FROM compensation_errors n \
         WHERE n.compensation_id = e.compensation_id AND n.recorded_us > e.recorded_us \
         AND n.compensation_error_id > e.compensation_error_id) AND EXISTS (SELECT 1 \
         FROM compensation_error_bins b WHERE b.compensation_error_id = e.compensation_error_id) LIMIT $2)",
    ),
    (
        "compensation_errors",
        "compensation_error_id IN (SELECT e.compensation_error_id FROM compensations c CROSS JOIN compensation_errors e \
         WHERE e.compensation_id = c.compensation_id AND e.recorded_us < $1 AND EXISTS (SELECT 1 FROM compensation_errors n \
         WHERE n.compensation_id = e.compensation_id AND n.recorded_us > e.recorded_us \
         AND n.compensation_error_id > e.compensation_error_id) AND NOT EXISTS (SELECT 1 \
         FROM compensation_error_bins b WHERE b.compensation_error_id = e.compensation_error_id) LIMIT $2)",
    ),
    (
        "compensation_refinements",
        "compensation_refinement_id IN (SELECT e.compensation_refinement_id FROM compensations c \
         CROSS JOIN compensation_refinements e WHERE e.compensation_id = c.compensation_id AND e.recorded_us < $1 AND EXISTS \
         (SELECT 1 FROM compensation_refinements n WHERE n.compensation_id = e.compensation_id \
         AND n.recorded_us > e.recorded_us AND n.compensation_refinement_id > e.compensation_refinement_id) LIMIT $2)",
    ),
    // Setpoints of compensations in force stay. States go before their setpoints, which the database demands.
    (
        "setpoint_states",
        "command_id IN (SELECT command_id FROM setpoints s WHERE issued_us < $1 AND (compensation_id IS NULL \
         OR EXISTS (SELECT 1 FROM compensations c WHERE c.compensation_id = s.compensation_id AND c.ended_us < $1)) \
         ORDER BY issued_us LIMIT $2)",
    ),
    (
        "setpoints",
        "command_id IN (SELECT command_id FROM setpoints s WHERE issued_us < $1 AND (compensation_id IS NULL \
         OR EXISTS (SELECT 1 FROM compensations c WHERE c.compensation_id = s.compensation_id AND c.ended_us < $1)) \
         AND NOT EXISTS (SELECT 1 FROM setpoint_states t WHERE t.command_id = s.command_id) \
         ORDER BY issued_us LIMIT $2)",
    ),
];

/// Time after which a whisker that is on no layout is removed if it was never used, µs.
const ABSENT_US: i64 = DAY_US;
/// Most such whiskers that are removed at once: the database searches other tables for each.
const WHISKERS: i64 = 500;

/// Tables whose rows keep a whisker, each with its column.
const USES: [(&str, &str); 9] = [
    ("contacts", "whisker_id"),
    ("contact_minutes", "whisker_id"),
    ("trims", "whisker_id"),
    ("compensations", "target_whisker_id"),
    ("compensations", "compensator_whisker_id"),
    ("compensation_candidates", "whisker_id"),
    ("setpoints", "whisker_id"),
    ("touch_tests", "whisker_id"),
    ("black_boxes", "whisker_id"),
];

/// The statement that deletes rows of a table. `row` is the database's name of a row.
pub(super) fn removal(table: &str, which: &str, row: &str) -> String {
    format!("DELETE FROM {table} WHERE {}", which.replace("ROW", row))
}

impl Store {
    /// Deletes records that are over and too old, some thousand of each table. Returns whether there may be more.
    pub(super) async fn remove_records(
        &self,
        before_us: Option<i64>,
        report: &mut impl FnMut(Done),
    ) -> sqlx::Result<bool> {
        let (Some(before_us), mut is_more) = (before_us, false) else { return Ok(false) };
        let row = match &self.pool {
            Either::Sqlite(_) => "rowid",
            Either::Postgres(_) => "ctid",
        };
        for (table, which) in RECORDS {
            let sql = AssertSqlSafe(removal(table, which, row));
            let rows = on!(&self.pool, |pool| sqlx::query(sql)
                .bind(before_us)
                .bind(ROWS)
                .execute(pool)
                .await
                .map(|done| done.rows_affected()))?;
            if rows > 0 {
                report(Done::Removed { table, rows });
            }
            is_more |= rows >= ROWS as u64;
        }
        Ok(is_more)
    }

    /// Deletes whiskers that are on no layout for a day and were never used, with their changes of health, alarms and hours,
    /// and arrays without whiskers. Returns whether there may be more.
    pub(super) async fn forget_absent_whiskers(
        &self,
        now_us: i64,
        report: &mut impl FnMut(Done),
    ) -> sqlx::Result<bool> {
        let unused = USES
            .map(|(table, column)| format!("AND NOT EXISTS (SELECT 1 FROM {table} u WHERE u.{column} = w.whisker_id)"));
        // SQLite gives the highest number again if its row is removed, but events still name the whisker or the alarm.
        const NEWEST: &str = "AND whisker_id < (SELECT max(whisker_id) FROM whiskers) AND NOT EXISTS (SELECT 1 FROM alarms a \
             WHERE a.whisker_id = w.whisker_id AND a.alarm_id = (SELECT max(alarm_id) FROM alarms))";
        // An owner may be putting a whisker on a layout again: its row stays.
        let free = match &self.pool {
            Either::Sqlite(_) => "",
            Either::Postgres(_) => "FOR UPDATE OF w SKIP LOCKED",
        };
        let absent = AssertSqlSafe(format!(
            "SELECT whisker_id FROM whiskers w WHERE absent_us < $1 AND position IS NULL {} {NEWEST} ORDER BY absent_us LIMIT $2 \
             {free}",
            unused.join(" ")
        ));
        let mut tx = self.pool.begin().await?;
        let before_us = now_us - ABSENT_US;
        let whiskers: Vec<i64> =
            on!(&mut tx, |tx| sqlx::query_scalar(absent).bind(before_us).bind(WHISKERS).fetch_all(&mut **tx).await)?;
        if whiskers.is_empty() {
            return Ok(false);
        }
        // The list contains only numbers, no text from outside.
        let list: Vec<String> = whiskers.iter().map(i64::to_string).collect();
        let of_whiskers = ["health_changes", "alarms", "alarm_shelves", "contact_hours", "whiskers"]
            .map(|table| format!("DELETE FROM {table} WHERE whisker_id IN ({})", list.join(", ")));
        let of_arrays =
            "DELETE FROM arrays WHERE NOT EXISTS (SELECT 1 FROM whiskers w WHERE w.array_id = arrays.array_id)";
        for sql in of_whiskers.into_iter().chain([of_arrays.to_owned()]) {
            let sql = AssertSqlSafe(sql).into_sql_str();
            on!(&mut tx, |tx| sqlx::query(sql).persistent(false).execute(&mut **tx).await.map(drop))?;
        }
        tx.commit().await?;
        report(Done::Removed { table: "whiskers", rows: whiskers.len() as u64 });
        Ok(whiskers.len() as i64 == WHISKERS)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tables::{Kept, TABLES};
    use super::*;

    #[test]
    fn regress_each_table_with_finished_records_is_emptied() {
        let kept = TABLES.iter().filter(|(_, kept)| *kept == Kept::Days("records.days")).map(|(table, _)| *table);
        let (mut kept, mut emptied): (Vec<&str>, Vec<&str>) = (kept.collect(), RECORDS.map(|(table, _)| table).into());
        kept.sort_unstable();
        emptied.sort_unstable();
        assert_eq!(kept, emptied);
    }
}
