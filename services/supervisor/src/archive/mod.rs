//! The archive of contacts: Parquet files on an object store, by fleet and day.
//!
//! The owner of a fleet writes one file after the other from the database, which has the position, and the span of
//! the file that is being written (`vibrissa_store::archive`). The name of a file follows from its span, so an attempt that was interrupted at any moment is repeated under the same name with the same
//! contacts. Failures delay the archive, and nothing else.

mod cause;
mod file;
mod object;

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::time::sleep;
use tracing::{debug, error, info, warn};
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::{Name, Timestamp};
use vibrissa_store::archive::{Archived, Span};
use vibrissa_store::export::CONTACTS;
use vibrissa_store::fault::{self, Fault};
use vibrissa_store::{Lease, Store, StoreError, Writer};

use self::cause::cause;
use crate::archive_options::ArchiveOptions;
use crate::backoff::Backoff;
use crate::metrics::FleetMetrics;
use file::File;
use object::Objects;

/// Longest pause between two looks for a span that is complete.
const LOOK_EVERY: Duration = Duration::from_secs(5);

/// Groups of rows that may wait for the writer of the file.
const GROUPS: usize = 4;

/// The archive. Clones share its connections.
#[derive(Debug, Clone)]
pub(crate) struct Archive {
    objects: Arc<Objects>,
    every: Duration,
}

impl Archive {
    /// Opens the archive, without a connection yet.
    ///
    /// # Errors
    /// The URL is not one of a folder or bucket, or the folder or the file of the secret cannot be read.
    pub(crate) fn open(options: &ArchiveOptions) -> anyhow::Result<Self> {
        Ok(Self { objects: Arc::new(Objects::open(options)?), every: options.every })
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
                        sleep(LOOK_EVERY.min(self.every)).await;
                    }
                }
                Err(problem) if is_lease_lost(&problem) => return debug!(%fleet, "archiving ends with the lease"),
                Err(problem) => {
                    metrics.archive_errors.inc();
                    warn!(%fleet, problem = cause(&problem), "cannot archive contacts, retrying");
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
        // Before the file: an archive that fails from the start of the process is behind, too.
        if let Some(archived_us) = store.archived_to(fleet).await? {
            metrics.archive_position_timestamp_seconds.set(archived_us as f64 / 1e6);
        }
        let planned = writer.plan_archive(lease, i64::try_from(self.every.as_micros()).unwrap_or(i64::MAX)).await?;
        if let Some(span) = planned {
            let archived = self.write(lease, store, writer, span).await?;
            strike(archived);
            writer.advance_archive(lease, span, archived).await?;
            metrics.archive_contacts.inc_by(archived.contacts);
            metrics.archive_bytes.inc_by(archived.bytes);
            if archived.contacts > 0 {
                let (path, Archived { contacts, bytes }) = (path(fleet, span), archived);
                info!(%fleet, path, contacts, bytes, "contacts archived");
            }
        }
        Ok(planned.is_some())
    }

    /// Writes the file of a span; none if there are no contacts.
    async fn write(&self, lease: &Lease, store: &Store, writer: &mut Writer, span: Span) -> anyhow::Result<Archived> {
        let fleet = lease.fleet();
        let mut file = File::begin(&self.objects, path(fleet, span), CONTACTS.columns)?;
        let (found, mut read) = mpsc::channel(GROUPS);
        let reading = async { store.read_span(fleet, span, found).await.map_err(anyhow::Error::from) };
        let writing = async {
            while let Some(group) = read.recv().await {
                for cells in group {
                    file.push(cells).await?;
                }
            }
            anyhow::Ok(())
        };
        if let Err(problem) = tokio::try_join!(reading, writing) {
            file.abort().await;
            return Err(problem);
        }
        if file.contacts() == 0 {
            return Ok(Archived::default());
        }
        // Otherwise another supervisor has archived the span, and some of its contacts may have been deleted meanwhile.
        if !writer.is_archive_planned(lease, span).await? {
            file.abort().await;
            anyhow::bail!("another supervisor has archived this span");
        }
        file.complete(&self.objects).await
    }
}

/// Dies if a test has planted that fault, and a file has been written.
fn strike(archived: Archived) {
    if fault::is(Fault::DeathAfterUpload) && archived.bytes > 0 {
        error!("a test ends the process");
        std::process::abort();
    }
}

/// Folder of a fleet's contacts of a day, in the form by which readers recognise both.
fn folder(fleet: &Name, us: i64) -> String {
    let day: String = Timestamp(us.unsigned_abs()).to_string().chars().take(10).collect();
    format!("fleet={fleet}/day={day}")
}

/// Name of the file of a span.
fn path(fleet: &Name, span: Span) -> String {
    format!("{}/contacts-{}-{}.parquet", folder(fleet, span.from_us), span.from_us, span.to_us)
}

fn is_lease_lost(problem: &anyhow::Error) -> bool {
    matches!(problem.downcast_ref::<StoreError>(), Some(StoreError::LeaseLost { .. }))
}

#[cfg(test)]
mod tests {
    use vibrissa_store::{DatabaseAddress, Supervisor};

    use super::*;
    use crate::metrics::Metrics;

    /// The alert leaves out positions of 0. Such an archive had one until its first file.
    #[tokio::test]
    async fn regress_an_archive_that_fails_from_the_start_shows_its_position() {
        let folder = std::env::temp_dir().join(format!("vibrissa-archive-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let store = Store::open(&DatabaseAddress::Sqlite(folder.join("v.sqlite3")), "test").await.unwrap();
        store.prepare().await.unwrap();
        let (fleet, mut writer) = (Name::new("lab").unwrap(), store.writer());
        let time_to_live = Duration::from_secs(600);
        let supervisor =
            Supervisor { id: "a".into(), name: "test".to_owned(), fleets: vec![fleet.clone()], time_to_live };
        let lease = writer.acquire(&supervisor, &fleet).await.unwrap().unwrap();
        // In place of an object store that refuses: nothing is planned without the lease.
        writer.release(&lease).await.unwrap();
        let url = format!("file://{}", folder.join("files").display());
        let options = ArchiveOptions { url, every: Duration::from_secs(600), s3: Default::default() };
        let (archive, metrics) = (Archive::open(&options).unwrap(), Metrics::new(false).unwrap().of_fleet(&fleet));
        archive.next(&lease, &store, &mut writer, &metrics).await.unwrap_err();
        let archived_us = store.archived_to(&fleet).await.unwrap().unwrap();
        assert_eq!(metrics.archive_position_timestamp_seconds.get(), archived_us as f64 / 1e6);
        store.close().await;
        std::fs::remove_dir_all(&folder).unwrap();
    }

    #[test]
    fn the_name_of_a_file_tells_fleet_day_and_span() {
        let fleet = Name::new("lab").unwrap();
        // `date -u -d @1795262400`: 2026-11-21 12:00:00
        let span = Span { from_us: 1_795_262_400_000_000, to_us: 1_795_263_000_000_000 };
        let expected = "fleet=lab/day=2026-11-21/contacts-1795262400000000-1795263000000000.parquet";
        assert_eq!(path(&fleet, span), expected);
    }
}
