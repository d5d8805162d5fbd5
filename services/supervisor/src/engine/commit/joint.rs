//! Joint commits: small batches of several shards of one supervisor become one transaction.
//!
//! A transaction costs PostgreSQL some 2.5 ms of processor time, however few rows it has, and a divided fleet with little
//! to do has two for each shard and second. Measured benefit: docs/performance.md, "Shards and supervisors". If a joint
//! commit fails, each shard commits its batch on its own, so that no shard can stop another for longer than that.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::sync::{mpsc, oneshot};
use tokio::time::{Duration, Instant, Interval, MissedTickBehavior, interval_at, sleep};
use tracing::debug;
use vibrissa_store::{Batch, Lease, Store, Writer};

/// How long a transaction waits for the batches of further shards. All shards tick at the same times.
const GATHER: Duration = Duration::from_millis(3);
/// Largest size of a batch that is committed together with others. A larger one gets a transaction of its own: it is
/// large enough for `COPY`, and runs at the same time as those of other shards.
const SIZE_OF_BATCH_MAX: usize = 2000;
/// Size from which on no further batch is added: enough for `COPY`, which halves PostgreSQL's work, and not more than an
/// undivided fleet commits at once.
const SIZE_ENOUGH: usize = 4000;
/// Bytes of a contact in the journal, on average.
const JOURNAL_BYTES_A_CONTACT: usize = 75;
/// Number of batches that may wait.
const WAITING: usize = 64;

/// Commits batches of the shards of this supervisor together.
#[derive(Debug, Clone)]
pub(crate) struct JointCommits {
    requests: mpsc::Sender<Request>,
    members: Arc<AtomicUsize>,
    /// Whether the database gains by it: SQLite writes to one file, one transaction after the other.
    is_useful: bool,
    /// Ticks are multiples of their periods after this time, for all shards.
    origin: Instant,
}

#[derive(Debug)]
struct Request {
    lease: Lease,
    batch: Arc<Batch>,
    /// Gets whether the batch was committed.
    answer: oneshot::Sender<bool>,
}

/// Takes part in joint commits until it is dropped.
#[derive(Debug)]
pub(crate) struct Member(JointCommits);

impl JointCommits {
    /// Starts a task that writes over its own connection, until all members are gone.
    pub(crate) fn start(store: &Store) -> Self {
        let (requests, received) = mpsc::channel(WAITING);
        tokio::spawn(commit_all(store.writer(), received));
        Self { requests, members: Arc::default(), is_useful: store.is_shared(), origin: Instant::now() }
    }

    /// Adds a shard.
    pub(crate) fn join(&self) -> Member {
        self.members.fetch_add(1, Ordering::Relaxed);
        Member(self.clone())
    }

    /// Ticks at the same times as those of all other shards.
    pub(crate) fn ticks(&self, period: Duration) -> Interval {
        let passed = self.origin.elapsed().div_duration_f64(period).floor() as u32;
        let mut ticks = interval_at(self.origin + period * (passed + 1), period);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
        ticks
    }

    /// Number of the tick with this period that was due at `due`; the same for all shards.
    pub(crate) fn tick_number(&self, period: Duration, due: Instant) -> u32 {
        due.saturating_duration_since(self.origin).div_duration_f64(period).round() as u32
    }
}

impl Member {
    /// Commits a batch together with those of other shards. Returns false if it must be committed on its own: because it
    /// is large, because no other shard is here, or because the attempt failed. Such an attempt may have been committed;
    /// [`Writer::commit`] recognises that.
    pub(super) async fn commit(&self, lease: &Lease, batch: &mut Batch) -> bool {
        let is_alone = self.0.members.load(Ordering::Relaxed) < 2;
        let has_others = self.0.is_useful && !is_alone;
        if !has_others || batch.is_empty() || !batch.fits_one_statement() || size(batch) > SIZE_OF_BATCH_MAX {
            return false;
        }
        let shared = Arc::new(std::mem::take(batch));
        let (answer, answered) = oneshot::channel();
        let request = Request { lease: lease.clone(), batch: shared.clone(), answer };
        let is_sent = self.0.requests.send(request).await.is_ok();
        let is_committed = is_sent && answered.await.unwrap_or(false);
        *batch = Arc::into_inner(shared).expect("dropped before the answer");
        is_committed
    }
}

impl Drop for Member {
    fn drop(&mut self) {
        self.0.members.fetch_sub(1, Ordering::Relaxed);
    }
}

/// Size of a batch: its rows, or its contacts in the journal if they have no rows.
fn size(batch: &Batch) -> usize {
    let journal_bytes = batch.journal.as_ref().map_or(0, |row| row.entries.len());
    let contacts = batch.contacts.len().max(journal_bytes / JOURNAL_BYTES_A_CONTACT);
    let others = batch.whiskers.len() + batch.records.len() + batch.responses.len();
    contacts + others + batch.rollups.len() + batch.events.len()
}

async fn commit_all(mut writer: Writer, mut requests: mpsc::Receiver<Request>) {
    while let Some(first) = requests.recv().await {
        if requests.is_empty() {
            sleep(GATHER).await;
        }
        let mut taken = size(&first.batch);
        let mut together = vec![first];
        while taken < SIZE_ENOUGH
            && let Ok(next) = requests.try_recv()
        {
            taken += size(&next.batch);
            together.push(next);
        }
        let batches: Vec<_> = together.iter().map(|request| (&request.lease, &*request.batch)).collect();
        let is_committed = writer.commit_together(&batches).await.unwrap_or_else(|problem| {
            debug!(%problem, batches = batches.len(), "a joint commit failed, each shard commits on its own");
            false
        });
        for Request { batch, answer, .. } in together {
            drop(batch);
            // An error means that the shard has ended.
            let _ = answer.send(is_committed);
        }
    }
}
