//! Makes the broker forget all retained messages, as brokers without persistence do.

use std::collections::BTreeSet;
use std::time::Duration;

use rumqttc::{AsyncClient, Event, MqttOptions, Packet, PublishOptions, QoS};
use vibrissa_protocol::{Name, RobotTopic, Topic};

/// Time limit for the acknowledgements.
const PATIENCE: Duration = Duration::from_secs(5);

/// Deletes the retained messages of these robots, each with its fleet, and of the fleets' supervisors; returns whether the broker
/// has acknowledged it.
pub async fn forget(broker: (&str, u16), (user, password): (&str, &str), robots: &[(Name, Name)]) -> bool {
    let of_robot = |(fleet, robot): &(Name, Name)| {
        let retained = RobotTopic::ALL.into_iter().filter(|kind| kind.is_retained());
        retained.map(|kind| kind.of(fleet, robot).to_string()).collect::<Vec<_>>()
    };
    let fleets: BTreeSet<&Name> = robots.iter().map(|(fleet, _)| fleet).collect();
    let states = fleets.into_iter().map(|fleet| Topic::SupervisorState { fleet: fleet.clone() }.to_string());
    let topics: Vec<String> = robots.iter().flat_map(of_robot).chain(states).collect();
    let mut options = MqttOptions::new("forget", broker);
    options.set_clean_start(true).set_credentials(user, password.to_owned());
    options.set_outgoing_inflight_upper_limit(64);
    let (client, mut events) = AsyncClient::builder(options).capacity(topics.len()).build();
    for topic in &topics {
        let empty = client.try_publish(topic, Vec::new(), PublishOptions::new(QoS::AtLeastOnce).retained());
        empty.expect("a queue for all of them");
    }
    let acknowledged = async {
        let mut missing = topics.len();
        while missing > 0 {
            match events.poll().await {
                Ok(Event::Incoming(Packet::PubAck(_))) => missing -= 1,
                Ok(_) => {}
                Err(_) => return false,
            }
        }
        true
    };
    tokio::time::timeout(PATIENCE, acknowledged).await.unwrap_or(false)
}
