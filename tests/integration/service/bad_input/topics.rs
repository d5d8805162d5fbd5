//! Invalid topics, and invalid messages on valid topics.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use vibrissa_protocol::{ArrayType, RobotTopic, encode};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{ARRAY, HandRobot, array};
use vibrissa_tests::wait;

use super::{assert_recorded, counts, good, names, start, template};
use crate::running::{Running, quick};

#[tokio::test]
async fn a_topic_that_is_not_the_contracts_is_refused_or_not_even_heard() {
    let (running, mut robot) = start("r").await;
    let mut expected = good(&mut robot).await;
    let long = format!("whisker/v1/f/{}/contacts", "x".repeat(65));
    let payload = template(&mut robot).to_string().into_bytes();
    for topic in [
        "whisker/v1/f/a b/contacts",
        "whisker/v1/f/r\u{e9}/status",
        "whisker/v1/f//factsheet",
        &long,
        "whisker/v1/f/supervisor/contacts",
        "whisker/v1/f/r/nonsense",
        "whisker/v1/f/r/contacts/more",
        "whisker/v1/f/r",
        "whisker/v2/f/r/contacts",
        "whisker/v1/g/r/contacts",
        "whisker/v1/f/r/receipt2",
    ] {
        robot.mqtt.publish(topic, payload.clone(), false).await;
    }
    robot.say(RobotTopic::Contacts, payload.clone()).await;
    expected.extend(names(&serde_json::from_slice(&payload).unwrap()));
    robot.receipted().await;
    assert_recorded(&running, &expected).await;
    let reasons = ["bad_name", "bad_name", "bad_name", "bad_name", "unknown_topic"];
    assert_eq!(running.metrics().await.refused(), counts(&reasons));
    assert_eq!(running.database.texts("SELECT robot FROM robots").await, ["r"]);
    running.service.stop().await;
}

/// Invalid messages on the other topics of a robot, with the reason of their refusal.
fn other_junk(robot: &mut HandRobot) -> Vec<(RobotTopic, Vec<u8>, &'static str)> {
    let boot_id = robot.boot_id.clone();
    let entry = |field: &str, value: Value| {
        let mut entry = json!({ "array": ARRAY, "whisker": 0, "pressure_mpa": 0.1, "setpoint_mpa": 0.1,
            "regulator": "OK", "gauge": "OK" });
        entry[field] = value;
        json!({ "boot_id": boot_id, "seq": 100, "t_us": 1, "whiskers": [entry] })
    };
    let state = json!({ "boot_id": boot_id, "seq": 100, "command_id": "c", "state": "REJECTED", "t_us": 1 });
    let connection =
        |state: &str, timestamp: &str| json!({ "boot_id": boot_id, "seq": 9, "timestamp": timestamp, "state": state });
    let mut factsheets: [Value; 4] = std::array::from_fn(|_| serde_json::to_value(robot.factsheet()).unwrap());
    factsheets[0]["arrays"][0]["whiskers"][1]["whisker"] = json!(0);
    factsheets[1]["arrays"][0]["whiskers"][1]["neighbours"] = json!([7]);
    factsheets[2]["arrays"][0]["whiskers"][1]["model"] = json!("steel");
    factsheets[3]["arrays"][0]["whiskers"][1]["length_mm"] = json!(0);
    let [twice, neighbour, model, length] = factsheets;
    let mut junk = vec![
        (RobotTopic::Status, entry("regulator", json!("BROKEN")), "malformed"),
        (RobotTopic::Status, entry("pressure_mpa", json!(1.5)), "out_of_range"),
        (RobotTopic::SetpointState, state, "malformed"),
        (RobotTopic::Connection, connection("SLEEPING", "2026-11-21T08:00:00.000Z"), "malformed"),
        (RobotTopic::Connection, connection("OFFLINE", "yesterday"), "malformed"),
        (RobotTopic::Factsheet, twice, "duplicate"),
        (RobotTopic::Factsheet, neighbour, "wrong_neighbour"),
        (RobotTopic::Factsheet, model, "unknown_model"),
        (RobotTopic::Factsheet, length, "out_of_range"),
    ]
    .into_iter()
    .map(|(kind, value, reason)| (kind, value.to_string().into_bytes(), reason))
    .collect::<Vec<_>>();
    for kind in [RobotTopic::Status, RobotTopic::SetpointState, RobotTopic::Connection, RobotTopic::Factsheet] {
        junk.push((kind, b"{\"boot_id\":".to_vec(), "not_json"));
        junk.push((kind, b"{}".to_vec(), "malformed"));
        junk.push((kind, vec![b' '; 1 << 20], "too_large"));
    }
    junk
}

#[tokio::test]
async fn junk_on_any_other_topic_changes_nothing_of_what_is_known_of_a_robot() {
    let (running, mut robot) = start("r").await;
    let mut expected = good(&mut robot).await;
    robot.receipted().await;
    let known = |list: Vec<Value>| -> Vec<Value> {
        let fields = ["whisker", "whole_length_mm", "fault", "pressure_mpa", "setpoint_mpa"];
        list.iter().map(|one| fields.iter().map(|&field| one[field].clone()).collect()).collect()
    };
    let before = known(running.list("whiskers").await);
    let mut reasons = Vec::new();
    for (kind, payload, reason) in other_junk(&mut robot) {
        robot.say(kind, payload).await;
        reasons.push(reason);
    }
    expected.extend(good(&mut robot).await);
    robot.receipted().await;
    assert_recorded(&running, &expected).await;
    assert_eq!(running.metrics().await.refused(), counts(&reasons));
    assert_eq!(known(running.list("whiskers").await), before);
    assert_eq!(running.database.texts("SELECT connection FROM robots").await, ["ONLINE"]);
    running.service.stop().await;
}

#[tokio::test]
async fn a_robot_with_an_unknown_model_is_taken_when_it_has_a_known_one() {
    let running = Running::start().await;
    let mut unknown = array(ArrayType::Type2, &[70.0, 65.0]);
    unknown.whiskers[0].model = "steel".to_owned();
    let mut robot = HandRobot::connect(running.port(), "r", unknown).await;
    robot.birth().await;
    wait::until_true("the refusal of the model", async || {
        running.metrics().await.refused() == counts(&["unknown_model"])
    })
    .await;
    robot.array.whiskers[0].model = "nguyen-2021".to_owned();
    let factsheet = robot.factsheet();
    robot.say(RobotTopic::Factsheet, encode(&factsheet)).await;
    robot.settle().await;
    let expected = good(&mut robot).await;
    robot.receipted().await;
    assert_recorded(&running, &expected).await;
    running.service.stop().await;
}

#[tokio::test]
async fn a_packet_larger_than_the_supervisor_takes_does_not_break_its_connection() {
    let broker = Mosquitto::start();
    let running = Running::with(quick(), Some(broker.port())).await;
    let mut robot = HandRobot::born(broker.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    let mut expected = good(&mut robot).await;
    robot.say(RobotTopic::Contacts, vec![b'x'; 3 << 20]).await;
    expected.extend(good(&mut robot).await);
    robot.receipted().await;
    assert_recorded(&running, &expected).await;
    assert_eq!(running.metrics().await.refused(), BTreeMap::new(), "the broker must not pass it on");
    running.service.stop().await;
}
