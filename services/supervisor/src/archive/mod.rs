//! The archive of contacts: Parquet files on an object store, by fleet and day.
//!
//! The owner of a fleet's first shard writes one file after the other. The database has the position, and the span of the file
//! that is being written (`vibrissa_store::archive`). The name of a file follows from its span, so an attempt that was
//! interrupted at any moment is repeated under the same name with the same contacts. Failures delay the archive, and nothing
//! else.

mod object;

use std::sync::Arc;
use std::time::Duration;

use tokio::io::AsyncWriteExt as _;
use tokio::sync::mpsc;
use tokio::time::sleep;
use tracing::{debug, error, info, warn};
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::{Name, Timestamp};
use vibrissa_store::archive::{Archived, Span};
use vibrissa_store::export::CONTACTS;
use vibrissa_store::fault::{self, Fault};
use vibrissa_store::{Lease, Store, StoreError, Writer};

use crate::archive_options::ArchiveOptions;
use crate::backoff::Backoff;
use crate::metrics::FleetMetrics;
use crate::parquet_rows::ParquetRows;
use object::{Objects, Piece};

/// Longest pause between two looks for a span that is complete.
const LOOK_EVERY: Duration = Duration::from_secs(5);

/// Groups of rows that may wait for the writer of the file.
const GROUPS: usize = 4;

/// The archive. Clones share its connections.
#[derive(Debug, Clone)]
pub(crate) struct Archive {
    objects: Arc<Objects>,
    every_us: i64,
}

impl Archive {
    /// Opens the archive, without a connection yet.
    ///
    /// # Errors
    /// The URL is not one of a folder or bucket, or the folder or the file of the secret cannot be read.
    pub(crate) fn open(options: &ArchiveOptions) -> anyhow::Result<Self> {
        let every_us = i64::try_from(options.every.as_micros()).unwrap_or(i64::MAX);
        Ok(Self { objects: Arc::new(Objects::open(options)?), every_us })
    }

    /// Archives the contacts of the lease's fleet until the lease is lost.
    pub(crate) async fn run(self, lease: Lease, store: Store, metrics: FleetMetrics) {
        let mut writer = store.writer();
        let mut backoff = Backoff::default();
        let fleet = lease.fleet().clone();
        loop {
            match self.next(&lease, &store, &mut writer, &metrics).await {
                Ok(is_more) => {
                    backoff = Backoff::default();
                    if !is_more {
                        sleep(LOOK_EVERY.min(Duration::from_micros(self.every_us.unsigned_abs()))).await;
                    }
                }
                Err(problem) if is_lease_lost(&problem) => return debug!(%fleet, "archiving ends with the lease"),
                Err(problem) => {
                    metrics.archive_errors.inc();
                    warn!(%fleet, problem = format!("{problem:#}"), "cannot archive contacts, retrying");
                    backoff.wait().await;
                }
            }
        }
    }

    /// Writes the next file, if its span is complete. Returns whether there was one.
    async fn next(
        &self,
        lease: &Lease,
        store: &Store,
        writer: &mut Writer,
        metrics: &FleetMetrics,
    ) -> anyhow::Result<bool> {
        let fleet = lease.fleet();
        store.begin_archives(std::slice::from_ref(fleet), wall_clock().0 as i64).await?;
        let planned = writer.plan_archive(lease, self.every_us).await?;
        if let Some(span) = planned {
            let archived = self.write(lease, store, writer, span).await?;
            if fault::is(Fault::DeathAfterUpload) && archived.bytes > 0 {
                // A fault planted by a test.
                error!("a test ends the process");
                std::process::abort();
            }
            writer.advance_archive(lease, span, archived).await?;
            metrics.archive_contacts.inc_by(archived.contacts);
            metrics.archive_bytes.inc_by(archived.bytes);
            if archived.contacts > 0 {
                let (path, Archived { contacts, bytes }) = (path(fleet, span), archived);
                info!(%fleet, path, contacts, bytes, "contacts archived");
            }
        }
        if let Some(archived_us) = store.archived_to(fleet).await? {
            metrics.archive_position_timestamp_seconds.set(archived_us as f64 / 1e6);
        }
        Ok(planned.is_some())
    }

    /// Writes the file of a span; none if there are no contacts.
    async fn write(&self, lease: &Lease, store: &Store, writer: &mut Writer, span: Span) -> anyhow::Result<Archived> {
        let fleet = lease.fleet();
        let path = path(fleet, span);
        let mut object = self.objects.writer(&path)?;
        let (found, mut read) = mpsc::channel(GROUPS);
        let reading = async { store.read_span(fleet, span, found).await.map_err(anyhow::Error::from) };
        let writing = async {
            let piece = Piece::default();
            let mut rows = ParquetRows::begin(piece.clone(), &CONTACTS)?;
            let mut archived = Archived::default();
            while let Some(group) = read.recv().await {
                archived.contacts += group.len() as u64;
                for cells in group {
                    rows.push(cells)?;
                }
                let bytes = piece.take();
                archived.bytes += bytes.len() as u64;
                object.write_all(&bytes).await?;
            }
            rows.finish()?;
            let bytes = piece.take();
            archived.bytes += bytes.len() as u64;
            object.write_all(&bytes).await?;
            anyhow::Ok(archived)
        };
        let ((), archived) = tokio::try_join!(reading, writing)?;
        if archived.contacts == 0 {
            return Ok(Archived::default());
        }
        // Otherwise another supervisor has archived the span, and some of its contacts may have been deleted meanwhile.
        anyhow::ensure!(writer.is_archive_planned(lease, span).await?, "another supervisor has archived this span");
        object.shutdown().await?;
        self.objects.settle(&path).await?;
        Ok(archived)
    }
}

/// Name of the file of a span, in the form by which readers recognise the fleet and the day.
fn path(fleet: &Name, span: Span) -> String {
    let day: String = Timestamp(span.from_us.unsigned_abs()).to_string().chars().take(10).collect();
    format!("fleet={fleet}/day={day}/contacts-{}-{}.parquet", span.from_us, span.to_us)
}

fn is_lease_lost(problem: &anyhow::Error) -> bool {
    matches!(problem.downcast_ref::<StoreError>(), Some(StoreError::LeaseLost { .. }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_file_tells_fleet_day_and_span() {
        let fleet = Name::new("lab").unwrap();
        // `date -u -d @1795262400`: 2026-11-21 12:00:00
        let span = Span { from_us: 1_795_262_400_000_000, to_us: 1_795_263_000_000_000 };
        let expected = "fleet=lab/day=2026-11-21/contacts-1795262400000000-1795263000000000.parquet";
        assert_eq!(path(&fleet, span), expected);
    }
}
