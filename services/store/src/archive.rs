//! The archive's position: up to which time of receipt a fleet's contacts are in files on an object store.
//!
//! The owner of the fleet states a horizon: it will write no contact that was received before. The end of a file is the
//! horizon at most, so the contacts of its span are complete and never change. The span is written down before the file,
//! so that every attempt writes the same contacts under the same name.

use futures_util::TryStreamExt as _;
use sqlx::{Postgres, Row as _, Sqlite};

use super::database::{Either, Tx, on};
use super::export::{CONTACTS, Cell, cell};
use super::from_row::from_row;
use super::model::{Model, none};
use super::retention::oldest_contact;
use super::retention::partitions::DAY_US;
use super::set_aside::Tried;
use super::{Lease, Store, StoreError, Writer, failed};
use std::time::Duration;
use tokio::sync::mpsc;
use tokio::time::timeout;
use vibrissa_protocol::Name;

#[cfg(test)]
mod tests;

/// Time limit for a statement about the position.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time limit for the next contact of a file: without an answer, the server's host may have vanished.
const NEXT_PATIENCE: Duration = Duration::from_secs(600);
/// Number of rows in a group that is sent to their reader.
const GROUP_ROWS: usize = 1024;
/// Longest span of a file, µs, if the archive is behind: an hour, or the usual length if that is more.
const BEHIND_US: i64 = 3_600_000_000;

/// The contacts of a file, by the time of receipt; the end is excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// Begin, µs since 1970 UTC.
    pub from_us: i64,
    /// End, µs since 1970 UTC, on the same day (UTC) or at its end.
    pub to_us: i64,
}

/// Content of an archived file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Archived {
    /// Number of contacts.
    pub contacts: u64,
    /// Length of the file, bytes; 0 for a span without contacts, which has no file.
    pub bytes: u64,
}

from_row! {
    /// A row of `archives`.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    struct Position {
        archived_to_us: i64,
        planned_to_us: Option<i64>,
    }
}

/// The next span after a position, if the contacts up to its end are complete. It has the usual length, ends with the day, and
/// is longer if the archive is behind.
fn next_span(from_us: i64, horizon_us: i64, every_us: i64) -> Option<Span> {
    let day_end_us = (from_us.div_euclid(DAY_US) + 1) * DAY_US;
    let least_us = day_end_us.min(from_us.saturating_add(every_us));
    let most_us = day_end_us.min(from_us.saturating_add(every_us.max(BEHIND_US)));
    (horizon_us >= least_us).then(|| Span { from_us, to_us: horizon_us.min(most_us) })
}

/// The query of contacts for SQLite, which otherwise reads all contacts of each whisker.
fn by_time() -> String {
    CONTACTS.select.replacen("contacts c JOIN", "contacts c INDEXED BY contacts_by_time CROSS JOIN", 1)
}

async fn position(tx: &mut Tx<'_>, fleet: &str) -> sqlx::Result<Option<Position>> {
    const SQL: &str = "SELECT archived_to_us, planned_to_us FROM archives WHERE fleet = $1";
    on!(tx, |tx| sqlx::query_as(SQL).bind(fleet).fetch_optional(&mut **tx).await)
}

async fn horizon(tx: &mut Tx<'_>, fleet: &str) -> sqlx::Result<Option<i64>> {
    const SQL: &str = "SELECT written_to_us FROM archive_horizons WHERE fleet = $1";
    on!(tx, |tx| sqlx::query_scalar(SQL).bind(fleet).fetch_optional(&mut **tx).await)
}

impl Writer {
    /// Time of receipt before which no contact of the fleet may be written any more, µs since 1970 UTC; 0 without an archive.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn archive_floor(&mut self, fleet: &Name) -> Result<i64, StoreError> {
        const WHAT: &str = "read the archive's horizon";
        const SQL: &str = "SELECT coalesce(max(written_to_us), 0) FROM archive_horizons WHERE fleet = $1";
        self.attempt(
            WHAT,
            PATIENCE,
            |model| Ok(model.archive_floor(fleet)),
            async |link| {
                on!(link, |link| sqlx::query_scalar(SQL).bind(fleet.as_str()).fetch_one(link).await)
                    .map_err(failed(WHAT))
            },
        )
        .await
    }

    /// States that the lease's owner will write no contact that was received before `written_to_us`, and that all earlier ones
    /// are committed.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn state_horizon(&mut self, lease: &Lease, written_to_us: i64) -> Result<(), StoreError> {
        const WHAT: &str = "state the archive's horizon";
        const SQL: &str = "INSERT INTO archive_horizons (fleet, written_to_us) VALUES ($1, $2) \
             ON CONFLICT (fleet) DO UPDATE SET written_to_us = excluded.written_to_us \
             WHERE archive_horizons.written_to_us < excluded.written_to_us";
        let model = |model: &mut dyn Model| lease.hold_in(model).map(|model| model.state_horizon(lease, written_to_us));
        self.attempt(WHAT, PATIENCE, model, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            on!(&mut tx, |tx| sqlx::query(SQL)
                .bind(lease.fleet().as_str())
                .bind(written_to_us)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }

    /// The span of the next file: the one that an earlier attempt has begun, or a new one if it is due.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn plan_archive(&mut self, lease: &Lease, every_us: i64) -> Result<Option<Span>, StoreError> {
        const WHAT: &str = "plan a file of the archive";
        const SQL: &str = "UPDATE archives SET planned_to_us = $2 WHERE fleet = $1";
        const BACK: &str = "UPDATE archives SET archived_to_us = $2 WHERE fleet = $1";
        self.attempt(WHAT, PATIENCE, none, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            let fleet = lease.fleet().as_str();
            let horizon_us = horizon(&mut tx, fleet).await.map_err(failed(WHAT))?;
            let mut at = position(&mut tx, fleet).await.map_err(failed(WHAT))?;
            // A clock that was ahead began the archive: no position is beyond the horizon otherwise. It begins anew with the oldest
            // contact. A day more for clocks that were set back.
            if let (Some(at), Some(horizon_us)) = (&mut at, horizon_us)
                && at.archived_to_us > horizon_us
                && at.planned_to_us.is_none()
            {
                let oldest_us = oldest_contact(&mut tx).await.map_err(failed(WHAT))?;
                let least_us = oldest_us.map_or(horizon_us, |oldest_us| oldest_us.min(horizon_us));
                at.archived_to_us = least_us.div_euclid(DAY_US) * DAY_US - DAY_US;
                on!(&mut tx, |tx| sqlx::query(BACK)
                    .bind(fleet)
                    .bind(at.archived_to_us)
                    .execute(&mut **tx)
                    .await
                    .map(drop))
                .map_err(failed(WHAT))?;
            }
            let horizon_us = horizon_us.unwrap_or_default();
            let begun = at.and_then(|at| Some(Span { from_us: at.archived_to_us, to_us: at.planned_to_us? }));
            let new = at.and_then(|at| next_span(at.archived_to_us, horizon_us, every_us));
            if let Some(span) = new.filter(|_| begun.is_none()) {
                on!(&mut tx, |tx| sqlx::query(SQL).bind(fleet).bind(span.to_us).execute(&mut **tx).await.map(drop))
                    .map_err(failed(WHAT))?;
            }
            // Also without a change: an open transaction would hold the lease's row, and block the fleet's commits.
            tx.commit().await.map_err(failed(WHAT))?;
            Ok(begun.or(new))
        })
        .await
    }

    /// Whether a span is still the one to archive. If so, none of its contacts has been deleted yet.
    ///
    /// # Errors
    /// The database cannot be read, or the lease is lost.
    pub async fn is_archive_planned(&mut self, lease: &Lease, span: Span) -> Result<bool, StoreError> {
        const WHAT: &str = "check the plan of the archive";
        self.attempt(WHAT, PATIENCE, none, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            let at = position(&mut tx, lease.fleet().as_str()).await.map_err(failed(WHAT))?;
            tx.rollback().await.map_err(failed(WHAT))?;
            Ok(at.is_some_and(|at| at.archived_to_us == span.from_us && at.planned_to_us == Some(span.to_us)))
        })
        .await
    }

    /// Advances the position over a span whose file is on the object store. Does nothing if that has happened already.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn advance_archive(&mut self, lease: &Lease, span: Span, archived: Archived) -> Result<(), StoreError> {
        const WHAT: &str = "advance the archive's position";
        const SQL: &str = "UPDATE archives SET archived_to_us = $3, planned_to_us = NULL, contacts = contacts + $4, \
             bytes = bytes + $5, files = files + $6 WHERE fleet = $1 AND archived_to_us = $2 AND planned_to_us = $3";
        self.attempt(WHAT, PATIENCE, none, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            on!(&mut tx, |tx| sqlx::query(SQL)
                .bind(lease.fleet().as_str())
                .bind(span.from_us)
                .bind(span.to_us)
                .bind(archived.contacts as i64)
                .bind(archived.bytes as i64)
                .bind(i64::from(archived.bytes > 0))
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }
}

impl Store {
    /// Begins the archives of fleets that have none, with their oldest contacts. From then on no contact of these fleets is
    /// deleted before it is archived.
    ///
    /// # Errors
    /// The database cannot be written.
    pub async fn begin_archives(&self, fleets: &[Name], now_us: i64) -> Result<(), StoreError> {
        const WHAT: &str = "begin the archive";
        // Contacts that are still in a partitioned log were received after the first boot of their robot. A clock that was ahead may
        // have seen the boots, hence the oldest contact; a day more for clocks that were set back.
        const SQL: &str = "INSERT INTO archives (fleet, archived_to_us) SELECT CAST($1 AS TEXT), coalesce(min(CASE WHEN \
             first_seen_us < $2 THEN first_seen_us ELSE $2 END), $2) / $3 * $3 - $3 FROM boots JOIN robots USING (robot_id) \
             WHERE fleet = $1 ON CONFLICT DO NOTHING";
        for fleet in fleets {
            if self.archived_to(fleet).await?.is_some() {
                continue;
            }
            let oldest_us = self.oldest_contact().await?.map_or(now_us, |oldest_us| oldest_us.min(now_us));
            on!(&self.pool, |pool| sqlx::query(SQL)
                .bind(fleet.as_str())
                .bind(oldest_us)
                .bind(DAY_US)
                .execute(pool)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
        }
        Ok(())
    }

    /// Time of receipt before which the contacts of all fleets with an archive are archived, µs since 1970 UTC; `None` if no
    /// fleet has one. 0 if a position is beyond its horizon: a clock that was ahead began that archive, and its owner will
    /// begin it anew.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn archived_before(&self) -> Result<Option<i64>, StoreError> {
        const SQL: &str = "SELECT min(CASE WHEN archived_to_us > coalesce(h.written_to_us, 0) THEN 0 ELSE archived_to_us END) \
             FROM archives a LEFT JOIN archive_horizons h ON h.fleet = a.fleet";
        on!(&self.pool, |pool| sqlx::query_scalar(SQL).fetch_one(pool).await)
            .map_err(failed("read the archive's position"))
    }

    /// The fleet whose archive is furthest behind, and the time of receipt up to which its contacts are archived, µs since 1970
    /// UTC. `None` without an archive.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn last_archive(&self) -> Result<Option<(String, i64)>, StoreError> {
        const SQL: &str = "SELECT fleet, archived_to_us FROM archives ORDER BY archived_to_us, fleet LIMIT 1";
        on!(&self.pool, |pool| sqlx::query_as(SQL).fetch_optional(pool).await)
            .map_err(failed("read the archive's position"))
    }

    /// The fleet whose archive is furthest in the future, and its position, µs since 1970 UTC: a clock was ahead. `None` if no
    /// position is later than `now_us`.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn archive_ahead(&self, now_us: i64) -> Result<Option<(String, i64)>, StoreError> {
        const SQL: &str = "SELECT fleet, archived_to_us FROM archives WHERE archived_to_us > $1 \
             ORDER BY archived_to_us DESC, fleet LIMIT 1";
        on!(&self.pool, |pool| sqlx::query_as(SQL).bind(now_us).fetch_optional(pool).await)
            .map_err(failed("read the archive's position"))
    }

    /// Time of receipt up to which a fleet's contacts are archived, µs since 1970 UTC; `None` without an archive.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn archived_to(&self, fleet: &Name) -> Result<Option<i64>, StoreError> {
        const SQL: &str = "SELECT archived_to_us FROM archives WHERE fleet = $1";
        on!(&self.pool, |pool| sqlx::query_scalar(SQL).bind(fleet.as_str()).fetch_optional(pool).await)
            .map_err(failed("read the archive's position"))
    }

    /// Reads a fleet's contacts of a span, in the columns of [`CONTACTS`], and sends them in groups.
    ///
    /// # Errors
    /// The database cannot be read.
    pub async fn read_span(
        &self,
        fleet: &Name,
        span: Span,
        rows: mpsc::Sender<Vec<Vec<Cell>>>,
    ) -> Result<(), StoreError> {
        const WHAT: &str = "read the contacts to archive";
        // The two arms differ in their types only.
        macro_rules! stream {
            ($link:expr, $database:ty, $select:expr) => {{
                let mut sql = sqlx::QueryBuilder::<$database>::new($select);
                sql.push(" WHERE r.fleet = ").push_bind(fleet.as_str()).push(" AND c.received_us >= ");
                sql.push_bind(span.from_us).push(" AND c.received_us < ").push_bind(span.to_us);
                let mut found = sql.build().persistent(false).fetch($link);
                let mut group = Vec::new();
                while let Some(row) = timeout(NEXT_PATIENCE, found.try_next())
                    .await
                    .map_err(|_| StoreError::NoAnswer { what: WHAT, patience: NEXT_PATIENCE })?
                    .map_err(failed(WHAT))?
                {
                    let cells: sqlx::Result<Vec<Cell>> =
                        CONTACTS.columns.iter().map(|column| cell(&row, column)).collect();
                    let cells = Tried::of(&row, cells).map_err(failed(WHAT))?;
                    let received_us = row.try_get("received_at").ok();
                    group.extend(self.set_aside.read("contacts", cells.named("received_us", received_us)));
                    // If nobody receives the rows any more, their reader has failed and says so.
                    if group.len() == GROUP_ROWS && rows.send(std::mem::take(&mut group)).await.is_err() {
                        return Ok(());
                    }
                }
                let _ = rows.send(group).await;
            }};
        }
        match &self.pool {
            Either::Sqlite(pool) => stream!(pool, Sqlite, by_time()),
            Either::Postgres(_) => {
                // A connection of its own: a large file takes longer than the limit for statements of the pool.
                let Either::Postgres(mut link) = self.options.connect(WHAT).await? else { return Ok(()) };
                sqlx::raw_sql("SET statement_timeout = 0").execute(&mut link).await.map_err(failed(WHAT))?;
                stream!(&mut link, Postgres, CONTACTS.select);
            }
        }
        Ok(())
    }
}
