//! Writes a batch in one transaction, exactly once.

use tokio::time::Instant;

use super::batch::{ContactRow, JournalRow};
use super::database::{Either, Link, Tx, on};
use super::model::{Model, atomically};
use super::postgres::whole::Whole;
use super::tables::{CONTACTS, InFleet, JOURNAL, JOURNAL_UNFENCED};
use super::{Batch, Lease, StoreError, events, failed, log_position, postgres, records};
use crate::fault::{self, Fault};

/// Writes a batch in one transaction. Returns the moment before its query; `None` if an earlier attempt was committed and
/// only its answer was lost: then nothing is written.
pub(super) async fn write(link: &mut Link, lease: &Lease, batch: &Batch) -> Result<Option<Instant>, StoreError> {
    let asked = Instant::now();
    if let Either::Postgres(link) = link
        && !fault::is(Fault::NoFence)
        && let Some(whole) = Whole::of(lease, batch)
        && whole.write(link).await?
    {
        return Ok(Some(asked));
    }
    let asked = Instant::now();
    let is_new = write_in_steps(link, lease, batch).await?;
    Ok(is_new.then_some(asked))
}

/// As [`write`], into a model; `asked` is the moment before its query.
pub(super) fn write_model(
    model: &mut dyn Model,
    lease: &Lease,
    batch: &Batch,
    asked: Instant,
) -> Result<Option<Instant>, StoreError> {
    let is_written = fault::is(Fault::RowsBeforeFence);
    if is_written {
        atomically(model, |model| Ok(model.write(lease, &batch.rows())?))?;
    }
    atomically(model, |model| {
        if !lease.begin_in(model)? {
            return Ok(None);
        }
        if !is_written {
            model.write(lease, &batch.rows())?;
        }
        if let Some(row) = &batch.journal {
            model.write_journal(lease, row, false)?;
        }
        end_model(model, lease, batch, true);
        Ok(Some(asked))
    })
}

/// Writes into a model what does not belong to single robots; if rows of some are left out, the journal stays.
pub(super) fn end_model(model: &mut dyn Model, lease: &Lease, batch: &Batch, is_complete: bool) {
    model.set_log_positions(lease, &batch.log);
    if let Some(number) = batch.journal_done.filter(|_| is_complete) {
        model.forget_journal(lease, number);
    }
}

/// Writes a batch with one statement for each kind of row, or for each row. Returns false if it was written before.
///
/// Contacts are written before the lease's row is locked: a `COPY` lasts as long as its bytes take to arrive, and a
/// supervisor that freezes in it must not block others from acquiring the fleet.
async fn write_in_steps(link: &mut Link, lease: &Lease, batch: &Batch) -> Result<bool, StoreError> {
    let mut tx = link.begin().await.map_err(failed("begin a transaction"))?;
    write_contacts(&mut tx, &batch.contacts).await?;
    if !lease.begin(&mut tx).await? {
        // The contacts of this attempt were written before, too.
        tx.rollback().await.map_err(failed("roll back"))?;
        return Ok(false);
    }
    let fleet = lease.fleet().as_str();
    records::write(&mut tx, fleet, &batch.rows()).await?;
    if let Some(row) = &batch.journal {
        write_journal(&mut tx, lease, row).await.map_err(failed("write the journal"))?;
    }
    log_position::write(&mut tx, lease, &batch.log).await?;
    write_done(&mut tx, lease, batch, true).await?;
    events::write::write(&mut tx, fleet, &batch.events).await.map_err(failed("write events"))?;
    tx.commit().await.map_err(failed("commit"))?;
    Ok(true)
}

/// Writes the contacts that are stored as single rows.
pub(super) async fn write_contacts(tx: &mut Tx<'_>, contacts: &[ContactRow]) -> Result<(), StoreError> {
    let written = match tx {
        Either::Postgres(tx) if postgres::are_copied(contacts.len()) => postgres::copy_contacts(tx, contacts).await,
        Either::Postgres(_) | Either::Sqlite(_) => CONTACTS.write(tx, contacts).await.map(drop),
    };
    written.map_err(failed("append contacts"))
}

/// Removes rows that are obsolete once all rows of this batch are committed; if some are left out, the journal stays.
pub(super) async fn write_done(
    tx: &mut Tx<'_>,
    lease: &Lease,
    batch: &Batch,
    is_complete: bool,
) -> Result<(), StoreError> {
    if let Some(number) = batch.journal_done.filter(|_| is_complete) {
        forget_journal(tx, lease, number).await.map_err(failed("delete the journal's old rows"))?;
    }
    Ok(())
}

/// Writes a row of the journal.
async fn write_journal(tx: &mut Tx<'_>, lease: &Lease, row: &JournalRow) -> sqlx::Result<()> {
    let journal = if fault::is(Fault::NoFence) { &JOURNAL_UNFENCED } else { &JOURNAL };
    journal.write(tx, &[(InFleet::of(lease), row)]).await.map(drop)
}

/// Deletes the journal's rows up to a number, which the checkpoints contain.
async fn forget_journal(tx: &mut Tx<'_>, lease: &Lease, number: i64) -> sqlx::Result<()> {
    on!(tx, |tx| sqlx::query("DELETE FROM journal WHERE fleet = $1 AND number <= $2")
        .bind(lease.fleet().as_str())
        .bind(number)
        .execute(&mut **tx)
        .await
        .map(drop))
}
