//! The programs of a cluster's run, each node in a network namespace of its own.

use std::path::Path;

use vibrissa_protocol::Name;
use vibrissa_tests::kafka::Kafka;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::network::Network;
use vibrissa_tests::patroni::Patroni;
use vibrissa_tests::process::{Launch, Process};

use super::bridge::{PARTITIONS, TOPIC};
use super::broker::{Broker, BrokerKind};
use super::parts::{Brokers, Database, KafkaBrokers, Supervisor};
use super::plan::{Nodes, SUPERVISORS_COUNT};
use crate::plan::{Control, LEASE_S};
use crate::scenario::robot_name;
use crate::stage::{Program, write_password};

/// Names of the fleets.
pub const FLEETS: [&str; 6] = ["hall-1", "hall-2", "hall-3", "hall-4", "hall-5", "hall-6"];
/// User and password of all clients of the broker.
pub const CLIENT: (&str, &str) = ("chaos", "correct-horse");
/// Names of the supervisors.
pub const SUPERVISORS: [&str; SUPERVISORS_COUNT] = ["a", "b", "c"];
/// Contacts until a whisker counts as learned; few, so that trims are detected from the start.
const LEARNED: u32 = 20;
/// Numbers of the namespaces of the first broker node, supervisor and database node, of etcd, and of the first broker of Kafka.
pub const BROKERS: usize = 0;
pub const SUPERVISOR: usize = BROKERS + 3;
pub const DATABASES: usize = SUPERVISOR + SUPERVISORS_COUNT;
pub const ETCD: usize = DATABASES + 2;
pub const KAFKA: usize = ETCD + 1;

/// All programs except the robots. The network comes last: it is deleted after the programs have ended.
pub struct Stage {
    /// The broker's nodes.
    pub broker: Broker,
    /// The supervisors.
    pub supervisors: Vec<Process>,
    /// A pair of PostgreSQL servers with etcd.
    pub database: Patroni,
    /// The log between broker and supervisors, if contacts come from there.
    pub kafka: Option<Kafka>,
    network: Network,
    _folder: tempfile::TempDir,
}

impl Stage {
    /// Starts everything; `Err` says what is not installed or not allowed here.
    pub async fn set(
        program: &Program,
        control: Control,
        (kind, nodes): (BrokerKind, Nodes),
        logs: &Path,
    ) -> Result<Self, &'static str> {
        let network = Network::make(KAFKA + nodes.kafka).ok_or("network namespaces on a bridge need root")?;
        let (user, password) = CLIENT;
        let folder = tempfile::tempdir().expect("a temporary folder");
        let places: Vec<_> = (BROKERS..BROKERS + kind.nodes()).map(|at| network.place(at)).collect();
        let broker = tokio::task::block_in_place(|| Broker::start(kind, &places, folder.path()))
            .ok_or("RMQTT is not installed: tests/rmqtt installs it, or use --broker mosquitto")?;
        let kafka = kafka(&network, nodes.kafka).await?;
        let servers = [network.place(DATABASES), network.place(DATABASES + 1)];
        let database = Patroni::start_at(&servers, &network.place(ETCD), control != Control::Asynchronous).await;
        let password_file = folder.path().join("password");
        write_password(&password_file, password);
        let mut supervisors = Vec::new();
        for (at, name) in SUPERVISORS.iter().enumerate() {
            let url = broker_url(&broker, at);
            let mut arguments: Vec<String> = program.first_argument.iter().cloned().collect();
            arguments.extend(["run", "--name", name, "--fleets", &FLEETS.join(",")].map(str::to_owned));
            arguments.extend(["--http-listen".to_owned(), format!("127.0.0.1:{}", free_port())]);
            arguments.extend(["--mqtt-username", user, "--mqtt-url", &url].map(str::to_owned));
            arguments.extend(["--mqtt-password-file".to_owned(), password_file.display().to_string()]);
            arguments.extend(["--database-url".to_owned(), database.url()]);
            arguments.extend(["--lease-time-to-live-s".to_owned(), LEASE_S.to_string()]);
            arguments.extend(["--detection-cold-start-contacts".to_owned(), LEARNED.to_string()]);
            if let Some(kafka) = &kafka {
                arguments.extend(["--ingest", "kafka", "--kafka-url", &kafka.url()].map(str::to_owned));
            }
            let level = ("RUST_LOG".to_owned(), "info,rumqttc=warn".to_owned());
            supervisors.push(Process::start(network.place(SUPERVISOR + at).launch(Launch {
                program: program.path.clone(),
                arguments,
                environment: [level].into_iter().chain(control.environment()).collect(),
                log: crate::stage::log_of(logs, name),
            })));
        }
        Ok(Self { broker, supervisors, database, kafka, network, _folder: folder })
    }

    /// The broker as a group of robots reaches it: each group begins with another node.
    pub fn broker_of(&self, group: usize) -> vibrissa_simulator::Broker {
        let broker =
            vibrissa_simulator::Broker::from_url(&broker_url(&self.broker, group)).expect("an address of ours");
        vibrissa_simulator::Broker { credentials: Some((CLIENT.0.to_owned(), CLIENT.1.to_owned())), ..broker }
    }

    /// The broker's nodes, to fail.
    pub fn brokers(&mut self) -> Brokers<'_> {
        Brokers { nodes: &mut self.broker, network: &self.network }
    }

    /// A supervisor, to fail.
    pub fn supervisor(&mut self, at: usize) -> Supervisor<'_> {
        let servers = [0, 1].map(|node| self.database.connect(node));
        Supervisor { at, process: &mut self.supervisors[at], network: &self.network, servers }
    }

    /// The databases and etcd, to fail.
    pub fn database_part(&mut self) -> Database<'_> {
        Database { pair: &mut self.database, network: &self.network }
    }

    /// The brokers of Kafka, to fail.
    pub fn kafka_brokers(&mut self) -> Option<KafkaBrokers<'_>> {
        let Self { kafka, network, .. } = self;
        kafka.as_mut().map(|nodes| KafkaBrokers { nodes, network })
    }

    /// Whether each broker of Kafka answers, if there are any.
    pub async fn kafka_answers(&self) -> bool {
        match &self.kafka {
            Some(kafka) => kafka.all_answer().await,
            None => true,
        }
    }

    /// All parts, to fail at the same time.
    pub fn parts(&mut self) -> Parts<'_> {
        let Self { broker, supervisors, database, kafka, network, .. } = self;
        let network = &*network;
        let servers = [0, 1].map(|node| database.connect(node));
        let one = |(at, process)| Supervisor { at, process, network, servers: servers.clone() };
        Parts {
            brokers: Brokers { nodes: broker, network },
            supervisors: supervisors.iter_mut().enumerate().map(one).collect(),
            database: Database { pair: database, network },
            kafka: kafka.as_mut().map(|nodes| KafkaBrokers { nodes, network }),
        }
    }

    /// Restarts supervisors that have ended unexpectedly, and returns their number.
    pub fn revive(&mut self) -> u64 {
        let mut ended = 0;
        for (process, name) in self.supervisors.iter_mut().zip(SUPERVISORS) {
            if let Some(status) = process.ended_already() {
                eprintln!("chaos: supervisor {name} has ended unexpectedly: {status}");
                ended += 1;
                process.restart();
            }
        }
        ended
    }
}

/// The parts of the cluster, each to fail alone.
pub struct Parts<'a> {
    pub brokers: Brokers<'a>,
    pub supervisors: Vec<Supervisor<'a>>,
    pub database: Database<'a>,
    pub kafka: Option<KafkaBrokers<'a>>,
}

/// Starts so many brokers of Kafka, with the topic.
async fn kafka(network: &Network, count: usize) -> Result<Option<Kafka>, &'static str> {
    if count == 0 {
        return Ok(None);
    }
    let places: Vec<_> = (KAFKA..KAFKA + count).map(|at| network.place(at)).collect();
    let kafka = Kafka::start_at(&places).await.ok_or("Kafka is not installed: tests/kafka installs it")?;
    kafka.create_topic(TOPIC, PARTITIONS).await;
    Ok(Some(kafka))
}

/// The nodes' addresses, beginning with another one for each number.
fn broker_url(broker: &Broker, first: usize) -> String {
    let mut urls: Vec<String> = broker.addresses().iter().map(|(host, port)| format!("mqtt://{host}:{port}")).collect();
    let count = urls.len();
    urls.rotate_left(first % count);
    urls.join(",")
}

/// The fleets.
pub fn fleets() -> Vec<Name> {
    FLEETS.into_iter().map(|name| Name::new(name).expect("a name")).collect()
}

/// This number of robots, each with its fleet; the fleets have them by turns.
pub fn robots(count: usize) -> Vec<(Name, Name)> {
    fleets().into_iter().cycle().take(count).zip((0..).map(robot_name)).collect()
}
