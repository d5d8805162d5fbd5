//! A robot that connects by MQTT 3.1.1.

use vibrissa_protocol::{ArrayType, Message, SetpointOutcome};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::engine::{ALL, Engine, PASSWORD};
use crate::running::{LEARNED, Running};

/// Its whole life: birth, contacts, receipts, a cut, a setpoint, and its answer.
async fn works_on(engine: Engine) {
    let Some(started) = engine.start().await else { return };
    let ports = started.ports();
    let running = Running::start(&ports[..1]).await;
    let far = ports[ports.len() - 1];
    let facts = array(ArrayType::Type2, &[70.0, 69.3]);
    let mut robot = HandRobot::connect_311(far, "old", Some((ALL, PASSWORD)), facts).await;
    robot.birth().await;
    robot.settle().await;
    for whisker in [0, 1] {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.receipted().await;
    robot.cut(0, 65.0);
    let mut touched = 0;
    while robot.setpoints_left().is_empty() {
        assert!(touched < 400, "no setpoint after {touched} contacts");
        robot.touch(0, 20).await;
        robot.receipted().await;
        touched += 20;
    }
    let (setpoint, heard) = robot.setpoint().await;
    // MQTT 3.1.1 has no expiry; the time is in the message.
    assert_eq!((heard.expiry_s, heard.retained), (None, false));
    assert!(setpoint.expires_us > robot.clock_us);
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    until_true("it is known as applied", async || {
        let setpoints = running.list("setpoints").await;
        setpoints.iter().any(|one| one["robot"] == "old" && one["state"] == "APPLIED")
    })
    .await;
    robot.hear("an estimate", |heard| matches!(heard.message, Message::Estimate(_)).then_some(())).await;
    running.service.stop().await;
    started.stop().await;
}

#[tokio::test]
async fn a_robot_with_mqtt_3_1_1_works_on_mosquitto() {
    works_on(Engine::Mosquitto).await;
}

#[tokio::test]
async fn a_robot_with_mqtt_3_1_1_works_on_the_embedded_broker() {
    works_on(Engine::Embedded).await;
}

#[tokio::test]
async fn a_robot_with_mqtt_3_1_1_works_at_another_node_than_the_supervisor() {
    works_on(Engine::RmqttCluster).await;
}

#[tokio::test]
async fn a_robot_with_mqtt_3_1_1_works_on_artemis() {
    works_on(Engine::Artemis).await;
}
