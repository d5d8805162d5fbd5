//! Each fault, and that it is counted.

use std::sync::{Arc, Mutex};

use rumqttc::{Packet, PubAckReason};
use tokio::time::{Instant, sleep};

use super::*;
use crate::broker::{Delay, Ending, Memory, NotAccepting, Way};

#[tokio::test(start_paused = true)]
async fn a_connection_ends_with_its_will_and_the_client_is_told_or_not() {
    for (ending, is_told) in [(Ending::Told, true), (Ending::Silent, false)] {
        let broker = broker();
        let mut watcher = subscribed(&broker, "watcher", "will/+").await;
        let mut client = mortal(&broker, "client").await;
        broker.end(Some("client"), ending);
        assert_eq!(heard(&mut watcher).await.0, "will/client");
        assert_eq!(broker.clients(), ["watcher"]);
        client.publish("will/x", "lost", QoS::AtLeastOnce, false);
        let end = timeout(LONG, client.recv()).await;
        assert_eq!(end.is_ok_and(|packet| packet.is_none()), is_told);
        client.die();
        assert!(is_quiet(&mut watcher).await);
        let counts = broker.counts();
        assert_eq!((counts.ended, counts.ended_silently), (is_told.into(), (!is_told).into()));
    }
}

#[tokio::test(start_paused = true)]
async fn all_connections_end_at_once() {
    let broker = broker();
    let mut clients = [mortal(&broker, "a").await, mortal(&broker, "b").await];
    broker.end(None, Ending::Told);
    for client in &mut clients {
        assert!(client.recv().await.is_none());
    }
    assert_eq!((broker.counts().ended, broker.counts().wills), (2, 2));
}

#[tokio::test(start_paused = true)]
async fn a_restart_ends_connections_without_wills_and_forgets_all_or_keeps_sessions_and_retained() {
    for (memory, is_kept) in [(Memory::Kept, true), (Memory::Lost, false)] {
        let broker = broker();
        let mut client = Client::connect(&broker, lasting("client")).await.unwrap();
        client.publish("kept", "x", QoS::AtLeastOnce, true);
        client.subscribe(["t"]);
        let mut doomed = mortal(&broker, "doomed").await;
        broker.restart(memory);
        assert!(doomed.recv().await.is_none());
        let mut client = Client::connect(&broker, lasting("client")).await.unwrap();
        assert_eq!(client.is_session_present(), is_kept);
        subscribe(&mut client, "#").await;
        assert_eq!(timeout(LONG, client.message()).await.is_ok(), is_kept);
        assert!(is_quiet(&mut client).await);
        assert_eq!((broker.counts().restarts, broker.counts().wills), (1, 0));
    }
}

#[tokio::test(start_paused = true)]
async fn a_broker_that_accepts_no_connections_keeps_those_it_has() {
    let broker = broker();
    let mut client = subscribed(&broker, "client", "t").await;
    broker.set_accepting(false);
    assert_eq!(Client::connect(&broker, ClientOptions::new("other")).await.err(), Some(NotAccepting));
    say(&mut client, "x");
    assert_eq!(payload(&mut client).await, "x");
    broker.set_accepting(true);
    connected(&broker, "other").await.disconnect();
    assert_eq!(broker.counts().refused_connections, 1);
}

#[tokio::test(start_paused = true)]
async fn a_frozen_broker_answers_nothing_and_then_goes_on_with_everything() {
    let broker = broker();
    let mut client = mortal(&broker, "client").await;
    subscribe(&mut client, "#").await;
    broker.set_frozen(true);
    say(&mut client, "x");
    let connecting = timeout(Duration::from_secs(30), connected(&broker, "other")).await;
    assert!(connecting.is_err() && client.try_recv().is_none());
    broker.set_frozen(false);
    assert_eq!(payload(&mut client).await, "x");
    assert!(is_quiet(&mut client).await);
    assert_eq!((broker.counts().freezes, broker.counts().keep_alive_timeouts), (1, 0));
}

#[tokio::test(start_paused = true)]
async fn delays_add_up_and_messages_never_overtake_each_other() {
    let broker = broker();
    let mut client = subscribed(&broker, "client", "t").await;
    let (least, spread) = (Duration::from_millis(10), Duration::from_millis(40));
    broker.set_delay(Way::ToBroker, Delay::fixed(least));
    broker.set_delay(Way::ToClient, Delay { least, spread });
    let begun = Instant::now();
    let mut last = 0;
    for number in 0..50_u8 {
        client.publish("t", vec![number], QoS::AtMostOnce, false);
    }
    for number in 0..50 {
        assert_eq!(client.message().await.unwrap().payload, vec![number]);
        let took_ms = begun.elapsed().as_millis();
        assert!((20..=61).contains(&took_ms) && took_ms >= last, "{took_ms} ms");
        last = took_ms;
    }
    assert!(last > 40);
    assert_eq!(broker.counts().delayed, 100);
}

#[tokio::test(start_paused = true)]
async fn deliveries_with_qos_1_are_repeated_with_the_flag() {
    let broker = broker();
    let mut client = subscribed(&broker, "client", "t").await;
    broker.set_repetition(1.0);
    say(&mut client, "x");
    let [first, second] = [client.message().await.unwrap(), client.message().await.unwrap()];
    assert_eq!((first.dup, second.dup, &first.payload), (false, true, &second.payload));
    client.publish("t", "once", QoS::AtMostOnce, false);
    assert_eq!(payload(&mut client).await, "once");
    assert!(is_quiet(&mut client).await);
    assert_eq!(broker.counts().repeated, 1);
}

#[tokio::test(start_paused = true)]
async fn single_deliveries_with_qos_0_are_lost() {
    let broker = broker();
    let mut client = subscribed(&broker, "client", "t").await;
    broker.set_loss(0.5);
    for _ in 0..100 {
        client.publish("t", "x", QoS::AtMostOnce, false);
        say(&mut client, "certain");
    }
    let (mut zeros, mut ones) = (0, 0);
    while let Ok(Some(publish)) = timeout(LONG, client.message()).await {
        if publish.qos == QoS::AtMostOnce { zeros += 1 } else { ones += 1 }
    }
    assert_eq!((ones, zeros + broker.counts().lost), (100, 100));
    assert!((30..70).contains(&zeros), "{zeros}");
}

#[tokio::test(start_paused = true)]
async fn subscriptions_are_lost_without_a_word() {
    let broker = broker();
    let mut client = subscribed(&broker, "client", "t").await;
    broker.forget_subscriptions("client");
    say(&mut client, "x");
    assert!(matches!(client.recv().await, Some(Packet::PubAck(_))));
    assert!(is_quiet(&mut client).await);
    subscribe(&mut client, "t").await;
    say(&mut client, "again");
    assert_eq!(payload(&mut client).await, "again");
    assert_eq!(broker.counts().forgotten_subscriptions, 1);
}

#[tokio::test(start_paused = true)]
async fn retained_messages_are_lost() {
    let broker = broker();
    let mut client = connected(&broker, "client").await;
    for topic in ["f/a", "f/b", "g"] {
        client.publish(topic, topic, QoS::AtLeastOnce, true);
    }
    broker.forget_retained("f/+");
    client.subscribe(["#"]);
    assert_eq!(payload(&mut client).await, "g");
    assert!(is_quiet(&mut client).await);
    assert_eq!(broker.counts().forgotten_retained, 2);
}

#[tokio::test(start_paused = true)]
async fn publications_are_refused_with_the_reason() {
    let broker = broker();
    let mut client = subscribed(&broker, "client", "#").await;
    broker.refuse("f/+");
    client.publish("f/a", "refused", QoS::AtMostOnce, false);
    let mut reasons = Vec::new();
    for _ in 0..2 {
        client.publish("f/a", "x", QoS::AtLeastOnce, false);
        match client.recv().await {
            Some(Packet::PubAck(ack)) => reasons.push(ack.reason),
            Some(Packet::Publish(_)) => reasons.push(PubAckReason::Success),
            other => panic!("{other:?}"),
        }
        broker.stop_refusing("f/+");
    }
    assert_eq!(reasons, [PubAckReason::NotAuthorized, PubAckReason::Success]);
    assert_eq!(broker.counts().refused_publications, 2);
}

#[tokio::test(start_paused = true)]
async fn an_observer_sees_each_acceptance_and_each_delivery() {
    let broker = broker();
    let seen = Arc::new(Mutex::new(Vec::new()));
    let sink = seen.clone();
    broker.observe(Box::new(move |observed| {
        let topic = observed.topic.to_owned();
        sink.lock().unwrap().push((observed.from.to_owned(), topic, observed.to.map(str::to_owned)));
    }));
    let _listener = subscribed(&broker, "listener", "will/+").await;
    mortal(&broker, "client").await.die();
    sleep(LONG).await;
    let (from, topic) = ("client".to_owned(), "will/client".to_owned());
    let expected = [(from.clone(), topic.clone(), None), (from, topic, Some("listener".to_owned()))];
    assert_eq!(*seen.lock().unwrap(), expected);
}

/// What happens in a short history with draws.
async fn history(seed: u64) -> Vec<(Duration, u8)> {
    let broker = ModelBroker::new(seed, Limits::default());
    broker.set_loss(0.3);
    broker.set_delay(Way::ToClient, Delay { least: Duration::ZERO, spread: Duration::from_secs(1) });
    let mut client = subscribed(&broker, "client", "t").await;
    let begun = Instant::now();
    let mut heard = Vec::new();
    for number in 0..50 {
        client.publish("t", vec![number], QoS::AtMostOnce, false);
        sleep(Duration::from_millis(300)).await;
        while let Some(packet) = client.try_recv() {
            let Packet::Publish(publish) = packet else { panic!("{packet:?}") };
            heard.push((begun.elapsed(), publish.payload[0]));
        }
    }
    heard
}

#[tokio::test(start_paused = true)]
async fn property_a_seed_gives_one_history() {
    let [first, same, other] = [history(7).await, history(7).await, history(8).await];
    assert_eq!(first, same);
    assert_ne!(first, other);
}
