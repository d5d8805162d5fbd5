//! A store without a way to it.

use std::future::ready;
use std::io;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::watch;
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::model::{Model, ModelServer, Way};

use super::ModelStore;

/// A store that requests reach at once.
#[derive(Debug, Default)]
pub struct AtHand {
    store: Mutex<ModelStore>,
    /// The database's clock, µs since 1970 UTC; 0 for this process's.
    clock_us: AtomicI64,
    /// Number of answers that are left up to the one that is lost; 0 if none is lost.
    lost_in: AtomicI64,
    leaders: watch::Sender<u64>,
}

impl AtHand {
    /// The data.
    pub fn store(&self) -> MutexGuard<'_, ModelStore> {
        self.store.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stops the database's clock at a time, µs since 1970 UTC.
    pub fn stop_clock(&self, clock_us: i64) {
        self.clock_us.store(clock_us, Ordering::Relaxed);
    }

    /// Loses the answer to the next request but `further`.
    pub fn lose_answer(&self, further: i64) {
        self.lost_in.store(further + 1, Ordering::Relaxed);
    }
}

impl ModelServer for AtHand {
    fn reach(&self) -> Way<'_> {
        Box::pin(ready(Ok(())))
    }

    fn answer(&self) -> Way<'_> {
        let is_lost = self.lost_in.fetch_sub(1, Ordering::Relaxed) == 1;
        Box::pin(ready(if is_lost { Err(io::ErrorKind::ConnectionReset.into()) } else { Ok(()) }))
    }

    fn with(&self, work: &mut dyn FnMut(&mut dyn Model)) {
        let mut store = self.store();
        let stopped_us = self.clock_us.load(Ordering::Relaxed);
        store.set_clock(if stopped_us == 0 { wall_clock().0 as i64 } else { stopped_us });
        work(&mut *store);
    }

    fn leader_changes(&self) -> watch::Receiver<u64> {
        self.leaders.subscribe()
    }
}
