//! Brokers of Apache Kafka, which `tests/kafka` installs, and clients of them.

mod bridge;
mod clients;
mod losses;
mod partitions;

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use nix::sys::signal::Signal;
use rskafka::client::Client;
use rskafka::record::Record;
use tempfile::TempDir;

use crate::mosquitto::free_port;
use crate::network::ServerAddress;
use crate::process::{Launch, Process};
use crate::wait::until_within;

pub use bridge::{Bridge, BridgeOptions};
pub use rskafka::client::partition::Compression;

pub use clients::{Numbers, Reader, Writer, record, record_of};
use clients::{connect, partition_client};

/// Time limit of a start, and of an election. Java takes some seconds on a busy machine.
pub const START: Duration = Duration::from_secs(240);
/// Time in which one answer of a broker must come.
const ANSWER: Duration = Duration::from_secs(5);

/// Credentials of the one user whom a secured broker knows.
pub const USER: &str = "vibrissa";
/// Password of [`USER`].
pub const PASSWORD: &str = "secret";

/// A broker: its address, and its ports for clients and for the controllers' votes.
#[derive(Debug, Clone)]
struct Node {
    host: String,
    clients: u16,
    votes: u16,
    /// Port with TLS and credentials, and the PEM file with the key and the certificate.
    secured: Option<(u16, PathBuf)>,
}

impl Node {
    fn address(&self) -> String {
        format!("{}:{}", self.host, self.clients)
    }
}

/// Running brokers, each also a controller; killed on drop.
pub struct Kafka {
    brokers: Vec<Process>,
    nodes: Vec<Node>,
    _folder: TempDir,
}

impl Kafka {
    /// Starts so many brokers on 127.0.0.1; `None`, with a line on standard error, if Kafka is not installed.
    ///
    /// # Panics
    /// They do not start.
    pub async fn start(count: usize) -> Option<Self> {
        Self::start_at(&vec![ServerAddress::here(); count]).await
    }

    /// Starts one broker that also listens with TLS, and asks there for the credentials of [`USER`]. `identity` is the PEM file
    /// with its key and certificate.
    ///
    /// # Panics
    /// It does not start.
    pub async fn start_secured(identity: PathBuf) -> Option<Self> {
        Self::start_with(&[ServerAddress::here()], Some(identity)).await
    }

    /// Starts a broker at each of these places.
    ///
    /// # Panics
    /// They do not start.
    pub async fn start_at(places: &[ServerAddress]) -> Option<Self> {
        Self::start_with(places, None).await
    }

    async fn start_with(places: &[ServerAddress], identity: Option<PathBuf>) -> Option<Self> {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("kafka");
        let output = Command::new(script).arg("--if-installed").output().expect("tests/kafka");
        if !output.status.success() {
            eprintln!("skipped: {}", String::from_utf8_lossy(&output.stderr).trim());
            return None;
        }
        let home = PathBuf::from(String::from_utf8(output.stdout).expect("a path").trim());
        let folder = tempfile::tempdir().expect("a folder");
        let node = |place: &ServerAddress| {
            let secured = identity.clone().map(|identity| (free_port(), identity));
            Node { host: place.host.clone(), clients: free_port(), votes: free_port(), secured }
        };
        let nodes: Vec<Node> = places.iter().map(node).collect();
        let start = |(at, place): (usize, &ServerAddress)| {
            Process::start(place.launch(launch(&home, folder.path(), at, &nodes)))
        };
        let brokers = places.iter().enumerate().map(start).collect();
        let started = Self { brokers, nodes, _folder: folder };
        for at in 0..places.len() {
            started.until_answers(at).await;
        }
        Some(started)
    }

    /// URL of all brokers, for `kafka.url`.
    #[must_use]
    pub fn url(&self) -> String {
        format!("kafka://{}", self.addresses().join(","))
    }

    /// URL of the port with TLS.
    ///
    /// # Panics
    /// The broker has none.
    #[must_use]
    pub fn secured_url(&self) -> String {
        let (port, _) = self.nodes[0].secured.as_ref().expect("a secured broker");
        format!("kafkas://{}:{port}", self.nodes[0].host)
    }

    /// Hosts and ports of all brokers.
    #[must_use]
    pub fn addresses(&self) -> Vec<String> {
        self.nodes.iter().map(Node::address).collect()
    }

    /// Kills a broker without any cleanup.
    pub fn kill(&mut self, at: usize) {
        self.brokers[at].kill();
    }

    /// Starts a killed broker again, and waits until it answers.
    pub async fn restart(&mut self, at: usize) {
        self.begin_restart(at);
        self.until_answers(at).await;
    }

    /// Makes a broker store all new batches with a codec, by a restart.
    ///
    /// # Panics
    /// Its settings cannot be written.
    pub async fn restart_with_codec(&mut self, at: usize, codec: &str) {
        self.kill(at);
        let path = self._folder.path().join(at.to_string()).join("server.properties");
        let mut settings = fs::OpenOptions::new().append(true).open(path).expect("the broker's settings");
        writeln!(settings, "compression.type={codec}").expect("the broker's settings");
        self.restart(at).await;
    }

    /// Starts a killed broker again, without waiting.
    pub fn begin_restart(&mut self, at: usize) {
        self.brokers[at].restart();
    }

    /// Stops a broker with SIGSTOP, or continues it.
    pub fn freeze(&self, at: usize, is_frozen: bool) {
        self.brokers[at].signal(if is_frozen { Signal::SIGSTOP } else { Signal::SIGCONT });
    }

    /// The process of a broker.
    #[must_use]
    pub fn broker(&self, at: usize) -> &Process {
        &self.brokers[at]
    }

    async fn until_answers(&self, at: usize) {
        until_within(START, "a broker that answers", async || self.answers(at).await.then_some(())).await;
    }

    /// Whether a broker answers a client.
    pub async fn answers(&self, at: usize) -> bool {
        let Some(client) = connect(vec![self.nodes[at].address()]).await else { return false };
        tokio::time::timeout(ANSWER, client.list_topics()).await.is_ok_and(|listed| listed.is_ok())
    }

    /// Number of brokers.
    #[must_use]
    pub fn count(&self) -> usize {
        self.nodes.len()
    }

    /// Whether every broker answers a client.
    pub async fn all_answer(&self) -> bool {
        for at in 0..self.count() {
            if !self.answers(at).await {
                return false;
            }
        }
        true
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
        self.create_replicated_topic(name, partitions, self.nodes.len()).await;
    }

    /// Creates a topic with a replica on so many of the brokers.
    ///
    /// # Panics
    /// The brokers do not create it.
    pub async fn create_replicated_topic(&self, name: &str, partitions: u32, replicas: usize) {
        until_within(START, "a new topic", async || {
            let client = self.client().await;
            let controller = client.controller_client().ok()?;
            let creating = controller.create_topic(name, partitions as i32, replicas as i16, 5000);
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
        self.write_compressed(topic, partition, records, Compression::NoCompression).await;
    }

    /// As [`Self::write`], compressed.
    ///
    /// # Panics
    /// The brokers do not take them.
    pub async fn write_compressed(&self, topic: &str, partition: u32, records: Vec<Record>, compression: Compression) {
        until_within(START, "a write", async || {
            let client = partition_client(&self.client().await, topic, partition).await?;
            let writing = client.produce(records.clone(), compression);
            tokio::time::timeout(ANSWER, writing).await.ok()?.ok()
        })
        .await;
    }

    /// Damages the stored batch with these bytes, at every broker.
    ///
    /// # Panics
    /// No file has them.
    pub fn damage(&self, needle: &[u8]) {
        let mut damaged = 0;
        let segments = files(self._folder.path()).into_iter();
        for segment in segments.filter(|file| file.extension().is_some_and(|end| end == "log")) {
            let bytes = fs::read(&segment).expect("a segment");
            let Some(place) = bytes.windows(needle.len()).position(|found| found == needle) else { continue };
            let mut file = fs::OpenOptions::new().write(true).open(segment).expect("a segment");
            file.seek(SeekFrom::Start(place as u64)).expect("a place in a file");
            file.write_all(b"#").expect("a segment");
            damaged += 1;
        }
        assert!(damaged > 0, "no segment has the bytes");
    }

    /// A reader of all partitions of a topic, from the beginning.
    pub async fn reader(&self, topic: &str, partitions: u32) -> Reader {
        Reader::new(self.addresses(), topic, partitions)
    }
}

/// All files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Settings of the port with TLS and credentials.
fn secured_settings(identity: &Path) -> String {
    let login = |mechanism: &str, module: &str, rest: &str| {
        let class = format!("org.apache.kafka.common.security.{module}LoginModule required{rest};");
        format!("listener.name.secured.{mechanism}.sasl.jaas.config={class}\n")
    };
    [
        "listener.security.protocol.map=PLAINTEXT:PLAINTEXT,CONTROLLER:PLAINTEXT,SECURED:SASL_SSL\n",
        "sasl.enabled.mechanisms=SCRAM-SHA-512,SCRAM-SHA-256,PLAIN\n",
        &login("scram-sha-512", "scram.Scram", ""),
        &login("scram-sha-256", "scram.Scram", ""),
        &login("plain", "plain.Plain", &format!(" user_{USER}=\"{PASSWORD}\"")),
        &format!("ssl.keystore.type=PEM\nssl.keystore.location={}\n", identity.display()),
    ]
    .concat()
}

fn launch(home: &Path, folder: &Path, at: usize, nodes: &[Node]) -> Launch {
    let own = folder.join(at.to_string());
    fs::create_dir_all(&own).expect("a folder");
    let write = |name: &str, text: &str| {
        fs::write(own.join(name), text).expect("a file");
        own.join(name).display().to_string()
    };
    let Node { host, clients, votes, secured } = &nodes[at];
    let voters = nodes.iter().zip(1..).map(|(node, id)| format!("{id}@{}:{}", node.host, node.votes));
    let voters = voters.collect::<Vec<_>>().join(",");
    let (id, copies, data) = (at + 1, nodes.len(), own.join("data"));
    let in_sync = copies / 2 + 1;
    let properties = write(
        "server.properties",
        &format!(
            "process.roles=broker,controller\nnode.id={id}\ncontroller.quorum.voters={voters}\n\
             listeners=PLAINTEXT://{host}:{clients},CONTROLLER://{host}:{votes}{}\n\
             controller.listener.names=CONTROLLER\nlog.dirs={}\nauto.create.topics.enable=false\n\
             offsets.topic.replication.factor={copies}\nmin.insync.replicas={in_sync}\n\
             transaction.state.log.replication.factor={copies}\ntransaction.state.log.min.isr={in_sync}\n\
             broker.session.timeout.ms=3000\nbroker.heartbeat.interval.ms=500\n\
             controller.quorum.election.timeout.ms=1000\ncontroller.quorum.fetch.timeout.ms=2000\n{}",
            secured.as_ref().map(|(port, _)| format!(",SECURED://{host}:{port}")).unwrap_or_default(),
            data.display(),
            secured.as_ref().map(|(_, identity)| secured_settings(identity)).unwrap_or_default(),
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
    let user = |mechanism: &str| format!("{mechanism}=[name={USER},password={PASSWORD}]");
    let (sha_512, sha_256) = (user("SCRAM-SHA-512"), user("SCRAM-SHA-256"));
    let mut format = vec!["format", "-t", "AAAAAAAAQACAAAAAAAAAAQ", "-c", &properties];
    if secured.is_some() {
        format.extend(["--add-scram", &sha_512, "--add-scram", &sha_256]);
    }
    let format = java("kafka.tools.StorageTool", &format);
    let formatted = Command::new("java").args(format).output().expect("java");
    assert!(formatted.status.success(), "{}", String::from_utf8_lossy(&formatted.stderr));
    Launch {
        program: PathBuf::from("java"),
        arguments: java("kafka.Kafka", &[&properties]),
        environment: Vec::new(),
        log: own.join("log"),
    }
}
