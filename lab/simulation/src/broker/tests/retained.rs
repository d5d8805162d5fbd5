//! Retained messages and wills.

use rumqttc::{QoS, RetainForwardRule, SubscribeFilter};

use super::*;

fn retain(client: &mut Client, topic: &str, payload: &str) {
    client.publish(topic, payload.to_owned(), QoS::AtLeastOnce, true);
}

#[tokio::test(start_paused = true)]
async fn the_last_retained_message_of_each_topic_comes_at_each_subscription_with_the_flag() {
    let broker = broker();
    let mut sender = connected(&broker, "sender").await;
    for (topic, payload) in [("f/a/x", "1"), ("f/a/x", "2"), ("f/b/x", "3"), ("f/b/y", "4"), ("g", "5")] {
        retain(&mut sender, topic, payload);
    }
    let mut client = connected(&broker, "client").await;
    for _ in 0..2 {
        subscribe(&mut client, "f/+/x").await;
        for expected in ["2", "3"] {
            let publish = client.message().await.unwrap();
            assert!(publish.retain && publish.payload == expected);
        }
    }
    assert!(is_quiet(&mut client).await);
}

#[tokio::test(start_paused = true)]
async fn an_empty_retained_message_clears_the_topic_and_is_delivered() {
    let broker = broker();
    let mut live = subscribed(&broker, "live", "t").await;
    retain(&mut live, "t", "kept");
    retain(&mut live, "t", "");
    assert_eq!([payload(&mut live).await, payload(&mut live).await], ["kept", ""]);
    let mut late = subscribed(&broker, "late", "t").await;
    assert!(is_quiet(&mut late).await);
}

#[tokio::test(start_paused = true)]
async fn live_messages_have_the_retain_flag_only_if_the_subscription_asks_for_it() {
    let broker = broker();
    let mut plain = subscribed(&broker, "plain", "t").await;
    let mut exact = connected(&broker, "exact").await;
    exact.subscribe_as([SubscribeFilter { preserve_retain: true, ..SubscribeFilter::new("t", QoS::AtLeastOnce) }]);
    retain(&mut plain, "t", "kept");
    assert!(!plain.message().await.unwrap().retain);
    assert!(exact.message().await.unwrap().retain);
}

#[tokio::test(start_paused = true)]
async fn a_subscription_may_ask_for_retained_messages_never_or_only_when_it_is_new() {
    let broker = broker();
    let mut client = connected(&broker, "client").await;
    retain(&mut client, "never", "1");
    retain(&mut client, "new", "2");
    for _ in 0..2 {
        for (filter, rule) in [("never", RetainForwardRule::Never), ("new", RetainForwardRule::OnNewSubscribe)] {
            let filter = SubscribeFilter::new(filter, QoS::AtLeastOnce);
            client.subscribe_as([SubscribeFilter { retain_forward_rule: rule, ..filter }]);
        }
    }
    assert_eq!(payload(&mut client).await, "2");
    assert!(is_quiet(&mut client).await);
}

#[tokio::test(start_paused = true)]
async fn a_retained_message_expires() {
    let broker = broker();
    let mut sender = connected(&broker, "sender").await;
    let properties =
        rumqttc::PublishProperties { message_expiry_interval: Some(5), ..rumqttc::PublishProperties::default() };
    sender.publish_as(Publish { retain: true, ..Publish::new("t", QoS::AtLeastOnce, "x", Some(properties)) });
    let mut early = subscribed(&broker, "early", "t").await;
    assert_eq!(payload(&mut early).await, "x");
    tokio::time::advance(Duration::from_secs(5)).await;
    let mut late = subscribed(&broker, "late", "#").await;
    assert!(is_quiet(&mut late).await);
}

#[tokio::test(start_paused = true)]
async fn a_will_is_published_and_retained_unless_the_client_says_farewell() {
    let broker = broker();
    let mut watcher = subscribed(&broker, "watcher", "will/+").await;
    mortal(&broker, "dead").await.die();
    mortal(&broker, "polite").await.disconnect();
    assert_eq!(heard(&mut watcher).await.0, "will/dead");
    assert!(is_quiet(&mut watcher).await);
    let mut late = subscribed(&broker, "late", "will/#").await;
    assert_eq!(heard(&mut late).await.0, "will/dead");
    assert!(is_quiet(&mut late).await);
}
