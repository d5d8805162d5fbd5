//! The parts of the cluster that fail. Each one borrows only its own processes, so several can fail at the same time.

use std::time::Duration;

use nix::sys::signal::Signal;
use sqlx::ConnectOptions;
use sqlx::postgres::PgConnectOptions;
use tokio::time::{sleep, timeout};
use vibrissa_tests::kafka::Kafka;
use vibrissa_tests::network::Network;
use vibrissa_tests::patroni::{Patroni, TTL_S};
use vibrissa_tests::process::Process;

use super::bridge::PARTITIONS;
use super::broker::Broker;
use super::plan::{Deed, SEPARATED, Victim};
use super::stage::{BROKERS, DATABASES, ETCD, FLEETS, KAFKA, SUPERVISOR};

/// A leader that stands still for a shorter time still has its lock.
const KEEPS_LOCK: Duration = Duration::from_secs(TTL_S - 2);
/// Number of records by which a position in Kafka is set back: about half a minute.
const SET_BACK: i64 = 50;
/// Time limit for that: then the fleets have other owners.
const SET_BACK_PATIENCE: Duration = Duration::from_secs(2);

/// The broker's nodes.
pub struct Brokers<'a> {
    pub nodes: &'a mut Broker,
    pub network: &'a Network,
}

impl Brokers<'_> {
    pub fn hit(&mut self, at: usize, deed: Deed) {
        match deed {
            Deed::Killed => self.nodes.kill(at),
            Deed::Frozen => self.nodes.freeze(at, true),
            _ => self.network.cut(BROKERS + at, true),
        }
    }

    pub fn repair(&mut self, at: usize, deed: Deed) {
        match deed {
            Deed::Killed => self.nodes.restart(at),
            Deed::Frozen => self.nodes.freeze(at, false),
            _ => self.network.cut(BROKERS + at, false),
        }
    }

    /// Ends all nodes and starts them again, because they run but messages do not pass.
    pub fn restart_all(&mut self) {
        eprintln!("chaos: messages do not pass between the broker's nodes: all are started again");
        self.nodes.restart_all();
    }
}

/// One of the supervisors.
pub struct Supervisor<'a> {
    /// Number of the supervisor, from 0.
    pub at: usize,
    pub process: &'a mut Process,
    pub network: &'a Network,
    /// The databases with the leases.
    pub servers: [PgConnectOptions; 2],
}

impl Supervisor<'_> {
    pub async fn hit(&mut self, deed: Deed) {
        match deed {
            Deed::Killed | Deed::KilledAndForgotten => self.process.kill(),
            Deed::KilledAndSetBack => {
                self.process.kill();
                self.set_back().await;
            }
            Deed::Frozen => self.process.signal(Signal::SIGSTOP),
            _ => self.network.cut(SUPERVISOR + self.at, true),
        }
    }

    pub fn repair(&mut self, deed: Deed) {
        match deed {
            Deed::Killed | Deed::KilledAndForgotten | Deed::KilledAndSetBack => self.process.restart(),
            Deed::Frozen => self.process.signal(Signal::SIGCONT),
            _ => self.network.cut(SUPERVISOR + self.at, false),
        }
    }

    /// Sets the positions of all partitions of all fleets back. Living owners write each again with the next records.
    async fn set_back(&self) {
        const SQL: &str =
            "UPDATE log_positions SET next = greatest(next - $1, 0) WHERE fleet = $2 AND log_partition = $3";
        let set_back = async {
            for server in &self.servers {
                let Ok(mut connection) = server.connect().await else { continue };
                let mut changed = 0;
                // One by one: together they could wait for a supervisor that waits for them.
                for (fleet, partition) in
                    FLEETS.into_iter().flat_map(|fleet| (0..PARTITIONS).map(move |one| (fleet, one)))
                {
                    let update = sqlx::query(SQL).bind(SET_BACK).bind(fleet).bind(i64::from(partition));
                    // The standby refuses it.
                    let Ok(done) = update.execute(&mut connection).await else { break };
                    changed += done.rows_affected();
                }
                if changed > 0 {
                    return;
                }
            }
            eprintln!("chaos: no database took the positions in Kafka");
        };
        if timeout(SET_BACK_PATIENCE, set_back).await.is_err() {
            eprintln!("chaos: the positions in Kafka were not set back in time");
        }
    }
}

/// The brokers of Kafka.
pub struct KafkaBrokers<'a> {
    pub nodes: &'a mut Kafka,
    pub network: &'a Network,
}

impl KafkaBrokers<'_> {
    pub fn hit(&mut self, at: usize, deed: Deed) {
        match deed {
            Deed::Killed => self.nodes.kill(at),
            Deed::Frozen => self.nodes.freeze(at, true),
            _ => self.network.cut(KAFKA + at, true),
        }
    }

    pub fn repair(&mut self, at: usize, deed: Deed) {
        match deed {
            Deed::Killed => self.nodes.begin_restart(at),
            Deed::Frozen => self.nodes.freeze(at, false),
            _ => self.network.cut(KAFKA + at, false),
        }
    }
}

/// The pair of databases and etcd.
pub struct Database<'a> {
    pub pair: &'a mut Patroni,
    pub network: &'a Network,
}

impl Database<'_> {
    /// `leader` is the number of the server that leads.
    pub async fn hit(&mut self, victim: Victim, deed: Deed, leader: usize) {
        match (victim, deed) {
            (Victim::Leader, Deed::SeparatedThenKilled) => {
                self.separate(leader, true);
                sleep(SEPARATED).await;
                self.pair.kill(leader);
            }
            (Victim::Etcd, Deed::Killed) => self.pair.kill_etcd(),
            (Victim::Etcd, Deed::Frozen) => self.pair.freeze_etcd(true),
            (Victim::Etcd, _) => self.network.cut(ETCD, true),
            (victim, deed) => {
                let node = server(victim, leader);
                match deed {
                    Deed::Killed => self.pair.kill(node),
                    Deed::Frozen => self.pair.freeze(node, true),
                    _ => self.network.cut(DATABASES + node, true),
                }
            }
        }
    }

    /// `leader` is the number of the server that led at the hit, `length` the time since then.
    pub fn repair(&mut self, victim: Victim, deed: Deed, leader: usize, length: Duration) {
        match (victim, deed) {
            (Victim::Leader, Deed::SeparatedThenKilled) => {
                self.separate(leader, false);
                self.pair.restart(leader);
            }
            (Victim::Etcd, Deed::Killed) => self.pair.restart_etcd(),
            (Victim::Etcd, Deed::Frozen) => self.pair.freeze_etcd(false),
            (Victim::Etcd, _) => self.network.cut(ETCD, false),
            (victim, deed) => {
                let node = server(victim, leader);
                match deed {
                    Deed::Killed => self.pair.restart(node),
                    Deed::Frozen if length < KEEPS_LOCK => self.pair.freeze(node, false),
                    // A watchdog resets such a machine before it continues. Patroni 3.0.2 loses commits without one:
                    // docs/postgresql.md.
                    Deed::Frozen => {
                        self.pair.kill(node);
                        self.pair.restart(node);
                    }
                    _ => self.network.cut(DATABASES + node, false),
                }
            }
        }
    }

    /// From the other server and from etcd, but not from supervisors.
    fn separate(&self, node: usize, is_separate: bool) {
        self.network.separate(DATABASES + node, &[DATABASES + 1 - node, ETCD], is_separate);
    }

    /// Whether each commit waits for a standby that may be promoted, and the leader has reached etcd since this time
    /// in seconds since 1970.
    pub async fn is_redundant(&self, since_s: f64) -> bool {
        let pair = &*self.pair;
        pair.is_replicated().await && pair.has_reached_etcd_since(since_s).await && pair.may_promote().await
    }

    /// The server that leads, once the pair is redundant; `None` after this time.
    pub async fn until_redundant(&self, patience: Duration) -> Option<usize> {
        let since_s = vibrissa_simulator::clock::now_us() as f64 / 1e6;
        let wait = async {
            loop {
                if self.is_redundant(since_s).await
                    && let Some(leader) = self.pair.leader().await
                {
                    return leader;
                }
                sleep(super::PAUSE).await;
            }
        };
        tokio::time::timeout(patience, wait).await.ok()
    }

    /// Starts the standby again. Patroni 3.0.2 may forget the standby at a start of its own beside a running leader, and notes
    /// it again when it returns: docs/postgresql.md.
    pub async fn restart_standby(&mut self) {
        if let Some(leader) = self.pair.leader().await {
            self.pair.kill(1 - leader);
            self.pair.restart(1 - leader);
        }
    }

    /// Makes a new standby, as `patronictl reinit` does: one that crashed while it followed a former leader may be unable to start.
    pub async fn rebuild_standby(&mut self) {
        if let Some(leader) = self.pair.leader().await {
            self.pair.rebuild(1 - leader);
        }
    }
}

fn server(victim: Victim, leader: usize) -> usize {
    if victim == Victim::Leader { leader } else { 1 - leader }
}
