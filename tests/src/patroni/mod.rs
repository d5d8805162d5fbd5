//! Runs a cluster of two PostgreSQL servers with Patroni and one etcd, on free ports and in a temporary folder.

mod node;

use std::os::unix::fs::chown;
use std::path::Path;
use std::time::Duration;

use nix::sys::signal::Signal;
use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Executor, Row};
use tempfile::TempDir;
use tokio::time::{sleep, timeout};

use crate::mosquitto::free_port;
use crate::network::{Network, ServerAddress};
use crate::postgres::{DATABASE, USER, account};
use crate::process::{Launch, Process};
use crate::wait::until_within;

use node::Node;

/// Seconds after which Patroni replaces a silent leader, at least.
pub const TTL_S: u64 = 5;
/// Time limit for a start, a failover or a rejoin.
const PATIENCE: Duration = Duration::from_secs(60);
/// Time limit of a question to a server, which may be frozen.
const ANSWER: Duration = Duration::from_millis(500);
const PAUSE: Duration = Duration::from_millis(20);

/// The running cluster, stopped on drop.
#[derive(Debug)]
pub struct Patroni {
    nodes: [Node; 2],
    etcd: Process,
    network: Option<Network>,
    is_synchronous: bool,
    _folder: TempDir,
}

impl Patroni {
    /// Starts the cluster with `synchronous_mode`, and waits until node 0 leads and node 1 replicates.
    ///
    /// # Panics
    /// A program is not installed, or the cluster does not start.
    pub async fn start() -> Self {
        Self::start_at(&[ServerAddress::here(), ServerAddress::here()], &ServerAddress::here(), true).await
    }

    /// Starts the cluster with node 0 in a network namespace of its own, which [`Self::cut_off`] disconnects; `None` if
    /// namespaces cannot be made here, which needs root.
    ///
    /// # Panics
    /// As [`Self::start`].
    pub async fn start_with_network() -> Option<Self> {
        let network = Network::make(1)?;
        let here = network.here();
        let mut cluster = Self::start_at(&[network.place(0), here.clone()], &here, true).await;
        cluster.network = Some(network);
        Some(cluster)
    }

    /// Starts the cluster with its nodes and etcd at these places, and with `synchronous_mode` or without.
    ///
    /// # Panics
    /// As [`Self::start`].
    pub async fn start_at(nodes: &[ServerAddress; 2], etcd_place: &ServerAddress, is_synchronous: bool) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        if let Some((uid, gid)) = account() {
            chown(folder.path(), Some(uid), Some(gid)).expect("a folder of ours");
        }
        let etcd_port = free_port();
        let etcd = etcd(folder.path(), etcd_place, etcd_port);
        let etcd_address = format!("{}:{etcd_port}", etcd_place.host);
        let [a, b] = nodes;
        let first = Node::start("a", folder.path(), a, &etcd_address, is_synchronous);
        let second = Node::new("b", folder.path(), b, &etcd_address, is_synchronous);
        let mut cluster = Self { nodes: [first, second], etcd, network: None, is_synchronous, _folder: folder };
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
        accepts_writes(&self.options(node, "postgres")).await
    }

    /// Waits until a node accepts writes.
    pub async fn until_leader(&self, node: usize) {
        until_within(PATIENCE, "a leader of the cluster", async || self.leads(node).await.then_some(())).await;
    }

    /// Waits until each commit of the leader waits for the other node, and Patroni has noted this; without
    /// `synchronous_mode` until it goes there. If the standby fails between both, Patroni 3.0 does not notice it, and commits
    /// wait until the standby is back.
    pub async fn until_replicated(&self) {
        let waited = async {
            while !(self.is_replicated().await && self.may_promote().await) {
                sleep(PAUSE).await;
            }
        };
        if timeout(PATIENCE, waited).await.is_err() {
            let logs = [0, 1].map(|node| self.log(node));
            panic!("timed out waiting for a standby\nlog of node 0:\n{}\nlog of node 1:\n{}", logs[0], logs[1]);
        }
    }

    /// Whether each commit of the leader waits for the other node; without `synchronous_mode` whether it goes there.
    pub async fn is_replicated(&self) -> bool {
        const SYNCHRONOUS: &str = "SELECT count(*) FROM pg_stat_replication WHERE sync_state = 'sync'";
        const ANY: &str = "SELECT count(*) FROM pg_stat_replication WHERE state = 'streaming'";
        let sql = if self.is_synchronous { SYNCHRONOUS } else { ANY };
        match self.leader().await {
            Some(leader) => self.ask(leader, sql).await == Some(1_i64),
            None => false,
        }
    }

    /// The node that accepts writes.
    pub async fn leader(&self) -> Option<usize> {
        for node in 0..2 {
            if self.leads(node).await {
                return Some(node);
            }
        }
        None
    }

    /// Whether the leader's Patroni has reached etcd since this time, in seconds since 1970: a leader that has missed etcd
    /// gives up only some seconds later.
    pub async fn has_reached_etcd_since(&self, time_s: f64) -> bool {
        let member = self.ask_patroni("/patroni").await;
        member["role"] != "replica" && member["dcs_last_seen"].as_f64().is_some_and(|seen| seen > time_s)
    }

    /// Whether Patroni may promote the other node: with `synchronous_mode` only one that it has noted as synchronous, which
    /// happens after PostgreSQL waits for it.
    pub async fn may_promote(&self) -> bool {
        let cluster = self.ask_patroni("/cluster").await;
        let role = if self.is_synchronous { "sync_standby" } else { "replica" };
        cluster["members"].as_array().is_some_and(|members| members.iter().any(|one| one["role"] == role))
    }

    /// The answer of the leader's Patroni; null without one.
    async fn ask_patroni(&self, path: &str) -> serde_json::Value {
        let Some(leader) = self.leader().await else { return serde_json::Value::Null };
        let Node { host, rest_port, .. } = &self.nodes[leader];
        let Ok(address) = format!("{host}:{rest_port}").parse() else { return serde_json::Value::Null };
        match timeout(ANSWER, crate::web::try_get(address, path)).await {
            Ok(Ok((_, body))) => serde_json::from_str(&body).unwrap_or_default(),
            Ok(Err(_)) | Err(_) => serde_json::Value::Null,
        }
    }

    /// Kills Patroni and PostgreSQL of a node, as a loss of power does.
    pub fn kill(&mut self, node: usize) {
        self.nodes[node].kill();
    }

    /// Starts a killed node again.
    pub fn restart(&mut self, node: usize) {
        self.nodes[node].restart();
    }

    /// Ends a server and starts it again without its data, which it copies from the leader.
    pub fn rebuild(&mut self, node: usize) {
        self.nodes[node].kill();
        self.nodes[node].remove_data();
        self.nodes[node].restart();
    }

    /// Stops all processes of a node with SIGSTOP, or continues them.
    pub fn freeze(&self, node: usize, is_frozen: bool) {
        self.nodes[node].freeze(is_frozen);
    }

    /// Kills Patroni of a node, and continues its PostgreSQL if that is frozen: a server that accepts writes although another
    /// one leads. [`Self::restart`] starts Patroni again.
    pub fn kill_patroni(&mut self, node: usize) {
        self.nodes[node].kill_patroni();
    }

    /// Disconnects node 0 from everything, or connects it again. Needs [`Self::start_with_network`].
    ///
    /// # Panics
    /// The cluster has no network of its own.
    pub fn cut_off(&self, is_off: bool) {
        self.network.as_ref().expect("a network of its own").cut(0, is_off);
    }

    /// Kills etcd, without which Patroni's leader gives up.
    pub fn kill_etcd(&mut self) {
        self.etcd.kill();
    }

    /// Stops etcd with SIGSTOP, or continues it.
    pub fn freeze_etcd(&self, is_frozen: bool) {
        self.etcd.signal(if is_frozen { Signal::SIGSTOP } else { Signal::SIGCONT });
    }

    /// Starts etcd again.
    pub fn restart_etcd(&mut self) {
        self.etcd.restart();
    }
}

/// Whether a server accepts writes.
pub async fn accepts_writes(server: &PgConnectOptions) -> bool {
    let asked = async {
        let mut connection: PgConnection = server.connect().await.ok()?;
        connection.fetch_one("SELECT NOT pg_is_in_recovery()").await.ok()?.try_get(0).ok()
    };
    timeout(ANSWER, asked).await.ok().flatten().unwrap_or(false)
}

fn etcd(folder: &Path, place: &ServerAddress, port: u16) -> Process {
    let host = &place.host;
    let (client, peer) = (format!("http://{host}:{port}"), format!("http://127.0.0.1:{}", free_port()));
    let arguments = ["--name", "e", "--listen-client-urls", &client, "--advertise-client-urls", &client]
        .into_iter()
        .chain(["--listen-peer-urls", &peer, "--initial-advertise-peer-urls", &peer])
        .map(str::to_owned)
        .chain(["--initial-cluster".to_owned(), format!("e={peer}")])
        .chain(["--data-dir".to_owned(), folder.join("etcd").display().to_string()]);
    Process::start(place.launch(Launch {
        program: "etcd".into(),
        arguments: arguments.collect(),
        environment: Vec::new(),
        log: folder.join("etcd.log"),
    }))
}
