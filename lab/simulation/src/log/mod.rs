//! A model of Apache Kafka as readers see it: topics with partitions, whose batches have offsets, are kept for a while,
//! and come over a connection. It speaks Kafka's protocol, so the clients are real.

mod batch;
mod bridge;
mod requests;
mod serve;

use std::collections::{BTreeMap, VecDeque};
use std::future::Future;
use std::io;
use std::pin::Pin;
use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bytes::Bytes;
use tokio::sync::Notify;

use crate::broker::{Server, WireEnd};

pub use batch::Entry;
pub use bridge::{Bridge, PARTITIONS, TOPIC};

/// The brokers, which are one here. Clones are the same ones.
#[derive(Debug, Clone)]
pub struct ModelLog(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    state: Mutex<State>,
    /// Told after each change of the state.
    changed: Notify,
    /// Host and port that answers name.
    address: (String, u16),
}

#[derive(Debug, Default)]
struct State {
    topics: BTreeMap<String, Vec<Partition>>,
    /// Connections are accepted, and requests get no answer.
    is_frozen: bool,
    /// Connections are refused.
    is_down: bool,
}

#[derive(Debug, Default)]
struct Partition {
    /// Offset of the first record that is kept.
    begin: i64,
    /// Offset after the last record.
    end: i64,
    batches: VecDeque<Batch>,
    /// Offset after the last record that was sent to a client.
    read: AtomicI64,
    /// No broker leads it.
    is_away: bool,
}

#[derive(Debug)]
struct Batch {
    /// Offset after its last record.
    next: i64,
    bytes: Bytes,
}

impl ModelLog {
    /// A log that clients reach at this host and port.
    #[must_use]
    pub fn new(host: &str, port: u16) -> Self {
        let (state, changed) = (Mutex::default(), Notify::new());
        Self(Arc::new(Inner { state, changed, address: (host.to_owned(), port) }))
    }

    /// Creates a topic, or raises the number of its partitions.
    pub fn create(&self, topic: &str, partitions: usize) {
        self.change(|state| {
            let known = state.topics.entry(topic.to_owned()).or_default();
            while known.len() < partitions {
                known.push(Partition::default());
            }
        });
    }

    /// Appends records to a partition as one batch. Nothing happens if there is no such partition.
    pub fn append(&self, topic: &str, partition: usize, records: &[Entry]) {
        self.with(topic, partition, |partition| {
            let bytes = batch::encode(partition.end, records);
            partition.end += records.len() as i64;
            partition.batches.push_back(Batch { next: partition.end, bytes });
        });
    }

    /// Damages the newest batch of a partition, as a disk does, if nobody has read it.
    pub fn damage(&self, topic: &str, partition: usize) {
        self.with(topic, partition, |partition| {
            let is_read = partition.read.load(Ordering::Relaxed) >= partition.end;
            if let Some(batch) = partition.batches.back_mut().filter(|_| !is_read) {
                let mut bytes = batch.bytes.to_vec();
                if let Some(last) = bytes.last_mut() {
                    *last ^= 1;
                }
                batch.bytes = bytes.into();
            }
        });
    }

    /// Deletes the records of a partition before an offset.
    pub fn delete_before(&self, topic: &str, partition: usize, offset: i64) {
        self.with(topic, partition, |partition| {
            partition.begin = offset.clamp(partition.begin, partition.end);
            let begin = partition.begin;
            while partition.batches.pop_front_if(|batch| batch.next <= begin).is_some() {}
        });
    }

    /// First offset of a partition, and the one after its last record; `None` if there is no such partition.
    #[must_use]
    pub fn offsets(&self, topic: &str, partition: usize) -> Option<(i64, i64)> {
        let state = self.state();
        let partition = state.topics.get(topic)?.get(partition)?;
        Some((partition.begin, partition.end))
    }

    /// Sets whether a partition is without a leader.
    pub fn set_away(&self, topic: &str, partition: usize, is_away: bool) {
        self.with(topic, partition, |partition| partition.is_away = is_away);
    }

    /// Sets whether requests get no answer.
    pub fn set_frozen(&self, is_frozen: bool) {
        self.change(|state| state.is_frozen = is_frozen);
    }

    /// Sets whether connections are refused, and those that exist are closed.
    pub fn set_down(&self, is_down: bool) {
        self.change(|state| state.is_down = is_down);
    }

    fn with(&self, topic: &str, partition: usize, change: impl FnOnce(&mut Partition)) {
        self.change(|state| {
            if let Some(partition) = state.topics.get_mut(topic).and_then(|topic| topic.get_mut(partition)) {
                change(partition);
            }
        });
    }

    fn change(&self, change: impl FnOnce(&mut State)) {
        change(&mut self.state());
        self.0.changed.notify_waiters();
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Server for ModelLog {
    fn accepts(&self) -> bool {
        self.is_accepting()
    }

    fn attend(&self, end: WireEnd) -> Pin<Box<dyn Future<Output = io::Result<()>> + Send>> {
        let log = self.clone();
        Box::pin(async move { log.serve(end).await })
    }
}
