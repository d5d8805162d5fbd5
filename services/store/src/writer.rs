//! A separate connection for writing. After any error it is closed, and the next attempt opens a new one.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::watch;
use tokio::time::{Instant, timeout_at};
use vibrissa_protocol::Name;

use super::connect::Options;
use super::database::{Either, Link};
use super::lease_watch::LeaseWatch;
use super::model::{Model, ModelServer};
use super::{Batch, Lease, SetAside, StoreError, commit, failed};

/// Time limit for one attempt: a server that hangs counts as unreachable.
const PATIENCE: Duration = Duration::from_secs(10);

/// Writes over its own connection, one operation after the other.
#[derive(Debug)]
pub struct Writer {
    options: Arc<Options>,
    link: Option<Link>,
    /// Answers in place of a connection.
    model: Option<Arc<dyn ModelServer>>,
    /// Changes of the leader among several servers, seen since the connection was opened.
    changes: Option<watch::Receiver<u64>>,
    /// Newest epoch of each fleet in the database.
    pub(super) last_epochs: BTreeMap<Name, u64>,
    /// Highest epoch of each fleet that this process has seen: after a failover the database may know only lower ones.
    pub(super) highest_epochs: BTreeMap<Name, u64>,
    /// Tells leases and members that are alive, by this process's monotonic clock.
    pub(super) lease_watch: LeaseWatch,
    /// Rows that could not be read.
    pub(super) set_aside: SetAside,
}

impl Writer {
    pub(super) fn new(options: Arc<Options>, set_aside: SetAside, model: Option<Arc<dyn ModelServer>>) -> Self {
        let changes = match (&model, &*options) {
            (Some(model), _) => Some(model.leader_changes()),
            (None, Either::Sqlite(_)) => None,
            (None, Either::Postgres(route)) => Some(route.changes()),
        };
        let (last_epochs, highest_epochs) = (BTreeMap::new(), BTreeMap::new());
        let lease_watch = LeaseWatch::default();
        Self { options, link: None, model, changes, last_epochs, highest_epochs, lease_watch, set_aside }
    }

    /// Writes a batch in one transaction. Idempotent: retrying the same batch after an error never writes it twice.
    ///
    /// # Errors
    /// The database cannot be written now, or the lease is lost.
    pub async fn commit(&mut self, lease: &Lease, batch: &Batch) -> Result<(), StoreError> {
        let asked = Instant::now();
        let model = |model: &mut dyn Model| commit::write_model(model, lease, batch, asked);
        let new = self.attempt("commit", PATIENCE, model, async |link| commit::write(link, lease, batch).await).await?;
        lease.committed(new);
        Ok(())
    }

    /// Runs an operation on the connection, or on the model, within a time limit. The connection is used again only after a
    /// success: if an answer is missing, it may never answer again. If the database gets a new leader meanwhile, the
    /// operation fails.
    pub(super) async fn attempt<T>(
        &mut self,
        what: &'static str,
        patience: Duration,
        model: impl FnOnce(&mut dyn Model) -> Result<T, StoreError>,
        work: impl AsyncFnOnce(&mut Link) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let deadline = Instant::now() + patience;
        let late = || StoreError::NoAnswer { what, patience };
        if let Some(server) = self.model.clone() {
            self.changes.iter_mut().for_each(watch::Receiver::mark_unchanged);
            let attempt = async {
                tokio::select! {
                    // Not by chance: a simulation must repeat.
                    biased;
                    done = server.ask(what, model) => done,
                    () = changed(&mut self.changes) => Err(failed(what)(former_leader())),
                }
            };
            return timeout_at(deadline, attempt).await.unwrap_or_else(|_| Err(late()));
        }
        let attempt = async {
            let is_of_leader = !self.changes.as_ref().is_some_and(|changes| changes.has_changed().unwrap_or(false));
            let mut link = match self.link.take().filter(|_| is_of_leader) {
                Some(link) => link,
                None => self.connect(what).await?,
            };
            let done = tokio::select! {
                done = work(&mut link) => done?,
                () = changed(&mut self.changes) => return Err(failed(what)(former_leader())),
            };
            Ok((link, done))
        };
        let (link, done) = timeout_at(deadline, attempt).await.unwrap_or_else(|_| Err(late()))?;
        self.link = Some(link);
        Ok(done)
    }

    async fn connect(&mut self, what: &'static str) -> Result<Link, StoreError> {
        let link = self.options.connect(what).await?;
        if let Some(changes) = &mut self.changes {
            changes.mark_unchanged();
        }
        Ok(link)
    }

    /// Waits until the database has a new leader among several servers; forever with one server.
    pub async fn new_leader(&mut self) {
        changed(&mut self.changes).await;
    }
}

async fn changed(changes: &mut Option<watch::Receiver<u64>>) {
    let is_there = match changes {
        Some(changes) => changes.changed().await.is_ok(),
        None => false,
    };
    if !is_there {
        std::future::pending::<()>().await;
    }
}

pub(super) fn former_leader() -> sqlx::Error {
    sqlx::Error::Io(std::io::Error::new(std::io::ErrorKind::ConnectionAborted, "the database has a new leader"))
}
