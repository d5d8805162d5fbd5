//! Brokers of Apache Kafka, which `tests/kafka` installs, and a reader of a topic.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use rskafka::BackoffConfig;
use rskafka::client::partition::{Compression, PartitionClient, UnknownTopicHandling};
use rskafka::client::{Client, ClientBuilder};
use rskafka::record::{Record, RecordAndOffset};
use tempfile::TempDir;

use crate::mosquitto::free_port;
use crate::process::{Launch, Process};
use crate::wait::until_within;

/// Time limit of a start, and of an election. Java takes some seconds on a busy machine.
const START: Duration = Duration::from_secs(90);
/// Time in which one answer of a broker must come.
const ANSWER: Duration = Duration::from_secs(5);
/// Bytes of one read.
const READ_BYTES: i32 = 8 * 1024 * 1024;

/// Ports of a broker: clients, and the controllers' votes.
#[derive(Debug, Clone, Copy)]
struct Ports {
    clients: u16,
    votes: u16,
}

/// Running brokers, each also a controller; killed on drop.
pub struct Kafka {
    brokers: Vec<Process>,
    ports: Vec<Ports>,
    _folder: TempDir,
}

impl Kafka {
    /// Starts so many brokers; `None`, with a line on standard error, if Kafka is not installed.
    ///
    /// # Panics
    /// They do not start.
    pub async fn start(count: usize) -> Option<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("kafka");
        let output = Command::new(script).arg("--if-installed").output().expect("tests/kafka");
        if !output.status.success() {
            eprintln!("skipped: {}", String::from_utf8_lossy(&output.stderr).trim());
            return None;
        }
        let home = PathBuf::from(String::from_utf8(output.stdout).expect("a path").trim());
        let folder = tempfile::tempdir().expect("a folder");
        let ports: Vec<Ports> = (0..count).map(|_| Ports { clients: free_port(), votes: free_port() }).collect();
        let brokers = (0..count).map(|at| Process::start(launch(&home, folder.path(), at, &ports))).collect();
        let started = Self { brokers, ports, _folder: folder };
        for at in 0..count {
            started.answers(at).await;
        }
        Some(started)
    }

    /// URL of all brokers, for `kafka.url`.
    #[must_use]
    pub fn url(&self) -> String {
        format!("kafka://{}", self.addresses().join(","))
    }

    fn addresses(&self) -> Vec<String> {
        self.ports.iter().map(|ports| format!("127.0.0.1:{}", ports.clients)).collect()
    }

    /// Kills a broker without any cleanup.
    pub fn kill(&mut self, at: usize) {
        self.brokers[at].kill();
    }

    /// Starts a killed broker again, and waits until it answers.
    pub async fn restart(&mut self, at: usize) {
        self.brokers[at].restart();
        self.answers(at).await;
    }

    /// The process of a broker.
    #[must_use]
    pub fn broker(&self, at: usize) -> &Process {
        &self.brokers[at]
    }

    async fn answers(&self, at: usize) {
        let address = format!("127.0.0.1:{}", self.ports[at].clients);
        until_within(START, "a broker that answers", async || {
            let client = connect(vec![address.clone()]).await?;
            tokio::time::timeout(ANSWER, client.list_topics()).await.ok()?.ok()
        })
        .await;
    }

    /// A client of all brokers.
    ///
    /// # Panics
    /// None answers.
    pub async fn client(&self) -> Client {
        until_within(START, "a client", async || connect(self.addresses()).await).await
    }

    /// Creates a topic with a replica on each broker.
    ///
    /// # Panics
    /// The brokers do not create it.
    pub async fn create_topic(&self, name: &str, partitions: u32) {
        let replicas = self.ports.len() as i16;
        until_within(START, "a new topic", async || {
            let client = self.client().await;
            let controller = client.controller_client().ok()?;
            let creating = controller.create_topic(name, partitions as i32, replicas, 5000);
            let created = tokio::time::timeout(ANSWER, creating).await;
            let topics = tokio::time::timeout(ANSWER, client.list_topics()).await.ok()?.ok()?;
            let exists = topics.iter().any(|topic| topic.name == name && topic.partitions.len() == partitions as usize);
            if !exists {
                eprintln!("topic {name}: {created:?}");
            }
            exists.then_some(())
        })
        .await;
    }

    /// Writes records to a partition.
    ///
    /// # Panics
    /// The brokers do not take them.
    pub async fn write(&self, topic: &str, partition: u32, records: Vec<Record>) {
        until_within(START, "a write", async || {
            let client = partition_client(&self.client().await, topic, partition).await?;
            let writing = client.produce(records.clone(), Compression::NoCompression);
            tokio::time::timeout(ANSWER, writing).await.ok()?.ok()
        })
        .await;
    }

    /// A reader of all partitions of a topic, from the beginning.
    pub async fn reader(&self, topic: &str, partitions: u32) -> Reader {
        Reader {
            addresses: self.addresses(),
            topic: topic.to_owned(),
            client: None,
            next: vec![0; partitions as usize],
        }
    }
}

async fn connect(addresses: Vec<String>) -> Option<Client> {
    let backoff = BackoffConfig { deadline: Some(ANSWER / 2), ..BackoffConfig::default() };
    let building = ClientBuilder::new(addresses).backoff_config(backoff).build();
    tokio::time::timeout(ANSWER, building).await.ok()?.ok()
}

async fn partition_client(client: &Client, topic: &str, partition: u32) -> Option<PartitionClient> {
    let opening = client.partition_client(topic, partition as i32, UnknownTopicHandling::Error);
    tokio::time::timeout(ANSWER, opening).await.ok()?.ok()
}

/// Reads a topic, each partition in order.
pub struct Reader {
    addresses: Vec<String>,
    topic: String,
    client: Option<Client>,
    /// Next offset by partition.
    next: Vec<i64>,
}

impl Reader {
    /// The records that came since the last call, by partition; some if a broker does not answer.
    pub async fn read(&mut self) -> Vec<(u32, RecordAndOffset)> {
        let mut all = Vec::new();
        for partition in 0..self.next.len() {
            while let Some(records) = self.read_some(partition).await {
                let Some(last) = records.last() else { break };
                self.next[partition] = last.offset + 1;
                all.extend(records.into_iter().map(|record| (partition as u32, record)));
            }
        }
        all
    }

    async fn read_some(&mut self, partition: usize) -> Option<Vec<RecordAndOffset>> {
        if self.client.is_none() {
            self.client = connect(self.addresses.clone()).await;
        }
        let read = async {
            let client = partition_client(self.client.as_ref()?, &self.topic, partition as u32).await?;
            let fetching = client.fetch_records(self.next[partition], 1..READ_BYTES, 100);
            tokio::time::timeout(ANSWER, fetching).await.ok()?.ok()
        };
        let read = read.await;
        if read.is_none() {
            self.client = None;
        }
        read.map(|(records, _)| records)
    }
}

/// Recognises events that were written twice: the names of a shard's events rise within a partition.
#[derive(Debug, Default)]
pub struct Names {
    last: BTreeMap<(u32, i64), (i64, i64, i64)>,
    /// Number of events that were read before.
    pub repeated: usize,
}

impl Names {
    /// Whether an event of a partition is new.
    ///
    /// # Panics
    /// It has no name.
    pub fn is_new(&mut self, partition: u32, event: &serde_json::Value) -> bool {
        let part = |name: &str| event["id"][name].as_i64().unwrap_or_else(|| panic!("no {name}: {event}"));
        let name = (part("epoch"), part("number"), part("index"));
        let last = self.last.entry((partition, part("shard"))).or_insert((-1, -1, -1));
        let is_new = name > *last;
        if is_new {
            *last = name;
        } else {
            self.repeated += 1;
        }
        is_new
    }
}

fn launch(home: &Path, folder: &Path, at: usize, ports: &[Ports]) -> Launch {
    let own = folder.join(at.to_string());
    fs::create_dir_all(&own).expect("a folder");
    let write = |name: &str, text: &str| {
        fs::write(own.join(name), text).expect("a file");
        own.join(name).display().to_string()
    };
    let Ports { clients, votes } = ports[at];
    let voters = ports.iter().zip(1..).map(|(ports, id)| format!("{id}@127.0.0.1:{}", ports.votes));
    let voters = voters.collect::<Vec<_>>().join(",");
    let (id, copies, data) = (at + 1, ports.len(), own.join("data"));
    let in_sync = copies / 2 + 1;
    let properties = write(
        "server.properties",
        &format!(
            "process.roles=broker,controller\nnode.id={id}\ncontroller.quorum.voters={voters}\n\
             listeners=PLAINTEXT://127.0.0.1:{clients},CONTROLLER://127.0.0.1:{votes}\n\
             controller.listener.names=CONTROLLER\nlog.dirs={}\nauto.create.topics.enable=false\n\
             offsets.topic.replication.factor={copies}\nmin.insync.replicas={in_sync}\n\
             broker.session.timeout.ms=3000\nbroker.heartbeat.interval.ms=500\n\
             controller.quorum.election.timeout.ms=1000\ncontroller.quorum.fetch.timeout.ms=2000\n",
            data.display()
        ),
    );
    let log = write(
        "log4j2.yaml",
        "Configuration:\n  status: ERROR\n  Appenders:\n    Console:\n      name: STDERR\n      target: SYSTEM_ERR\n      \
         PatternLayout:\n        pattern: \"%d %p %m%n\"\n  Loggers:\n    Root:\n      level: WARN\n      \
         AppenderRef:\n        - ref: STDERR\n",
    );
    let java = |class: &str, rest: &[&str]| {
        let mut arguments = vec![
            "-Xmx256M".to_owned(),
            // They shorten the start.
            "-XX:+UseSerialGC".to_owned(),
            "-XX:TieredStopAtLevel=1".to_owned(),
            format!("-Dlog4j2.configurationFile={log}"),
            "-cp".to_owned(),
            home.join("libs/*").display().to_string(),
            class.to_owned(),
        ];
        arguments.extend(rest.iter().map(|&text| text.to_owned()));
        arguments
    };
    let format = java("kafka.tools.StorageTool", &["format", "-t", "AAAAAAAAQACAAAAAAAAAAQ", "-c", &properties]);
    let formatted = Command::new("java").args(format).output().expect("java");
    assert!(formatted.status.success(), "{}", String::from_utf8_lossy(&formatted.stderr));
    Launch {
        program: PathBuf::from("java"),
        arguments: java("kafka.Kafka", &[&properties]),
        environment: Vec::new(),
        log: own.join("log"),
    }
}
