//! Order and delivery over random disconnects.

use std::collections::BTreeMap;

use proptest::prelude::*;
use rumqttc::SubscribeFilter;
use tokio::time::sleep;

use super::*;
use crate::broker::{Delay, Ending, Way};

/// What happens next.
#[derive(Debug, Clone)]
enum Step {
    /// The sender of this number publishes on the topic of this number, retained or not.
    Publish { sender: usize, topic: usize, is_retained: bool },
    /// The receiver takes up to this many messages.
    Take(usize),
    /// The receiver's connection breaks, and it connects again.
    Break(Ending),
    /// Time passes, ms.
    Wait(u64),
    /// Messages to the receiver are delayed by up to this, ms, and overtake those of other topics or not.
    Delay(u64, bool),
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        6 => (0..2_usize, 0..2_usize, any::<bool>())
            .prop_map(|(sender, topic, is_retained)| Step::Publish { sender, topic, is_retained }),
        3 => (1..6_usize).prop_map(Step::Take),
        1 => prop_oneof![Just(Ending::Told), Just(Ending::Silent)].prop_map(Step::Break),
        1 => (0..50_u64).prop_map(Step::Wait),
        1 => (0..50_u64, any::<bool>()).prop_map(|(ms, overtake)| Step::Delay(ms, overtake)),
    ]
}

/// A receiver with a session, and what it heard: numbers by sender and topic.
struct Receiver {
    client: Client,
    heard: BTreeMap<(u8, String), Vec<(u8, bool)>>,
}

impl Receiver {
    fn note(&mut self, publish: Publish) {
        let topic = String::from_utf8(publish.topic.into()).unwrap();
        self.heard.entry((publish.payload[0], topic)).or_default().push((publish.payload[1], publish.dup));
    }
}

async fn receiver(broker: &ModelBroker) -> Client {
    Client::connect(broker, ClientOptions { in_flight_max: 4, ..lasting("receiver") }).await.unwrap()
}

async fn plays(steps: Vec<Step>, repetition: f64) {
    let broker = broker();
    broker.set_repetition(repetition);
    let mut receiver = Receiver { client: receiver(&broker).await, heard: BTreeMap::new() };
    subscribe(&mut receiver.client, "t/+").await;
    let mut senders = [connected(&broker, "a").await, connected(&broker, "b").await];
    let mut sent = BTreeMap::<(u8, String), u8>::new();
    let mut retained = BTreeMap::new();
    for step in steps {
        match step {
            Step::Publish { sender, topic, is_retained } => {
                let topic = format!("t/{topic}");
                let number = sent.entry((sender as u8, topic.clone())).or_default();
                let payload = vec![sender as u8, *number];
                *number += 1;
                senders[sender].publish(&topic, payload.clone(), QoS::AtLeastOnce, is_retained);
                if is_retained {
                    retained.insert(topic, payload);
                }
            }
            Step::Take(count) => {
                for _ in 0..count {
                    if let Some(Packet::Publish(publish)) = receiver.client.try_recv() {
                        receiver.note(publish);
                    }
                }
            }
            Step::Break(ending) => {
                broker.end(Some("receiver"), ending);
                receiver.client = self::receiver(&broker).await;
                assert!(receiver.client.is_session_present());
            }
            Step::Wait(ms) => sleep(Duration::from_millis(ms)).await,
            Step::Delay(ms, topics_overtake) => {
                broker.set_topics_overtake(topics_overtake);
                broker.set_delay(Way::ToClient, Delay { least: Duration::ZERO, spread: Duration::from_millis(ms) });
            }
        }
    }
    while let Ok(Some(publish)) = timeout(LONG, receiver.client.message()).await {
        receiver.note(publish);
    }
    for (of, count) in sent {
        let heard = receiver.heard.remove(&of).unwrap_or_default();
        // Each number is first heard in order; repetitions say so.
        let mut next = 0;
        for (number, dup) in heard {
            assert!(number <= next, "{number} before {next}");
            assert!(number == next || dup, "{number} again without the flag");
            next = next.max(number + 1);
        }
        assert_eq!(next, count, "{of:?}");
    }
    assert!(receiver.heard.is_empty());
    broker.set_repetition(0.0);
    broker.set_delay(Way::ToClient, Delay::default());
    let mut late = connected(&broker, "late").await;
    late.subscribe_as([SubscribeFilter::new("t/#", QoS::AtLeastOnce)]);
    for (topic, payload) in retained {
        let publish = late.message().await.unwrap();
        assert_eq!((publish.topic.as_ref(), publish.payload.as_ref()), (topic.as_bytes(), payload.as_slice()));
    }
    assert!(is_quiet(&mut late).await);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn property_each_message_with_qos_1_is_heard_in_order_over_disconnects_and_the_last_is_retained(
        steps in prop::collection::vec(step(), 1..120),
        repetition in prop_oneof![Just(0.0), Just(0.3)],
    ) {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build().unwrap();
        runtime.block_on(plays(steps, repetition));
    }
}
