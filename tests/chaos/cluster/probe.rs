//! Whether messages pass between the nodes of the broker, by clients that have nothing to do with the product.

use std::time::Duration;

use rumqttc::{AsyncClient, Event, EventLoop, MqttOptions, Packet, PublishOptions, QoS};
use tokio::time::{Instant, timeout_at};

use super::stage::CLIENT;

/// Topic of the probes.
const TOPIC: &str = "chaos/probe";
/// Time limit of an attempt.
const PATIENCE: Duration = Duration::from_secs(2);

/// Whether each of these nodes accepts a client, and a message from each one reaches all.
pub async fn pass(nodes: &[(String, u16)]) -> bool {
    let deadline = Instant::now() + PATIENCE;
    timeout_at(deadline, attempt(nodes)).await.is_ok_and(|passed| passed.is_some())
}

async fn attempt(nodes: &[(String, u16)]) -> Option<()> {
    let mut clients = Vec::new();
    for (at, (host, port)) in nodes.iter().enumerate() {
        let id = format!("probe-{at}-{}", vibrissa_simulator::clock::now_us());
        let mut options = MqttOptions::new(id, (host.clone(), *port));
        options.set_clean_start(true).set_credentials(CLIENT.0, CLIENT.1);
        let (client, mut events) = AsyncClient::builder(options).capacity(16).build();
        client.try_subscribe(TOPIC, QoS::AtMostOnce).ok()?;
        until(&mut events, |packet| matches!(packet, Packet::SubAck(_)).then_some(())).await?;
        clients.push((client, events));
    }
    for at in 0..clients.len() {
        let payload = format!("{at}-{}", vibrissa_simulator::clock::now_us());
        clients[at].0.try_publish(TOPIC, payload.clone(), PublishOptions::new(QoS::AtMostOnce)).ok()?;
        // The sender first: its client must work for its message to go out.
        let mut order: Vec<usize> = (0..clients.len()).collect();
        order.swap(0, at);
        for of in order {
            let is_it = |packet: Packet| match packet {
                Packet::Publish(publish) if publish.payload == payload.as_bytes() => Some(()),
                _ => None,
            };
            until(&mut clients[of].1, is_it).await?;
        }
    }
    Some(())
}

/// Polls until a packet from the broker is the one that is waited for; `None` if the connection ends.
async fn until<T>(events: &mut EventLoop, is_it: impl Fn(Packet) -> Option<T>) -> Option<T> {
    loop {
        if let Event::Incoming(packet) = events.poll().await.ok()?
            && let Some(found) = is_it(packet)
        {
            return Some(found);
        }
    }
}
