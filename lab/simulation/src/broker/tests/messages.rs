//! Publications, filters, and limits.

use bytes::Bytes;
use rumqttc::{
    DisconnectReasonCode, Packet, PubAckReason, Publish, PublishProperties, QoS, SubscribeFilter, SubscribeReasonCode,
    UnsubAckReason,
};

use super::*;

#[tokio::test(start_paused = true)]
async fn a_publication_is_acknowledged_and_says_whether_somebody_listens() {
    let broker = broker();
    let mut sender = connected(&broker, "sender").await;
    let mut reasons = Vec::new();
    let mut listeners = Vec::new();
    for _ in 0..2 {
        let id = sender.publish("t", "x", QoS::AtLeastOnce, false);
        match sender.recv().await {
            Some(Packet::PubAck(ack)) if ack.pkid == id => reasons.push(ack.reason),
            other => panic!("{other:?}"),
        }
        listeners.push(subscribed(&broker, "listener", "t").await);
    }
    assert_eq!(reasons, [PubAckReason::NoMatchingSubscribers, PubAckReason::Success]);
    sender.publish("t", "x", QoS::AtMostOnce, false);
    assert!(sender.try_recv().is_none());
}

#[tokio::test(start_paused = true)]
async fn filters_match_one_level_or_all_below() {
    let broker = broker();
    let mut one = subscribed(&broker, "one", "a/+/c").await;
    let mut all = subscribed(&broker, "all", "a/#").await;
    let mut sender = connected(&broker, "sender").await;
    for topic in ["a", "a/b", "a/b/c", "a/b/c/d", "b/b/c"] {
        sender.publish(topic, "", QoS::AtMostOnce, false);
    }
    assert_eq!(heard(&mut one).await.0, "a/b/c");
    for topic in ["a", "a/b", "a/b/c", "a/b/c/d"] {
        assert_eq!(heard(&mut all).await.0, topic);
    }
    assert!(is_quiet(&mut one).await && is_quiet(&mut all).await);
}

#[tokio::test(start_paused = true)]
async fn a_client_with_two_filters_that_match_gets_a_message_once() {
    let broker = broker();
    let mut client = subscribed(&broker, "client", "a/+").await;
    subscribe(&mut client, "a/b").await;
    client.publish("a/b", "x", QoS::AtLeastOnce, false);
    assert_eq!(client.message().await.unwrap().qos, QoS::AtLeastOnce);
    assert!(is_quiet(&mut client).await);
}

#[tokio::test(start_paused = true)]
async fn own_messages_come_back_unless_the_subscription_says_no_local() {
    let broker = broker();
    let mut client = connected(&broker, "client").await;
    client.subscribe_as([SubscribeFilter { nolocal: true, ..SubscribeFilter::new("deaf", QoS::AtLeastOnce) }]);
    client.subscribe(["own"]);
    client.publish("deaf", "", QoS::AtLeastOnce, false);
    client.publish("own", "", QoS::AtLeastOnce, false);
    assert_eq!(heard(&mut client).await.0, "own");
    assert!(is_quiet(&mut client).await);
}

#[tokio::test(start_paused = true)]
async fn a_delivery_has_the_lower_quality_of_service() {
    let broker = broker();
    let mut low = connected(&broker, "low").await;
    low.subscribe_as([SubscribeFilter::new("t", QoS::AtMostOnce)]);
    let mut high = connected(&broker, "high").await;
    high.subscribe_as([SubscribeFilter::new("t", QoS::ExactlyOnce)]);
    assert!(matches!(high.recv().await, Some(Packet::SubAck(ack))
        if ack.return_codes == [SubscribeReasonCode::Success(QoS::AtLeastOnce)]));
    let mut sender = connected(&broker, "sender").await;
    for (sent, heard_by_low, heard_by_high) in [(0, 0, 0), (1, 0, 1)] {
        let qos = if sent == 0 { QoS::AtMostOnce } else { QoS::AtLeastOnce };
        sender.publish("t", "x", qos, false);
        assert_eq!(low.message().await.unwrap().qos as u8, heard_by_low);
        assert_eq!(high.message().await.unwrap().qos as u8, heard_by_high);
    }
}

#[tokio::test(start_paused = true)]
async fn wrong_and_shared_filters_are_refused_and_an_end_of_a_subscription_says_whether_it_existed() {
    let broker = broker();
    let mut client = connected(&broker, "client").await;
    client.subscribe(["a/#/b", "$share/g/a", "a"]);
    let codes = match client.recv().await {
        Some(Packet::SubAck(ack)) => ack.return_codes,
        other => panic!("{other:?}"),
    };
    assert_eq!(codes[0], SubscribeReasonCode::TopicFilterInvalid);
    assert_eq!(codes[1], SubscribeReasonCode::SharedSubscriptionsNotSupported);
    assert_eq!(codes[2], SubscribeReasonCode::Success(QoS::AtLeastOnce));
    for expected in [UnsubAckReason::Success, UnsubAckReason::NoSubscriptionExisted] {
        client.unsubscribe("a");
        assert!(matches!(client.recv().await, Some(Packet::UnsubAck(ack)) if ack.reasons == [expected]));
    }
    client.publish("a", "", QoS::AtMostOnce, false);
    assert!(is_quiet(&mut client).await);
}

#[tokio::test(start_paused = true)]
async fn properties_pass_and_the_expiry_counts_down() {
    let broker = broker();
    let mut sleeper = Client::connect(&broker, lasting("sleeper")).await.unwrap();
    subscribe(&mut sleeper, "t").await;
    sleeper.disconnect();
    let mut sender = connected(&broker, "sender").await;
    let properties = PublishProperties {
        message_expiry_interval: Some(10),
        content_type: Some("application/cbor".to_owned()),
        correlation_data: Some(Bytes::from_static(b"7")),
        user_properties: vec![("a".to_owned(), "b".to_owned())],
        ..PublishProperties::default()
    };
    sender.publish_as(Publish::new("t", QoS::AtLeastOnce, "x", Some(properties.clone())));
    sender.publish_expiring("t", "late", QoS::AtLeastOnce, 3);
    tokio::time::advance(Duration::from_millis(3500)).await;
    let mut sleeper = Client::connect(&broker, lasting("sleeper")).await.unwrap();
    let expected = PublishProperties { message_expiry_interval: Some(7), ..properties };
    assert_eq!(sleeper.message().await.unwrap().properties, Some(expected));
    assert!(is_quiet(&mut sleeper).await);
    assert_eq!(broker.counts().expired, 1);
}

#[tokio::test(start_paused = true)]
async fn what_a_broker_does_not_accept_ends_the_connection_with_the_reason_and_the_will() {
    let large = Publish::new("t", QoS::AtMostOnce, vec![0; 3_000_000], None);
    let alias = PublishProperties { topic_alias: Some(1), ..PublishProperties::default() };
    for (publish, reason) in [
        (large, DisconnectReasonCode::PacketTooLarge),
        (Publish::new("t", QoS::ExactlyOnce, "", None), DisconnectReasonCode::QoSNotSupported),
        (Publish::new("t", QoS::AtMostOnce, "", Some(alias)), DisconnectReasonCode::TopicAliasInvalid),
        (Publish::new("t/+", QoS::AtMostOnce, "", None), DisconnectReasonCode::TopicNameInvalid),
        (Publish::new("", QoS::AtMostOnce, "", None), DisconnectReasonCode::TopicNameInvalid),
    ] {
        let broker = broker();
        let mut watcher = subscribed(&broker, "watcher", "will/+").await;
        let mut client = mortal(&broker, "client").await;
        client.publish_as(publish);
        assert!(matches!(client.recv().await, Some(Packet::Disconnect(told)) if told.reason_code == reason));
        assert!(client.recv().await.is_none());
        assert_eq!(heard(&mut watcher).await, ("will/client".to_owned(), "dead".to_owned()));
    }
}

#[tokio::test(start_paused = true)]
async fn the_queue_of_a_client_is_limited_and_messages_with_qos_0_make_room_first() {
    let broker = ModelBroker::new(1, Limits { queued_max: 3, ..Limits::default() });
    let slow = ClientOptions { in_flight_max: 1, ..ClientOptions::new("slow") };
    let mut slow = Client::connect(&broker, slow).await.unwrap();
    subscribe(&mut slow, "t").await;
    let mut sender = connected(&broker, "sender").await;
    for (payload, qos) in [("in flight", 1), ("1", 1), ("old 0", 0), ("2", 1), ("3", 1), ("too much", 1)] {
        let qos = if qos == 0 { QoS::AtMostOnce } else { QoS::AtLeastOnce };
        sender.publish("t", payload, qos, false);
    }
    for expected in ["in flight", "1", "2", "3"] {
        assert_eq!(payload(&mut slow).await, expected);
    }
    assert!(is_quiet(&mut slow).await);
    assert_eq!(broker.counts().dropped_for_room, 2);
}

#[tokio::test(start_paused = true)]
async fn no_more_than_the_receive_maximum_is_in_flight() {
    let broker = broker();
    let mut slow =
        Client::connect(&broker, ClientOptions { in_flight_max: 2, ..ClientOptions::new("slow") }).await.unwrap();
    subscribe(&mut slow, "t").await;
    let mut sender = connected(&broker, "sender").await;
    for payload in ["1", "2", "3"] {
        say(&mut sender, payload);
    }
    assert_eq!(broker.counts().delivered, 2);
    assert_eq!(payload(&mut slow).await, "1");
    assert_eq!(broker.counts().delivered, 3);
}
