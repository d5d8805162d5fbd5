//! An access list of the broker that forbids one thing too many, or a limit of the broker that is too small. For each: the
//! answer of `/readyz`, which does not change until the broker does, the alarms, and the log.

use std::net::SocketAddr;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::{Value, json};
use tempfile::TempDir;
use vibrissa_protocol::{ArrayType, RobotTopic, SetpointOutcome, encode};
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::certificates::write;
use vibrissa_tests::mosquitto::{Builder, Mosquitto};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

use crate::listener::Supervised;

const ACL: &str = include_str!("../../../deploy/mosquitto/acl");
const PASSWORD: &str = "correct-horse-battery-staple";
/// Time after which a robot sends contacts again that have no receipt.
const SEND_AGAIN: std::time::Duration = std::time::Duration::from_millis(500);

/// The shipped access list without a line, and a supervisor of fleet `f`.
struct Stage {
    broker: Mosquitto,
    supervisor: Supervised,
    _folder: TempDir,
}

impl Stage {
    /// Forbids what a line of the shipped list allows.
    fn without(line: &str) -> Self {
        let line = format!("{line}\n");
        assert!(ACL.contains(&line), "the shipped list has no line {line}");
        Self::on(&Mosquitto::builder().acl(&ACL.replace(&line, "")))
    }

    fn on(builder: &Builder) -> Self {
        let folder = tempfile::tempdir().unwrap();
        // The broker logs each publication that it refuses.
        let broker = builder.clone().line("log_type all").user("vibrissa", PASSWORD).user("f/r", PASSWORD).start();
        let (url, file) = (format!("mqtt://127.0.0.1:{}", broker.port()), write(folder.path(), "password", PASSWORD));
        let file = file.display().to_string();
        let arguments =
            ["--fleet", "f", "--mqtt-url", &url, "--mqtt-username", "vibrissa", "--mqtt-password-file", &file];
        let supervisor = Supervised::start(folder.path(), "s", &arguments);
        Self { broker, supervisor, _folder: folder }
    }

    /// Allows everything that the shipped list allows.
    async fn allow(&self) {
        std::fs::write(self.broker.folder().join("acl"), ACL).unwrap();
        kill(Pid::from_raw(self.broker.pid().cast_signed()), Signal::SIGHUP).unwrap();
        until_true("the broker reads its list again", async || self.broker.logged("Reloading config") == 1).await;
    }

    /// Number of publications on a topic that the broker has refused.
    fn refused(&self, kind: RobotTopic) -> usize {
        let topic = format!("whisker/v1/f/r/{kind}");
        let is_refusal = |line: &String| line.contains("Denied PUBLISH") && line.contains(&topic);
        self.broker.lines().iter().filter(|line| is_refusal(line)).count()
    }

    /// A robot that is born once it can be heard.
    async fn robot(&self) -> HandRobot {
        until_true("robots are heard", async || {
            self.supervisor.ready().await.is_some_and(|(_, text)| text.contains("\"receiving\":\"127.0.0.1"))
        })
        .await;
        let facts = array(ArrayType::Type1, &[70.0, 65.0]);
        let mut robot = HandRobot::connect_as(self.broker.port(), "r", Some(("f/r", PASSWORD)), facts).await;
        robot.birth().await;
        robot
    }

    /// Waits until something holds. `/readyz` gives the same answer meanwhile.
    async fn steadily(&self, is_ready: bool, words: &[String], what: &str, mut holds: impl AsyncFnMut() -> bool) {
        until_true(what, async || {
            let (ready, text) = self.supervisor.ready().await.unwrap();
            assert!(ready == is_ready && words.iter().all(|word| text.contains(word)), "{what}: {text}");
            holds().await
        })
        .await;
    }

    /// Kinds of the standing alarms.
    async fn alarms(&self) -> Vec<String> {
        let (status, body) = try_get(self.address(), "/v1/alarms?standing=true").await.unwrap();
        assert_eq!(status, 200, "{body}");
        let page: Value = serde_json::from_str(&body).unwrap();
        let kind = |alarm: &Value| alarm["kind"].as_str().unwrap().to_owned();
        page["items"].as_array().unwrap().iter().map(kind).collect()
    }

    /// Acts on whisker 0 as an operator.
    async fn act(&self, what: &str, body: &Value) {
        let path = format!("/v1/fleets/f/robots/r/arrays/left/whiskers/0/{what}");
        let answer = send(self.address(), "POST", &path, &[], Some(body)).await.unwrap();
        assert_eq!(answer.status / 100, 2, "{}", answer.body);
    }

    fn address(&self) -> SocketAddr {
        self.supervisor.address()
    }
}

fn words<const N: usize>(words: [&str; N]) -> [String; N] {
    words.map(str::to_owned)
}

async fn tell_time(robot: &mut HandRobot) {
    robot.clock_us = now_us();
    robot.status().await;
}

#[tokio::test]
async fn regress_a_list_that_refuses_receipts_is_named_until_it_allows_them() {
    let mut stage = Stage::without("topic readwrite whisker/v1/+/+/receipt");
    let mut robot = stage.robot().await;
    let expected =
        words(["rejects publications", "whisker/v1/f/r/receipt", "this user may not do it", "broker's access list"]);
    until_true("a refused receipt", async || {
        robot.touch(0, 5).await;
        stage.refused(RobotTopic::Receipt) > 0
    })
    .await;
    stage.supervisor.says(false, &expected).await;
    stage
        .steadily(false, &expected, "further refused receipts", async || {
            robot.touch(0, 5).await;
            stage.refused(RobotTopic::Receipt) >= 6
        })
        .await;
    assert_eq!(stage.supervisor.logged("whisker/v1/f/r/receipt, because this user may not do it"), 1);
    stage.allow().await;
    robot.touch(0, 5).await;
    robot.receipted().await;
    stage.supervisor.says(true, &[]).await;
    assert_eq!(stage.supervisor.logged("accepts publications on this topic again"), 1);
    stage.supervisor.terminate().await;
}

#[tokio::test]
async fn regress_a_list_that_keeps_receipts_from_robots_is_an_alarm_that_names_the_topic() {
    let mut stage = Stage::without("pattern read whisker/v1/%u/receipt");
    let mut robot = stage.robot().await;
    let contacts = (0..5).map(|_| robot.contact(0)).collect();
    let message = encode(&robot.message(contacts));
    stage.supervisor.says(true, &[]).await;
    stage
        .steadily(true, &[], "an alarm", async || {
            robot.say(RobotTopic::Contacts, message.clone()).await;
            robot.status().await;
            tokio::time::sleep(SEND_AGAIN).await;
            stage.alarms().await == ["RECEIPTS_UNHEARD"]
        })
        .await;
    let expected = words(["1 robot(s)", "whisker/v1/f/r/receipt", "broker's access list"]);
    stage.supervisor.says(true, &expected).await;
    let logged = "the robot sends contacts again that were receipted on this topic";
    assert_eq!(stage.supervisor.logged(logged), 1);
    assert!(stage.supervisor.log().contains("whisker/v1/f/r/receipt"));
    stage.allow().await;
    // Its next receipt covers all of them.
    robot.touch(0, 5).await;
    robot.receipted().await;
    // A robot that says nothing for long would raise an alarm of its own.
    until_true("no alarm", async || {
        robot.status().await;
        stage.alarms().await.is_empty()
    })
    .await;
    let (_, text) = stage.supervisor.ready().await.unwrap();
    assert!(!text.contains("receipt in"), "{text}");
    stage.supervisor.terminate().await;
}

#[tokio::test]
async fn regress_a_list_that_refuses_setpoints_is_named_steadily_and_an_alarm() {
    let mut stage = Stage::without("topic readwrite whisker/v1/+/+/setpoint");
    let mut robot = stage.robot().await;
    robot.settle().await;
    stage.supervisor.says(true, &[]).await;
    tell_time(&mut robot).await;
    robot.touch(0, 5).await;
    robot.receipted().await;
    let pressure = json!({ "pressure_mpa": 0.15, "reason": "a test" });
    stage.act("setpoint", &pressure).await;
    let expected =
        words(["rejects publications", "whisker/v1/f/r/setpoint", "this user may not do it", "broker's access list"]);
    stage.supervisor.says(false, &expected).await;
    stage
        .steadily(false, &expected, "an alarm", async || {
            // The robot is heard, so nothing but the setpoint fails.
            tell_time(&mut robot).await;
            stage.alarms().await == ["SETPOINT_FAILED"]
        })
        .await;
    assert!(stage.refused(RobotTopic::Setpoint) > 1, "it is tried again");
    assert_eq!(stage.supervisor.logged("whisker/v1/f/r/setpoint, because this user may not do it"), 1);
    stage.allow().await;
    // A pressure that is set by hand is sent at once or not at all.
    stage.act("setpoint", &pressure).await;
    let (setpoint, _) = robot.setpoint().await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.status().await;
    stage.supervisor.says(true, &[]).await;
    // A robot that says nothing for long would raise an alarm of its own.
    until_true("no alarm", async || {
        robot.status().await;
        stage.alarms().await.is_empty()
    })
    .await;
    stage.supervisor.terminate().await;
}

#[tokio::test]
async fn regress_a_list_that_refuses_factsheets_is_told_as_long_as_the_robot_lacks_one() {
    let mut stage = Stage::without("pattern write whisker/v1/%u/factsheet");
    let mut robot = stage.robot().await;
    until_true("a refused factsheet", async || stage.refused(RobotTopic::Factsheet) == 1).await;
    let expected = words(["1 robot(s) announced themselves", "whisker/v1/f/r/factsheet", "broker's access list"]);
    stage.supervisor.says(true, &expected).await;
    assert_eq!(stage.supervisor.metric("vibrissa_robots_without_factsheet", "fleet=\"f\"").await, 1.0);
    assert!(stage.supervisor.logged("whisker/v1/f/r/factsheet") > 0, "{}", stage.supervisor.log());
    let mut statuses = 0;
    stage
        .steadily(true, &expected, "further statuses", async || {
            robot.status().await;
            statuses += 1;
            statuses == 50
        })
        .await;
    stage.allow().await;
    robot.birth().await;
    robot.settle().await;
    until_true("no robot without a factsheet", async || {
        let (_, text) = stage.supervisor.ready().await.unwrap();
        !text.contains("announced themselves")
    })
    .await;
    stage.supervisor.terminate().await;
}

#[tokio::test]
async fn regress_a_broker_whose_packets_are_too_small_is_named_with_its_setting() {
    let mut stage = Stage::on(&Mosquitto::builder().acl(ACL).line("max_packet_size 2000"));
    let expected = words(["packets of at most 2000 bytes", "Mosquitto: max_packet_size and message_size_limit"]);
    stage.supervisor.says(false, &expected).await;
    let mut robot = stage.robot().await;
    robot.settle().await;
    let mut receipts = 0;
    stage
        .steadily(false, &expected, "receipts", async || {
            robot.touch(0, 2).await;
            robot.receipted().await;
            receipts += 1;
            receipts == 5
        })
        .await;
    assert_eq!(stage.supervisor.logged("packets of at most 2000 bytes"), 1, "both connections have the same limit");
    stage.supervisor.terminate().await;
}
