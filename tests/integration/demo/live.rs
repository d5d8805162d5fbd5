//! The demo that goes on touching, with commands on standard input and over HTTP.

use serde_json::{Value, json};
use vibrissa_tests::demo::LiveDemo;
use vibrissa_tests::web::{ask, send, try_get};

const PROGRAM: &str = env!("CARGO_BIN_EXE_lab-under-test");
const OF_WHISKER: &str = "robot=crawler-1&array=left";

#[tokio::test(flavor = "multi_thread")]
async fn paper_a_typed_cut_is_called_and_compensated_and_a_replaced_whisker_is_learned_again() {
    let mut demo = LiveDemo::start(PROGRAM).await;
    demo.prints("cut 5 whisker 2").await;
    demo.type_line("chop 5 whisker 2");
    demo.prints("not understood: \"chop\" is no command: type cut, erode, leak, heat, replace, help or quit").await;
    demo.type_line("cut 50 whisker 2");
    demo.prints("not done: crawler-1/left/2 is 70.0 mm long: cut more than 0 and at most 30.0 mm, not 50").await;
    demo.type_line("leak 7");
    demo.prints(
        "not done: there is no whisker crawler-1/left/7; there are crawler-1/left/0 to 5, crawler-1/tail/0, crawler-2/nose/0 to 2",
    )
    .await;
    demo.type_line("cut 5 whisker 2");
    demo.prints("crawler-1/left/2 is cut by 5 mm to 65.0 mm").await;
    demo.type_line("cut 22 crawler-1/tail/0");

    let trim = demo.item(&format!("/v1/trims?{OF_WHISKER}&whisker=2"), |_| true).await;
    let length_mm = trim["length_after_mm"].as_f64().unwrap();
    assert!((length_mm - 65.0).abs() < 1.5, "{trim}");
    let uncompensated = |one: &Value| one["array"] == "tail" && one["kind"] == "UNCOMPENSATED";
    let alarm = demo.item("/v1/alarms?robot=crawler-1", uncompensated).await;
    assert!(alarm["hint"].as_str().is_some_and(|hint| !hint.is_empty()), "{alarm}");
    let applied = |one: &Value| one["setpoint_state"] == "APPLIED";
    let decision = demo.item(&format!("/v1/compensations?{OF_WHISKER}&target_whisker=2"), applied).await;
    assert!(!decision["compensator_whisker"].is_null(), "{decision}");
    demo.prints(" s  crawler-1/left/2: trimmed").await;
    demo.prints("crawler-1/tail/0: alarm, trimmed, not compensated. Do not rely on").await;

    demo.type_line("replace crawler-1/left/2");
    demo.prints("crawler-1/left/2 is new, and reported as replaced").await;
    let learning = |one: &Value| one["whisker"] == 2 && one["condition"] == "LEARNING";
    demo.item(&format!("/v1/whiskers?{OF_WHISKER}"), learning).await;
    let ended = |one: &Value| one["end_reason"] == "REPLACED";
    demo.item(&format!("/v1/compensations?{OF_WHISKER}&target_whisker=2"), ended).await;

    names_of_the_log_resolve(&demo).await;

    demo.close_input();
    let counted = async || ask(demo.http, "GET", "/metrics", &[]).await.unwrap().status;
    assert_eq!(counted().await, 200, "without standard input it serves on");
    demo.interrupt();
    assert!(demo.ended().await.success());
}

/// Fields of the log that name a robot or a whisker.
const NAMING: [&str; 4] = ["robot", "whisker", "by", "subject"];

/// Each name in the log is the path of a robot or of a whisker in REST, and the log has told the story so far.
async fn names_of_the_log_resolve(demo: &LiveDemo) {
    let log = demo.log();
    let mut names = std::collections::BTreeSet::new();
    for line in &log {
        for (field, value) in line.split_whitespace().filter_map(|word| word.split_once('=')) {
            if NAMING.contains(&field) {
                names.insert(value.to_owned());
            }
        }
    }
    for name in &names {
        let path = match name.split('/').collect::<Vec<_>>()[..] {
            [fleet, robot] => format!("/v1/fleets/{fleet}/robots/{robot}"),
            [fleet, robot, array, whisker] => {
                format!("/v1/fleets/{fleet}/robots/{robot}/arrays/{array}/whiskers/{whisker}")
            }
            _ => panic!("{name} is no name of a robot or a whisker"),
        };
        assert_eq!(ask(demo.http, "GET", &path, &[]).await.unwrap().status, 200, "{path}");
    }
    let fleet = names.iter().find_map(|name| name.split_once('/')).unwrap().0;
    for expected in [
        format!("new robot registered robot={fleet}/crawler-1"),
        format!("are left of 70.0 mm whisker={fleet}/crawler-1/left/2"),
        format!(" whisker={fleet}/crawler-1/left/2 by={fleet}/crawler-1/left/"),
        "compensation begins: ".to_owned(),
        "setpoint sent: ".to_owned(),
        format!("setpoint applied whisker={fleet}/crawler-1/left/"),
        format!("whisker={fleet}/crawler-1/tail/0 alarm=\"UNCOMPENSATED\""),
        format!("subject={fleet}/crawler-1/left/2"),
    ] {
        assert!(log.iter().any(|line| line.contains(&expected)), "{expected}\n{}", log.join("\n"));
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn incidents_over_http_are_checked_and_described() {
    let mut demo = LiveDemo::start(PROGRAM).await;
    let incident = |kind: &str, more: Value| {
        let mut body = json!({ "robot": "crawler-2", "array": "nose", "whisker": 0, "kind": kind });
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        body
    };
    let cause = async |headers: &[(&str, &str)], body: &Value| {
        let answer = send(demo.http, "POST", "/demo/incidents", headers, Some(body)).await.unwrap();
        (answer.status, answer.json())
    };
    let (status, happened) = cause(&[], &incident("HEAT", json!({ "by_k": 10.0 }))).await;
    assert_eq!(status, 200, "{happened}");
    assert!(happened["told"].as_str().unwrap().contains("crawler-2/nose have 34.0"), "{happened}");
    for (body, expected, field) in [
        (incident("CUT", json!({})), 422, Some("by_mm")),
        (incident("CUT", json!({ "by_mm": -1 })), 422, Some("by_mm")),
        (incident("LEAK", json!({ "by_k": 1 })), 422, Some("by_k")),
        (incident("HEAT", json!({ "by_k": 1000 })), 422, Some("by_k")),
        (incident("BURN", json!({})), 422, Some("kind")),
        (incident("LEAK", json!({ "whisker": 9 })), 404, None),
    ] {
        let (status, problem) = cause(&[], &body).await;
        assert_eq!(status, expected, "{body}: {problem}");
        assert_eq!(problem["errors"][0]["field"].as_str(), field, "{body}: {problem}");
    }
    let (status, problem) = cause(&[("Origin", "http://elsewhere.example")], &incident("LEAK", json!({}))).await;
    assert_eq!(status, 403, "{problem}");
    let (_, document) = try_get(demo.http, "/openapi.json").await.unwrap();
    let document: Value = serde_json::from_str(&document).unwrap();
    assert_eq!(document["paths"]["/demo/incidents"]["post"]["x-required-role"], "ADMIN");
    demo.type_line("quit");
    assert!(demo.ended().await.success());
}
