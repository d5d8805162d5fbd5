//! Measures the cost of a contact that comes through Kafka.

use std::collections::BTreeMap;
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use rskafka::record::Record;
use rumqttc::{AsyncClient, Event, MqttOptions, Packet, Publish, QoS};
use serde_json::json;
use tokio::time::{Instant, timeout_at};
use vibrissa_edge::partition::robot_hash;
use vibrissa_protocol::RobotTopic;
use vibrissa_tests::kafka::{Kafka, Writer, record_of};
use vibrissa_tests::mosquitto::Mosquitto;

use crate::Bench;
use crate::cost::{CONTACTS, Costs, Loading};
use crate::report::{Figure, Target, median};
use crate::stage::{self, Store, Supervisor};

const PART: &str = "kafka";
const TOPIC: &str = "vibrissa.messages";
const PARTITIONS: u32 = 4;
/// Messages per second of all robots: 20,000 contacts per second.
const RATE: f64 = 1000.0;
/// Time with this load before the measurement, s: Java compiles the most frequent functions in it.
const WARM_UP_S: f64 = 20.0;
/// Measured time, as a multiple of the pace's.
const MEASURED: f64 = 2.0;
/// Time between two writes of the bridge.
const GATHER: Duration = Duration::from_millis(50);

/// Where contacts come from, and what becomes of them.
struct Case {
    name: &'static str,
    /// Number of brokers of Kafka; 0 for contacts over MQTT.
    brokers: usize,
    keep: &'static str,
    costs: Vec<Costs>,
}

fn cases() -> [Case; 4] {
    let case = |name, brokers, keep| Case { name, brokers, keep, costs: Vec::new() };
    [
        case("MQTT", 0, "all"),
        case("Kafka", 1, "all"),
        case("Kafka, no contact kept", 1, "none"),
        case("three brokers of Kafka, no contact kept", 3, "none"),
    ]
}

impl Case {
    /// Runs the load once, with new servers.
    async fn round(&mut self, bench: &mut Bench, broker: &Mosquitto, round: usize) -> anyhow::Result<()> {
        let store = Store::postgres().await;
        let fleet = format!("{PART}-{}-{}-{round}", self.brokers, self.keep);
        let kafka = match self.brokers {
            0 => None,
            count => Some(Kafka::start(count).await.context("Kafka is not installed: run tests/kafka")?),
        };
        let (mut further, mut bridge) = (vec!["--contacts-keep", self.keep], None);
        let kafka_url = kafka.as_ref().map(Kafka::url);
        if let (Some(kafka), Some(url)) = (&kafka, &kafka_url) {
            kafka.create_topic(TOPIC, PARTITIONS).await;
            further.extend(["--ingest", "kafka", "--kafka-url", url]);
            bridge = Some(tokio::spawn(carry(broker.port(), fleet.clone(), kafka.addresses())));
        }
        let supervisor = Supervisor::start_with(&bench.stage, broker, &store, &fleet, &further).await?;
        let mut watched = vec![("supervisor", supervisor.pid()), ("broker", broker.pid())];
        watched.extend(store.pid().map(|pid| ("postgresql", pid)));
        let brokers = kafka.iter().flat_map(|kafka| (0..self.brokers).map(|at| kafka.broker(at).pid()));
        watched.extend(brokers.map(|pid| ("kafka", pid)));
        let measured_s = MEASURED * bench.pace.latency_s;
        let (rate, warm_up_s) = (RATE, WARM_UP_S);
        let loading = Loading { broker, store: &store, fleet: &fleet, rate, warm_up_s, measured_s, watched };
        let costs = loading.costs().await?;
        ensure!(costs.report.receipted == costs.report.sent, "messages without a receipt");
        if let Some(bridge) = bridge {
            // A bridge that has ended has failed.
            ensure!(!bridge.is_finished(), "the bridge has failed: {:?}", bridge.await);
            bridge.abort();
        }
        supervisor.stop().await?;
        let line = json!({
            "subject": self.name, "messages_per_s": RATE, "contacts": costs.contacts, "us_per_contact": costs.us,
            "wal_bytes_per_contact": costs.wal_bytes,
        });
        bench.line(PART, round, line)?;
        bench.say(&format!("{PART}, round {}: {}: {:.1?} us per contact", round + 1, self.name, costs.us));
        self.costs.push(costs);
        Ok(())
    }

    fn median(&self, of: impl Fn(&Costs) -> f64) -> f64 {
        median(self.costs.iter().map(of))
    }
}

/// Carries contacts and statuses of a fleet from the MQTT broker to Kafka until it fails or is dropped.
async fn carry(mqtt: u16, fleet: String, addresses: Vec<String>) -> anyhow::Result<()> {
    let mut options = MqttOptions::new("bench-bridge", ("127.0.0.1".to_owned(), mqtt));
    options.set_max_packet_size(Some(2 * 1024 * 1024)).set_keep_alive(30);
    let (client, mut events) = AsyncClient::builder(options).capacity(64).build();
    for kind in [RobotTopic::Contacts, RobotTopic::Status] {
        client.try_subscribe(format!("whisker/v1/{fleet}/+/{kind}"), QoS::AtLeastOnce)?;
    }
    let mut writers: Vec<_> =
        (0..PARTITIONS).map(|partition| Writer::new(addresses.clone(), TOPIC, partition)).collect();
    let mut waiting: BTreeMap<u32, Vec<Record>> = BTreeMap::new();
    loop {
        let until = Instant::now() + GATHER;
        while let Ok(event) = timeout_at(until, events.poll()).await {
            let Event::Incoming(Packet::Publish(publish)) = event? else { continue };
            let (partition, record) = of_message(&fleet, &publish)?;
            waiting.entry(partition).or_default().push(record);
        }
        for (partition, records) in std::mem::take(&mut waiting) {
            if !writers[partition as usize].write(records).await {
                bail!("Kafka does not take records");
            }
        }
    }
}

/// A message as a record, and its partition.
fn of_message(fleet: &str, publish: &Publish) -> anyhow::Result<(u32, Record)> {
    let topic = std::str::from_utf8(&publish.topic)?;
    let (rest, kind) = topic.rsplit_once('/').context("a topic")?;
    let robot = rest.rsplit_once('/').context("a topic")?.1;
    let kind = if kind == "contacts" { RobotTopic::Contacts } else { RobotTopic::Status };
    Ok((robot_hash(fleet, robot) % PARTITIONS, record_of(fleet, robot, kind, publish.payload.to_vec())))
}

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let broker = stage::broker();
    let mut cases = cases();
    let mut round = 0;
    while bench.has_time_for(round) {
        for case in &mut cases {
            case.round(bench, &broker, round).await?;
        }
        round += 1;
    }
    for case in &cases {
        let us = |kind: &str| Figure(case.median(|costs| costs.us(kind)), "us");
        let beside = format!(
            "Kafka {}, PostgreSQL {}, broker {}; WAL {}",
            us("kafka"),
            us("postgresql"),
            us("broker"),
            Figure(case.median(|costs| costs.wal_bytes), "bytes")
        );
        let what = format!("{}: CPU of the supervisor per contact at {} contacts/s", case.name, RATE * CONTACTS as f64);
        bench.row(PART, &what, Target::None, us("supervisor"), beside)?;
    }
    Ok(())
}
