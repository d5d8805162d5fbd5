//! Watches the leases of all fleets at the database's leader.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Row};
use tokio::task::JoinHandle;
use tokio::time::{sleep, timeout};

use super::stage::{FLEETS, SUPERVISORS};

/// Interval of the queries.
const PAUSE: Duration = Duration::from_millis(40);
/// Time limit of a query; a slower server is not the leader.
const PATIENCE: Duration = Duration::from_millis(500);

/// The lease of a fleet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lease {
    /// Epoch of its newest owner.
    pub epoch: i64,
    /// Name of that owner; `None` if it has released the fleet or the lease has expired.
    pub owner: Option<String>,
    /// Number of its commits.
    pub commits: i64,
}

/// The leases by fleet, as last seen.
pub type Leases = BTreeMap<String, Lease>;

/// Watches until it is dropped.
#[derive(Debug)]
pub struct Watch {
    seen: Arc<Mutex<Leases>>,
    task: JoinHandle<()>,
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Watch {
    /// Starts to watch the server of these that leads.
    pub fn start(servers: [PgConnectOptions; 2]) -> Self {
        let seen = Arc::new(Mutex::new(Leases::new()));
        let task = tokio::spawn(look(servers, seen.clone()));
        Self { seen, task }
    }

    /// The leases as last seen.
    pub fn leases(&self) -> Leases {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Epochs of the fleets that a supervisor owns.
    pub fn owned_by(&self, supervisor: &str) -> BTreeMap<String, i64> {
        let of = self.leases().into_iter().filter(|(_, lease)| lease.owner.as_deref() == Some(supervisor));
        of.map(|(fleet, lease)| (fleet, lease.epoch)).collect()
    }

    /// Number of these fleets that have a next owner.
    pub fn owned_again(&self, before: &BTreeMap<String, i64>) -> usize {
        self.taken(before, false)
    }

    /// Number of these fleets whose next owner has committed; without a fence, commits are not counted.
    pub fn taken(&self, before: &BTreeMap<String, i64>, has_fence: bool) -> usize {
        let leases = self.leases();
        let is_taken = |(fleet, epoch): &(&String, &i64)| {
            let lease = leases.get(*fleet);
            lease.is_some_and(|one| one.epoch > **epoch && one.owner.is_some() && (one.commits > 0 || !has_fence))
        };
        before.iter().filter(is_taken).count()
    }

    /// Whether all fleets have an owner, and all supervisors have an equal share.
    pub fn is_shared_evenly(&self) -> bool {
        let leases = self.leases();
        let least = FLEETS.len() / SUPERVISORS.len();
        let share = |name: &&str| leases.values().filter(|one| one.owner.as_deref() == Some(*name)).count();
        let shares: Vec<usize> = SUPERVISORS.iter().map(share).collect();
        shares.iter().sum::<usize>() == FLEETS.len() && shares.iter().all(|&share| share >= least)
    }
}

async fn look(servers: [PgConnectOptions; 2], seen: Arc<Mutex<Leases>>) {
    let mut connection: Option<PgConnection> = None;
    let mut at = 0;
    loop {
        sleep(PAUSE).await;
        let asked = timeout(PATIENCE, ask(&mut connection, &servers[at])).await;
        match asked {
            Ok(Some(leases)) => *seen.lock().unwrap_or_else(PoisonError::into_inner) = leases,
            Ok(None) | Err(_) => {
                connection = None;
                at = 1 - at;
            }
        }
    }
}

/// The leases; `None` if the server does not answer, or does not lead.
async fn ask(connection: &mut Option<PgConnection>, server: &PgConnectOptions) -> Option<Leases> {
    const SQL: &str = "SELECT pg_is_in_recovery(), fleet, epoch, \
        CASE WHEN owner IS NOT NULL AND expires_us > clock_us() THEN holder END, commits \
        FROM leases";
    if connection.is_none() {
        *connection = server.connect().await.ok();
    }
    let rows = sqlx::query(SQL).fetch_all(connection.as_mut()?).await.ok()?;
    if rows.iter().any(|row| row.get(0)) {
        return None;
    }
    let lease =
        |row: &sqlx::postgres::PgRow| (row.get(1), Lease { epoch: row.get(2), owner: row.get(3), commits: row.get(4) });
    Some(rows.iter().map(lease).collect())
}
