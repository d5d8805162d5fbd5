//! The way to the server that accepts writes: of several servers, one is the leader, and after a failover another one.
//!
//! A writer that needs a connection tries the servers, the last leader first. Its success directs the pool, whose older
//! connections are closed: a former leader may be frozen or cut off, and answer never or too late.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use futures_util::StreamExt;
use futures_util::future::BoxFuture;
use futures_util::stream::FuturesUnordered;
use sqlx::pool::PoolConnectionMetadata;
use sqlx::postgres::{PgConnectOptions, PgConnection, PgPool, PgPoolOptions};
use sqlx::{ConnectOptions, Connection};
use tokio::sync::watch;
use tokio::time::{Instant, sleep, timeout};
use tracing::info;

use super::role::{self, Leader};
use crate::address::{PostgresAddress, place};
use crate::database::ACQUIRE_PATIENCE;
use crate::no_server::{NoServer, Refusal};

/// Most connections of the pool.
const CONNECTIONS: u32 = 5;
/// Time that a server has for itself before the next one is tried, too: a frozen one must not cost its whole time limit.
const HEAD_START: Duration = Duration::from_millis(300);
/// Time limit of the test of an idle connection of the pool.
const TEST_PATIENCE: Duration = Duration::from_secs(1);

/// Result of one server: its index, and the connection or the reason against it.
type Tried = (usize, Result<(PgConnection, Leader), Refusal>);

/// Server that accepted writes last.
#[derive(Debug)]
struct Known {
    /// Index of the server that accepted writes last.
    server: usize,
    leader: Option<Leader>,
    /// Time of the last change of the leader: older connections are not used.
    since: Instant,
}

/// The servers, and the pool of connections to the leader.
#[derive(Debug)]
pub(crate) struct Route {
    address: PostgresAddress,
    pool: PgPool,
    known: Arc<Mutex<Known>>,
    changes: watch::Sender<u64>,
}

impl Route {
    /// Opens no connection yet.
    pub(super) fn new(address: PostgresAddress) -> Self {
        let known = Arc::new(Mutex::new(Known { server: 0, leader: None, since: Instant::now() }));
        let of_pool = known.clone();
        let of_new = known.clone();
        let pool = PgPoolOptions::new()
            .max_connections(CONNECTIONS)
            .acquire_timeout(ACQUIRE_PATIENCE)
            // `before_acquire` tests within a time limit.
            .test_before_acquire(false)
            .after_connect(move |link, _| {
                let known = of_new.clone();
                Box::pin(async move { accepted(link, &known).await })
            })
            .before_acquire(move |link, idle| {
                let is_old = is_older(&of_pool, &idle);
                Box::pin(
                    async move { Ok(!is_old && timeout(TEST_PATIENCE, link.ping()).await.is_ok_and(|ok| ok.is_ok())) },
                )
            })
            .connect_lazy_with((*address).clone());
        Self { address, pool, known, changes: watch::Sender::new(0) }
    }

    /// The pool of connections for queries.
    pub(super) fn pool(&self) -> &PgPool {
        &self.pool
    }

    /// Whether there are several servers.
    pub(crate) fn has_several_servers(&self) -> bool {
        self.address.servers().len() > 1
    }

    /// Counts the changes of the leader.
    pub(crate) fn changes(&self) -> watch::Receiver<u64> {
        self.changes.subscribe()
    }

    /// Opens a connection to the server that accepts writes. Tries the servers one after the other, each of them after the
    /// one before has failed or has had its head start.
    pub(crate) async fn connect(&self) -> Result<PgConnection, NoServer> {
        let address = self.address.with_password_read_again();
        let patience = address.connect_timeout();
        let first = self.known.lock().unwrap_or_else(PoisonError::into_inner).server;
        let servers = address.servers();
        let mut waiting = (0..servers.len()).map(|at| (at + first) % servers.len());
        let (mut trying, mut refused) = (FuturesUnordered::new(), Vec::new());
        loop {
            if trying.is_empty() && !start_next(&mut waiting, servers, patience, &trying) {
                return Err(NoServer(refused));
            }
            let tried = tokio::select! {
                tried = trying.next() => tried,
                () = sleep(HEAD_START) => {
                    start_next(&mut waiting, servers, patience, &trying);
                    continue;
                }
            };
            let Some((at, tried)) = tried else { continue };
            let tried = tried.and_then(|(link, leader)| self.admit(leader).map(|()| (link, leader)));
            let Some(server) = servers.get(at) else { continue };
            match tried {
                Ok((link, leader)) => {
                    self.lead_to(at, server, leader);
                    return Ok(link);
                }
                Err(refusal) => {
                    refused.push((place(server), refusal));
                    start_next(&mut waiting, servers, patience, &trying);
                }
            }
        }
    }

    /// Refuses a leader of a timeline that has ended: it was cut off or frozen, and does not know its successor yet.
    fn admit(&self, leader: Leader) -> Result<(), Refusal> {
        admit(self.known.lock().unwrap_or_else(PoisonError::into_inner).leader, leader)
    }

    /// Notes the leader, and directs the pool to it.
    fn lead_to(&self, server: usize, options: &PgConnectOptions, leader: Leader) {
        self.pool.set_connect_options(options.clone());
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let before = known.leader.replace(leader);
        let is_new = known.server != server || before.is_some_and(|before| before != leader);
        known.server = server;
        if is_new {
            known.since = Instant::now();
        }
        drop(known);
        if is_new {
            info!(server = %place(options), timeline = leader.timeline, "the database has a new leader");
            self.changes.send_modify(|changes| *changes += 1);
        }
    }
}

/// Begins to connect to the next server; false after the last one.
fn start_next(
    waiting: &mut impl Iterator<Item = usize>,
    servers: &[PgConnectOptions],
    patience: Duration,
    trying: &FuturesUnordered<BoxFuture<'static, Tried>>,
) -> bool {
    let Some((at, server)) = waiting.next().and_then(|at| Some((at, servers.get(at)?.clone()))) else { return false };
    trying.push(Box::pin(async move {
        let opened = async {
            let mut link = server.connect().await.map_err(Refusal::Failed)?;
            let leader = role::ask(&mut link).await?;
            Ok((link, leader))
        };
        (at, timeout(patience, opened).await.unwrap_or(Err(Refusal::NoAnswer(patience))))
    }));
    true
}

fn admit(known: Option<Leader>, leader: Leader) -> Result<(), Refusal> {
    match known {
        Some(known) if known.cluster == leader.cluster && known.timeline > leader.timeline => {
            Err(Refusal::Outdated { timeline: leader.timeline, newest: known.timeline })
        }
        Some(_) | None => Ok(()),
    }
}

/// Checks a new connection of the pool. After an error the pool tries again, with the server that is known then.
async fn accepted(link: &mut PgConnection, known: &Mutex<Known>) -> sqlx::Result<()> {
    let leader = role::ask(link).await.map_err(refused)?;
    let known = known.lock().unwrap_or_else(PoisonError::into_inner).leader;
    admit(known, leader).map_err(refused)
}

fn refused(refusal: Refusal) -> sqlx::Error {
    match refusal {
        Refusal::Failed(problem) => problem,
        Refusal::NoAnswer(_) | Refusal::Standby | Refusal::ReadOnly | Refusal::Outdated { .. } => {
            sqlx::Error::Io(std::io::Error::other(format!("the server is not used: {refusal}")))
        }
    }
}

/// Whether a connection of the pool is older than the last change of the leader.
fn is_older(known: &Mutex<Known>, connection: &PoolConnectionMetadata) -> bool {
    known.lock().unwrap_or_else(PoisonError::into_inner).since.elapsed() < connection.age
}
