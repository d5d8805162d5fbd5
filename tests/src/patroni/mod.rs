//! Runs a cluster of two PostgreSQL servers with Patroni and one etcd, on free ports and in a temporary folder.

mod network;
mod node;

use std::os::unix::fs::chown;
use std::path::Path;
use std::time::Duration;

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Executor, Row};
use tempfile::TempDir;
use tokio::time::timeout;

use crate::mosquitto::free_port;
use crate::postgres::{DATABASE, USER, account};
use crate::process::{Launch, Process};
use crate::wait::until_within;

use network::Network;
use node::Node;

/// Seconds after which Patroni replaces a silent leader, at least.
pub const TTL_S: u64 = 5;
/// Time limit for a start, a failover or a rejoin.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time limit of a question to a server, which may be frozen.
const ANSWER: Duration = Duration::from_millis(500);

/// The running cluster, stopped on drop.
#[derive(Debug)]
pub struct Patroni {
    nodes: [Node; 2],
    etcd: Process,
    network: Option<Network>,
    _folder: TempDir,
}

impl Patroni {
    /// Starts the cluster with `synchronous_mode`, and waits until node 0 leads and node 1 replicates.
    ///
    /// # Panics
    /// A program is not installed, or the cluster does not start.
    pub async fn start() -> Self {
        Self::start_with(None).await
    }

    /// Starts the cluster with node 0 in a network namespace of its own, which [`Self::cut_off`] disconnects; `None` if
    /// namespaces cannot be made here, which needs root.
    ///
    /// # Panics
    /// As [`Self::start`].
    pub async fn start_with_network() -> Option<Self> {
        Some(Self::start_with(Some(Network::make()?)).await)
    }

    async fn start_with(network: Option<Network>) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        if let Some((uid, gid)) = account() {
            chown(folder.path(), Some(uid), Some(gid)).expect("a folder of ours");
        }
        let (outside, inside) = match &network {
            Some(network) => (network.outside(), network.inside()),
            None => ("127.0.0.1".to_owned(), "127.0.0.1".to_owned()),
        };
        let etcd_port = free_port();
        let etcd = etcd(folder.path(), &outside, etcd_port);
        let namespace = network.as_ref().map(Network::name);
        let etcd_address = format!("{outside}:{etcd_port}");
        let first = Node::start("a", folder.path(), &inside, &etcd_address, namespace);
        let mut cluster = Self {
            nodes: [first, Node::new("b", folder.path(), &outside, &etcd_address, None)],
            etcd,
            network,
            _folder: folder,
        };
        cluster.until_leader(0).await;
        let mut connection = cluster.options(0, "postgres").connect().await.expect("a leader");
        connection.execute("CREATE DATABASE vibrissa").await.expect("a new server");
        cluster.nodes[1].restart();
        cluster.until_replicated().await;
        cluster
    }

    /// URL of the database, which names both servers.
    #[must_use]
    pub fn url(&self) -> String {
        let [a, b] = self.nodes.each_ref().map(Node::address);
        format!("postgres://{USER}@{a},{b}/{DATABASE}?target_session_attrs=read-write")
    }

    /// Options for a connection to the database at a node.
    #[must_use]
    pub fn connect(&self, node: usize) -> PgConnectOptions {
        self.options(node, DATABASE)
    }

    fn options(&self, node: usize, database: &str) -> PgConnectOptions {
        let Node { host, port, .. } = &self.nodes[node];
        PgConnectOptions::new().host(host).port(*port).username(USER).database(database)
    }

    /// Address of PostgreSQL at a node, and port of Patroni's REST API there.
    #[must_use]
    pub fn addresses(&self, node: usize) -> (String, u16) {
        (self.nodes[node].address(), self.nodes[node].rest_port)
    }

    /// Log of Patroni and of PostgreSQL at a node.
    #[must_use]
    pub fn log(&self, node: usize) -> String {
        self.nodes[node].log()
    }

    /// The answer of a node to a query of one row; `None` without an answer.
    pub async fn ask<T>(&self, node: usize, sql: &'static str) -> Option<T>
    where
        T: for<'r> sqlx::Decode<'r, sqlx::Postgres> + sqlx::Type<sqlx::Postgres>,
    {
        let asked = async {
            let mut connection: PgConnection = self.options(node, "postgres").connect().await.ok()?;
            connection.fetch_one(sql).await.ok()?.try_get(0).ok()
        };
        timeout(ANSWER, asked).await.ok()?
    }

    /// Whether a node accepts writes.
    pub async fn leads(&self, node: usize) -> bool {
        self.ask(node, "SELECT NOT pg_is_in_recovery()").await.unwrap_or(false)
    }

    /// Waits until a node accepts writes.
    pub async fn until_leader(&self, node: usize) {
        until_within(PATIENCE, "a leader of the cluster", async || self.leads(node).await.then_some(())).await;
    }

    /// Waits until each commit of the leader waits for the other node.
    pub async fn until_replicated(&self) {
        const SQL: &str = "SELECT count(*) FROM pg_stat_replication WHERE sync_state = 'sync'";
        until_within(PATIENCE, "a synchronous standby", async || {
            for node in 0..2 {
                if self.leads(node).await && self.ask(node, SQL).await == Some(1_i64) {
                    return Some(());
                }
            }
            None
        })
        .await;
    }

    /// Kills Patroni and PostgreSQL of a node, as a loss of power does.
    pub fn kill(&mut self, node: usize) {
        self.nodes[node].kill();
    }

    /// Starts a killed node again.
    pub fn restart(&mut self, node: usize) {
        self.nodes[node].restart();
    }

    /// Stops all processes of a node with SIGSTOP, or continues them.
    pub fn freeze(&self, node: usize, is_frozen: bool) {
        self.nodes[node].freeze(is_frozen);
    }

    /// Disconnects node 0 from everything, or connects it again. Needs [`Self::start_with_network`].
    ///
    /// # Panics
    /// The cluster has no network of its own.
    pub fn cut_off(&self, is_off: bool) {
        self.network.as_ref().expect("a network of its own").cut(is_off);
    }

    /// Kills etcd, without which Patroni's leader gives up.
    pub fn kill_etcd(&mut self) {
        self.etcd.kill();
    }

    /// Starts etcd again.
    pub fn restart_etcd(&mut self) {
        self.etcd.restart();
    }
}

fn etcd(folder: &Path, host: &str, port: u16) -> Process {
    let (client, peer) = (format!("http://{host}:{port}"), format!("http://127.0.0.1:{}", free_port()));
    let arguments = ["--name", "e", "--listen-client-urls", &client, "--advertise-client-urls", &client]
        .into_iter()
        .chain(["--listen-peer-urls", &peer, "--initial-advertise-peer-urls", &peer])
        .map(str::to_owned)
        .chain(["--initial-cluster".to_owned(), format!("e={peer}")])
        .chain(["--data-dir".to_owned(), folder.join("etcd").display().to_string()]);
    Process::start(Launch {
        program: "etcd".into(),
        arguments: arguments.collect(),
        environment: Vec::new(),
        log: folder.join("etcd.log"),
    })
}
