//! The supervisor's MQTT client, over a route.

use std::sync::{Arc, Mutex};

use rumqttc::{
    AsyncClient, ConnAck, ConnectionError, Event, EventLoop, LastWill, MqttOptions, Packet, PublishOptions, QoS,
};

use tokio::runtime::RngSeed;
use tokio::time::{Instant, sleep};

use super::*;
use crate::broker::{Delay, Ending, Memory, Route, Way};

/// A client that dials over this route.
fn dialler(route: &Route, id: &str) -> (AsyncClient, EventLoop) {
    let mut options = MqttOptions::new(id, ("broker", 1883));
    options.set_keep_alive(6).set_last_will(LastWill::new("will/far", "dead", QoS::AtLeastOnce, false, None));
    options.set_max_packet_size(Some(10_000));
    let route = route.clone();
    options.set_socket_connector(move |_, _| {
        let route = route.clone();
        async move { route.connect().await }
    });
    AsyncClient::builder(options).capacity(64).build()
}

/// The first incoming packet that `choose` accepts.
async fn incoming<T>(events: &mut EventLoop, choose: impl Fn(Packet) -> Option<T>) -> Result<T, Box<ConnectionError>> {
    loop {
        if let Event::Incoming(packet) = events.poll().await?
            && let Some(chosen) = choose(packet)
        {
            return Ok(chosen);
        }
    }
}

fn conn_ack(packet: Packet) -> Option<ConnAck> {
    if let Packet::ConnAck(ack) = packet { Some(ack) } else { None }
}

fn published(packet: Packet) -> Option<Publish> {
    if let Packet::Publish(publish) = packet { Some(publish) } else { None }
}

fn sub_ack(packet: Packet) -> Option<()> {
    matches!(packet, Packet::SubAck(_)).then_some(())
}

/// A connected client, which has subscribed to `t`.
async fn far(route: &Route) -> (AsyncClient, EventLoop) {
    let (client, mut events) = dialler(route, "far");
    incoming(&mut events, conn_ack).await.unwrap();
    client.try_subscribe("t", QoS::AtLeastOnce).unwrap();
    incoming(&mut events, sub_ack).await.unwrap();
    (client, events)
}

#[tokio::test(start_paused = true)]
async fn the_client_reads_what_the_broker_promises() {
    let (_client, mut events) = dialler(&Route::new(broker(), Duration::ZERO), "far");
    let properties = incoming(&mut events, conn_ack).await.unwrap().properties.unwrap();
    assert_eq!((properties.receive_max, properties.max_packet_size), (Some(65_535), Some(270_336)));
    assert_eq!((properties.max_qos, properties.retain_available), (Some(1), Some(1)));
}

#[tokio::test(start_paused = true)]
async fn messages_pass_between_a_stream_and_a_client_in_this_process() {
    let broker = broker();
    let (client, mut events) = far(&Route::new(broker.clone(), Duration::from_millis(5))).await;
    let mut near = subscribed(&broker, "near", "u").await;
    let large = vec![0; 12_000];
    near.publish("t", large, QoS::AtLeastOnce, false);
    say(&mut near, "to the stream");
    assert_eq!(incoming(&mut events, published).await.unwrap().payload, "to the stream");
    assert_eq!(broker.counts().too_large, 1);
    client.try_publish("u", "from the stream", PublishOptions::new(QoS::AtLeastOnce)).unwrap();
    let acknowledged = incoming(&mut events, |packet| matches!(packet, Packet::PubAck(_)).then_some(())).await;
    assert!(acknowledged.is_ok());
    assert_eq!(payload(&mut near).await, "from the stream");
}

#[tokio::test(start_paused = true)]
async fn a_stream_stays_while_it_pings_and_ends_with_its_will_when_it_is_dropped() {
    let broker = broker();
    let mut watcher = subscribed(&broker, "watcher", "will/+").await;
    let (client, mut events) = far(&Route::new(broker.clone(), Duration::from_millis(5))).await;
    assert!(timeout(LONG, incoming(&mut events, published)).await.is_err());
    assert_eq!(broker.counts().keep_alive_timeouts, 0);
    drop((client, events));
    assert_eq!(heard(&mut watcher).await.0, "will/far");
}

#[tokio::test(start_paused = true)]
async fn a_farewell_over_a_stream_publishes_no_will() {
    let broker = broker();
    let mut watcher = subscribed(&broker, "watcher", "will/+").await;
    let (client, mut events) = far(&Route::new(broker.clone(), Duration::ZERO)).await;
    client.try_disconnect().unwrap();
    while events.poll().await.is_ok() {}
    assert!(is_quiet(&mut watcher).await);
    assert_eq!(broker.clients(), ["watcher"]);
}

#[tokio::test(start_paused = true)]
async fn a_cut_of_either_direction_ends_the_connection_at_both_ends() {
    for way in Way::BOTH {
        let broker = broker();
        let route = Route::new(broker.clone(), Duration::from_millis(5));
        let mut watcher = subscribed(&broker, "watcher", "will/+").await;
        let (_client, mut events) = far(&route).await;
        route.set_cut(way, true);
        assert!(timeout(Duration::from_secs(13), incoming(&mut events, published)).await.unwrap().is_err());
        drop(events);
        assert!(timeout(Duration::from_secs(10), heard(&mut watcher)).await.is_ok());
    }
}

#[tokio::test(start_paused = true)]
async fn a_client_notices_a_silent_end_and_a_frozen_broker_by_its_pings() {
    for fault in
        [|broker: &ModelBroker| broker.end(None, Ending::Silent), |broker: &ModelBroker| broker.set_frozen(true)]
    {
        let broker = broker();
        let (_client, mut events) = far(&Route::new(broker.clone(), Duration::ZERO)).await;
        fault(&broker);
        assert!(timeout(Duration::from_secs(13), incoming(&mut events, published)).await.unwrap().is_err());
    }
}

#[tokio::test(start_paused = true)]
async fn a_takeover_is_told_to_a_stream() {
    let broker = broker();
    let (_client, mut events) = far(&Route::new(broker.clone(), Duration::ZERO)).await;
    let _twin = connected(&broker, "far").await;
    let end = incoming(&mut events, published).await.unwrap_err().to_string();
    assert!(end.contains("SessionTakenOver"), "{end}");
}

#[tokio::test(start_paused = true)]
async fn what_is_not_mqtt_ends_the_stream() {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut end = Route::new(broker(), Duration::ZERO).connect().await.unwrap();
    end.write_all(&[0xFF; 16]).await.unwrap();
    assert_eq!(end.read(&mut [0; 8]).await.unwrap(), 0);
}

/// A client over a route that answers each message, connects again after failures, and never ends.
async fn answers(route: Route) {
    let (client, mut events) = dialler(&route, "far");
    loop {
        match events.poll().await {
            Ok(Event::Incoming(Packet::ConnAck(_))) => client.try_subscribe("t", QoS::AtLeastOnce).unwrap(),
            Ok(Event::Incoming(Packet::Publish(publish))) => {
                client.try_publish("u", publish.payload, PublishOptions::new(QoS::AtLeastOnce)).unwrap();
            }
            Ok(_) => {}
            Err(_) => sleep(Duration::from_secs(1)).await,
        }
    }
}

/// Each message with its time, in three minutes with cuts, resets, repetitions, losses and delays.
async fn hard_times() -> Vec<String> {
    let (broker, seen) = (broker(), Arc::new(Mutex::new(Vec::new())));
    let (begun, sink) = (Instant::now(), seen.clone());
    broker.observe(Box::new(move |observed| {
        let (from, topic, to) = (observed.from, observed.topic, observed.to);
        sink.lock().unwrap().push(format!("{:?} {from} {topic} {to:?}", observed.at - begun));
    }));
    broker.set_repetition(0.2);
    for way in Way::BOTH {
        broker.set_delay(way, Delay { least: Duration::ZERO, spread: Duration::from_millis(40) });
    }
    let route = Route::new(broker.clone(), Duration::from_millis(5));
    let far = vibrissa_host::task::spawn(answers(route.clone()));
    let mut near = subscribed(&broker, "near", "u").await;
    for number in 0..600_u32 {
        sleep(Duration::from_millis(300)).await;
        say(&mut near, &number.to_string());
        match number % 100 {
            20 => route.set_cut(Way::ToBroker, true),
            70 => route.set_cut(Way::ToBroker, false),
            90 => route.reset(),
            95 => broker.restart(Memory::Kept),
            96 => near = subscribed(&broker, "near", "u").await,
            _ => while near.try_recv().is_some() {},
        }
    }
    far.abort();
    std::mem::take(&mut *seen.lock().unwrap())
}

#[test]
fn property_a_seed_gives_one_history_over_streams() {
    let history = || {
        let seed = RngSeed::from_bytes(b"7");
        let mut runtime = tokio::runtime::Builder::new_current_thread();
        runtime.enable_time().start_paused(true).rng_seed(seed).build().unwrap().block_on(hard_times())
    };
    let first = history();
    assert!(first.len() > 1000 && first == history(), "{}", first.len());
}
