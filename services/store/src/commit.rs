//! Writes a batch in one transaction, exactly once.

use tokio::time::Instant;
use tracing::warn;

use super::batch::{ContactRow, JournalRow, RollupRow, Rows};
use super::database::{Either, Link, Tx, on};
use super::postgres::whole::Whole;
use super::{Batch, Lease, StoreError, changes, failed, postgres, records, redo, sqlite};
use crate::Resolution;
use crate::fault::{self, Fault};

/// Writes a batch in one transaction. If an earlier attempt was committed and only its answer was lost, nothing is
/// written.
pub(super) async fn write(link: &mut Link, lease: &Lease, batch: &Batch) -> Result<(), StoreError> {
    let asked = Instant::now();
    let now_us = vibrissa_edge::clock::wall_clock().0 as i64;
    if let Either::Postgres(link) = link
        && !fault::is(Fault::NoFence)
        && let Some(whole) = Whole::of(batch)
        && whole.write(link, lease, now_us).await?
    {
        lease.committed(Some(asked));
        return Ok(());
    }
    let is_new = write_in_steps(link, lease, batch, now_us).await?;
    lease.committed(is_new.then_some(asked));
    Ok(())
}

/// Writes a batch with one statement for each kind of row, or for each row. Returns false if it was written before.
///
/// Contacts are written before the lease's row is locked: a `COPY` lasts as long as its bytes take to arrive, and a
/// supervisor that freezes in it must not block others from acquiring the fleet.
async fn write_in_steps(link: &mut Link, lease: &Lease, batch: &Batch, now_us: i64) -> Result<bool, StoreError> {
    let mut tx = link.begin().await.map_err(failed("begin a transaction"))?;
    write_contacts(&mut tx, &batch.contacts).await?;
    if !lease.begin(&mut tx).await? {
        // The contacts of this attempt were written before, too.
        tx.rollback().await.map_err(failed("roll back"))?;
        return Ok(false);
    }
    let fleet = lease.fleet().as_str();
    write_rest(&mut tx, fleet, &batch.rows()).await?;
    if let Some(row) = &batch.journal {
        write_journal(&mut tx, fleet, row).await.map_err(failed("write the journal"))?;
    }
    write_done(&mut tx, fleet, batch, true).await?;
    changes::write_of(&mut tx, fleet, &batch.records, now_us).await.map_err(failed("write the changes"))?;
    tx.commit().await.map_err(failed("commit"))?;
    Ok(true)
}

/// Writes the contacts that are stored as single rows.
pub(super) async fn write_contacts(tx: &mut Tx<'_>, contacts: &[ContactRow]) -> Result<(), StoreError> {
    if contacts.is_empty() {
        return Ok(());
    }
    match tx {
        Either::Sqlite(tx) => sqlite::append_contacts(tx, contacts).await,
        Either::Postgres(tx) => postgres::append_contacts(tx, contacts).await,
    }
    .map_err(failed("append contacts"))
}

/// Writes the rows of all other tables that belong to robots.
pub(super) async fn write_rest(tx: &mut Tx<'_>, fleet: &str, rows: &Rows<'_>) -> Result<(), StoreError> {
    for layout in rows.layouts {
        records::write_layout(tx, layout).await.map_err(failed("write a layout"))?;
    }
    write_rows(tx, rows).await?;
    for record in rows.records {
        records::write_record(tx, fleet, record).await?;
    }
    if !rows.responses.is_empty() {
        match tx {
            Either::Sqlite(tx) => sqlite::append_responses(tx, rows.responses).await,
            Either::Postgres(tx) => postgres::append_responses(tx, rows.responses).await,
        }
        .map_err(failed("append responses"))?;
    }
    Ok(())
}

/// Removes rows that are obsolete once all rows of this batch are committed; if some are left out, the journal stays.
pub(super) async fn write_done(
    tx: &mut Tx<'_>,
    fleet: &str,
    batch: &Batch,
    is_complete: bool,
) -> Result<(), StoreError> {
    if let Some(number) = batch.journal_done.filter(|_| is_complete) {
        forget_journal(tx, fleet, number).await.map_err(failed("delete the journal's old rows"))?;
    }
    if let Some(number) = batch.redo_done {
        redo::forget(tx, fleet, number).await.map_err(failed("delete an intent"))?;
    }
    Ok(())
}

/// Writes checkpoints and aggregates: many rows of few kinds.
async fn write_rows(tx: &mut Tx<'_>, rows: &Rows<'_>) -> Result<(), StoreError> {
    if !rows.robots.is_empty() {
        match tx {
            Either::Sqlite(tx) => sqlite::write_robots(tx, rows.robots).await,
            Either::Postgres(tx) => postgres::write_robots(tx, rows.robots).await,
        }
        .map_err(failed("write robots"))?;
    }
    if !rows.whiskers.is_empty() {
        match tx {
            Either::Sqlite(tx) => sqlite::write_whiskers(tx, rows.whiskers).await,
            Either::Postgres(tx) => postgres::write_whiskers(tx, rows.whiskers).await,
        }
        .map_err(failed("write whiskers"))?;
    }
    if !rows.rollups.is_empty() {
        write_rollups(tx, rows.rollups).await.map_err(failed("write aggregates of minutes and hours"))?;
    }
    Ok(())
}

async fn write_rollups(tx: &mut Tx<'_>, rollups: &[RollupRow]) -> sqlx::Result<()> {
    for resolution in Resolution::ALL {
        let rows: Vec<&RollupRow> = rollups.iter().filter(|row| row.resolution == resolution).collect();
        if rows.is_empty() {
            continue;
        }
        let written = match &mut *tx {
            Either::Sqlite(tx) => sqlite::append_rollups(tx, resolution, &rows).await?,
            Either::Postgres(tx) => postgres::append_rollups(tx, resolution, &rows).await?,
        };
        tell_of_rollups(resolution, rows.len(), written);
    }
    Ok(())
}

/// Warns if aggregates existed already. No span is closed twice, but an operator may have restored a single table;
/// that must not stop the fleet.
pub(super) fn tell_of_rollups(resolution: Resolution, rows: usize, written: u64) {
    if written < rows as u64 {
        warn!(?resolution, rows, written, "skipped aggregates of minutes or hours that exist already");
    }
}

/// Writes a row of the journal.
async fn write_journal(tx: &mut Tx<'_>, fleet: &str, row: &JournalRow) -> sqlx::Result<()> {
    // Without the fence two owners write the same numbers. The conflict would protect each from the damage that the
    // test waits for.
    let sql = if fault::is(Fault::NoFence) {
        "INSERT INTO journal (fleet, number, entries) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING"
    } else {
        "INSERT INTO journal (fleet, number, entries) VALUES ($1, $2, $3)"
    };
    on!(tx, |tx| sqlx::query(sql).bind(fleet).bind(row.number).bind(&row.entries).execute(&mut **tx).await.map(drop))
}

/// Deletes the journal's rows up to a number, which the checkpoints contain.
async fn forget_journal(tx: &mut Tx<'_>, fleet: &str, number: i64) -> sqlx::Result<()> {
    on!(tx, |tx| sqlx::query("DELETE FROM journal WHERE fleet = $1 AND number <= $2")
        .bind(fleet)
        .bind(number)
        .execute(&mut **tx)
        .await
        .map(drop))
}
