//! The outbox on disk: written before messages are sent, and synchronised beside the work.

use std::path::Path;
use std::time::Duration;

use tokio::time::{Instant, sleep};
use vibrissa_host::task;

use super::{Hub, State};
use crate::Input;
use crate::clock::now;
use crate::store::Record;
use crate::store::file::{Damage, StoreFile};
use crate::store::spool::Spool;

/// Time between two synchronisations of the store with the disk: a power cut loses no more than about this.
const SYNC_EVERY: Duration = Duration::from_millis(200);
/// Time after which a store that failed is tried again.
const STORE_AGAIN: Duration = Duration::from_secs(5);

/// The store, with its health.
pub(super) struct Store {
    pub(super) file: StoreFile,
    /// Contacts that have no room in memory.
    pub(super) spool: Option<Spool>,
    pub(super) is_dirty: bool,
    pub(super) failed_at: Option<Instant>,
    /// The agent has asked for a message back from the disk, and has not got it yet.
    pub(super) owes: bool,
    /// Time of the last attempt to read it, if it failed.
    pub(super) unreadable_at: Option<Instant>,
    /// Segments that could not be removed. They are tried again with the next one.
    unremoved: usize,
}

impl Store {
    fn new(file: StoreFile, spool: Option<Spool>) -> Self {
        Self { file, spool, is_dirty: false, failed_at: None, owes: false, unreadable_at: None, unremoved: 0 }
    }

    /// Begins the file anew with the present state. A full disk does not keep the agent from its chambers.
    pub(super) fn begin(file: StoreFile, spool: Option<Spool>, records: Vec<Record>) -> Self {
        let mut store = Self::new(file, spool);
        store.replace(records);
        store
    }

    /// The file, if records were appended that may not be on the disk yet.
    fn unsynced(&mut self) -> Option<std::io::Result<std::fs::File>> {
        std::mem::take(&mut self.is_dirty).then(|| self.file.synced())
    }

    pub(super) fn append(&mut self, records: &[Record]) {
        if records.is_empty() || self.failed_at.is_some() {
            return;
        }
        self.is_dirty = true;
        if let Err(problem) = self.file.append(records) {
            tracing::error!(%problem, "a restart would lose contacts from now on");
            self.failed_at = Some(Instant::now());
        }
    }

    /// Replaces the file when it is full, or some time after it has failed.
    fn renew(&mut self, records: impl FnOnce() -> Vec<Record>) {
        let is_due = self.failed_at.map_or_else(|| self.file.is_full(), |at| at.elapsed() >= STORE_AGAIN);
        if !is_due {
            return;
        }
        self.replace(records());
    }

    fn replace(&mut self, records: Vec<Record>) {
        match self.file.replace(records) {
            Ok(()) => {
                if self.failed_at.take().is_some() {
                    tracing::info!("the outbox is stored again");
                }
            }
            Err(problem) => {
                tracing::error!(%problem, "a restart would lose contacts");
                self.failed_at = Some(Instant::now());
            }
        }
    }
}

/// Logs what of the outbox is lost, and where the rest of the damaged file is.
pub(super) fn tell_damage(path: &Path, Damage { lines, torn_bytes, aside }: &Damage) {
    let path = path.display();
    if *lines > 0 {
        let kept = match aside {
            Some(aside) => format!("the damaged file is kept as {}", aside.display()),
            None => "the damaged file could not be copied".to_owned(),
        };
        tracing::error!(
            "outbox.file: {lines} lines of {path} are damaged and left out, with the contacts in them; {kept}; check the disk"
        );
    } else if *torn_bytes > 0 {
        tracing::warn!("outbox.file: the last line of {path} is incomplete, as after a power cut, and left out");
    }
}

impl Hub {
    /// Writes contacts to the disk, and counts those that have no room there.
    pub(super) fn spool(&self, state: &mut State, contacts: &[Vec<u8>]) {
        let Some(spool) = state.store.as_mut().and_then(|store| store.spool.as_mut()) else { return };
        let mut lost = 0;
        for message in contacts {
            match spool.append(message) {
                Ok(dropped) => lost += dropped,
                Err(problem) => {
                    tracing::error!(%problem, "contacts are lost: they cannot be written to the outbox on disk");
                    lost += 1;
                }
            }
        }
        self.count_lost(state, lost);
    }

    fn count_lost(&self, state: &mut State, messages: u64) {
        if messages > 0 {
            let outputs = state.agent.step(now(), Input::LostOnDisk(messages));
            self.handle(state, outputs);
        }
    }

    /// Gives the agent the messages back from the disk that it asks for. After an error [`Hub::keep_store`] tries
    /// again: the agent waits, so that no later message overtakes them.
    pub(super) fn take_back(&self, state: &mut State) {
        while let Some(store) = state.store.as_mut().filter(|store| store.owes && store.unreadable_at.is_none()) {
            let Some(spool) = &mut store.spool else { return };
            let (back, lost) = (spool.take(), spool.lost());
            store.owes = back.is_err();
            if let Err(problem) = &back {
                tracing::error!(%problem, "cannot read contacts from the outbox on disk");
                store.unreadable_at = Some(Instant::now());
            }
            if lost > 0 {
                tracing::error!("contacts are lost: at least {lost} messages of the outbox on disk cannot be read");
            }
            self.count_lost(state, lost);
            let Ok(back) = back else { return };
            let back = back.as_ref().map(|(contacts, position)| (&contacts[..], *position));
            let outputs = state.agent.step(now(), Input::CameBack(back));
            self.handle(state, outputs);
        }
    }

    /// Synchronises the store with the disk, and replaces its file when it is full.
    pub(super) async fn keep_store(&self) {
        loop {
            sleep(SYNC_EVERY).await;
            {
                let mut state = self.lock();
                let State { agent, store, .. } = &mut *state;
                if let Some(store) = store {
                    store.renew(|| agent.records());
                    store.unreadable_at = store.unreadable_at.filter(|at| at.elapsed() < STORE_AGAIN);
                }
                self.take_back(&mut state);
            }
            self.sync().await;
        }
    }

    pub(super) async fn sync(&self) {
        let (file, spooled, done) = {
            let mut state = self.lock();
            let State { agent, store: Some(store), .. } = &mut *state else { return };
            let mut done = store.spool.as_ref().map_or_else(Vec::new, Spool::done);
            // While the file fails, it lacks what has come back: the segments are the only copy until receipts cover it.
            if store.failed_at.is_some() && agent.messages_kept() > 0 || done.len() <= store.unremoved {
                done.clear();
            }
            (store.unsynced(), store.spool.as_mut().and_then(Spool::unsynced), done)
        };
        if file.is_none() && spooled.is_none() && done.is_empty() {
            return;
        }
        let synced = task::blocking(move || {
            [spooled, file].into_iter().flatten().try_for_each(|file| file.and_then(|file| file.sync_data()))
        })
        .await;
        let synced = synced.unwrap_or_else(|problem| Err(std::io::Error::other(problem)));
        let mut state = self.lock();
        let Some(store) = &mut state.store else { return };
        if let Err(problem) = synced {
            tracing::error!(%problem, "cannot synchronise the outbox with the disk");
            // What the disk has of the file is not known: it is written anew.
            store.failed_at = Some(Instant::now());
            return;
        }
        // What was in the segments is on the disk in the file of the outbox.
        if let Some(spool) = store.spool.as_mut().filter(|_| !done.is_empty()) {
            store.unremoved = match spool.remove(&done) {
                Ok(()) => 0,
                Err(problem) => {
                    tracing::error!(%problem, "cannot remove contacts from the outbox on disk that have come back");
                    spool.done().len()
                }
            };
        }
    }
}

#[cfg(test)]
mod tests;
