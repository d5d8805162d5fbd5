//! How long what whiskers felt is kept: old contacts and minutes are removed in pieces that no commit waits for.

use sqlx::PgConnection;

use super::database::Either;
use super::partitions::{self, CONTACTS, DAY_US, MINUTES};
use super::{Store, StoreError, failed};

/// For how many days what is kept; 0 is for ever.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Retention {
    /// Contacts.
    pub contacts_days: u32,
    /// Minutes of whiskers.
    pub minutes_days: u32,
}

impl Default for Retention {
    fn default() -> Self {
        Self { contacts_days: 30, minutes_days: 400 }
    }
}

/// Something that was done to keep the tables in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Done {
    /// A partition was made.
    Made {
        /// Which.
        partition: String,
    },
    /// A partition that is over got its index.
    Indexed {
        /// Which.
        partition: String,
    },
    /// A partition was dropped, because all of it was too old.
    Dropped {
        /// Which.
        partition: String,
        /// Its size, with its indices.
        bytes: i64,
    },
    /// Rows were removed, because they were too old.
    Removed {
        /// Where.
        table: &'static str,
        /// How many.
        rows: u64,
    },
}

/// Rows that SQLite removes at once.
const ROWS: i64 = 2000;

/// From when on it is kept.
fn kept_from(now_us: i64, days: u32) -> Option<i64> {
    (days > 0).then(|| now_us - i64::from(days) * DAY_US)
}

impl Store {
    /// Makes PostgreSQL's partitions of now and of the next day; SQLite has none.
    ///
    /// # Errors
    /// The database cannot be written, or somebody reads a whole table for too long: rows go to the default partition
    /// meanwhile, and it is to be tried again.
    pub async fn make_partitions(&self, now_us: i64, told: &mut impl FnMut(Done)) -> Result<(), StoreError> {
        const WHAT: &str = "make partitions";
        match &self.pool {
            Either::Sqlite(_) => Ok(()),
            Either::Postgres(pool) => {
                let mut link = pool.acquire().await.map_err(failed(WHAT))?;
                partitions::make(&mut link, now_us, told).await.map_err(failed(WHAT))
            }
        }
    }

    /// Removes what is too old: partitions in PostgreSQL, some thousand rows in SQLite. True if there is more of it.
    ///
    /// # Errors
    /// The database cannot be written, or is too busy: it is to be tried again later.
    pub async fn look_after(
        &self,
        retention: Retention,
        now_us: i64,
        told: &mut impl FnMut(Done),
    ) -> Result<bool, StoreError> {
        const WHAT: &str = "remove what is old";
        let contacts_us = kept_from(now_us, retention.contacts_days);
        let minutes_us = kept_from(now_us, retention.minutes_days);
        match &self.pool {
            Either::Sqlite(_) => self.remove_some([contacts_us, minutes_us], told).await.map_err(failed(WHAT)),
            Either::Postgres(_) => {
                // A connection of its own, which takes its lock along if this is given up.
                let link = self.options.connect().await.map_err(failed(WHAT))?;
                let Either::Postgres(mut link) = link else { return Ok(false) };
                let before = [(&CONTACTS, contacts_us), (&MINUTES, minutes_us)];
                let done = partitions::look_after(&mut link, now_us, before, told).await;
                close(link).await;
                done.map_err(failed(WHAT)).map(|()| false)
            }
        }
    }

    /// The oldest rows of each table, as they were recorded: contacts without an index of their time, because what was
    /// recorded first lies in front.
    async fn remove_some(&self, before: [Option<i64>; 2], told: &mut impl FnMut(Done)) -> sqlx::Result<bool> {
        const CONTACTS: &str = "DELETE FROM contacts WHERE contact_id IN (SELECT contact_id FROM \
             (SELECT contact_id, received_us FROM contacts ORDER BY contact_id LIMIT $2) c WHERE received_us < $1)";
        const MINUTES: &str = "DELETE FROM contact_minutes WHERE (whisker_id, start_us) IN \
             (SELECT whisker_id, start_us FROM contact_minutes WHERE start_us < $1 ORDER BY start_us LIMIT $2)";
        let Either::Sqlite(pool) = &self.pool else { return Ok(false) };
        let mut is_more = false;
        for (table, sql, before_us) in [("contacts", CONTACTS, before[0]), ("contact_minutes", MINUTES, before[1])] {
            let Some(before_us) = before_us else { continue };
            let rows = sqlx::query(sql).bind(before_us).bind(ROWS).execute(pool).await?.rows_affected();
            if rows > 0 {
                told(Done::Removed { table, rows });
            }
            is_more |= rows == ROWS as u64;
        }
        Ok(is_more)
    }
}

/// A robot that has said no more than that it is there is forgotten after this.
const ANNOUNCED_US: i64 = DAY_US;
/// Such robots that are removed at once: PostgreSQL looks through other tables for each.
const ROBOTS: i64 = 500;

impl Store {
    /// Removes robots of which nothing is known but that they were there: earlier versions of the program made rows of births.
    /// True if there are more.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn forget_announced(&self, now_us: i64, told: &mut impl FnMut(Done)) -> Result<bool, StoreError> {
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
        .map_err(failed("forget robots that were only announced"))?;
        if rows > 0 {
            told(Done::Removed { table: "robots", rows });
        }
        Ok(rows == ROBOTS as u64)
    }
}

async fn close(link: PgConnection) {
    // What is done is committed.
    let _ = sqlx::Connection::close(link).await;
}
