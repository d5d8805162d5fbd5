//! A bridge from the broker to Kafka, as some brokers have one.
//!
//! It writes a message of contacts that a robot sends again only if it has not been written yet: Kafka is the journal, so
//! a message that the supervisors lose after that stays missing. Some records are written twice, as bridges do that
//! repeat a write without a confirmation.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rumqttc::{AsyncClient, Event, EventLoop, MqttOptions, Packet, QoS};
use serde::Deserialize;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::task::JoinHandle;
use tokio::time::sleep;
use vibrissa_edge::partition::robot_hash;
use vibrissa_protocol::{Name, RobotTopic};
use vibrissa_tests::kafka::{Writer, record};

use super::stage::{CLIENT, fleets};

/// The topic of Kafka; the supervisors' default.
pub const TOPIC: &str = "vibrissa.messages";
/// Number of its partitions. The owner of each fleet reads all of them.
pub const PARTITIONS: u32 = 4;
/// Number of messages that wait for each partition. Robots send again what finds no room.
const WAITING: usize = 1000;
/// Largest number of records in a write.
const RECORDS: usize = 200;
/// Share of writes that are repeated.
const TWICE: f64 = 0.05;
/// Pause after a failure.
const PAUSE: Duration = Duration::from_millis(200);

/// Carries contacts and statuses until it is dropped.
pub struct Bridge {
    is_open: Arc<AtomicBool>,
    repeated: Arc<AtomicU64>,
    tasks: Vec<JoinHandle<()>>,
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }
}

impl Bridge {
    /// A closed bridge from these nodes of the broker to these of Kafka.
    pub fn start(nodes: Vec<(String, u16)>, kafka: &[String], seed: u64) -> Self {
        let (is_open, repeated) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicU64::new(0)));
        let (mut partitions, mut tasks) = (Vec::new(), Vec::new());
        for partition in 0..PARTITIONS {
            let (sender, messages) = channel(WAITING);
            partitions.push(sender);
            let writer = Writer::new(kafka.to_vec(), TOPIC, partition);
            let random =
                ChaCha8Rng::seed_from_u64(seed.wrapping_mul(u64::from(PARTITIONS)).wrapping_add(partition.into()));
            tasks.push(tokio::spawn(write(messages, writer, random, repeated.clone())));
        }
        let entrance = Entrance { is_open: is_open.clone(), partitions, written: HashMap::new() };
        tasks.push(tokio::spawn(listen(nodes, entrance)));
        Self { is_open, repeated, tasks }
    }

    /// Opens it. Before, the supervisors must know all robots: they refuse contacts of others, which are then missing.
    pub fn open(&self) {
        self.is_open.store(true, Ordering::Relaxed);
    }

    /// Number of records that were written twice.
    pub fn repeated(&self) -> u64 {
        self.repeated.load(Ordering::Relaxed)
    }
}

struct Message {
    /// Fleet and robot.
    key: String,
    topic: String,
    payload: Vec<u8>,
}

/// Boot and number of a message of contacts.
#[derive(PartialEq, Eq, Hash, Deserialize)]
struct Number {
    boot_id: String,
    seq: u64,
}

/// The way from the broker to the writers.
struct Entrance {
    is_open: Arc<AtomicBool>,
    partitions: Vec<Sender<Message>>,
    /// The messages of contacts that were handed on, by robot.
    written: HashMap<Name, HashSet<Number>>,
}

impl Entrance {
    fn take(&mut self, topic: &[u8], payload: Vec<u8>) {
        let topic = String::from_utf8(topic.to_vec()).expect("text");
        let mut levels = topic.split('/').skip(2);
        let Some((fleet, robot)) = levels.next().zip(levels.next()) else { return };
        let Ok(robot) = Name::robot(robot) else { return };
        if !self.is_open.load(Ordering::Relaxed) {
            return;
        }
        let partition = &self.partitions[(robot_hash(fleet, robot.as_str()) % PARTITIONS) as usize];
        let Ok(room) = partition.try_reserve() else { return };
        let is_contacts = topic.ends_with(RobotTopic::Contacts.as_str());
        let is_new = !is_contacts || {
            let number = serde_json::from_slice(&payload).expect("contacts of the contract");
            self.written.entry(robot.clone()).or_default().insert(number)
        };
        if is_new {
            room.send(Message { key: format!("{fleet}/{robot}"), topic, payload });
        }
    }
}

/// Receives messages, from the next node after each failure.
async fn listen(nodes: Vec<(String, u16)>, mut entrance: Entrance) {
    for node in nodes.iter().cycle() {
        let mut options = MqttOptions::new("bridge", node.clone());
        options.set_clean_start(true).set_keep_alive(2).set_credentials(CLIENT.0, CLIENT.1);
        let (client, mut events) = AsyncClient::builder(options).capacity(16).build();
        receive(&client, &mut events, &mut entrance).await;
        sleep(PAUSE).await;
    }
}

/// The topics of contacts and statuses of all fleets.
fn filters() -> impl Iterator<Item = (Name, RobotTopic)> {
    fleets()
        .into_iter()
        .flat_map(|fleet| [RobotTopic::Contacts, RobotTopic::Status].map(|topic| (fleet.clone(), topic)))
}

/// Receives messages until the connection fails.
async fn receive(client: &AsyncClient, events: &mut EventLoop, entrance: &mut Entrance) {
    while let Ok(event) = events.poll().await {
        match event {
            Event::Incoming(Packet::ConnAck(_)) => {
                for (fleet, topic) in filters() {
                    client.try_subscribe(topic.fleet_filter(&fleet), QoS::AtLeastOnce).expect("an empty queue");
                }
            }
            Event::Incoming(Packet::Publish(publish)) => entrance.take(&publish.topic, publish.payload.to_vec()),
            _ => {}
        }
    }
}

/// Writes the messages of a partition, each at least once.
async fn write(mut messages: Receiver<Message>, mut writer: Writer, mut random: ChaCha8Rng, repeated: Arc<AtomicU64>) {
    let mut some = Vec::new();
    while messages.recv_many(&mut some, RECORDS).await > 0 {
        let of = |Message { key, topic, payload }| {
            let mut of_robot = record("", &topic, payload);
            of_robot.key = Some(key.into_bytes());
            of_robot
        };
        let records: Vec<_> = some.drain(..).map(of).collect();
        while !writer.write(records.clone()).await {
            sleep(PAUSE).await;
        }
        if random.random_bool(TWICE) {
            let count = records.len() as u64;
            if writer.write(records).await {
                repeated.fetch_add(count, Ordering::Relaxed);
            }
        }
    }
}
