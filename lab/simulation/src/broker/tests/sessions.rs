//! Sessions, clean starts and takeovers.

use rumqttc::{DisconnectReasonCode, Packet};

use super::*;

/// A client that was here, subscribed to `t`, and is away.
async fn away(broker: &ModelBroker, session_s: u32) {
    let mut client = Client::connect(broker, ClientOptions { session_s, ..lasting("sleeper") }).await.unwrap();
    assert!(!client.is_session_present());
    subscribe(&mut client, "t").await;
    client.disconnect();
}

#[tokio::test(start_paused = true)]
async fn a_session_keeps_subscriptions_and_messages_with_qos_1_while_its_client_is_away() {
    let broker = broker();
    away(&broker, 60).await;
    let mut sender = connected(&broker, "sender").await;
    say(&mut sender, "1");
    sender.publish("t", "only with QoS 0", QoS::AtMostOnce, false);
    say(&mut sender, "2");
    tokio::time::advance(Duration::from_secs(59)).await;
    let mut back = Client::connect(&broker, lasting("sleeper")).await.unwrap();
    assert!(back.is_session_present());
    say(&mut sender, "3");
    for expected in ["1", "2", "3"] {
        let publish = back.message().await.unwrap();
        assert!(!publish.dup && publish.payload == expected);
    }
    assert!(is_quiet(&mut back).await);
}

#[tokio::test(start_paused = true)]
async fn a_session_ends_with_its_expiry_and_with_a_clean_start() {
    for (waits_s, is_clean_start, is_present) in [(59, false, true), (61, false, false), (1, true, false)] {
        let broker = broker();
        away(&broker, 60).await;
        tokio::time::advance(Duration::from_secs(waits_s)).await;
        let options = ClientOptions { is_clean_start, ..lasting("sleeper") };
        let mut back = Client::connect(&broker, options).await.unwrap();
        assert_eq!(back.is_session_present(), is_present);
        say(&mut back, "x");
        assert_eq!(is_quiet(&mut back).await, !is_present);
    }
}

#[tokio::test(start_paused = true)]
async fn a_session_without_expiry_ends_with_the_connection() {
    let broker = broker();
    away(&broker, 0).await;
    let back = Client::connect(&broker, lasting("sleeper")).await.unwrap();
    assert!(!back.is_session_present());
}

#[tokio::test(start_paused = true)]
async fn messages_without_an_acknowledgement_are_repeated_in_order_with_the_flag() {
    let broker = broker();
    let mut first = Client::connect(&broker, lasting("client")).await.unwrap();
    subscribe(&mut first, "t").await;
    let mut sender = connected(&broker, "sender").await;
    for payload in ["1", "2", "3"] {
        say(&mut sender, payload);
    }
    assert_eq!(payload(&mut first).await, "1");
    first.die();
    say(&mut sender, "4");
    let mut second = Client::connect(&broker, lasting("client")).await.unwrap();
    let mut heard = Vec::new();
    for _ in 0..3 {
        let publish = second.message().await.unwrap();
        heard.push((String::from_utf8(publish.payload.into()).unwrap(), publish.dup));
    }
    assert_eq!(heard, [("2".to_owned(), true), ("3".to_owned(), true), ("4".to_owned(), false)]);
    assert!(is_quiet(&mut second).await);
}

#[tokio::test(start_paused = true)]
async fn a_second_connection_with_a_client_id_ends_the_first_with_the_reason_and_the_will() {
    let broker = broker();
    let mut watcher = subscribed(&broker, "watcher", "will/+").await;
    let mut first = mortal(&broker, "twin").await;
    let mut second = mortal(&broker, "twin").await;
    let reason = DisconnectReasonCode::SessionTakenOver;
    assert!(matches!(first.recv().await, Some(Packet::Disconnect(told)) if told.reason_code == reason));
    assert!(first.recv().await.is_none());
    assert_eq!(heard(&mut watcher).await.0, "will/twin");
    // The end of the first connection does not end the second one.
    first.die();
    subscribe(&mut second, "t").await;
    say(&mut second, "alive");
    assert_eq!(payload(&mut second).await, "alive");
    assert!(is_quiet(&mut watcher).await);
    assert_eq!((broker.counts().takeovers, broker.counts().wills), (1, 1));
}

#[tokio::test(start_paused = true)]
async fn the_session_of_a_connection_that_is_taken_over_goes_on() {
    let broker = broker();
    let mut first = Client::connect(&broker, lasting("twin")).await.unwrap();
    subscribe(&mut first, "t").await;
    say(&mut first, "x");
    let mut second = Client::connect(&broker, lasting("twin")).await.unwrap();
    assert!(second.is_session_present());
    assert!(second.message().await.unwrap().dup);
}
