//! RMQTT: one node, or a cluster by Raft.

use std::fs;
use std::path::{Path, PathBuf};

use nix::sys::signal::Signal;
use tempfile::TempDir;

use crate::installed::{installed, listens};
use crate::mosquitto::free_port;
use crate::network::ServerAddress;
use crate::process::{Launch, Process};

/// Attempts to start: another test may take a port between the check and the start of the nodes.
const ATTEMPTS: usize = 3;

/// A node: its place, and its ports for MQTT, gRPC and Raft.
#[derive(Debug, Clone)]
struct Node {
    host: String,
    mqtt: u16,
    grpc: u16,
    raft: u16,
}

/// Settings of the plugins: the lines of the access list, and the file of the bridge to Kafka.
struct Plugins<'a> {
    rules: &'a str,
    bridge: Option<&'a str>,
}

/// Running nodes; killed on drop.
#[derive(Debug)]
pub struct Rmqtt {
    processes: Vec<Process>,
    nodes: Vec<Node>,
    folder: TempDir,
}

impl Rmqtt {
    /// Starts this number of nodes on 127.0.0.1; `None` if RMQTT is not installed. `rules` are the lines of its access list.
    ///
    /// # Panics
    /// It does not start.
    #[must_use]
    pub fn start(count: usize, rules: &str) -> Option<Self> {
        Self::start_at(&vec![ServerAddress::here(); count], rules)
    }

    /// Starts one node on 127.0.0.1 whose bridge to Kafka has these settings; `None` if RMQTT is not installed.
    ///
    /// # Panics
    /// It does not start.
    #[must_use]
    pub fn start_with_bridge(rules: &str, bridge: &str) -> Option<Self> {
        Self::start_with(&[ServerAddress::here()], &Plugins { rules, bridge: Some(bridge) })
    }

    /// Starts a node at each of these places.
    ///
    /// # Panics
    /// It does not start.
    #[must_use]
    pub fn start_at(places: &[ServerAddress], rules: &str) -> Option<Self> {
        Self::start_with(places, &Plugins { rules, bridge: None })
    }

    fn start_with(places: &[ServerAddress], plugins: &Plugins<'_>) -> Option<Self> {
        let program = installed("rmqtt", Some("--if-installed"))?;
        let started = (0..ATTEMPTS).find_map(|_| Self::try_start(&program, places, plugins));
        Some(started.expect("RMQTT starts"))
    }

    fn try_start(program: &Path, places: &[ServerAddress], plugins: &Plugins<'_>) -> Option<Self> {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let node = |place: &ServerAddress| Node {
            host: place.host.clone(),
            mqtt: free_port(),
            grpc: free_port(),
            raft: free_port(),
        };
        let nodes: Vec<Node> = places.iter().map(node).collect();
        let mut processes = Vec::new();
        for (at, place) in places.iter().enumerate() {
            let home = home(&folder, at);
            configure(&home, at, &nodes, plugins);
            configure_cluster(&home, 0, &nodes);
            let arguments = ["-f".to_owned(), home.join("rmqtt.toml").display().to_string()];
            processes.push(Process::start(place.launch(Launch {
                program: program.to_owned(),
                arguments: arguments.to_vec(),
                environment: Vec::new(),
                log: home.join("log"),
            })));
        }
        let all_listen = nodes
            .iter()
            .zip(&mut processes)
            .all(|(node, process)| listens(&node.host, node.mqtt, || process.ended_already().is_some()));
        all_listen.then(|| Self { processes, nodes, folder })
    }

    /// MQTT ports of the nodes.
    #[must_use]
    pub fn ports(&self) -> Vec<u16> {
        self.nodes.iter().map(|node| node.mqtt).collect()
    }

    /// Hosts and MQTT ports of the nodes.
    #[must_use]
    pub fn addresses(&self) -> Vec<(String, u16)> {
        self.nodes.iter().map(|node| (node.host.clone(), node.mqtt)).collect()
    }

    /// Log of a node.
    #[must_use]
    pub fn log(&self, node: usize) -> String {
        fs::read_to_string(home(&self.folder, node).join("log")).unwrap_or_default()
    }

    /// Kills a node.
    pub fn kill(&mut self, node: usize) {
        self.processes[node].kill();
    }

    /// Stops a node with SIGSTOP, or continues it.
    pub fn freeze(&self, node: usize, is_frozen: bool) {
        self.processes[node].signal(if is_frozen { Signal::SIGSTOP } else { Signal::SIGCONT });
    }

    /// Starts a killed node again. It joins the others; if none runs, it founds a cluster.
    pub fn restart(&mut self, node: usize) {
        let other = (0..self.nodes.len()).find(|&at| at != node && self.processes[at].is_running());
        configure_cluster(&home(&self.folder, node), other.unwrap_or(node), &self.nodes);
        self.processes[node].restart();
    }

    /// Ends all nodes and starts them again. Two of three nodes must not be away while the third one runs: it has no majority
    /// then, and nobody can join it.
    pub fn restart_all(&mut self) {
        for process in &mut self.processes {
            if process.ended_already().is_none() && process.is_running() {
                process.kill();
            }
        }
        (0..self.nodes.len()).for_each(|node| self.restart(node));
    }

    /// Starts nodes again that have ended on their own; their number.
    pub fn revive(&mut self) -> u64 {
        // First find all nodes that have ended, because a start depends on the nodes that run.
        let ended = |(at, process): (usize, &mut Process)| process.ended_already().map(|_| at);
        let ended: Vec<usize> = self.processes.iter_mut().enumerate().filter_map(ended).collect();
        ended.iter().for_each(|&node| self.restart(node));
        ended.len() as u64
    }
}

fn home(folder: &TempDir, at: usize) -> PathBuf {
    folder.path().join((at + 1).to_string())
}

fn configure(home: &Path, at: usize, nodes: &[Node], Plugins { rules, bridge }: &Plugins<'_>) {
    let write = |path: PathBuf, text: &str| fs::write(path, text).expect("a folder of ours");
    let plugins = home.join("plugins");
    fs::create_dir_all(&plugins).expect("a folder of ours");
    let is_cluster = nodes.len() > 1;
    let mut started = vec!["rmqtt-retainer", "rmqtt-acl"];
    if is_cluster {
        started.insert(0, "rmqtt-cluster-raft");
    }
    if let Some(settings) = bridge {
        started.push("rmqtt-bridge-egress-kafka");
        write(plugins.join("rmqtt-bridge-egress-kafka.toml"), settings);
    }
    let (id, Node { host, mqtt, grpc, .. }) = (at + 1, &nodes[at]);
    let settings = format!(
        r#"
[node]
id = {id}
busy.check_enable = false
[rpc]
server_addr = "{host}:{grpc}"
[log]
to = "console"
level = "warn"
[plugins]
dir = "{}/"
default_startups = {started:?}
disabled_default_startups = ["rmqtt-http-api", "rmqtt-counter"]
[listener.tcp.external]
addr = "{host}:{mqtt}"
allow_anonymous = false
max_packet_size = "2MB"
max_inflight = 1024
max_mqueue_len = 100000
nodelay = true
"#,
        plugins.display()
    );
    write(home.join("rmqtt.toml"), &settings);
    let access = format!("disconnect_if_pub_rejected = false\nrules = [{rules}]\n");
    write(plugins.join("rmqtt-acl.toml"), &access);
    write(plugins.join("rmqtt-retainer.toml"), "max_retained_messages = 0\n");
}

/// Writes the settings of a node of a cluster, and the node that it joins; its own number if it may found a cluster.
fn configure_cluster(home: &Path, leader: usize, nodes: &[Node]) {
    if nodes.len() < 2 {
        return;
    }
    let list = |port: fn(&Node) -> u16| {
        let one = |(at, node): (usize, &Node)| format!("\"{}@{}:{}\"", at + 1, node.host, port(node));
        nodes.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
    };
    // Without a leader, nodes that start at once found a cluster each. Without a setting of `raft`, a killed node cannot use its
    // port for Raft again for 60 s. A node asks the last node of a client to end its session before it accepts the client:
    // with the default of 10 s, clients of a node that is cut off give up first.
    let settings = format!(
        "leader_id = {}\nraft.grpc_reuseaddr = true\nnode_grpc_client_timeout = \"1s\"\nnode_grpc_addrs = [{}]\n\
         raft_peer_addrs = [{}]\n",
        leader + 1,
        list(|node| node.grpc),
        list(|node| node.raft)
    );
    let file = home.join("plugins/rmqtt-cluster-raft.toml");
    fs::write(file, settings).expect("a folder of ours");
}
