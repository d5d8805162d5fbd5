//! Late and repeated deliveries: setpoints from the broker are published again, unchanged, seconds later. A broker may
//! do that; a robot must answer them again or refuse them.

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rumqttc::{AsyncClient, Event, EventLoop, MqttOptions, Packet, PublishOptions, QoS};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use vibrissa_protocol::{Name, RobotTopic, Setpoint};

/// Delays in seconds: while the setpoint is being applied or shortly after, and after it has expired.
const DELAYS_S: [std::ops::Range<f64>; 2] = [0.5..5.0, LATE_S..18.0];
/// A setpoint has expired after this time, in seconds.
const LATE_S: f64 = 13.0;

/// Repeats setpoints until it is dropped.
pub struct Replay {
    count: Arc<AtomicU64>,
    late: watch::Receiver<u64>,
    task: JoinHandle<()>,
}

impl Drop for Replay {
    fn drop(&mut self) {
        self.task.abort();
    }
}

impl Replay {
    /// Starts repeating the setpoints of these fleets at this host and port of the broker, as this user.
    pub fn start(broker: (&str, u16), (user, password): (&str, &str), fleets: &[Name], seed: u64) -> Self {
        let filters = fleets.iter().map(|fleet| RobotTopic::Setpoint.fleet_filter(fleet)).collect();
        let mut options = MqttOptions::new("replay", broker);
        options.set_clean_start(true).set_max_packet_size(Some(1 << 20)).set_outgoing_inflight_upper_limit(256);
        options.set_credentials(user, password.to_owned());
        let (client, events) = AsyncClient::builder(options).capacity(1000).build();
        let count = Arc::new(AtomicU64::new(0));
        let (late, receiver) = watch::channel(0);
        let task =
            tokio::spawn(repeat((client, events), filters, ChaCha8Rng::seed_from_u64(seed), count.clone(), late));
        Self { count, late: receiver, task }
    }

    /// Number of setpoints that were published again.
    pub fn count(&self) -> u64 {
        self.count.load(Ordering::Relaxed)
    }

    /// Waits until so many setpoints were published again after they had expired.
    pub async fn late(&mut self, least: u64) {
        self.late.wait_for(|&late| late >= least).await.expect("it repeats until it is dropped");
    }
}

async fn repeat(
    (client, mut events): (AsyncClient, EventLoop),
    filters: Vec<String>,
    mut random: ChaCha8Rng,
    count: Arc<AtomicU64>,
    late: watch::Sender<u64>,
) {
    let mut known = HashSet::new();
    loop {
        match events.poll().await {
            Ok(Event::Incoming(Packet::ConnAck(_))) => {
                for filter in &filters {
                    client.try_subscribe(filter.as_str(), QoS::AtLeastOnce).expect("room for each fleet");
                }
            }
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                let setpoint: Setpoint = serde_json::from_slice(&publish.payload).expect("a setpoint of the contract");
                // It was sent again, by the supervisor or by this client.
                if !known.insert(setpoint.command_id) {
                    continue;
                }
                let topic = String::from_utf8(publish.topic.to_vec()).expect("text");
                for delay_s in DELAYS_S {
                    let after = Duration::from_secs_f64(random.random_range(delay_s));
                    let (client, topic, payload) = (client.clone(), topic.clone(), publish.payload.clone());
                    let (count, late) = (count.clone(), late.clone());
                    tokio::spawn(async move {
                        tokio::time::sleep(after).await;
                        // Without a connection the message waits in the client and arrives even later.
                        let again = client.try_publish(topic, payload, PublishOptions::new(QoS::AtLeastOnce));
                        count.fetch_add(u64::from(again.is_ok()), Ordering::Relaxed);
                        if after.as_secs_f64() >= LATE_S {
                            late.send_modify(|late| *late += u64::from(again.is_ok()));
                        }
                    });
                }
            }
            Ok(_) => {}
            // The broker is down; the client would otherwise try again at once.
            Err(_) => tokio::time::sleep(Duration::from_millis(200)).await,
        }
    }
}
