//! Clients of Kafka: a writer, a reader, and their records.

use std::collections::BTreeMap;

use rskafka::BackoffConfig;
use rskafka::chrono::Utc;
use rskafka::client::partition::{Compression, PartitionClient, UnknownTopicHandling};
use rskafka::client::{Client, ClientBuilder};
use rskafka::record::{Record, RecordAndOffset};

use vibrissa_protocol::RobotTopic;

use super::ANSWER;

/// Bytes of one read.
const READ_BYTES: i32 = 8 * 1024 * 1024;

/// The record of a robot's message in fleet `f`, as a bridge writes it: with the MQTT topic in a header.
#[must_use]
pub fn record(robot: &str, topic: &str, value: Vec<u8>) -> Record {
    Record {
        key: Some(format!("f/{robot}").into_bytes()),
        value: Some(value),
        headers: BTreeMap::from([("topic".to_owned(), topic.as_bytes().to_vec())]),
        timestamp: Utc::now(),
    }
}

/// The record of a robot's message as a bridge writes it.
#[must_use]
pub fn record_of(fleet: &str, robot: &str, kind: RobotTopic, value: Vec<u8>) -> Record {
    let topic = format!("whisker/v1/{fleet}/{robot}/{kind}");
    Record { key: Some(format!("{fleet}/{robot}").into_bytes()), ..record(robot, &topic, value) }
}

/// Writes to a partition.
pub struct Writer {
    addresses: Vec<String>,
    topic: String,
    partition: u32,
    client: Option<PartitionClient>,
}

impl Writer {
    /// A writer that connects to one of these brokers.
    #[must_use]
    pub fn new(addresses: Vec<String>, topic: &str, partition: u32) -> Self {
        Self { addresses, topic: topic.to_owned(), partition, client: None }
    }

    /// Writes records once. Returns whether the brokers have confirmed them; otherwise they may be written or not.
    pub async fn write(&mut self, records: Vec<Record>) -> bool {
        if self.client.is_none()
            && let Some(client) = connect(self.addresses.clone()).await
        {
            self.client = partition_client(&client, &self.topic, self.partition).await;
        }
        let Some(client) = &self.client else { return false };
        let writing = client.produce(records, Compression::NoCompression);
        let is_written = tokio::time::timeout(ANSWER, writing).await.is_ok_and(|written| written.is_ok());
        if !is_written {
            self.client = None;
        }
        is_written
    }
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
    pub(super) fn new(addresses: Vec<String>, topic: &str, partitions: u32) -> Self {
        Self { addresses, topic: topic.to_owned(), client: None, next: vec![0; partitions as usize] }
    }

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

/// Recognises events that were written twice: the names of a fleet's events rise within a partition.
#[derive(Debug, Default)]
pub struct Names {
    last: BTreeMap<u32, (i64, i64, i64)>,
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
        let last = self.last.entry(partition).or_insert((-1, -1, -1));
        let is_new = name > *last;
        if is_new {
            *last = name;
        } else {
            self.repeated += 1;
        }
        is_new
    }
}

pub(super) async fn connect(addresses: Vec<String>) -> Option<Client> {
    let backoff = BackoffConfig { deadline: Some(ANSWER / 2), ..BackoffConfig::default() };
    let building = ClientBuilder::new(addresses).backoff_config(backoff).build();
    tokio::time::timeout(ANSWER, building).await.ok()?.ok()
}

pub(super) async fn partition_client(client: &Client, topic: &str, partition: u32) -> Option<PartitionClient> {
    let opening = client.partition_client(topic, partition as i32, UnknownTopicHandling::Error);
    tokio::time::timeout(ANSWER, opening).await.ok()?.ok()
}
