//! The connection that publishes: setpoints, receipts, requests, and whether the supervisor is there.

use std::time::Duration;

use rumqttc::{
    AsyncClient, Event, LastWill, Outgoing, Packet, PubAck, PubAckReason, PublishOptions, PublishProperties, QoS,
};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tracing::warn;
use vibrissa_protocol::{Message, QualityOfService, SupervisorPresence, SupervisorState, Topic, decode, encode};

use super::Connection;
use super::link::{Backoff, Side};
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem};
use crate::engine::Publication;

/// Publications that wait for the connection.
const WAITING: usize = 1000;
/// How long the good-bye may take.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(2);

/// Publishes what comes out of `outbox` until it is closed, then says good-bye.
pub fn publish(connection: &Connection, mut outbox: mpsc::Receiver<Publication>) -> JoinHandle<()> {
    let (topic, offline) = presence(connection, SupervisorPresence::Offline, 1);
    let (mut options, reached) = connection.options("out");
    options.set_last_will(LastWill::new(topic.clone(), offline.clone(), QoS::AtLeastOnce, true, None));
    let (client, events) = AsyncClient::builder(options).capacity(WAITING).build();
    let poller = Poller::new(events, connection, reached);
    let mut polling = tokio::spawn(keep_up(connection.clone(), client.clone(), poller));
    tokio::spawn(async move {
        while let Some(publication) = outbox.recv().await {
            let options = options_of(&publication);
            let Publication { topic, payload, stopwatch, .. } = publication;
            if client.publish(topic, payload, options).await.is_err() {
                break;
            }
            if let Some(stopwatch) = stopwatch {
                stopwatch.stop();
            }
        }
        let farewell = async {
            client.publish(topic, offline, retained()).await?;
            client.disconnect().await?;
            // Ends by itself when the disconnect is out.
            let _ = (&mut polling).await;
            Ok::<(), rumqttc::ClientError>(())
        };
        // Without it the broker publishes the will, which says the same.
        let _ = tokio::time::timeout(FAREWELL_TIMEOUT, farewell).await;
        polling.abort();
    })
}

/// Polls, connects again, and says at each connection that the supervisor is there.
async fn keep_up(connection: Connection, client: AsyncClient, mut poller: Poller) {
    let (topic, online) = presence(&connection, SupervisorPresence::Online, 0);
    let mut backoff = Backoff::new();
    loop {
        match poller.next().await {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                // Never awaited here: who polls must not wait for the queue that polling empties.
                if let Err(problem) = client.try_subscribe(topic.as_str(), QoS::AtLeastOnce) {
                    warn!(%problem, "cannot hear what is said of the supervisor");
                }
                say_online(&client, &topic, &online);
            }
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                if is_a_predecessors(&connection, &publish.payload) {
                    say_online(&client, &topic, &online);
                }
            }
            Ok(Event::Incoming(Packet::PubAck(ack))) if is_failure(&ack) => {
                let problem = Problem::new(&connection.broker, Cause::Publication(format!("{:?}", ack.reason)));
                connection.link.broken(Side::Publishing, &problem);
            }
            Ok(Event::Incoming(Packet::PubAck(_))) => {
                backoff.reset();
                connection.link.connected(Side::Publishing);
            }
            Ok(Event::Outgoing(Outgoing::Disconnect)) | Err(Failure::Finished) => return,
            Ok(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) => {}
            Err(Failure::Broken(problem)) => {
                connection.link.broken(Side::Publishing, &problem);
                tokio::time::sleep(backoff.pause()).await;
            }
        }
    }
}

fn say_online(client: &AsyncClient, topic: &str, online: &[u8]) {
    if let Err(problem) = client.try_publish(topic, online.to_vec(), retained()) {
        warn!(%problem, "cannot say that the supervisor is online");
    }
}

/// Whether this is what a broker says, late, of a supervisor that froze or lost its link, and whose fleet we have:
/// its will has taken the place of our own word.
fn is_a_predecessors(connection: &Connection, payload: &[u8]) -> bool {
    let topic = Topic::SupervisorState { fleet: connection.fleet.clone() };
    match decode(&topic, payload) {
        Ok(Message::SupervisorState(told)) => {
            told.epoch < connection.epoch && told.state == SupervisorPresence::Offline
        }
        Ok(_) | Err(_) => false,
    }
}

fn presence(connection: &Connection, state: SupervisorPresence, seq: u64) -> (String, Vec<u8>) {
    let topic = Topic::SupervisorState { fleet: connection.fleet.clone() };
    let message = SupervisorState { boot_id: connection.boot_id.clone(), seq, state, epoch: connection.epoch };
    (topic.to_string(), encode(&message))
}

fn retained() -> PublishOptions {
    PublishOptions::at_least_once().retained()
}

fn options_of(publication: &Publication) -> PublishOptions {
    let options = PublishOptions::new(match publication.qos {
        QualityOfService::AtMostOnce => QoS::AtMostOnce,
        QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
    });
    match publication.expiry_s {
        None => options,
        Some(expiry_s) => options
            .properties(PublishProperties { message_expiry_interval: Some(expiry_s), ..PublishProperties::default() }),
    }
}

/// Whether the broker did not take a publication.
pub(super) fn is_failure(ack: &PubAck) -> bool {
    !matches!(ack.reason, PubAckReason::Success | PubAckReason::NoMatchingSubscribers)
}
