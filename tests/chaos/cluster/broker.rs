//! The broker of a cluster's run: three nodes of RMQTT, or one Mosquitto where RMQTT is not installed.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use nix::sys::signal::Signal;
use vibrissa_tests::installed::listens;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::network::ServerAddress;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::rmqtt::Rmqtt;

use super::stage::CLIENT;

/// Which broker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum BrokerKind {
    /// Three nodes of RMQTT.
    Rmqtt,
    /// One Mosquitto: no other node takes over when it fails.
    Mosquitto,
}

impl BrokerKind {
    /// Number of its nodes.
    pub fn nodes(self) -> usize {
        match self {
            Self::Rmqtt => 3,
            Self::Mosquitto => 1,
        }
    }

    /// Its name in outputs.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Rmqtt => "RMQTT, 3 nodes",
            Self::Mosquitto => "Mosquitto, 1 node",
        }
    }
}

/// A running broker; killed on drop.
pub enum Broker {
    Rmqtt(Rmqtt),
    Mosquitto { process: Process, host: String, port: u16 },
}

impl Broker {
    /// Starts a node at each of these places; `None` if it is not installed.
    pub fn start(kind: BrokerKind, places: &[ServerAddress], folder: &Path) -> Option<Self> {
        let (user, password) = CLIENT;
        match kind {
            BrokerKind::Rmqtt => {
                let rules = format!(
                    "[\"allow\", {{ user = \"{user}\", password = \"{password}\" }}, \"connect\"],\n\
                     [\"allow\", {{ user = \"{user}\" }}, \"pubsub\"],\n[\"deny\", \"all\", \"all\"]"
                );
                Some(Self::Rmqtt(Rmqtt::start_at(places, &rules)?))
            }
            BrokerKind::Mosquitto => Some(mosquitto(places.first()?, folder)),
        }
    }

    /// Hosts and ports of the nodes.
    pub fn addresses(&self) -> Vec<(String, u16)> {
        match self {
            Self::Rmqtt(nodes) => nodes.addresses(),
            Self::Mosquitto { host, port, .. } => vec![(host.clone(), *port)],
        }
    }

    /// Kills a node.
    pub fn kill(&mut self, node: usize) {
        match self {
            Self::Rmqtt(nodes) => nodes.kill(node),
            Self::Mosquitto { process, .. } => process.kill(),
        }
    }

    /// Starts a killed node again.
    pub fn restart(&mut self, node: usize) {
        match self {
            Self::Rmqtt(nodes) => nodes.restart(node),
            Self::Mosquitto { process, .. } => process.restart(),
        }
    }

    /// Ends all nodes and starts them again.
    pub fn restart_all(&mut self) {
        match self {
            Self::Rmqtt(nodes) => nodes.restart_all(),
            Self::Mosquitto { process, .. } => {
                process.kill();
                process.restart();
            }
        }
    }

    /// Stops a node with SIGSTOP, or continues it.
    pub fn freeze(&self, node: usize, is_frozen: bool) {
        match self {
            Self::Rmqtt(nodes) => nodes.freeze(node, is_frozen),
            Self::Mosquitto { process, .. } => {
                process.signal(if is_frozen { Signal::SIGSTOP } else { Signal::SIGCONT });
            }
        }
    }

    /// Starts nodes again that have ended on their own; their number.
    pub fn revive(&mut self) -> u64 {
        match self {
            Self::Rmqtt(nodes) => nodes.revive(),
            Self::Mosquitto { process, .. } => match process.ended_already() {
                Some(_) => {
                    process.restart();
                    1
                }
                None => 0,
            },
        }
    }
}

/// Mosquitto without an access list; it retains messages only in memory.
fn mosquitto(place: &ServerAddress, folder: &Path) -> Broker {
    let (host, port) = (place.host.clone(), free_port());
    let file = folder.join("mosquitto.conf");
    let settings = format!(
        "listener {port} {host}\nallow_anonymous true\nlog_dest stderr\nset_tcp_nodelay true\n\
         max_queued_messages 100000\nuser root\n"
    );
    std::fs::write(&file, settings).expect("a folder of ours");
    let mut process = Process::start(place.launch(Launch {
        program: program(),
        arguments: vec!["-c".to_owned(), file.display().to_string()],
        environment: Vec::new(),
        log: folder.join("mosquitto.log"),
    }));
    assert!(listens(&host, port, || process.ended_already().is_some()), "Mosquitto starts");
    Broker::Mosquitto { process, host, port }
}

/// Debian keeps it off the search path of some users.
fn program() -> PathBuf {
    let path = PathBuf::from("/usr/sbin/mosquitto");
    if path.exists() { path } else { "mosquitto".into() }
}
