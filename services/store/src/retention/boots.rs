//! Removal of boots to which nothing refers any more.

use super::partitions::{self, CONTACTS, DAY_US};
use super::{Done, ROWS};
use crate::database::{Either, Tx};
use crate::{Store, StoreError, failed};

/// Former boots of each robot, the newest ones left out, beginning with its oldest; `$1` is the time before which a boot must
/// have been seen. Contacts refer to the newest 4 boots of their time alone, because the core refuses those of earlier ones. So
/// no contact after the fourth successor of a boot was seen refers to the boot. The state of the robot must have been stored
/// since, because the journal refers to boots, too. There is no search in the contacts: they have no index of the boot.
const FORMER: &str = "SELECT boot FROM (SELECT boot, row_number() OVER (PARTITION BY robot_id ORDER BY boot DESC) AS place \
     FROM boots b WHERE first_seen_us < $1 AND \
     first_seen_us < (SELECT updated_us FROM robots r WHERE r.robot_id = b.robot_id)) p WHERE place > 4 LIMIT $2";
/// The oldest contact that is left.
const OLDEST: &str = "SELECT min(received_us) FROM contacts";

/// A time of receipt that no contact is older than, as [`Store::oldest_contact`], within a transaction.
pub(crate) async fn oldest_contact(tx: &mut Tx<'_>) -> sqlx::Result<Option<i64>> {
    match tx {
        Either::Sqlite(tx) => sqlx::query_scalar(OLDEST).fetch_one(&mut **tx).await,
        Either::Postgres(tx) => partitions::oldest(tx, &CONTACTS).await,
    }
}

impl Store {
    /// A time of receipt that no contact is older than, µs since 1970 UTC; none without contacts.
    pub(crate) async fn oldest_contact(&self) -> Result<Option<i64>, StoreError> {
        const WHAT: &str = "look for the oldest contact";
        match &self.pool {
            Either::Sqlite(pool) => sqlx::query_scalar(OLDEST).fetch_one(pool).await.map_err(failed(WHAT)),
            Either::Postgres(_) => {
                let Either::Postgres(mut link) = self.options.connect(WHAT).await? else { return Ok(None) };
                let oldest = partitions::oldest(&mut link, &CONTACTS).await.map_err(failed(WHAT));
                super::close(link).await;
                oldest
            }
        }
    }

    /// Deletes boots to which no contact and no journal refers, some thousand at once, except the newest 4 of each robot.
    /// Returns whether there may be more.
    pub(super) async fn forget_boots(&self, now_us: i64, report: &mut impl FnMut(Done)) -> Result<bool, StoreError> {
        const WHAT: &str = "delete former boots";
        let oldest = self.oldest_contact().await?;
        // A connection of its own, which is closed: SQLite would search all contacts for each boot to check the foreign key.
        let link = self.options.connect(WHAT).await?;
        let removed = match link {
            Either::Sqlite(mut link) => {
                let removed = async {
                    sqlx::query("PRAGMA foreign_keys = OFF").execute(&mut link).await?;
                    let sql = sqlx::AssertSqlSafe(format!("DELETE FROM boots WHERE boot IN ({FORMER})"));
                    sqlx::query(sql).bind(seen_before(oldest, now_us)).bind(ROWS).execute(&mut link).await
                };
                let rows = removed.await.map_err(failed(WHAT))?.rows_affected();
                // All work is committed, so an error does not matter.
                let _ = sqlx::Connection::close(link).await;
                rows
            }
            Either::Postgres(mut link) => {
                let removed = async {
                    let sql = sqlx::AssertSqlSafe(format!("DELETE FROM boots WHERE boot IN ({FORMER})"));
                    sqlx::query(sql).bind(seen_before(oldest, now_us)).bind(ROWS).execute(&mut link).await
                };
                let rows = removed.await.map_err(failed(WHAT))?.rows_affected();
                super::close(link).await;
                rows
            }
        };
        if removed > 0 {
            report(Done::Removed { table: "boots", rows: removed });
        }
        Ok(removed >= ROWS as u64)
    }
}

/// Time before which the fourth successor of a boot was seen: before each contact, by a day more for clocks that were set back.
fn seen_before(oldest_us: Option<i64>, now_us: i64) -> i64 {
    oldest_us.unwrap_or(now_us).min(now_us).saturating_sub(DAY_US)
}
