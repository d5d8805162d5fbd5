//! Requests for many, executed by the fleet's owner.

use serde_json::{Value, json};
use vibrissa_protocol::ArrayType;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::{send, try_get};

use crate::program::PROGRAM;
use crate::running::Running;

async fn post(running: &Running, path: &str, body: Value) -> Value {
    let answer = send(running.service.http, "POST", path, &[], Some(&body)).await.unwrap();
    assert_eq!(answer.status, 200, "{path}: {}", answer.body);
    answer.json()
}

/// The request once no action waits.
async fn settled(running: &Running, begun: &Value) -> Value {
    let path = format!("/v1/bulk-actions/{}", begun["action_id"]);
    until("no pending action", async || {
        let (status, body) = try_get(running.service.http, &path).await.unwrap();
        assert_eq!(status, 200, "{body}");
        Some(serde_json::from_str::<Value>(&body).unwrap()).filter(|detail| detail["request"]["pending"] == 0)
    })
    .await
}

#[tokio::test]
async fn all_shown_are_held_and_released_and_refusals_have_their_reasons() {
    let running = Running::start().await;
    let mut robots = Vec::new();
    for number in 0..3 {
        let sheet = array(ArrayType::Type1, &[70.0, 65.0]);
        robots.push(HandRobot::born(running.port(), &format!("r{number}"), sheet).await);
    }
    let known = "SELECT count(*) FROM whiskers WHERE position IS NOT NULL";
    until_true("all whiskers", async || running.database.number(known).await == 6).await;
    let whiskers = post(&running, "/v1/whiskers/hold", json!({ "filter": { "robot": "r0" }, "per_second": 100 })).await;
    let detail = settled(&running, &whiskers).await;
    assert_eq!((&detail["request"]["done"], &detail["refusals"]), (&json!(2), &json!([])), "{detail}");
    let dry = post(&running, "/v1/robots/hold", json!({ "dry_run": true })).await;
    assert_eq!(dry["subjects"], 3);
    let all = post(&running, "/v1/robots/hold", json!({ "digest": dry["digest"], "per_second": 100 })).await;
    assert_eq!(settled(&running, &all).await["request"]["done"], 3);
    assert_eq!(running.database.number("SELECT sum(held) FROM robots").await, 3);
    // A whisker of a held robot cannot be released.
    let release = post(&running, "/v1/whiskers/release", json!({ "filter": { "robot": "r0" } })).await;
    let detail = settled(&running, &release).await;
    assert_eq!((&detail["request"]["refused"], &detail["refusals"][0]["subjects"]), (&json!(2), &json!(2)), "{detail}");
    assert!(detail["refusals"][0]["problem"].as_str().unwrap().starts_with("ROBOT_HELD: "), "{detail}");
    let robots = post(&running, "/v1/robots/release", json!({ "per_second": 100 })).await;
    assert_eq!(settled(&running, &robots).await["request"]["done"], 3);
    let learned = post(&running, "/v1/whiskers/rebaseline", json!({ "per_second": 100 })).await;
    assert_eq!(settled(&running, &learned).await["request"]["done"], 6);
    let policies = post(&running, "/v1/policies", {
        let policy = vibrissa_tests::actions::policy_body(&vibrissa_core::policy::PolicyParams::default());
        json!({ "policy": policy, "filter": { "robot": "r1" } })
    })
    .await;
    assert_eq!(settled(&running, &policies).await["request"]["done"], 1);
    assert_eq!(running.database.number("SELECT max(version) FROM policies").await, 1);
    running.service.stop().await;
}

#[tokio::test]
async fn actions_become_due_one_after_another_survive_the_owner_and_stop_on_request() {
    let running = Running::start().await;
    let sheet = array(ArrayType::Type1, &[70.0; 12]);
    let _robot = HandRobot::born(running.port(), "r", sheet).await;
    let known = "SELECT count(*) FROM whiskers WHERE position IS NOT NULL";
    until_true("all whiskers", async || running.database.number(known).await == 12).await;
    let begun = post(&running, "/v1/whiskers/hold", json!({ "per_second": 1 })).await;
    let done = "SELECT count(*) FROM actions WHERE kind = 'HOLD' AND state = 'DONE'";
    until_true("some are done", async || running.database.number(done).await >= 2).await;
    let late = "SELECT count(*) FROM actions WHERE kind = 'HOLD' AND state = 'DONE' AND done_us < not_before_us";
    assert_eq!(running.database.number(late).await, 0);
    // The next owner goes on, and does none twice.
    let running = running.again(crate::running::quick(), None).await;
    let before = running.database.number(done).await;
    assert!(before < 12, "{before}");
    until_true("it goes on", async || running.database.number(done).await > before).await;
    post(&running, &format!("/v1/bulk-actions/{}/stop", begun["action_id"]), json!({})).await;
    let detail = settled(&running, &begun).await;
    let (done, refused) = (detail["request"]["done"].as_i64().unwrap(), detail["request"]["refused"].as_i64().unwrap());
    assert!(done >= 3 && refused >= 1 && done + refused == 12, "{detail}");
    assert_eq!(running.database.number("SELECT sum(held) FROM whiskers").await, done);
    running.service.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_command_lists_first_and_executes_on_request() {
    let running = Running::start().await;
    let _robot = HandRobot::born(running.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    let known = "SELECT count(*) FROM whiskers WHERE position IS NOT NULL";
    until_true("all whiskers", async || running.database.number(known).await == 2).await;
    let url = format!("http://{}", running.service.http);
    let run = async |arguments: &[&str]| {
        let mut command = tokio::process::Command::new(PROGRAM);
        command.arg("bulk").args(arguments).args(["--url", &url]).kill_on_drop(true);
        let done = command.output().await.unwrap();
        let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
        (done.status.code(), text(&done.stdout), text(&done.stderr))
    };
    let held = "SELECT sum(held) FROM robots";
    let (code, output, _) = run(&["hold-robots", "--fleet", "f"]).await;
    assert_eq!((code, output.as_str()), (Some(0), "f/r\n1 subjects\nnothing was changed: add --execute\n"));
    assert_eq!(running.database.number(held).await, 0);
    let (code, output, problem) = run(&["hold-robots", "--fleet", "f", "--execute", "--reason", "a test"]).await;
    assert_eq!(code, Some(0), "{output} {problem}");
    assert!(output.ends_with("1 of 1 done, 0 refused, 0 expired\n"), "{output}");
    assert_eq!(running.database.number(held).await, 1);
    let (code, output, problem) = run(&["release-whiskers", "--execute"]).await;
    assert_eq!(code, Some(3), "{output} {problem}");
    assert!(problem.contains("2 refused: ROBOT_HELD"), "{problem}");
    let (code, _, problem) = run(&["hold-robots", "--label", "Hall"]).await;
    assert!(code == Some(2) && problem.contains("a key begins with a small letter"), "{problem}");
    let (code, output, _) = run(&["acknowledge-alarms", "--label", "hall", "--execute"]).await;
    assert_eq!((code, output.as_str()), (Some(0), "0 alarms\nnothing was to be done\n"));
    let (code, output, _) = run(&["acknowledge-alarms", "--label", "hall", "--execute", "--json"]).await;
    let answer: Value = serde_json::from_str(&output).expect("only JSON with --json");
    assert_eq!((code, &answer["alarms"]), (Some(0), &json!(0)), "{answer}");
    running.service.stop().await;
}
