//! A connection that proves that this supervisor can hear a fleet, and then ends.

use std::time::Duration;

use rumqttc::{AsyncClient, Event, Packet, RetainForwardRule};
use tokio::time::{Instant, timeout};
use vibrissa_protocol::plain;

use super::Connection;
use super::hearing::Hearing;
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem, STOPPED};
use super::proofs::is_failure;
use super::receive::judge;
use super::subscriptions::{Subscriptions, inputs};

/// Time limit of the whole trial.
const LIMIT: Duration = Duration::from_secs(15);
/// Time limit for the disconnect.
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(1);

/// Connects, subscribes to the robots' topics without retained messages, and waits for a probe of each topic.
///
/// # Errors
/// Why robots would not be heard, as a sentence.
pub async fn try_hearing(connection: &Connection) -> Result<(), String> {
    let silent = || Problem::new(&connection.broker, Cause::Silent);
    let tried = timeout(LIMIT, prove(connection)).await;
    tried.unwrap_or_else(|_| Err(silent())).map_err(|problem| problem.to_string())
}

/// Tries the nodes one after the other, and returns the last problem if none of them is good.
async fn prove(connection: &Connection) -> Result<(), Problem> {
    let connection = connection.with_secrets_read_again();
    let mut proven = Ok(());
    for node in connection.broker.nodes() {
        proven = prove_at(&connection.at(&node)).await;
        if proven.is_ok() {
            break;
        }
    }
    proven
}

async fn prove_at(connection: &Connection) -> Result<(), Problem> {
    let fleet = &connection.fleet;
    let mut subscriptions = Subscriptions::new(connection.fleet.clone());
    let problem = |cause| Problem::new(&connection.broker, cause);
    let (options, reached) = connection.options("trial");
    let (client, events) = AsyncClient::builder(options).capacity(64).build();
    let mut poller = Poller::new(events, connection, reached);
    let mut hearing = Hearing::new(&connection.fleet, subscriptions.kinds(), Instant::now());
    while !hearing.is_proven() {
        let event = poller.next_while(&mut hearing, |hearing| judge(&client, hearing, connection, |_| {})).await?;
        match event {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                let subscribed = inputs(subscriptions.begin());
                let subscribed = subscribed.map(|filter| filter.retain_forward_rule(RetainForwardRule::Never));
                let sent = client.try_subscribe_many(subscribed);
                sent.map_err(|error| Problem::of_client(&connection.broker, &error))?;
                hearing.asked(Instant::now());
            }
            Ok(Event::Incoming(Packet::SubAck(ack))) => {
                if let Err(refused) = subscriptions.acknowledged(&ack.return_codes) {
                    return Err(problem(Cause::Subscription(refused)));
                }
                hearing.subscribed(Instant::now());
            }
            Ok(Event::Incoming(Packet::PubAck(ack))) if is_failure(&ack) => {
                return Err(problem(Cause::ProbeRefused {
                    fleet: fleet.clone(),
                    why: plain::reason_code(&format!("{:?}", ack.reason)),
                }));
            }
            Ok(Event::Incoming(Packet::PubAck(_))) => hearing.acknowledged(),
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                hearing.take(&publish.topic, &publish.payload);
            }
            Ok(Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_)) => {}
            Err(Failure::Broken(problem)) => return Err(problem),
            Err(Failure::Finished) => return Err(problem(Cause::Lost(STOPPED.to_owned()))),
        }
    }
    // Disconnects, so that the broker does not log a lost connection each time.
    if client.try_disconnect().is_ok() {
        let ended = async { while poller.next().await.is_ok() {} };
        let _ = timeout(FAREWELL_TIMEOUT, ended).await;
    }
    Ok(())
}
