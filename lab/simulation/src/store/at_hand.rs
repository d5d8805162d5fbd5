//! A store without a way to it.

use std::future::ready;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::model::{Model, ModelServer, Way};

use super::ModelStore;

/// A store that requests reach at once. Its clock is this process's.
#[derive(Debug, Default)]
pub struct AtHand {
    store: Mutex<ModelStore>,
    loses_answer: AtomicBool,
    leaders: watch::Sender<u64>,
}

impl AtHand {
    /// The data.
    pub fn store(&self) -> MutexGuard<'_, ModelStore> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Loses the answer to the next request.
    pub fn lose_answer(&self) {
        self.loses_answer.store(true, Ordering::Relaxed);
    }
}

impl ModelServer for AtHand {
    fn reach(&self) -> Way<'_> {
        Box::pin(ready(Ok(())))
    }

    fn answer(&self) -> Way<'_> {
        let is_lost = self.loses_answer.swap(false, Ordering::Relaxed);
        Box::pin(ready(if is_lost { Err(io::ErrorKind::ConnectionReset.into()) } else { Ok(()) }))
    }

    fn with(&self, work: &mut dyn FnMut(&mut dyn Model)) {
        let mut store = self.store();
        store.set_clock(wall_clock().0 as i64);
        work(&mut *store);
    }

    fn leader_changes(&self) -> watch::Receiver<u64> {
        self.leaders.subscribe()
    }
}
