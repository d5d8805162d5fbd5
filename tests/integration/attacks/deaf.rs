//! A supervisor notices that its broker has lost a subscription, reports it, and subscribes again.

use vibrissa_protocol::{ArrayType, Name, RobotTopic};
use vibrissa_simulator::load::{self, LoadPlan, Quality};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::mqtt_proxy::{Loss, MqttProxy};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::listener::{Supervised, metric_reaches};

const FAILURES: &str = "vibrissa_mqtt_probe_failures_total";
const CONNECTED: &str = "vibrissa_broker_connected";
const ROUND_TRIP: &str = "vibrissa_mqtt_probe_round_trip_seconds";

fn from_robots() -> Vec<RobotTopic> {
    RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot()).collect()
}

/// One fleet per topic of robots, which loses messages of this topic.
fn losses() -> Vec<(Name, RobotTopic, String)> {
    let of = |kind: RobotTopic| {
        let fleet = Name::new(&format!("lost-{kind}")).unwrap();
        let filter = kind.fleet_filter(&fleet);
        (fleet, kind, filter)
    };
    from_robots().into_iter().map(of).collect()
}

/// Every filter that `/readyz` must name.
fn filters() -> Vec<String> {
    losses().into_iter().map(|(_, _, filter)| filter).collect()
}

fn start(folder: &tempfile::TempDir, fleets: &str, proxy: &MqttProxy) -> Supervised {
    let url = format!("mqtt://127.0.0.1:{}", proxy.port());
    Supervised::start(folder.path(), "s", &["--fleets", fleets, "--mqtt-url", &url])
}

async fn every_topic_is_missed(supervisor: &Supervised) {
    for (fleet, kind, filter) in losses() {
        // The fleets may reconnect at different times.
        supervisor.says(false, &["did not come back within 2 s".to_owned(), filter]).await;
        metric_reaches(supervisor, FAILURES, &format!("fleet=\"{fleet}\",topic=\"{kind}\""), 1.0).await;
        let others = supervisor.metric(FAILURES, &format!("fleet=\"{fleet}\"")).await
            - supervisor.metric(FAILURES, &format!("fleet=\"{fleet}\",topic=\"{kind}\"")).await;
        assert_eq!(others, 0.0, "{fleet}: no other topic may be reported");
    }
}

#[tokio::test]
async fn regress_each_subscription_that_a_broker_loses_is_noticed_and_made_again() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let proxy = MqttProxy::to(broker.port()).await;
    let fleets: Vec<String> = losses().iter().map(|(fleet, _, _)| fleet.to_string()).collect();
    // The broker acknowledges all of these subscriptions.
    proxy.lose(Loss::Subscriptions(filters()));
    let mut supervisor = start(&folder, &fleets.join(","), &proxy);
    every_topic_is_missed(&supervisor).await;
    assert_eq!(supervisor.metric(CONNECTED, "").await, 0.0, "it must never be connected");
    proxy.lose(Loss::Nothing);
    supervisor.says(true, &[]).await;
    assert_eq!(supervisor.metric(CONNECTED, "").await, losses().len() as f64);
    supervisor.terminate().await;
}

#[tokio::test]
async fn regress_each_topic_that_a_broker_stops_passing_on_is_noticed_and_subscribed_again() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let proxy = MqttProxy::to(broker.port()).await;
    let fleets: Vec<String> = losses().iter().map(|(fleet, _, _)| fleet.to_string()).collect();
    let mut supervisor = start(&folder, &fleets.join(","), &proxy);
    supervisor.says(true, &[]).await;
    assert!(supervisor.metric(ROUND_TRIP, "").await > 0.0);
    let connections = supervisor.metric("vibrissa_broker_connections_total", "").await;
    proxy.lose(Loss::Topics(filters()));
    every_topic_is_missed(&supervisor).await;
    proxy.lose(Loss::Nothing);
    supervisor.says(true, &[]).await;
    assert!(
        supervisor.metric("vibrissa_broker_connections_total", "").await >= connections + 5.0,
        "expected new connections"
    );
    supervisor.terminate().await;
}

/// A robot keeps sending, and none of its messages is lost.
#[tokio::test]
async fn regress_one_direction_that_is_lost_is_noticed_and_robots_are_heard_again() {
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let proxy = MqttProxy::to(broker.port()).await;
    let mut supervisor = start(&folder, "f", &proxy);
    supervisor.says(true, &[]).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    for loss in [Loss::FromBroker, Loss::FromClients] {
        let failures = supervisor.metric(FAILURES, "").await;
        proxy.lose(loss.clone());
        supervisor.says(false, &[]).await;
        metric_reaches(&supervisor, FAILURES, "", failures + 5.0).await;
        let message = robot.message(Vec::new());
        proxy.lose(Loss::Nothing);
        supervisor.says(true, &[]).await;
        robot.say(RobotTopic::Contacts, vibrissa_protocol::encode(&message)).await;
        robot.receipted().await;
    }
    supervisor.terminate().await;
}

#[tokio::test]
async fn a_broker_that_does_not_take_probes_is_named_and_robots_are_heard_all_the_same() {
    const ACL: &str = "topic readwrite whisker/v1/f/r/#\ntopic read whisker/v1/#\ntopic write whisker/v1/+/+/receipt\n\
                       topic readwrite whisker/v1/+/supervisor/state\ntopic write whisker/v1/+/+/request\n";
    let (broker, folder) = (Mosquitto::builder().acl(ACL).start(), tempfile::tempdir().unwrap());
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-url", &url]);
    let words = ["whisker/v1/f/supervisor/+", "access list", "this user may not do it"].map(str::to_owned);
    supervisor.says(false, &words).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.touch(0, 5).await;
    robot.receipted().await;
    supervisor.says(false, &words).await;
    assert_eq!(supervisor.metric(FAILURES, "").await, 0.0, "a refused publication must not end the connection");
    supervisor.terminate().await;
}

/// Probes wait behind contacts that are sent at full speed; that must not count as a loss.
#[tokio::test]
async fn a_burst_does_not_pass_for_deafness() {
    let _turn = crate::turn().await;
    let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-url", &url]);
    supervisor.says(true, &[]).await;
    let plan = LoadPlan {
        mqtt_url: url,
        fleet: Name::new("f").unwrap(),
        robots: 20,
        whiskers: 2,
        array_whiskers: 2,
        messages: 100_000,
        contacts: 1,
        qos: Quality::AtLeastOnce,
        rate: None,
        connections: 2,
        window: 1_000,
        // The more messages wait, the later a probe arrives.
        unreceipted: Some(100_000),
        no_receipts: false,
        cbor: false,
        no_retained: false,
        learn: 0,
        trim_every: None,
        status_every_s: 10.0,
        patience_s: 60.0,
    };
    load::run(plan, || {}).await.unwrap();
    assert_eq!(supervisor.metric(FAILURES, "").await, 0.0);
    assert_eq!(supervisor.metric("vibrissa_broker_connections_total", "").await, 1.0);
    supervisor.terminate().await;
}

#[tokio::test]
async fn the_embedded_broker_returns_every_probe() {
    let (folder, port) = (tempfile::tempdir().unwrap(), free_port());
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-port", &port.to_string()]);
    supervisor.says(true, &[]).await;
    let mut seen = Vec::new();
    // Three rounds of probes, which have different delays.
    until_true("three rounds of probes", async || {
        let round_trip = supervisor.metric(ROUND_TRIP, "").await;
        if seen.last() != Some(&round_trip) {
            seen.push(round_trip);
        }
        seen.len() >= 3
    })
    .await;
    assert_eq!(supervisor.metric(FAILURES, "").await, 0.0);
    assert_eq!(
        supervisor.metric("vibrissa_messages_refused_total", "").await,
        0.0,
        "a probe must not count as a message"
    );
    supervisor.terminate().await;
}
