//! Subscribers that only receive: the ceiling of any service with this MQTT client, and the floor of its answers.

use std::time::Duration;

use rumqttc::{
    AsyncClient, Event, EventLoop, MqttOptions, NetworkOptions, Packet, PublishOptions, QoS, SubscribeFilterInput,
};
use serde::{Deserialize, Serialize};
use tokio::time::timeout;
use vibrissa_protocol::{Name, RobotTopic};
use vibrissa_simulator::clock::now_us;

use crate::child::READY;
use crate::usage;

/// Same limits as the supervisor's receiving connection in `services/supervisor/src/mqtt`.
const PACKET_MAX: u32 = 2 * 1024 * 1024;
const IN_FLIGHT: u16 = 512;
const KEEP_ALIVE_S: u16 = 6;
const CAPACITY: usize = 64;
/// After this time without a message the burst is over.
const SILENCE: Duration = Duration::from_millis(1500);
/// Fleet whose contacts are sent back.
pub const ECHO_FLEET: &str = "echo";

/// Subscription and end of the counting subscriber.
#[derive(Debug, clap::Args)]
pub struct NullArguments {
    /// Port of the broker on this machine
    #[arg(long)]
    port: u16,
    /// Name of the fleet
    #[arg(long)]
    fleet: Name,
    /// Number of contacts messages to wait for
    #[arg(long)]
    messages: u64,
}

/// Result of the counting subscriber.
#[derive(Debug, Serialize, Deserialize)]
pub struct Received {
    /// Number of contacts messages.
    pub messages: u64,
    /// Time of the last one, in microseconds since 1970 UTC.
    pub last_us: u64,
    /// Processor time from the first to the last one, seconds.
    pub cpu_s: f64,
}

fn connect(port: u16) -> (AsyncClient, EventLoop) {
    let mut options = MqttOptions::new(format!("null-{}", std::process::id()), ("127.0.0.1".to_owned(), port));
    options
        .set_clean_start(true)
        .set_keep_alive(KEEP_ALIVE_S)
        .set_max_packet_size(Some(PACKET_MAX))
        .set_outgoing_inflight_upper_limit(IN_FLIGHT);
    let mut network = NetworkOptions::new();
    network.set_tcp_nodelay(true);
    options.set_network_options(network);
    AsyncClient::builder(options).capacity(CAPACITY).build()
}

/// Subscribes to all messages of a fleet's robots, as a supervisor does, and counts contacts messages.
pub async fn run(arguments: NullArguments) -> anyhow::Result<Received> {
    let (client, mut events) = connect(arguments.port);
    let heard = RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot());
    let filter = |kind: RobotTopic| SubscribeFilterInput::new(kind.fleet_filter(&arguments.fleet), QoS::AtLeastOnce);
    client.try_subscribe_many(heard.map(filter))?;
    let cpu_s = || usage::of_tree(std::process::id()).cpu_s;
    let mut cpu_before_s = 0.0;
    let mut received = Received { messages: 0, last_us: 0, cpu_s: 0.0 };
    while received.messages < arguments.messages {
        let event = match timeout(SILENCE, events.poll()).await {
            Ok(event) => event?,
            Err(_) if received.messages > 0 => break,
            Err(_) => continue,
        };
        match event {
            Event::Incoming(Packet::SubAck(_)) => eprintln!("{READY}"),
            Event::Incoming(Packet::Publish(publish)) if publish.topic.ends_with(b"/contacts") => {
                if received.messages == 0 {
                    cpu_before_s = cpu_s();
                }
                received.messages += 1;
                // The clock is read only now and then: reading it costs as much as all the rest.
                if received.messages.is_multiple_of(64) || received.messages == arguments.messages {
                    received.last_us = now_us();
                }
            }
            Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_) => {}
        }
    }
    received.cpu_s = cpu_s() - cpu_before_s;
    Ok(received)
}

/// Sends each contacts message of fleet [`ECHO_FLEET`] back as a setpoint, until the process is killed.
pub async fn echo(port: u16) -> anyhow::Result<()> {
    let (client, mut events) = connect(port);
    client.try_subscribe(format!("whisker/v1/{ECHO_FLEET}/+/contacts"), QoS::AtLeastOnce)?;
    loop {
        match events.poll().await? {
            Event::Incoming(Packet::SubAck(_)) => eprintln!("{READY}"),
            Event::Incoming(Packet::Publish(publish)) => {
                let topic = format!("whisker/v1/{ECHO_FLEET}/r/setpoint");
                client.try_publish(topic, publish.payload, PublishOptions::new(QoS::AtLeastOnce))?;
            }
            Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_) => {}
        }
    }
}
