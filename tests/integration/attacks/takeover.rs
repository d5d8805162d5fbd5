//! A broker closes a connection when another client connects with the same client id, so the supervisor's ids must be
//! secret.

use std::collections::BTreeSet;

use rumqttc::{AsyncClient, Event, MqttOptions, Packet};
use vibrissa_protocol::{ArrayType, BootId, Message};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::mqtt_proxy::MqttProxy;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{PATIENCE, until, until_true};

use crate::listener::{Supervised, metric_reaches};

const TAKEOVERS: &str = "vibrissa_mqtt_session_takeovers_total";
const CLOSED: &str = "vibrissa_mqtt_connections_closed_total";
const CONNECTIONS: &str = "vibrissa_broker_connections_total";

/// A Mosquitto that logs client ids.
fn broker() -> Mosquitto {
    Mosquitto::builder().line("connection_messages true").start()
}

/// Connects with this client id and disconnects at once.
async fn intrude(port: u16, client_id: &str) {
    let mut options = MqttOptions::new(client_id, ("127.0.0.1", port));
    options.set_outgoing_inflight_upper_limit(16);
    let (client, mut events) = AsyncClient::builder(options).capacity(8).build();
    let connected = tokio::time::timeout(PATIENCE, events.poll()).await.unwrap();
    assert!(matches!(connected, Ok(Event::Incoming(Packet::ConnAck(_)))), "{connected:?}");
    client.try_disconnect().unwrap();
    while events.poll().await.is_ok() {}
}

/// The latest client id of a connection with this role in the broker's log.
fn newest_id(broker: &Mosquitto, role: &str) -> Option<String> {
    let begin = format!("vibrissa-f-{role}-");
    let lines = broker.lines();
    let mut ids = lines.iter().filter(|line| line.contains("New client connected")).filter_map(|line| {
        let id = &line[line.find(&begin)?..];
        id.split_whitespace().next().map(str::to_owned)
    });
    ids.next_back()
}

async fn born(port: u16) -> HandRobot {
    HandRobot::born(port, "r", array(ArrayType::Type1, &[70.0, 65.0])).await
}

/// The supervisor's boot id from a receipt.
async fn published_boot(robot: &mut HandRobot) -> BootId {
    robot.touch(0, 5).await;
    robot
        .hear("a receipt", |heard| match &heard.message {
            Message::Receipt(receipt) => Some(receipt.boot_id.clone()),
            _ => None,
        })
        .await
}

/// Client ids that a robot could guess from published data.
fn guesses(boot: &BootId) -> Vec<String> {
    let roles = ["in", "out", "trial", "record", "check"];
    let parts = |role: &str| {
        [
            format!("vibrissa-f-{boot}-{role}"),
            format!("vibrissa-f-{role}-{boot}"),
            format!("vibrissa-f-{role}"),
            format!("vibrissa-f-{role}-"),
            format!("{boot}-{role}"),
            boot.to_string(),
        ]
    };
    roles.iter().flat_map(|role| parts(role)).collect()
}

#[tokio::test]
async fn regress_what_a_receipt_tells_does_not_let_a_robot_take_over_the_supervisors_connections() {
    let (broker, folder) = (broker(), tempfile::tempdir().unwrap());
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-url", &url]);
    supervisor.says(true, &["OWNED".to_owned()]).await;
    let mut robot = born(broker.port()).await;
    let boot = published_boot(&mut robot).await;
    for id in guesses(&boot) {
        intrude(broker.port(), &id).await;
    }
    robot.touch(0, 5).await;
    robot.receipted().await;
    assert_eq!(broker.logged("already connected"), 0, "two clients used the same client id");
    assert_eq!(supervisor.metric(CONNECTIONS, "").await, 1.0);
    assert_eq!(supervisor.metric(TAKEOVERS, "").await, 0.0);
    supervisor.terminate().await;
}

#[tokio::test]
async fn regress_nor_at_the_embedded_broker() {
    let folder = tempfile::tempdir().unwrap();
    let port = vibrissa_tests::mosquitto::free_port();
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-port", &port.to_string()]);
    supervisor.says(true, &["OWNED".to_owned()]).await;
    let mut robot = born(port).await;
    let boot = published_boot(&mut robot).await;
    for id in guesses(&boot) {
        intrude(port, &id).await;
    }
    robot.touch(0, 5).await;
    robot.receipted().await;
    assert_eq!(supervisor.metric(CONNECTIONS, "").await, 1.0);
    assert_eq!(supervisor.metric(TAKEOVERS, "").await, 0.0);
    supervisor.terminate().await;
}

/// A broker with MQTT 5 reports takeovers in its DISCONNECT.
#[tokio::test]
async fn a_takeover_that_the_broker_tells_of_is_counted_and_logged_once_a_minute() {
    const SESSION_TAKEN_OVER: u8 = 0x8e;
    let (broker, folder) = (broker(), tempfile::tempdir().unwrap());
    let proxy = MqttProxy::to(broker.port()).await;
    let url = format!("mqtt://127.0.0.1:{}", proxy.port());
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-url", &url]);
    let mut ids = BTreeSet::new();
    for times in 1..=3 {
        supervisor.says(true, &["OWNED".to_owned()]).await;
        for role in ["in", "out"] {
            let new = async || newest_id(&broker, role).filter(|id| !ids.contains(id));
            let id = until("a new id", new).await;
            ids.insert(id);
        }
        proxy.end_for(SESSION_TAKEN_OVER);
        // Both connections of the fleet.
        metric_reaches(&supervisor, TAKEOVERS, "fleet=\"f\"", 2.0 * f64::from(times)).await;
    }
    supervisor.says(true, &[]).await;
    assert_eq!(supervisor.metric(TAKEOVERS, "").await, 6.0);
    assert_eq!(supervisor.metric(CLOSED, "").await, 0.0);
    assert_eq!(supervisor.logged("another client connected with the same client id"), 1, "once a minute");
    supervisor.terminate().await;
}

/// A reader of the broker's log knows the ids. Mosquitto before 2.0.15 closes the connection without a reason.
#[tokio::test]
async fn a_takeover_by_someone_who_reads_the_brokers_log_is_counted_and_the_next_connection_has_another_id() {
    const TIMES: usize = 5;
    let (broker, folder) = (broker(), tempfile::tempdir().unwrap());
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-url", &url]);
    supervisor.says(true, &["OWNED".to_owned()]).await;
    let mut robot = born(broker.port()).await;
    let mut known = Vec::new();
    for role in ["in", "out"] {
        for _ in 0..TIMES {
            let id = until("an id", async || newest_id(&broker, role)).await;
            let before = counted(&supervisor).await;
            intrude(broker.port(), &id).await;
            until_true("one more counted", async || counted(&supervisor).await > before).await;
            until_true("another id", async || newest_id(&broker, role).is_some_and(|newest| newest != id)).await;
            supervisor.says(true, &[]).await;
            known.push(id);
        }
    }
    assert_eq!(counted(&supervisor).await, 2.0 * TIMES as f64);
    // Ids that the intruder knows are no longer in use.
    for id in &known {
        intrude(broker.port(), id).await;
    }
    robot.touch(0, 5).await;
    robot.receipted().await;
    assert_eq!(counted(&supervisor).await, 2.0 * TIMES as f64);
    supervisor.says(true, &[]).await;
    // By the broker's version.
    let told = ["with the same client id", "it closed the connection without a reason"];
    assert_eq!(told.iter().map(|words| supervisor.logged(words)).sum::<usize>(), 1, "once a minute");
    let log = supervisor.log();
    known.extend(["in", "out"].iter().filter_map(|role| newest_id(&broker, role)));
    for id in known {
        let random = id.rsplit('-').next().unwrap();
        assert!(random.len() == 32 && !log.contains(random), "{id} is in the log");
    }
    supervisor.terminate().await;
}

/// Number of certain and of possible takeovers.
async fn counted(supervisor: &Supervised) -> f64 {
    supervisor.metric(TAKEOVERS, "").await + supervisor.metric(CLOSED, "").await
}

/// Both connections break at once, so this is not a takeover.
#[tokio::test]
async fn a_broker_that_is_killed_does_not_count_as_a_takeover() {
    let (mut broker, folder) = (broker(), tempfile::tempdir().unwrap());
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let mut supervisor = Supervised::start(folder.path(), "s", &["--fleet", "f", "--mqtt-url", &url]);
    for _ in 0..3 {
        supervisor.says(true, &["OWNED".to_owned()]).await;
        broker.kill();
        supervisor.says(false, &["nothing listens there".to_owned()]).await;
        broker.restart();
    }
    supervisor.says(true, &[]).await;
    assert_eq!(counted(&supervisor).await, 0.0);
    supervisor.terminate().await;
}
