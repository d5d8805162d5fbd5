//! Retention of all tables ([`tables`]): old rows are deleted in pieces so small that no commit waits for them.

use sqlx::PgConnection;

mod boots;
mod done;
pub(super) mod partitions;
mod records;
pub mod tables;
#[cfg(test)]
mod tests;

pub(crate) use boots::oldest_contact;
pub use done::Done;

use super::database::Either;
use super::{Store, StoreError, failed};
use partitions::{CONTACTS, DAY_US, MINUTES};

/// Retention times in days; 0 stands for unlimited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Retention {
    /// Retention of contacts, days.
    pub contacts_days: u32,
    /// Retention of the aggregates of minutes, days.
    pub minutes_days: u32,
    /// Retention of black boxes, days.
    pub black_boxes_days: u32,
    /// Retention of cleared alarms, changes of health and other finished records, days.
    pub records_days: u32,
}

impl Default for Retention {
    fn default() -> Self {
        Self { contacts_days: 30, minutes_days: 400, black_boxes_days: 90, records_days: 400 }
    }
}

/// Most rows that SQLite deletes at once.
const ROWS: i64 = 2000;
/// Most black boxes that are deleted at once: each has some ten kilobytes.
const BOXES: i64 = 100;

/// SQLite's contacts and minutes before `$1`, at most `$2`.
const OLD_CONTACTS: &str = "DELETE FROM contacts WHERE contact_id IN \
     (SELECT contact_id FROM contacts WHERE received_us < $1 ORDER BY received_us LIMIT $2)";
const OLD_MINUTES: &str = "DELETE FROM contact_minutes WHERE (whisker_id, start_us) IN \
     (SELECT whisker_id, start_us FROM contact_minutes WHERE start_us < $1 ORDER BY start_us LIMIT $2)";

/// Time before which rows are too old, µs since 1970 UTC; `None` for unlimited retention.
fn kept_from(now_us: i64, days: u32) -> Option<i64> {
    (days > 0).then(|| now_us - i64::from(days) * DAY_US)
}

impl Store {
    /// Creates PostgreSQL's partitions of the present and the next span; SQLite has none.
    ///
    /// # Errors
    /// The database cannot be written, or a query of a whole table lasts too long. Rows go to the default partition
    /// meanwhile; try again later.
    pub async fn make_partitions(&self, now_us: i64, report: &mut impl FnMut(Done)) -> Result<(), StoreError> {
        const WHAT: &str = "create partitions";
        match &self.pool {
            Either::Sqlite(_) => Ok(()),
            Either::Postgres(pool) => {
                let mut link = pool.acquire().await.map_err(failed(WHAT))?;
                partitions::make(&mut link, now_us, report).await.map_err(failed(WHAT))
            }
        }
    }

    /// Deletes rows that are too old: black boxes, whole partitions in PostgreSQL, some thousand rows in SQLite. No contact is
    /// deleted before it is archived, if there is an archive. Returns whether there may be more.
    ///
    /// # Errors
    /// The database cannot be written or is too busy; try again later.
    pub async fn look_after(
        &self,
        retention: Retention,
        now_us: i64,
        report: &mut impl FnMut(Done),
    ) -> Result<bool, StoreError> {
        const WHAT: &str = "delete old rows";
        let mut contacts_us = kept_from(now_us, retention.contacts_days);
        if let (Some(before_us), Some(archived_us)) = (&mut contacts_us, self.archived_before().await?) {
            *before_us = archived_us.min(*before_us);
        }
        let minutes_us = kept_from(now_us, retention.minutes_days);
        let mut is_more = false;
        if let Some(before_us) = kept_from(now_us, retention.black_boxes_days) {
            let rows = self.remove_black_boxes(before_us, BOXES).await.map_err(failed(WHAT))?;
            if rows > 0 {
                report(Done::Removed { table: "black_boxes", rows });
            }
            is_more = rows == BOXES as u64;
        }
        is_more |=
            self.remove_records(kept_from(now_us, retention.records_days), report).await.map_err(failed(WHAT))?;
        is_more |= self.forget_absent_whiskers(now_us, report).await.map_err(failed(WHAT))?;
        is_more |= self.forget_boots(now_us, report).await?;
        match &self.pool {
            Either::Sqlite(_) => {
                let more_rows = self.remove_some([contacts_us, minutes_us], report).await.map_err(failed(WHAT))?;
                Ok(more_rows || is_more)
            }
            Either::Postgres(_) => {
                // A separate connection: if this future is dropped, the connection and with it the advisory lock are
                // closed.
                let link = self.options.connect(WHAT).await?;
                let Either::Postgres(mut link) = link else { return Ok(is_more) };
                let before = [(&CONTACTS, contacts_us), (&MINUTES, minutes_us)];
                let done = partitions::look_after(&mut link, now_us, before, report).await;
                close(link).await;
                done.map_err(failed(WHAT)).map(|()| is_more)
            }
        }
    }

    /// Deletes the oldest rows of each table, which an index finds by their time.
    async fn remove_some(&self, before: [Option<i64>; 2], report: &mut impl FnMut(Done)) -> sqlx::Result<bool> {
        let Either::Sqlite(pool) = &self.pool else { return Ok(false) };
        let mut is_more = false;
        for (table, sql, before_us) in
            [("contacts", OLD_CONTACTS, before[0]), ("contact_minutes", OLD_MINUTES, before[1])]
        {
            let Some(before_us) = before_us else { continue };
            let rows = sqlx::query(sql).bind(before_us).bind(ROWS).execute(pool).await?.rows_affected();
            if rows > 0 {
                report(Done::Removed { table, rows });
            }
            is_more |= rows == ROWS as u64;
        }
        Ok(is_more)
    }
}

/// Time after which a robot that was only announced is deleted, µs.
const ANNOUNCED_US: i64 = DAY_US;
/// Most such robots that are deleted at once: PostgreSQL searches other tables for each.
const ROBOTS: i64 = 500;

impl Store {
    /// Deletes robots of which no factsheet, boot or array is known. Earlier versions of the program inserted a row
    /// for each robot that announced itself. Returns whether there may be more.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn forget_announced(&self, now_us: i64, report: &mut impl FnMut(Done)) -> Result<bool, StoreError> {
        const SQL: &str = "DELETE FROM robots WHERE robot_id IN (SELECT robot_id FROM robots r \
             WHERE updated_us < $1 AND model IS NULL AND NOT held \
             AND NOT EXISTS (SELECT 1 FROM boots b WHERE b.robot_id = r.robot_id) \
             AND NOT EXISTS (SELECT 1 FROM arrays a WHERE a.robot_id = r.robot_id) LIMIT $2)";
        let before_us = now_us - ANNOUNCED_US;
        let rows = super::database::on!(&self.pool, |pool| sqlx::query(SQL)
            .bind(before_us)
            .bind(ROBOTS)
            .execute(pool)
            .await
            .map(|done| done.rows_affected()))
        .map_err(failed("delete robots that were only announced"))?;
        if rows > 0 {
            report(Done::Removed { table: "robots", rows });
        }
        Ok(rows == ROBOTS as u64)
    }
}

async fn close(link: PgConnection) {
    // All work is committed, so an error does not matter.
    let _ = sqlx::Connection::close(link).await;
}
