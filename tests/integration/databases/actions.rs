//! Operator actions with several supervisors on one PostgreSQL: sent to any of them, executed once by the owner.

use std::collections::BTreeSet;

use sqlx::postgres::PgConnection;
use sqlx::{ConnectOptions, Row};
use vibrissa_protocol::ArrayType;
use vibrissa_store::actions::{Asked, NewAction};
use vibrissa_store::calibrations::NewCalibration;
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::readiness::Standing;
use vibrissa_supervisor::service::{Service, ServiceOptions};
use vibrissa_tests::actions::{answered, asks, asks_of};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::fleet;

/// Starts a supervisor of fleet `f` in this process.
pub(crate) async fn supervisor(name: &str, database_port: u16, broker: &Mosquitto) -> Service {
    Service::start(ServiceOptions {
        kafka: vibrissa_supervisor::service::KafkaOptions::default(),
        access: vibrissa_supervisor::http::access::AccessOptions::default(),
        name: name.to_owned(),
        fleets: vec![fleet()],
        database: Postgres::url(database_port).parse().unwrap(),
        is_new_installation: true,
        lease_time_to_live: std::time::Duration::from_secs(2),
        limits: vibrissa_supervisor::service::LimitOptions::default(),
        history: vibrissa_supervisor::service::HistoryOptions::default(),
        black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
        metrics_per_whisker: false,
        broker: Some(BrokerAddress::new("127.0.0.1", broker.port())),
        mqtt_port: 0,
        mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
        http: ([127, 0, 0, 1], 0).into(),
        webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
        traces: None,
        params: vibrissa_tests::robot::params(),
    })
    .await
    .unwrap()
}

pub(crate) fn owns(service: &Service) -> bool {
    matches!(service.readiness.fleets().get(&fleet()), Some(Standing::Owned { .. }))
}

/// A change of the policy that is accepted only if this version is in force.
fn policy(expected_version: i64) -> NewAction {
    let margin = 0.001 * expected_version as f64;
    asks(
        "POLICY",
        &format!(r#"{{"expected_version": {expected_version}, "mode": "ADVISE", "change_margin": {margin}}}"#),
    )
}

/// Number of policy versions, of actions that caused them, and of actions answered with DONE.
async fn policies(link: &mut PgConnection) -> (i64, i64, i64) {
    let row = sqlx::query(
        "SELECT (SELECT count(*) FROM policies) AS versions, (SELECT count(DISTINCT action_id) FROM policies) AS asked, \
         (SELECT count(*) FROM actions WHERE state = 'DONE') AS done",
    )
    .fetch_one(link)
    .await
    .unwrap();
    (row.get("versions"), row.get("asked"), row.get("done"))
}

#[tokio::test]
async fn what_is_asked_of_the_supervisor_that_stands_by_is_done_by_the_owner() {
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    let owner = supervisor("a", server.port(), &broker).await;
    until_true("an owner", async || owns(&owner)).await;
    let other = supervisor("b", server.port(), &broker).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    // The supervisor knows the robot's clock after its first contacts.
    robot.touch(1, 1).await;
    robot.receipted().await;
    let action = asks_of("SETPOINT", r#"{"pressure_mpa": 0.05}"#, Some(1));
    let answer = answered(&other.store, &other.action_notifier, &action).await;
    assert_eq!(answer.state, "DONE", "{answer:?}");
    let (setpoint, _) = robot.setpoint().await;
    assert_eq!((setpoint.whisker, setpoint.pressure_mpa), (1, 0.05));
    assert!(owns(&owner) && !owns(&other));
    // The new owner keeps the holds.
    owner.stop().await;
    until_true("another owner", async || owns(&other)).await;
    let release = asks_of("RELEASE", "{}", Some(1));
    assert_eq!(answered(&other.store, &other.action_notifier, &release).await.state, "DONE");
    let mut link = server.connect().connect().await.unwrap();
    let held: bool = sqlx::query_scalar("SELECT bool_or(held) FROM whiskers").fetch_one(&mut link).await.unwrap();
    assert!(!held);
    other.stop().await;
}

#[tokio::test]
async fn brute_force_connections_that_break_lose_no_action_and_do_none_twice() {
    const ACTIONS: i64 = 60;
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    let proxy = Proxy::to(server.port()).await;
    let service = supervisor("a", proxy.port(), &broker).await;
    until_true("an owner", async || owns(&service)).await;
    let asker = vibrissa_store::Store::open(&Postgres::url(server.port()).parse().unwrap(), "asker").await.unwrap();
    let mut link = server.connect().connect().await.unwrap();
    for at in 0..ACTIONS {
        assert_eq!(asker.ask(&policy(at)).await.unwrap(), Asked::New(at + 1));
        service.action_notifier.notify(&fleet());
        // Each attempt cuts the connection at a different moment of the transaction.
        tokio::time::sleep(std::time::Duration::from_micros(400 * (at as u64 % 17))).await;
        proxy.cut();
    }
    until_true("all done", async || policies(&mut link).await == (ACTIONS, ACTIONS, ACTIONS)).await;
    service.stop().await;
}

#[tokio::test]
async fn an_owner_that_loses_the_fleet_leaves_what_it_has_not_done_to_the_next_one() {
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    let proxy = Proxy::to(server.port()).await;
    let first = supervisor("a", proxy.port(), &broker).await;
    until_true("an owner", async || owns(&first)).await;
    let second = supervisor("b", server.port(), &broker).await;
    let mut link = server.connect().connect().await.unwrap();
    for at in 0..10 {
        if at == 5 {
            // From now on nothing that the owner does reaches the database.
            proxy.stall(true);
        }
        second.store.ask(&policy(at)).await.unwrap();
        first.action_notifier.notify(&fleet());
    }
    until_true("all done", async || policies(&mut link).await == (10, 10, 10)).await;
    assert!(owns(&second));
    proxy.stall(false);
    until_true("the first supervisor no longer owns the fleet", async || !owns(&first)).await;
    assert_eq!(policies(&mut link).await, (10, 10, 10), "the first supervisor must not write afterwards");
    first.stop().await;
    second.stop().await;
}

/// Each one took the same next version, and all but one failed.
#[tokio::test]
async fn regress_calibrations_of_a_model_that_come_at_the_same_time_have_one_version_each() {
    let database = crate::Fresh::postgres().await;
    let uploads: Vec<_> = (0..8)
        .map(|number| {
            let store = database.store.clone();
            tokio::spawn(async move {
                let [model, measurements, fit] = ["m", "[]", "{}"].map(str::to_owned);
                let new = NewCalibration { model, measurements, fit, calibration: number.to_string() };
                store.add_calibration(&new, &asks("UPLOAD", "{}")).await.unwrap().1.unwrap()
            })
        })
        .collect();
    let mut ids = BTreeSet::new();
    for upload in uploads {
        ids.insert(upload.await.unwrap());
    }
    assert_eq!(ids.len(), 8);
    let mut link = database.server.as_ref().unwrap().connect().connect().await.unwrap();
    let versions: Vec<i64> =
        sqlx::query_scalar("SELECT version FROM calibrations ORDER BY version").fetch_all(&mut link).await.unwrap();
    assert_eq!(versions, (1..=8).collect::<Vec<i64>>());
}
