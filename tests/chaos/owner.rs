//! Who supervises, as the database says, and since when to some effect.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{Connection, Row};
use tokio::task::JoinHandle;
use tokio::time::timeout;

use crate::scenario::FLEET;

/// How often the database is asked.
const PAUSE: Duration = Duration::from_millis(20);
/// A database that takes longer is not there.
const PATIENCE: Duration = Duration::from_secs(1);
/// How long somebody may take to become the owner and to record contacts, before a fault that is for the owner.
const OWNER_PATIENCE: Duration = Duration::from_secs(15);

/// An owner that has recorded contacts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reign {
    /// Its epoch.
    pub epoch: i64,
    /// What it is called.
    pub holder: String,
    /// When its first contacts were seen in the database.
    pub first_commit: Instant,
}

/// What was seen so far.
#[derive(Debug, Default)]
struct Seen {
    /// Owners that have recorded contacts, in their order.
    reigns: Vec<Reign>,
    /// The newest epoch, whether or not its owner has recorded anything.
    epoch: i64,
}

/// Keeps looking; dropped, it looks no more.
#[derive(Debug)]
pub struct Watch {
    seen: Arc<Mutex<Seen>>,
    task: JoinHandle<()>,
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Watch {
    /// Begins to look.
    pub fn start(database: PgConnectOptions) -> Self {
        let seen = Arc::new(Mutex::new(Seen::default()));
        let task = tokio::spawn(look(database, seen.clone()));
        Self { seen, task }
    }

    /// All so far, in their order.
    pub fn reigns(&self) -> Vec<Reign> {
        locked(&self.seen).reigns.clone()
    }

    /// The owner, as soon as it has recorded contacts; its epoch is at least that.
    pub async fn owner(&self, epoch_min: i64) -> Option<Reign> {
        let deadline = Instant::now() + OWNER_PATIENCE;
        loop {
            let last = {
                let seen = locked(&self.seen);
                seen.reigns.last().filter(|reign| reign.epoch == seen.epoch && reign.epoch >= epoch_min).cloned()
            };
            if last.is_some() || Instant::now() > deadline {
                return last;
            }
            tokio::time::sleep(PAUSE).await;
        }
    }
}

/// The row of the lease, with how often its owner has committed.
struct Look {
    epoch: i64,
    holder: Option<String>,
    commits: i64,
}

fn locked(seen: &Mutex<Seen>) -> MutexGuard<'_, Seen> {
    seen.lock().unwrap_or_else(PoisonError::into_inner)
}

async fn look(database: PgConnectOptions, all: Arc<Mutex<Seen>>) {
    let mut connection = None;
    let mut candidate: Option<Look> = None;
    loop {
        tokio::time::sleep(PAUSE).await;
        let Some(seen) = ask(&mut connection, &database).await else { continue };
        match &candidate {
            // Whatever is recorded from here on is recorded by this one: the epoch keeps the others out.
            Some(known) if known.epoch == seen.epoch => {
                let Some(holder) = seen.holder.filter(|_| seen.commits > known.commits) else { continue };
                let reign = Reign { epoch: seen.epoch, holder, first_commit: Instant::now() };
                let mut all = locked(&all);
                if all.reigns.last().is_none_or(|last| last.epoch < seen.epoch) {
                    all.reigns.push(reign);
                }
            }
            Some(_) | None => {
                locked(&all).epoch = seen.epoch;
                candidate = Some(seen);
            }
        }
    }
}

/// Asks over the connection that is there, or makes one.
async fn ask(connection: &mut Option<PgConnection>, database: &PgConnectOptions) -> Option<Look> {
    // Without a fence commits are not counted, but states are written all the same.
    const SQL: &str = "SELECT epoch, holder, \
        commits + coalesce((SELECT max(journal_number) FROM robots r WHERE r.fleet = l.fleet), 0) \
        FROM leases l WHERE fleet = $1";
    if connection.is_none() {
        *connection = timeout(PATIENCE, PgConnection::connect_with(database)).await.ok()?.ok();
    }
    let asked = timeout(PATIENCE, sqlx::query(SQL).bind(FLEET).fetch_optional(connection.as_mut()?)).await;
    let Ok(Ok(row)) = asked else {
        *connection = None;
        return None;
    };
    let row = row?;
    Some(Look { epoch: row.get(0), holder: row.get(1), commits: row.get(2) })
}
