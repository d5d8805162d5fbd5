//! Watches the database for the fleet's owner and for its first commit.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{Connection, Row};
use tokio::task::JoinHandle;
use tokio::time::timeout;

use crate::scenario::FLEET;

/// Interval of the queries.
const PAUSE: Duration = Duration::from_millis(20);
/// Time limit of a query; a slower database counts as down.
const PATIENCE: Duration = Duration::from_secs(1);
/// Time in which a supervisor must become owner and record contacts before a fault for the owner strikes.
pub const OWNER_PATIENCE: Duration = Duration::from_secs(15);
/// The same at the start, when no fault has struck yet: servers and supervisors start on a machine with other tests.
pub const START_PATIENCE: Duration = Duration::from_secs(120);

/// An owner that has recorded contacts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reign {
    /// Epoch of the lease.
    pub epoch: i64,
    /// Name of the supervisor.
    pub holder: String,
    /// Time at which its first contacts appeared in the database.
    pub first_commit: Instant,
}

/// Observations so far.
#[derive(Debug, Default)]
struct Seen {
    /// Owners that have recorded contacts, in order.
    reigns: Vec<Reign>,
    /// Newest epoch, even if its owner has not recorded anything.
    epoch: i64,
}

/// Watches the database until it is dropped.
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
    /// Starts to watch the database.
    pub fn start(database: PgConnectOptions) -> Self {
        let seen = Arc::new(Mutex::new(Seen::default()));
        let task = tokio::spawn(look(database, seen.clone()));
        Self { seen, task }
    }

    /// All reigns so far, in order.
    pub fn reigns(&self) -> Vec<Reign> {
        locked(&self.seen).reigns.clone()
    }

    /// Waits for an owner with at least this epoch that has recorded contacts, for at most this time.
    pub async fn owner(&self, epoch_min: i64, patience: Duration) -> Option<Reign> {
        let deadline = Instant::now() + patience;
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

/// The lease and the number of its owner's commits.
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
            // Only this supervisor can record from now on: the epoch fences the others out.
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

/// Queries the database over the existing connection, or over a new one.
async fn ask(connection: &mut Option<PgConnection>, database: &PgConnectOptions) -> Option<Look> {
    // Without a fence the supervisor does not count commits, but it still writes states.
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
