//! Each rule of the broker and each fault, in simulated time.

mod faults;
mod keep_alive;
mod messages;
mod order;
mod retained;
mod sessions;
mod streams;
mod wires;

use std::time::Duration;

use rumqttc::{LastWill, Packet, Publish, QoS};
use tokio::time::timeout;

use super::{Client, ClientOptions, Limits, ModelBroker};

/// A time in which nothing must come.
const LONG: Duration = Duration::from_secs(3600);

fn broker() -> ModelBroker {
    ModelBroker::new(1, Limits::default())
}

async fn connected(broker: &ModelBroker, id: &str) -> Client {
    Client::connect(broker, ClientOptions::new(id)).await.unwrap()
}

/// A client whose will on `will/ID` is retained.
async fn mortal(broker: &ModelBroker, id: &str) -> Client {
    let will = LastWill::new(format!("will/{id}"), "dead", QoS::AtLeastOnce, true, None);
    Client::connect(broker, ClientOptions { will: Some(will), ..ClientOptions::new(id) }).await.unwrap()
}

async fn subscribed(broker: &ModelBroker, id: &str, filter: &str) -> Client {
    let mut client = connected(broker, id).await;
    subscribe(&mut client, filter).await;
    client
}

async fn subscribe(client: &mut Client, filter: &str) {
    let id = client.subscribe([filter]);
    match client.recv().await {
        Some(Packet::SubAck(ack)) => assert_eq!(ack.pkid, id),
        other => panic!("{other:?}"),
    }
}

/// Options of a client with a session of a day, which it resumes.
fn lasting(id: &str) -> ClientOptions {
    ClientOptions { is_clean_start: false, session_s: 86_400, ..ClientOptions::new(id) }
}

/// Topic and payload of the next message.
async fn heard(client: &mut Client) -> (String, String) {
    let Publish { topic, payload, .. } = client.message().await.unwrap();
    (String::from_utf8(topic.into()).unwrap(), String::from_utf8(payload.into()).unwrap())
}

async fn payload(client: &mut Client) -> String {
    heard(client).await.1
}

/// Nothing more comes for an hour.
async fn is_quiet(client: &mut Client) -> bool {
    timeout(LONG, client.message()).await.is_err()
}

/// Publishes with QoS 1 on topic `t`.
fn say(client: &mut Client, payload: &str) {
    client.publish("t", payload.to_owned(), QoS::AtLeastOnce, false);
}
