//! The archive that is written from a partitioned log: positions, and plans of files.
//!
//! A plan is written down before its files, and names and content of the files follow from it, so that every attempt writes the
//! same files. The position advances after them.

use std::time::Duration;

use super::archive::Archived;
use super::database::{Tx, on};
use super::from_row::from_row;
use super::{Lease, StoreError, Writer, failed};

/// Time limit for a statement about the position.
const PATIENCE: Duration = Duration::from_secs(10);

/// Records of a partition that become files together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogSpan {
    /// Name of the topic.
    pub topic: String,
    /// Offset of the first record.
    pub from: i64,
    /// Offset after the last record.
    pub to: i64,
}

from_row! {
    /// Position of the archive in the partition of a shard.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct LogArchive {
        /// Name of the topic.
        pub topic: String,
        /// Offset of the first record that is not archived.
        pub next_offset: i64,
        /// Offset after the last record of the files that are being written; `None` between files.
        pub planned_to: Option<i64>,
        /// Messages in the files up to the position, as JSON.
        pub seen: String,
        /// Time before which all received records are archived, µs since 1970 UTC.
        pub archived_to_us: i64,
    }
}

async fn position(tx: &mut Tx<'_>, lease: &Lease) -> sqlx::Result<Option<LogArchive>> {
    const SQL: &str =
        "SELECT topic, next_offset, planned_to, seen, archived_to_us FROM log_archives WHERE fleet = $1 AND shard = $2";
    let (fleet, shard) = (lease.fleet().as_str(), lease.shard_number());
    on!(tx, |tx| sqlx::query_as(SQL).bind(fleet).bind(shard).fetch_optional(&mut **tx).await)
}

impl Writer {
    /// Position of the archive in the partition of the lease's shard; `None` before the first plan.
    ///
    /// # Errors
    /// The database cannot be read, or the lease is lost.
    pub async fn log_archive(&mut self, lease: &Lease) -> Result<Option<LogArchive>, StoreError> {
        const WHAT: &str = "read the archive's position in the log";
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            let at = position(&mut tx, lease).await.map_err(failed(WHAT))?;
            tx.rollback().await.map_err(failed(WHAT))?;
            Ok(at)
        })
        .await
    }

    /// Writes down the records of the next files, the messages in the files before them, and the time up to which these reach.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn plan_log_archive(
        &mut self,
        lease: &Lease,
        span: &LogSpan,
        (seen, archived_to_us): (&str, i64),
    ) -> Result<(), StoreError> {
        const WHAT: &str = "plan files of the archive from the log";
        const SQL: &str = "INSERT INTO log_archives (fleet, shard, topic, next_offset, planned_to, seen, archived_to_us) \
             VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT (fleet, shard) DO UPDATE SET topic = excluded.topic, \
             next_offset = excluded.next_offset, planned_to = excluded.planned_to, seen = excluded.seen, \
             archived_to_us = excluded.archived_to_us";
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            on!(&mut tx, |tx| sqlx::query(SQL)
                .bind(lease.fleet().as_str())
                .bind(lease.shard_number())
                .bind(&span.topic)
                .bind(span.from)
                .bind(span.to)
                .bind(seen)
                .bind(archived_to_us)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }

    /// Advances the position over records whose files are on the object store. `seen` has their messages, too. Does nothing if
    /// the position has advanced already.
    ///
    /// # Errors
    /// The database cannot be written, or the lease is lost.
    pub async fn advance_log_archive(
        &mut self,
        lease: &Lease,
        span: &LogSpan,
        (seen, archived_to_us): (&str, i64),
        (files, archived): (u64, Archived),
    ) -> Result<(), StoreError> {
        const WHAT: &str = "advance the archive's position in the log";
        const SQL: &str = "UPDATE log_archives SET next_offset = $4, planned_to = NULL, seen = $5, files = files + $6, \
             contacts = contacts + $7, bytes = bytes + $8, archived_to_us = $9 \
             WHERE fleet = $1 AND shard = $2 AND next_offset = $3 AND planned_to = $4";
        self.attempt(WHAT, PATIENCE, async |link| {
            let mut tx = link.begin().await.map_err(failed(WHAT))?;
            lease.hold(&mut tx).await?;
            on!(&mut tx, |tx| sqlx::query(SQL)
                .bind(lease.fleet().as_str())
                .bind(lease.shard_number())
                .bind(span.from)
                .bind(span.to)
                .bind(seen)
                .bind(files as i64)
                .bind(archived.contacts as i64)
                .bind(archived.bytes as i64)
                .bind(archived_to_us)
                .execute(&mut **tx)
                .await
                .map(drop))
            .map_err(failed(WHAT))?;
            tx.commit().await.map_err(failed(WHAT))
        })
        .await
    }
}
