//! The model of the log, for simulated time, beside the real one.

use std::collections::BTreeMap;
use std::time::Duration;

use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rskafka::chrono::{DateTime, Utc};
use rskafka::client::error::{Error, ProtocolError};
use rskafka::client::partition::{OffsetAt, PartitionClient, UnknownTopicHandling};
use rskafka::client::{Client, ClientBuilder};
use rskafka::record::Record;
use tokio::net::TcpListener;
use vibrissa_simulation::log::{Entry, ModelLog};
use vibrissa_tests::kafka::Kafka;

const TOPIC: &str = "t";
const PARTITIONS: u32 = 2;
/// Operations that are drawn. Each takes some milliseconds.
const OPERATIONS: usize = 300;
/// Time limit of a request.
const ANSWER: Duration = Duration::from_secs(60);

/// Answer to a read: records with their offsets, and the end of the partition; or the error.
type Read = Result<(Vec<(i64, Record)>, i64), ProtocolError>;

/// A client of one of the two.
struct End {
    client: Client,
    partitions: Vec<PartitionClient>,
}

impl End {
    async fn connect(address: &str) -> Self {
        let client = ClientBuilder::new(vec![address.to_owned()]).build().await.unwrap();
        let mut partitions = Vec::new();
        for partition in 0..PARTITIONS {
            let opening = client.partition_client(TOPIC, partition as i32, UnknownTopicHandling::Error);
            partitions.push(opening.await.unwrap());
        }
        Self { client, partitions }
    }

    async fn topics(&self) -> BTreeMap<String, usize> {
        let topics = self.client.list_topics().await.unwrap();
        topics.into_iter().map(|topic| (topic.name, topic.partitions.len())).collect()
    }

    async fn offsets(&self, partition: usize) -> (i64, i64) {
        let of = &self.partitions[partition];
        (of.get_offset(OffsetAt::Earliest).await.unwrap(), of.get_offset(OffsetAt::Latest).await.unwrap())
    }

    async fn read(&self, partition: usize, from: i64, bytes: i32) -> Read {
        let reading = self.partitions[partition].fetch_records(from, 1..bytes + 1, 20);
        match tokio::time::timeout(ANSWER, reading).await.unwrap() {
            Ok((records, end)) => {
                // The model knows no times.
                let record = |record| Record { timestamp: DateTime::UNIX_EPOCH, ..record };
                Ok((records.into_iter().map(|one| (one.offset, record(one.record))).collect(), end))
            }
            Err(Error::ServerError { protocol_error, .. }) => Err(protocol_error),
            Err(other) => panic!("{other}"),
        }
    }
}

fn drawn(random: &mut ChaCha8Rng) -> Entry {
    let mut bytes = |most: usize| (0..random.random_range(0..most)).map(|_| random.random()).collect::<Vec<u8>>();
    let (key, value, header) = (bytes(20), bytes(400), bytes(20));
    Entry {
        key: random.random_bool(0.8).then_some(key),
        value: random.random_bool(0.9).then_some(value),
        header: random.random_bool(0.5).then(|| ("topic".to_owned(), header)),
    }
}

#[tokio::test]
async fn property_the_model_of_the_log_answers_as_kafka_does() {
    let Some(kafka) = Kafka::start(1).await else { return };
    kafka.create_topic(TOPIC, PARTITIONS).await;
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let model = ModelLog::new("127.0.0.1", port);
    model.create(TOPIC, PARTITIONS as usize);
    let serving = model.clone();
    let serving = tokio::spawn(async move { serving.listen(listener).await });
    let real = End::connect(&kafka.addresses()[0]).await;
    let modelled = End::connect(&format!("127.0.0.1:{port}")).await;
    assert_eq!(modelled.topics().await, real.topics().await);
    let mut random = ChaCha8Rng::seed_from_u64(47);
    let (mut records_read, mut refusals) = (0, 0);
    for operation in 0..OPERATIONS {
        let partition = random.random_range(0..PARTITIONS as usize);
        let (begin, end) = real.offsets(partition).await;
        match random.random_range(0..10) {
            0..3 => {
                let entries: Vec<Entry> = (0..random.random_range(1..6)).map(|_| drawn(&mut random)).collect();
                let written = Utc::now();
                let record = |entry: &Entry| Record {
                    key: entry.key.clone(),
                    value: entry.value.clone(),
                    headers: entry.header.clone().into_iter().collect(),
                    timestamp: written,
                };
                kafka.write(TOPIC, partition as u32, entries.iter().map(record).collect()).await;
                // A write without an answer is repeated.
                let (_, end) = real.offsets(partition).await;
                while model.offsets(TOPIC, partition).is_some_and(|(_, of_model)| of_model < end) {
                    model.append(TOPIC, partition, &entries);
                }
            }
            3 => {
                let before = random.random_range(begin..=end);
                real.partitions[partition].delete_records(before, 5_000).await.unwrap();
                model.delete_before(TOPIC, partition, before);
            }
            4 => assert_eq!(modelled.offsets(partition).await, (begin, end), "operation {operation}"),
            _ => {
                let from = random.random_range(begin - 2..end + 3);
                let bytes = [1, 300, 1_500, 1_000_000][random.random_range(0..4)];
                let found = real.read(partition, from, bytes).await;
                records_read += found.as_ref().map_or(0, |(records, _)| records.len());
                refusals += usize::from(found.is_err());
                let of_model = modelled.read(partition, from, bytes).await;
                assert_eq!(of_model, found, "operation {operation}: {bytes} bytes from {from} of {begin}..{end}");
            }
        }
    }
    assert!(records_read > 100 && refusals > 5, "{records_read} records and {refusals} refusals compared");
    assert_eq!(model.offsets(TOPIC, 0), Some(real.offsets(0).await));
    serving.abort();
}
