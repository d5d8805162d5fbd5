//! Robots that leave for good, and robots that leave the allow list.

use std::time::Duration;

use serde_json::{Value, json};
use vibrissa_protocol::{ArrayType, ConnectionState, encode};
use vibrissa_tests::observer::Observer;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::send;

use crate::running::{Running, quick};
use crate::web;

const ROBOT: &str = "/v1/fleets/f/robots/old";

async fn born(running: &Running, name: &str) -> HandRobot {
    let mut robot = HandRobot::born(running.port(), name, array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.touch(0, 30).await;
    robot.receipted().await;
    robot
}

async fn decommission(running: &Running) -> (u16, Value) {
    let body = json!({ "reason": "scrapped" });
    let answer = send(running.service.http, "DELETE", ROBOT, &[], Some(&body)).await.unwrap();
    (answer.status, answer.json())
}

/// Names of the robots in a list.
async fn robots(running: &Running, list: &str) -> Vec<String> {
    let mut names: Vec<String> =
        running.list(list).await.iter().map(|row| row["robot"].as_str().unwrap().to_owned()).collect();
    names.sort();
    names.dedup();
    names
}

async fn alarms(running: &Running) -> usize {
    running.list("alarms?standing=true&robot=old").await.len()
}

async fn in_metrics(running: &Running) -> f64 {
    let metrics = running.metrics().await;
    ["ONLINE", "OFFLINE", "CONNECTION_BROKEN"]
        .iter()
        .map(|state| metrics.get(&format!("vibrissa_robots{{connection=\"{state}\",fleet=\"f\"}}")))
        .sum()
}

/// A robot that had left stood in every list, metric and alarm for ever.
#[tokio::test]
async fn regress_a_decommissioned_robot_is_forgotten_and_its_history_stays() {
    let running = Running::start().await;
    let mut old = born(&running, "old").await;
    let _stays = born(&running, "stays").await;
    let (status, problem) = decommission(&running).await;
    assert_eq!(status, 409, "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains("switch it off first"), "{problem}");

    old.connection(ConnectionState::ConnectionBroken).await;
    until_true("the alarm", async || alarms(&running).await == 1).await;
    let (status, action) = decommission(&running).await;
    assert_eq!((status, &action["state"]), (200, &json!("DONE")), "{action}");
    for list in ["robots", "arrays", "whiskers"] {
        assert_eq!(robots(&running, list).await, ["stays"], "{list}");
    }
    assert_eq!((alarms(&running).await, web::get(running.service.http, ROBOT).await.0), (0, 404));
    assert_eq!(running.list("fleets").await[0]["robots"], 1);
    until_true("the metric", async || in_metrics(&running).await == 1.0).await;
    let contacts = "SELECT count(*) FROM contacts JOIN whiskers USING (whisker_id) JOIN robots USING (robot_id) \
                    WHERE robot = 'old'";
    assert!(running.database.number(contacts).await >= 5, "its history stays");
    assert_eq!(running.list("alarms?robot=old").await.len(), 1);
    let mut observer = Observer::subscribed(running.port(), "o", &["whisker/v1/f/old/#"]).await;
    assert!(observer.next(Duration::from_millis(300)).await.is_none(), "nothing is retained");

    // The boot that was decommissioned does not come back, whoever sends its messages, also after a restart.
    old.connection(ConnectionState::Online).await;
    let factsheet = old.factsheet();
    old.say(vibrissa_protocol::RobotTopic::Factsheet, encode(&factsheet)).await;
    until_true("the refusal", async || running.metrics().await.refused().contains_key("old_boot")).await;
    assert_eq!(robots(&running, "robots").await, ["stays"]);
    drop(old);
    let running = running.again(quick(), None).await;
    assert_eq!(robots(&running, "robots").await, ["stays"]);

    let mut back = HandRobot::connect(running.port(), "old", array(ArrayType::Type1, &[70.0, 65.0])).await;
    back.restart();
    back.birth().await;
    back.settle().await;
    back.touch(0, 3).await;
    back.receipted().await;
    assert_eq!(robots(&running, "robots").await, ["old", "stays"]);
    let whiskers = running.list("whiskers?robot=old").await;
    let learned: Vec<_> = whiskers.iter().map(|row| (row["whisker"].as_i64(), row["contacts"].as_i64())).collect();
    assert_eq!(learned.len(), 2, "{whiskers:?}");
    assert!(learned.iter().all(|(_, contacts)| contacts.is_some_and(|contacts| contacts < 15)), "anew: {learned:?}");
    running.service.stop().await;
}

/// A robot that was taken off the list raised an alarm for its silence, and stood in the metrics.
#[tokio::test]
async fn regress_a_robot_that_leaves_the_allow_list_has_no_alarms_until_it_is_allowed_again() {
    let running = Running::start().await;
    let mut old = born(&running, "old").await;
    let allow = async |names: &[&str]| {
        let list = "/v1/fleets/f/allowed-robots";
        let version = web::json(running.service.http, list).await["version"].to_string();
        let headers = [("If-Match", format!("\"{version}\""))];
        let headers = headers.each_ref().map(|(name, value)| (*name, value.as_str()));
        let answer =
            send(running.service.http, "PUT", list, &headers, Some(&json!({ "robots": names }))).await.unwrap();
        assert_eq!(answer.status, 200, "{}", answer.body);
    };
    old.connection(ConnectionState::ConnectionBroken).await;
    until_true("the alarm", async || alarms(&running).await == 1).await;
    allow(&["stays"]).await;
    until_true("no alarm", async || alarms(&running).await == 0).await;
    until_true("the metric", async || in_metrics(&running).await == 0.0).await;
    assert_eq!(robots(&running, "robots").await, ["old"], "what was learned stays");
    allow(&["stays", "old"]).await;
    until_true("the alarm again", async || alarms(&running).await == 1).await;
    running.service.stop().await;
}

/// Lists and alarms kept a whisker for ever after its factsheet had dropped it.
#[tokio::test]
async fn regress_a_whisker_that_vanishes_from_a_factsheet_is_in_no_list() {
    let running = Running::start().await;
    let lengths_mm = [70.0, 68.0, 66.0, 65.0, 64.0];
    let mut robot = HandRobot::born(running.port(), "old", array(ArrayType::Type1, &lengths_mm)).await;
    robot.touch(4, 30).await;
    robot.receipted().await;
    assert_eq!(running.list("whiskers?robot=old").await.len(), 5);
    robot.restart();
    robot.array = array(ArrayType::Type1, &lengths_mm[..4]);
    robot.birth().await;
    until_true("four are left", async || running.list("whiskers?robot=old").await.len() == 4).await;
    let fleet = &running.list("fleets").await[0];
    assert_eq!((&fleet["whiskers"], &fleet["alarms"]), (&json!(4), &json!(0)), "{fleet}");
    let contacts = "SELECT count(*) FROM contacts JOIN whiskers USING (whisker_id) WHERE whisker = 4";
    assert!(running.database.number(contacts).await >= 5, "its history stays");
    running.service.stop().await;
}
