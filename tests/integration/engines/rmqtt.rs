//! RMQTT: one node, or a cluster by Raft.

use std::fs;
use std::path::Path;

use tempfile::TempDir;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::process::{Launch, Process};

use crate::engine::{ALL, FEW, PASSWORD};
use crate::folder::{installed, listens};

/// Ports of a node: MQTT, gRPC and Raft.
#[derive(Debug, Clone, Copy)]
struct Ports {
    mqtt: u16,
    grpc: u16,
    raft: u16,
}

/// Running nodes; killed on drop.
pub(crate) struct Rmqtt {
    pub(crate) nodes: Vec<Process>,
    pub(crate) ports: Vec<u16>,
    _folder: TempDir,
}

impl Rmqtt {
    /// Starts this number of nodes; `None` if RMQTT is not installed.
    pub(crate) fn start(count: usize) -> Option<Self> {
        let program = installed("rmqtt", Some("--if-installed"))?;
        // Another test may take a port between the check and the start of the nodes.
        for _ in 0..3 {
            if let Some(started) = Self::try_start(&program, count) {
                return Some(started);
            }
        }
        panic!("RMQTT did not start");
    }

    fn try_start(program: &Path, count: usize) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let ports: Vec<Ports> =
            (0..count).map(|_| Ports { mqtt: free_port(), grpc: free_port(), raft: free_port() }).collect();
        let mut nodes = Vec::new();
        for at in 0..count {
            let home = folder.path().join((at + 1).to_string());
            configure(&home, at, &ports);
            let arguments = ["-f".to_owned(), home.join("rmqtt.toml").display().to_string()];
            nodes.push(Process::start(Launch {
                program: program.to_owned(),
                arguments: arguments.to_vec(),
                environment: Vec::new(),
                log: home.join("log"),
            }));
        }
        let all_listen =
            ports.iter().zip(&mut nodes).all(|(ports, node)| listens(ports.mqtt, || node.ended_already().is_some()));
        let ports = ports.iter().map(|ports| ports.mqtt).collect();
        all_listen.then(|| Self { nodes, ports, _folder: folder })
    }
}

fn configure(home: &Path, at: usize, ports: &[Ports]) {
    let plugins = home.join("plugins");
    fs::create_dir_all(&plugins).unwrap();
    let is_cluster = ports.len() > 1;
    let raft = if is_cluster { "\"rmqtt-cluster-raft\", " } else { "" };
    let (id, Ports { mqtt, grpc, .. }) = (at + 1, ports[at]);
    let settings = format!(
        r#"
[node]
id = {id}
[rpc]
server_addr = "127.0.0.1:{grpc}"
[log]
to = "console"
level = "warn"
[plugins]
dir = "{}/"
default_startups = [{raft}"rmqtt-retainer", "rmqtt-acl"]
disabled_default_startups = ["rmqtt-http-api", "rmqtt-counter"]
[listener.tcp.external]
addr = "127.0.0.1:{mqtt}"
allow_anonymous = false
max_packet_size = "2MB"
max_inflight = 1024
max_mqueue_len = 100000
nodelay = true
"#,
        plugins.display()
    );
    fs::write(home.join("rmqtt.toml"), settings).unwrap();
    let access = format!(
        r#"
disconnect_if_pub_rejected = false
rules = [
    ["allow", {{ user = "{ALL}", password = "{PASSWORD}" }}, "connect"],
    ["allow", {{ user = "{FEW}", password = "{PASSWORD}" }}, "connect"],
    ["deny", "all", "connect"],
    ["allow", {{ user = "{ALL}" }}, "pubsub"],
    ["allow", {{ user = "{FEW}" }}, "pubsub", ["whisker/v1/f/{FEW}/#"]],
    ["deny", "all", "pubsub"],
]
"#
    );
    fs::write(plugins.join("rmqtt-acl.toml"), access).unwrap();
    fs::write(plugins.join("rmqtt-retainer.toml"), "max_retained_messages = 0\n").unwrap();
    if is_cluster {
        let list = |port: fn(&Ports) -> u16| {
            let one = |(at, ports): (usize, &Ports)| format!("\"{}@127.0.0.1:{}\"", at + 1, port(ports));
            ports.iter().enumerate().map(one).collect::<Vec<_>>().join(", ")
        };
        let cluster = format!(
            // Without a leader, nodes that start at once found a cluster each.
            "leader_id = 1\nnode_grpc_addrs = [{}]\nraft_peer_addrs = [{}]\n",
            list(|ports| ports.grpc),
            list(|ports| ports.raft)
        );
        fs::write(plugins.join("rmqtt-cluster-raft.toml"), cluster).unwrap();
    }
}
