//! Clients that fall silent.

use rumqttc::{DisconnectReasonCode, Packet};
use tokio::time::{Instant, sleep};

use super::*;
use crate::broker::{Memory, Way};

#[tokio::test(start_paused = true)]
async fn a_client_that_is_cut_off_for_one_and_a_half_keep_alives_is_ended_with_its_will() {
    let broker = broker();
    let mut watcher = subscribed(&broker, "watcher", "will/+").await;
    let mut client = mortal(&broker, "client").await;
    sleep(LONG).await;
    assert_eq!(broker.counts().keep_alive_timeouts, 0);
    client.publish("t", "alive", QoS::AtMostOnce, false);
    let cut = Instant::now();
    broker.set_held("client", Way::ToBroker, true);
    client.publish("t", "held back", QoS::AtMostOnce, false);
    assert_eq!(heard(&mut watcher).await.0, "will/client");
    // The keep-alive is 6 s; the last sign of life is up to 9 s older than the cut.
    assert!(cut.elapsed() <= Duration::from_secs(9), "{:?}", cut.elapsed());
    let counts = broker.counts();
    assert_eq!((counts.keep_alive_timeouts, counts.published, counts.holds), (1, 2, 1));
    let reason = DisconnectReasonCode::KeepAliveTimeout;
    assert!(matches!(client.recv().await, Some(Packet::Disconnect(told)) if told.reason_code == reason));
}

#[tokio::test(start_paused = true)]
async fn a_cut_shorter_than_the_patience_only_delays() {
    let broker = broker();
    let mut listener = subscribed(&broker, "listener", "t").await;
    let mut client = mortal(&broker, "client").await;
    client.ping();
    broker.set_held("client", Way::ToBroker, true);
    say(&mut client, "1");
    say(&mut client, "2");
    sleep(Duration::from_secs(8)).await;
    assert!(listener.try_recv().is_none());
    broker.set_held("client", Way::ToBroker, false);
    assert_eq!([payload(&mut listener).await, payload(&mut listener).await], ["1", "2"]);
    assert!(is_quiet(&mut listener).await);
    assert_eq!(broker.counts().wills, 0);
}

#[tokio::test(start_paused = true)]
async fn a_client_whose_way_is_cut_reaches_the_broker_after_the_healing_only() {
    let broker = broker();
    broker.set_held("client", Way::ToBroker, true);
    let connecting = vibrissa_host::task::spawn({
        let broker = broker.clone();
        async move { Client::connect(&broker, ClientOptions::new("client")).await.is_ok() }
    });
    sleep(LONG).await;
    assert!(!connecting.is_finished() && broker.clients().is_empty());
    broker.set_held("client", Way::ToBroker, false);
    assert!(connecting.await.unwrap());
}

#[tokio::test(start_paused = true)]
async fn nothing_remains_of_an_attempt_to_connect_through_a_cut() {
    let broker = broker();
    broker.set_held("client", Way::ToBroker, true);
    assert!(timeout(LONG, mortal(&broker, "client")).await.is_err());
    broker.set_held("client", Way::ToBroker, false);
    sleep(LONG).await;
    assert_eq!((broker.counts().connections, broker.counts().wills), (0, 0));
}

#[tokio::test(start_paused = true)]
async fn a_client_behind_a_cut_learns_of_the_end_after_the_healing() {
    let broker = broker();
    let mut client = connected(&broker, "client").await;
    broker.set_held("client", Way::ToClient, true);
    broker.restart(Memory::Kept);
    assert!(timeout(LONG, client.recv()).await.is_err());
    broker.set_held("client", Way::ToClient, false);
    assert!(client.recv().await.is_none());
}
