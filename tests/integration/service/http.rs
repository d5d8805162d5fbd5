//! Health, lists and metrics over HTTP.

use std::time::Duration;

use serde_json::Value;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use vibrissa_protocol::ArrayType;
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{ended, until, until_true};

use crate::running::{LEARNED, Running, quick};
use crate::web;

#[tokio::test]
async fn a_service_that_runs_is_alive_and_ready() {
    let running = Running::start().await;
    assert_eq!(web::get(running.service.http, "/livez").await, (200, "alive\n".to_owned()));
    until_true("ready", async || web::get(running.service.http, "/readyz").await.0 == 200).await;
    let mut ready = web::json(running.service.http, "/readyz").await;
    let nodes = ready.as_object_mut().and_then(|ready| ready.remove("mqtt_nodes")).unwrap();
    let node = format!("{}:{}", running.service.broker.host, running.service.broker.port);
    assert_eq!(nodes["f"]["receiving"], node, "{nodes}");
    let open = ready.as_object_mut().and_then(|ready| ready.remove("oldest_open_s")).unwrap();
    assert!(open["f"]["COMMITTED"].is_null() && open["f"]["RECEIVED"].is_null(), "{open}");
    let epoch = running.database.number("SELECT epoch FROM leases").await;
    let fleets = serde_json::json!({ "f": { "standing": "OWNED", "epoch": epoch } });
    assert_eq!(ready, serde_json::json!({ "ready": true, "reasons": [], "notices": [], "fleets": fleets }));
    assert_eq!(web::get(running.service.http, "/v1/nothing").await.0, 404);
    running.service.stop().await;
}

#[tokio::test]
async fn a_service_without_its_broker_is_alive_but_not_ready_until_the_broker_is_back() {
    let mut broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let http = running.service.http;
    until_true("ready", async || web::get(http, "/readyz").await.0 == 200).await;
    broker.kill();
    let answer = until("not ready", async || Some(web::get(http, "/readyz").await).filter(|answer| answer.0 == 503));
    let said: Value = serde_json::from_str(&answer.await.1).unwrap();
    assert_eq!(said["ready"], serde_json::json!(false));
    let reason = said["reasons"][0].as_str().unwrap();
    assert_eq!(said["fleets"]["f"]["standing"], "OWNED");
    assert!(reason.starts_with(&format!("MQTT broker 127.0.0.1:{}: ", broker.port())), "{reason}");
    until_true("no connection", async || running.metric("vibrissa_broker_connected{fleet=\"f\"}").await == 0.0).await;
    assert_eq!(web::get(http, "/livez").await.0, 200);
    broker.restart();
    until_true("ready again", async || web::get(http, "/readyz").await.0 == 200).await;
    assert_eq!(running.metric("vibrissa_broker_connected{fleet=\"f\"}").await, 1.0);
    running.service.stop().await;
}

#[tokio::test]
async fn what_happens_is_counted() {
    let running = Running::start().await;
    let before = running.metrics().await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0, 70.0])).await;
    robot.touch(0, LEARNED + 20).await;
    robot.receipted().await;
    let after = running.metrics().await;
    let rise = |name: &str| after.get(name) - before.get(name);
    assert_eq!(rise("vibrissa_contacts_total{fleet=\"f\",used=\"LEARNING\"}"), LEARNED as f64);
    assert_eq!(rise("vibrissa_contacts_total{fleet=\"f\",used=\"USED\"}"), 20.0);
    assert!(rise("vibrissa_messages_received_total{fleet=\"f\",topic=\"contacts\"}") >= 5.0);
    assert_eq!(rise("vibrissa_messages_received_total{fleet=\"f\",topic=\"factsheet\"}"), 1.0);
    assert!(rise("vibrissa_receipts_sent_total{fleet=\"f\"}") >= 1.0);
    assert!(rise("vibrissa_database_commit_seconds_count{fleet=\"f\"}") >= 1.0);
    assert!(rise("vibrissa_received_to_commit_seconds_count{fleet=\"f\"}") >= 5.0);
    assert!(rise("vibrissa_contact_to_commit_seconds_count{fleet=\"f\"}") >= 4.0);
    assert_eq!((rise("vibrissa_database_errors_total"), after.get("vibrissa_database_up")), (0.0, 1.0));
    until_true("whiskers counted by health", async || {
        let metrics = running.metrics().await;
        let count = |health: &str| metrics.get(&format!("vibrissa_whiskers{{fleet=\"f\",health=\"{health}\"}}"));
        (count("HEALTHY"), count("LEARNING")) == (1.0, 1.0)
    })
    .await;
    running.service.stop().await;
}

/// Each commit waits for the disk, and each receipt makes a robot act.
#[tokio::test]
async fn few_messages_are_committed_and_receipted_together() {
    const MESSAGES: usize = 60;
    let running = Running::start().await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0, 70.0])).await;
    robot.touch(0, 1).await;
    robot.receipted().await;
    let before = running.metrics().await;
    for _ in 0..MESSAGES {
        // The interval at which a busy fleet commits.
        tokio::time::sleep(Duration::from_millis(20)).await;
        robot.touch(0, 1).await;
    }
    robot.receipted().await;
    let after = running.metrics().await;
    let rise = |name: &str| after.get(name) - before.get(name);
    assert_eq!(rise("vibrissa_received_to_commit_seconds_count{fleet=\"f\"}"), MESSAGES as f64);
    for what in ["vibrissa_database_commit_seconds_count", "vibrissa_receipts_sent_total"] {
        let count = rise(&format!("{what}{{fleet=\"f\"}}"));
        assert!((1.0..=MESSAGES as f64 / 3.0).contains(&count), "{what}: {count}");
    }
    running.service.stop().await;
}

const SCENARIO: &str = r#"
fleet = "f"
seed = 3
[behaviour]
contacts_per_second = 150.0
contacts_per_message = 10
message_after_s = 0.2
[[robots]]
robot = "r"
events = [{ at_contact = 100, array = "left", whisker = 0, change = { kind = "TRIM", length_mm = 67.0 } }]
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
"#;

#[tokio::test]
async fn a_trim_and_its_compensation_are_told_with_their_measured_error() {
    let running = Running::start().await;
    let scenario = Scenario::from_toml_str(SCENARIO).unwrap();
    let fleet = Fleet::start(&scenario, &Broker::new("127.0.0.1", running.port())).unwrap();
    let compensation = until("a measured compensation", async || {
        running.list("compensations").await.into_iter().find(|one| one["measured_error"].is_number())
    })
    .await;
    let number = |field: &str| compensation[field].as_f64().unwrap_or_else(|| panic!("{field} in {compensation}"));
    for (field, expected) in [("fleet", "f"), ("robot", "r"), ("array", "left"), ("setpoint_state", "APPLIED")] {
        assert_eq!(compensation[field], expected, "{field}");
    }
    assert_eq!(compensation["case"], "SELF_COMPENSATION");
    assert_eq!((number("target_whisker"), number("compensator_whisker")), (0.0, 0.0));
    assert_eq!((number("target_length_mm"), number("pressure_before_mpa")), (70.0, 0.1));
    assert!((0.0..0.1).contains(&number("pressure_mpa")));
    assert!(number("measured_error_low") <= number("measured_error"));
    assert!(number("measured_error") <= number("measured_error_high"));
    assert!(number("predicted_error") > 0.0 && number("measured_bins") >= 1.0);
    assert!(compensation["decided_at"].as_str().unwrap().ends_with('Z') && number("candidate_count") == 1.0);
    assert!(compensation["ended_at"].is_null() && compensation["end_reason"].is_null());
    let id = &compensation["compensation_id"];
    let compensation = web::json(running.service.http, &format!("/v1/compensations/{id}")).await;
    let candidates = compensation["candidates"].as_array().unwrap();
    assert_eq!((candidates.len(), candidates[0]["chosen"].as_bool()), (1, Some(true)));

    let whiskers = running.list("whiskers").await;
    assert_eq!(whiskers.len(), 2);
    let [cut, whole] = [&whiskers[0], &whiskers[1]];
    assert_eq!((cut["whisker"].as_i64(), whole["whisker"].as_i64()), (Some(0), Some(1)));
    assert_eq!((cut["condition"].as_str(), whole["condition"].as_str()), (Some("TRIMMED"), Some("HEALTHY")));
    assert!((cut["length_mm"].as_f64().unwrap() - 67.0).abs() < 1.0, "{cut}");
    assert!((whole["length_mm"].as_f64().unwrap() - 70.0).abs() < 1.0, "{whole}");
    assert_eq!(cut["compensated_by"], compensation["compensation_id"]);
    assert_eq!(cut["serves_in"], compensation["compensation_id"]);
    assert!(whole["compensated_by"].is_null() && whole["serves_in"].is_null() && whole["fault"].is_null());
    assert!((cut["setpoint_mpa"].as_f64().unwrap() - number("pressure_mpa")).abs() < 1e-5);
    fleet.stop().await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_service_ends_though_someone_holds_a_connection_open() {
    let running = Running::start().await;
    let _silent = TcpStream::connect(running.service.http).await.unwrap();
    let mut half = TcpStream::connect(running.service.http).await.unwrap();
    half.write_all(b"GET /livez HTTP/1.1\r\nHost:").await.unwrap();
    assert_eq!(web::get(running.service.http, "/livez").await.0, 200, "earlier connections must be served, too");
    ended("the service", running.service.stop()).await;
}

#[tokio::test]
async fn a_service_ends_though_its_broker_is_away() {
    let mut broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    broker.kill();
    ended("the service", running.service.stop()).await;
}
