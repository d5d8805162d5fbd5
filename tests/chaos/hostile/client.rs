//! A hostile robot's MQTT connection, with its own name and password.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use rumqttc::{AsyncClient, Event, EventLoop, MqttOptions, Packet, PublishOptions, QoS};
use tokio::task::JoinHandle;
use vibrissa_protocol::{Message, Name, RobotTopic, Setpoint, Topic, decode};

use super::tally::Tally;
use crate::scenario::FLEET;
use crate::stage::ROBOT_PASSWORD;

/// Largest number of messages that wait in the client; it drops further ones.
const WAITING: usize = 4_000;
/// Largest number of setpoints that are remembered.
const SETPOINTS: usize = 64;
/// The largest packet in bytes: above the largest message of any behaviour.
const PACKET_MAX: u32 = 16 << 20;

/// Messages that the supervisor sent to the robot.
#[derive(Debug, Default)]
pub struct Heard {
    /// Number of receipts so far.
    pub receipts: u64,
    /// The supervisor's boot id, from the newest receipt.
    pub supervisor: Option<String>,
    /// The newest setpoints.
    pub setpoints: VecDeque<Setpoint>,
}

/// The connection, closed on drop.
pub struct Client {
    client: AsyncClient,
    heard: Arc<Mutex<Heard>>,
    poller: JoinHandle<()>,
}

impl Drop for Client {
    fn drop(&mut self) {
        self.poller.abort();
    }
}

fn options(port: u16, robot: &Name, id: String) -> MqttOptions {
    let mut options = MqttOptions::new(id, ("127.0.0.1", port));
    options
        .set_clean_start(true)
        .set_max_packet_size(Some(PACKET_MAX))
        .set_outgoing_inflight_upper_limit(256)
        .set_credentials(format!("{FLEET}/{robot}"), ROBOT_PASSWORD);
    options
}

impl Client {
    /// Connects, and connects again whenever the connection breaks.
    pub fn start(port: u16, robot: &Name, tally: Arc<Tally>) -> Self {
        let (client, events) =
            AsyncClient::builder(options(port, robot, format!("{FLEET}.{robot}"))).capacity(WAITING).build();
        let heard = Arc::new(Mutex::new(Heard::default()));
        let poller = tokio::spawn(poll(client.clone(), events, robot.clone(), heard.clone(), tally));
        Self { client, heard, poller }
    }

    /// Publishes a message, and returns whether the client had room for it. It waits in the client until there is a
    /// connection.
    pub fn say(&self, topic: &str, payload: Vec<u8>, quality: QoS, is_retained: bool) -> bool {
        self.client.try_publish(topic, payload, PublishOptions::new(quality).retain(is_retained)).is_ok()
    }

    /// The messages received so far. The caller must not hold the lock for long.
    pub fn heard(&self) -> MutexGuard<'_, Heard> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

async fn poll(client: AsyncClient, mut events: EventLoop, robot: Name, heard: Arc<Mutex<Heard>>, tally: Arc<Tally>) {
    let fleet = Name::new(FLEET).expect("a name");
    let own = [RobotTopic::Receipt, RobotTopic::Setpoint, RobotTopic::Request].map(|kind| kind.of(&fleet, &robot));
    loop {
        match events.poll().await {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                for topic in &own {
                    // A full queue is emptied by this loop; then nothing is received until the next connection.
                    let _ = client.try_subscribe(topic.to_string(), QoS::AtLeastOnce);
                }
            }
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                let topic = std::str::from_utf8(&publish.topic).ok().and_then(|topic| Topic::parse(topic).ok());
                let message = topic.and_then(|topic| decode(&topic, &publish.payload).ok());
                let mut heard = heard.lock().unwrap_or_else(PoisonError::into_inner);
                match message {
                    Some(Message::Receipt(receipt)) => {
                        heard.receipts += 1;
                        heard.supervisor = Some(receipt.boot_id.as_str().to_owned());
                    }
                    Some(Message::Setpoint(setpoint)) => {
                        tally.count_setpoint();
                        if heard.setpoints.len() == SETPOINTS {
                            heard.setpoints.pop_front();
                        }
                        heard.setpoints.push_back(setpoint);
                    }
                    Some(_) | None => {}
                }
            }
            Ok(_) => {}
            // The broker is down or refuses the client, which would otherwise try again at once.
            Err(_) => tokio::time::sleep(Duration::from_millis(200)).await,
        }
    }
}

/// Connects under any client id with the robot's own password, and returns whether the broker accepted it.
pub async fn connect_as(port: u16, robot: &Name, id: String, patience: Duration) -> bool {
    let (_client, mut events) = AsyncClient::builder(options(port, robot, id)).capacity(8).build();
    let connected = async {
        loop {
            match events.poll().await {
                Ok(Event::Incoming(Packet::ConnAck(_))) => return true,
                Ok(_) => {}
                Err(_) => return false,
            }
        }
    };
    tokio::time::timeout(patience, connected).await.unwrap_or(false)
}
