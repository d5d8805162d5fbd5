//! What a working receiver gets: signed events of a real robot in the order of their commits.

use std::io::Write as _;
use std::process::{Command, Stdio};

use serde_json::{Value, json};
use vibrissa_protocol::{SetpointError, SetpointOutcome};
use vibrissa_tests::wait::until_true;

use crate::receiver::{Manner, Receiver, Request};
use crate::stage::{FAST, LEARNED, Stage, call, hook, shown};

/// Verifies a request with the example of the document, which shares no code with the program.
pub(crate) fn is_genuine(secret: &str, request: &Request) -> bool {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/webhooks.md")).unwrap();
    let example = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let asked = "import json, sys\nasked = json.load(sys.stdin)\n\
                 print(is_genuine(asked['secret'], asked['headers'], asked['body'].encode()))\n";
    let mut python = Command::new("python3")
        .args(["-c", &format!("{example}\n{asked}")])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let input = json!({ "secret": secret, "headers": request.headers, "body": request.body });
    python.stdin.take().unwrap().write_all(input.to_string().as_bytes()).unwrap();
    let output = python.wait_with_output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().trim() == "True"
}

/// The JSON Schema of the document.
fn schema() -> jsonschema::Validator {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/event.schema.json")).unwrap();
    jsonschema::validator_for(&serde_json::from_str(&text).unwrap()).unwrap()
}

/// A robot is cut, its compensation begins, and it rejects a setpoint.
async fn a_robots_story(stage: Stage) {
    let receiver = Receiver::start(Manner::Status(204)).await;
    let service = stage.supervisor("a", FAST).await;
    let (webhook_id, secret) = hook(&service, &receiver, json!({})).await;
    let mut robot = stage.robot().await;
    for whisker in 0..3 {
        robot.touch(whisker, LEARNED as usize + 20).await;
    }
    robot.receipted().await;
    robot.cut(0, 65.0);
    for _ in 0..30 {
        for whisker in 0..3 {
            robot.touch(whisker, 20).await;
        }
        robot.receipted().await;
        if receiver.requests().iter().any(|one| one.kind() == "TRIM") {
            break;
        }
    }
    let (setpoint, _) = robot.setpoint().await;
    robot.answer(&setpoint, SetpointOutcome::Rejected, Some(SetpointError::OutOfRange)).await;
    let has = |kind: &str| receiver.requests().iter().any(|one| one.kind() == kind);
    for kind in
        ["TRIM", "CONDITION_CHANGED", "COMPENSATION_BEGUN", "SETPOINT_FAILED", "COMPENSATION_ENDED", "ALARM_RAISED"]
    {
        until_true(kind, async || has(kind)).await;
    }
    let path = "/v1/fleets/f/robots/r/arrays/left/whiskers/0/replaced";
    assert!(call(&service, "POST", path, None).await.status < 300);
    until_true("the alarm is cleared", async || has("ALARM_CLEARED")).await;

    let (requests, schema) = (receiver.requests(), schema());
    for request in &requests {
        let event = request.json();
        schema.validate(&event).unwrap_or_else(|problem| panic!("{problem}: {event}"));
        assert_eq!(request.headers["content-type"], "application/json");
        let id = &request.headers["webhook-id"];
        assert!(id.starts_with(&format!("vibrissa-{webhook_id}-{}-", request.event_id())), "{id}");
        assert_eq!((&event["data"]["fleet"], &event["data"]["robot"]), (&json!("f"), &json!("r")));
    }
    assert!(is_genuine(&secret, &requests[0]) && is_genuine(&secret, requests.last().unwrap()));
    let forged = Request { body: requests[0].body.replace("\"f\"", "\"g\""), ..requests[0].clone() };
    assert!(!is_genuine(&secret, &forged));
    in_order(&requests);
    let of = |kind: &str| requests.iter().find(|one| one.kind() == kind).unwrap().json();
    let trim = of("TRIM");
    assert_eq!((&trim["data"]["array"], &trim["data"]["whisker"]), (&json!("left"), &json!(0)));
    let after_mm = trim["data"]["trim"]["length_after_mm"].as_f64().unwrap();
    assert!((after_mm - 65.0).abs() < 1.0, "{trim}");
    assert_eq!(of("SETPOINT_FAILED")["data"]["setpoint"]["rejection"], "OUT_OF_RANGE");
    assert_eq!(of("COMPENSATION_ENDED")["data"]["compensation"]["end_reason"], "SETPOINT_FAILED");
    let (raised, cleared) = (of("ALARM_RAISED"), of("ALARM_CLEARED"));
    for name in ["fleet", "robot", "array", "whisker", "alarm"] {
        assert_eq!(raised["data"][name], cleared["data"][name], "{name}");
    }
    // The answer to the last event is noted after it.
    until_true("all events are noted as delivered", async || {
        let state = shown(&service, webhook_id).await;
        state["waiting"] == json!(0) && state["delivered"] == json!(receiver.requests().len())
    })
    .await;
    let state = shown(&service, webhook_id).await;
    assert_eq!((&state["state"], &state["last_status"]), (&json!("WORKING"), &json!(204)));
    service.stop().await;
}

/// Each event was sent once, and no effect before its cause.
fn in_order(requests: &[Request]) {
    let ids: Vec<i64> = requests.iter().map(Request::event_id).collect();
    let mut once = ids.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), ids.len(), "{ids:?}");
    let at = |kind: &str| requests.iter().position(|one| one.kind() == kind).unwrap();
    let kinds = ["TRIM", "COMPENSATION_BEGUN", "SETPOINT_FAILED", "ALARM_CLEARED"].map(at);
    assert!(kinds.is_sorted(), "{:?}", requests.iter().map(Request::kind).collect::<Vec<_>>());
    let times: Vec<String> = requests.iter().map(|one| one.json()["timestamp"].to_string()).collect();
    assert!(times.is_sorted(), "{times:?}");
}

#[tokio::test]
async fn a_robots_story_arrives_signed_and_in_order_from_sqlite() {
    a_robots_story(Stage::sqlite().await).await;
}

#[tokio::test]
async fn a_robots_story_arrives_signed_and_in_order_from_postgresql() {
    a_robots_story(Stage::postgres().await).await;
}

#[tokio::test]
async fn a_webhook_gets_what_its_filters_name_and_nothing_from_before() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let mut raw = stage.raw().await;
    raw.trim(1).await;
    let alarm = |kind: &str| {
        // Old events are removed at the start.
        let now_us = vibrissa_edge::clock::wall_clock().0;
        format!(
            "INSERT INTO events (recorded_us, version, kind, audience, word, fleet, robot_id, whisker_id, data) \
             SELECT {now_us}, 2, 'ALARM_RAISED', 'PEOPLE', '{kind}', 'f', robot_id, whisker_id, '{{}}' FROM whiskers \
             ORDER BY whisker_id LIMIT 1"
        )
    };
    let url = receiver.url();
    let create = async |name: &str, more: Value| {
        let mut body = json!({ "name": name, "url": format!("{url}&{name}") });
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        assert_eq!(call(&service, "POST", "/v1/webhooks", Some(body)).await.status, 201);
    };
    create("all", json!({})).await;
    create("trims", json!({ "kinds": ["TRIM"] })).await;
    create("critical", json!({ "level": "CRITICAL" })).await;
    create("elsewhere", json!({ "fleets": ["g"] })).await;
    create("both", json!({ "fleets": ["g", "f"], "kinds": ["ALARM_RAISED"], "level": "URGENT" })).await;
    for kind in ["ERODING", "LEAK", "SETPOINT_FAILED"] {
        raw.run(&alarm(kind)).await;
    }
    raw.trim(2).await;
    let got = |name: &str| -> Vec<String> {
        let requests = receiver.requests();
        let of = requests.iter().filter(|one| one.path.ends_with(&format!("&{name}"))).map(Request::json);
        of.map(|event| event["data"]["alarm"]["kind"].as_str().unwrap_or("TRIM").to_owned()).collect()
    };
    until_true("all events", async || receiver.requests().len() >= 8).await;
    assert_eq!(got("all"), ["ERODING", "LEAK", "SETPOINT_FAILED", "TRIM"]);
    assert_eq!(got("trims"), ["TRIM"]);
    assert_eq!(got("critical"), ["SETPOINT_FAILED"]);
    assert_eq!(got("both"), ["LEAK", "SETPOINT_FAILED"]);
    assert_eq!(got("elsewhere"), Vec::<String>::new());
    service.stop().await;
}
