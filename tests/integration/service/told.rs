//! The programs of a robot, and the states of its segmenters.

use serde_json::{Value, json};
use vibrissa_protocol::{ArrayType, Segmenter, Software, SoftwareKind};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::running::{Running, quick};

/// Programs of the robot, and states of the segmenters of its whiskers.
async fn told(running: &Running) -> (Value, Vec<Value>) {
    let whiskers = running.list("whiskers").await;
    (running.list("robots").await[0]["software"].clone(), whiskers.iter().map(|one| one["segmenter"].clone()).collect())
}

#[tokio::test]
async fn programs_and_segmenters_are_shown_and_outlive_a_restart_of_the_supervisor() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type2, &[70.0, 65.0])).await;
    assert_eq!(told(&running).await, (json!([]), vec![Value::Null; 2]));

    robot.restart();
    let (kind, name, version) = (SoftwareKind::Firmware, "board".to_owned(), "3".to_owned());
    robot.software = vec![Software { kind, name, version }];
    robot.segmenter = Some(Segmenter::Noisy);
    robot.birth().await;
    let software = json!([{ "kind": "FIRMWARE", "name": "board", "version": "3" }]);
    let noisy = (software.clone(), vec![json!("NOISY"); 2]);
    until_true("programs and segmenters", async || told(&running).await == noisy).await;

    // Contacts alone lead to a checkpoint of the new supervisor, which has not received a status yet.
    let running = running.again(quick(), Some(broker.port())).await;
    robot.touch(0, 40).await;
    let contacts = async || running.list("whiskers").await[0]["contacts"].as_i64();
    until_true("a checkpoint", async || contacts().await == Some(40)).await;
    assert_eq!(told(&running).await, noisy);

    robot.segmenter = None;
    robot.status().await;
    let silent = (software, vec![Value::Null; 2]);
    until_true("no segmenters", async || told(&running).await == silent).await;
    running.stop().await;
}
