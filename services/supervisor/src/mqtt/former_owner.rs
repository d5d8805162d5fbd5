//! A connection that reads the state of the fleet's last owner, which the broker retains, and then ends.

use std::time::Duration;

use rumqttc::{AsyncClient, Event, Packet, QoS};
use tokio::time::{Instant, timeout, timeout_at};
use vibrissa_protocol::{Message, Topic, decode};

use super::Connection;
use super::link::Side;
use super::nodes::Attempts;
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem, STOPPED};
use crate::metrics::FleetMetrics;

/// Time limit for the retained message, from the broker's answer to the subscription.
const RETAINED_PATIENCE: Duration = Duration::from_millis(300);
/// Time limit of one attempt.
const LIMIT: Duration = Duration::from_secs(15);
/// Time limit for the disconnect.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(1);

/// Epoch of the fleet's last owner, as the broker retains it; `None` if it retains none. Tries until a node of the broker
/// answers; calls `failed` after each failure, which the connection's link has then.
pub(crate) async fn retained_epoch(connection: &Connection, metrics: &FleetMetrics, failed: impl Fn()) -> Option<u64> {
    let mut attempts = Attempts::new();
    let mut connection = Attempts::first(connection);
    loop {
        let problem = match timeout(LIMIT, read_at(&connection)).await {
            Ok(Ok(epoch)) => return epoch,
            Ok(Err(problem)) => problem,
            Err(_) => Problem::new(&connection.broker, Cause::Silent),
        };
        metrics.mqtt_node_failures.count(&problem.node().to_string());
        for side in [Side::Receiving, Side::Publishing] {
            connection.link.broken(side, &problem);
        }
        failed();
        connection = attempts.next(&connection, &problem).await;
    }
}

async fn read_at(connection: &Connection) -> Result<Option<u64>, Problem> {
    let topic = Topic::SupervisorState { fleet: connection.fleet.clone() };
    let (options, reached) = connection.options("former-owner");
    let (client, events) = AsyncClient::builder(options).capacity(8).build();
    let mut poller = Poller::new(events, connection, reached);
    let mut until = None;
    let epoch = loop {
        let event = match until {
            None => poller.next().await,
            Some(until) => match timeout_at(until, poller.next()).await {
                Ok(event) => event,
                Err(_) => break None,
            },
        };
        match event {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                let asked = client.try_subscribe(topic.to_string(), QoS::AtLeastOnce);
                asked.map_err(|error| Problem::of_client(&connection.broker, &error))?;
            }
            // A broker that refuses the subscription sends nothing either.
            Ok(Event::Incoming(Packet::SubAck(_))) => until = Some(Instant::now() + RETAINED_PATIENCE),
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                if let Ok(Message::SupervisorState(state)) = decode(&topic, &publish.payload) {
                    break Some(state.epoch);
                }
            }
            Ok(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) => {}
            Err(Failure::Broken(problem)) => return Err(problem),
            Err(Failure::Finished) => return Err(Problem::new(&connection.broker, Cause::Lost(STOPPED.to_owned()))),
        }
    };
    if client.try_disconnect().is_ok() {
        let ended = async { while poller.next().await.is_ok() {} };
        let _ = timeout(FAREWELL_TIMEOUT, ended).await;
    }
    Ok(epoch)
}
