//! Operator actions over HTTP, from the request to the robot and the audit log.

use serde_json::{Value, json};
use vibrissa_core::policy::{LongerForShorter, PolicyParams};
use vibrissa_core::units::Megapascal;
use vibrissa_protocol::{ArrayType, SetpointOutcome, SetpointReason};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{Answer, Events, ServerEvent, open, send};

use crate::running::{LEARNED, Running};

const WHISKER: &str = "/v1/fleets/f/robots/r/arrays/left/whiskers";

/// A robot with two whiskers whose baselines are learned.
async fn learned(running: &Running) -> HandRobot {
    learned_in(running, ArrayType::Type1).await
}

async fn learned_in(running: &Running, kind: ArrayType) -> HandRobot {
    let mut robot = HandRobot::born(running.port(), "r", array(kind, &[70.0, 65.0])).await;
    for whisker in [0, 1] {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.receipted().await;
    robot
}

async fn ask(running: &Running, method: &str, path: &str, headers: &[(&str, &str)], body: Option<Value>) -> Answer {
    send(running.service.http, method, path, headers, body.as_ref()).await.unwrap()
}

async fn post(running: &Running, path: &str, body: Value) -> (u16, Value) {
    let answer = ask(running, "POST", path, &[], Some(body)).await;
    (answer.status, answer.json())
}

async fn get(running: &Running, path: &str) -> Value {
    let answer = ask(running, "GET", path, &[], None).await;
    assert_eq!(answer.status, 200, "{path}: {}", answer.body);
    answer.json()
}

#[tokio::test]
async fn a_pressure_by_hand_reaches_the_robot_and_the_audit_log_says_who_and_why() {
    let running = Running::start().await;
    let mut robot = learned(&running).await;
    let body = json!({ "pressure_mpa": 0.05, "reason": "too soft for glass" });
    let headers = [("Idempotency-Key", "k1"), ("X-Request-Id", "q1")];
    let first = ask(&running, "POST", &format!("{WHISKER}/1/setpoint"), &headers, Some(body.clone())).await;
    assert_eq!((first.status, first.json()["state"].as_str()), (200, Some("DONE")), "{}", first.body);
    let (setpoint, _) = robot.setpoint().await;
    assert_eq!((setpoint.whisker, setpoint.pressure_mpa, setpoint.reason), (1, 0.05, SetpointReason::Operator));
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    // Until the answer is taken, the supervisor may send the setpoint again.
    until_true("the setpoint is applied", async || {
        get(&running, &format!("/v1/setpoints/{}", setpoint.command_id)).await["state"] == "APPLIED"
    })
    .await;
    // Sending the same key again returns the same action; with other content it is refused.
    let again = ask(&running, "POST", &format!("{WHISKER}/1/setpoint"), &headers, Some(body)).await;
    assert_eq!((again.status, &again.json()["action_id"]), (200, &first.json()["action_id"]));
    let path = format!("{WHISKER}/1/setpoint");
    let other = ask(&running, "POST", &path, &headers, Some(json!({ "pressure_mpa": 0.06 }))).await;
    assert_eq!((other.status, &other.json()["type"]), (409, &json!("/problems/key-reused")));
    let audit = get(&running, "/v1/audit").await;
    let entry = &audit["items"][0];
    assert_eq!((audit["items"].as_array().unwrap().len(), &entry["kind"]), (1, &json!("SETPOINT")));
    assert_eq!(
        [&entry["actor"], &entry["reason"], &entry["request_id"]],
        [&json!("local"), &json!("too soft for glass"), &json!("q1")]
    );
    assert_eq!(first.headers["location"], format!("/v1/actions/{}", entry["action_id"]));
    assert_eq!(get(&running, &first.headers["location"]).await, *entry);
    assert_eq!(get(&running, &format!("{WHISKER}/1")).await["held"], true);
    let (status, problem) = post(&running, &format!("{WHISKER}/1/setpoint"), json!({ "pressure_mpa": 0.3 })).await;
    assert_eq!((status, &problem["errors"][0]["field"]), (422, &json!("pressure_mpa")), "{problem}");
    assert_eq!(post(&running, &format!("{WHISKER}/9/hold"), json!({})).await.0, 404);
    assert_eq!(post(&running, "/v1/fleets/f/robots/nobody/hold", json!({})).await.0, 404);
    assert!(robot.setpoints_left().is_empty());
    assert_eq!(post(&running, &format!("{WHISKER}/1/release"), json!({})).await.0, 200);
    let (release, _) = robot.setpoint().await;
    assert_eq!((release.whisker, release.reason), (1, SetpointReason::Release));
    running.service.stop().await;
}

#[tokio::test]
async fn a_policy_is_changed_by_those_who_have_read_it() {
    let running = Running::start().await;
    let _robot = learned(&running).await;
    let path = "/v1/fleets/f/policy";
    let read = ask(&running, "GET", path, &[], None).await;
    assert_eq!((read.headers["etag"].as_str(), &read.json()["mode"]), ("\"0\"", &json!("AUTOMATIC")));
    let policy = |mode: &str| {
        let set = PolicyParams {
            longer_for_shorter: LongerForShorter::Never,
            predicted_error_max: 0.4,
            ..PolicyParams::default()
        };
        let mut body = policy_body(&set);
        (body["mode"], body["reason"]) = (json!(mode), json!("first week"));
        body
    };
    let put = async |tag: Option<&str>, policy: Value| {
        let headers: Vec<(&str, &str)> = tag.iter().map(|tag| ("If-Match", *tag)).collect();
        ask(&running, "PUT", path, &headers, Some(policy)).await
    };
    assert_eq!(put(None, policy("ADVISE")).await.status, 428);
    assert_eq!(put(Some("\"7\""), policy("ADVISE")).await.status, 412);
    assert_eq!(put(Some("\"0\""), json!({ "mode": "ADVISE" })).await.status, 422);
    let done = put(Some("\"0\""), policy("ADVISE")).await;
    assert_eq!(done.status, 200, "{}", done.body);
    assert_eq!(put(Some("\"0\""), policy("AUTOMATIC")).await.status, 412, "version 1 is in force");
    let now = ask(&running, "GET", path, &[], None).await;
    assert_eq!((now.headers["etag"].as_str(), &now.json()["predicted_error_max"]), ("\"1\"", &json!(0.4)));
    assert_eq!(put(Some("*"), policy("AUTOMATIC")).await.status, 200);
    // A repeated request is the first one, although that has changed the version.
    let once = async || {
        let headers = [("If-Match", "\"2\""), ("Idempotency-Key", "k")];
        ask(&running, "PUT", path, &headers, Some(policy("ADVISE"))).await
    };
    let (first, again) = (once().await, once().await);
    assert_eq!((first.status, again.status), (200, 200), "{}", again.body);
    assert_eq!(first.json()["action_id"], again.json()["action_id"]);
    let history = get(&running, "/v1/fleets/f/policy/history").await;
    let modes: Vec<&Value> = history["items"].as_array().unwrap().iter().map(|one| &one["mode"]).collect();
    assert_eq!(modes, ["ADVISE", "AUTOMATIC", "ADVISE"]);
    assert_eq!(history["items"][2]["reason"], "first week");
    assert_eq!(ask(&running, "GET", "/v1/fleets/nobody/policy", &[], None).await.status, 404);
    running.service.stop().await;
}

/// The next event of this kind.
async fn event(events: &mut Events, kind: &str) -> (ServerEvent, Value) {
    loop {
        let event = events.next().await.unwrap().expect("the stream must continue");
        let data: Value = serde_json::from_str(&event.data).unwrap();
        if data["type"] == kind {
            return (event, data);
        }
    }
}

#[tokio::test]
async fn what_happens_is_followed_and_taken_up_again_where_it_was_left() {
    let running = Running::start().await;
    let mut robot = learned(&running).await;
    let (status, mut live) = open(running.service.http, "/v1/events", &[]).await.unwrap();
    assert_eq!(status, 200);
    let (_, mut elsewhere) = open(running.service.http, "/v1/events?fleet=another", &[]).await.unwrap();
    robot.cut(0, 54.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    let (trimmed, data) = event(&mut live, "TRIM").await;
    let data = &data["data"];
    assert_eq!([&data["fleet"], &data["robot"], &data["array"]], [&json!("f"), &json!("r"), &json!("left")]);
    assert_eq!((&data["whisker"], trimmed.event.as_str()), (&json!(0), "change"));
    let (_, decided) = event(&mut live, "DECISION").await;
    let (setpoint, sent) = event(&mut live, "SETPOINT").await;
    let of_decision = &decided["data"]["decision"]["compensation_id"];
    assert!(sent["data"]["setpoint"]["command_id"].is_string() && of_decision.is_i64(), "{sent} {decided}");
    // A stream that resumes after the trim repeats exactly the later events.
    let (_, mut again) = open(running.service.http, "/v1/events", &[("Last-Event-ID", &trimmed.id)]).await.unwrap();
    let mut seen = Vec::new();
    while seen.last() != Some(&setpoint.id) {
        seen.push(again.next().await.unwrap().unwrap().id);
    }
    assert!(!seen.contains(&trimmed.id));
    let (_, mut lost) = open(running.service.http, "/v1/events", &[("Last-Event-ID", "9.999999")]).await.unwrap();
    assert_eq!(lost.next().await.unwrap().unwrap().event, "reset");
    let bad = ask(&running, "GET", "/v1/events", &[("Last-Event-ID", "yesterday")], None).await;
    assert_eq!(bad.status, 422, "{}", bad.body);
    running.service.stop().await;
    assert_eq!(
        elsewhere.next().await.unwrap(),
        None,
        "no event of another fleet, and the end of the stream with the service"
    );
}

#[tokio::test]
async fn alarms_are_acknowledged_and_shelved_with_who_and_why() {
    let running = Running::start().await;
    let mut robot = learned_in(&running, ArrayType::Type2).await;
    // In this type of array a whisker can only compensate itself, and this one is then too short for that.
    robot.cut(0, 40.0);
    robot.touch(0, 120).await;
    robot.receipted().await;
    let standing = get(&running, "/v1/alarms?standing=true").await;
    let alarm = &standing["items"][0];
    assert_eq!(alarm["state"], "UNACKNOWLEDGED", "{standing}");
    let path = format!("/v1/alarms/{}", alarm["alarm_id"]);
    let (status, action) = post(&running, &format!("{path}/acknowledge"), json!({ "reason": "on my way" })).await;
    assert_eq!((status, &action["kind"]), (200, &json!("ALARM_ACKNOWLEDGE")));
    assert_eq!(post(&running, &format!("{path}/acknowledge"), json!({})).await.0, 409, "once");
    assert_eq!(post(&running, &format!("{path}/unshelve"), json!({})).await.0, 409, "the alarm is not shelved");
    // The console sends a key with each request.
    for (one, key) in [("acknowledge", "a"), ("unshelve", "b")] {
        let headers = [("Idempotency-Key", key)];
        let answer = ask(&running, "POST", &format!("{path}/{one}"), &headers, Some(json!({}))).await;
        assert_eq!(answer.status, 409, "{one}: {}", answer.body);
    }
    let shelf = |until: &str| json!({ "until": until, "reason": "spare part on its way" });
    assert_eq!(post(&running, &format!("{path}/shelve"), shelf("2020-01-01T00:00:00Z")).await.0, 422);
    let until = vibrissa_protocol::Timestamp(vibrissa_simulator::clock::now_us() + 3_600_000_000).to_string();
    assert_eq!(post(&running, &format!("{path}/shelve"), shelf(&until)).await.0, 200);
    let now = get(&running, &format!("/v1/alarms?kind={}", alarm["kind"].as_str().unwrap())).await;
    let now = &now["items"][0];
    assert_eq!([&now["state"], &now["shelved_until"]], [&json!("SHELVED"), &json!(until)]);
    assert_eq!([&now["acknowledged_by"], &now["acknowledged_reason"]], [&json!("local"), &json!("on my way")]);
    assert_eq!(post(&running, &format!("{path}/unshelve"), json!({})).await.0, 200);
    let acknowledged = get(&running, "/v1/alarms?state=ACKNOWLEDGED").await;
    assert_eq!(acknowledged["items"][0]["alarm_id"], alarm["alarm_id"]);
    let kinds: Vec<Value> =
        get(&running, "/v1/audit").await["items"].as_array().unwrap().iter().map(|one| one["kind"].clone()).collect();
    assert_eq!(kinds, ["ALARM_UNSHELVE", "ALARM_SHELVE", "ALARM_ACKNOWLEDGE"]);
    running.service.stop().await;
}

#[tokio::test]
async fn golden_measurements_become_a_calibration_that_a_fleet_works_with() {
    let running = Running::start().await;
    let mut robot = learned(&running).await;
    let before = get(&running, &format!("{WHISKER}/0")).await;
    assert_eq!(before["condition"], "HEALTHY", "{before}");
    // The strains of the paper's own model at these pressures, so the fit must find its parameters.
    let model = vibrissa_core::mechanics::Model::nguyen_2021(vibrissa_core::mechanics::Formulation::Published);
    let truth = *model.calibration();
    let row = |pressure_mpa: f64| {
        let k2 = truth.c + truth.a * (-truth.b_per_mpa * pressure_mpa).exp();
        json!({ "pressure_mpa": pressure_mpa, "strain": model.axial_strain(Megapascal::new(pressure_mpa).unwrap()).ratio(),
                "elongation_mm": truth.elongation_gain_mm * pressure_mpa / (k2 * truth.youngs_modulus_mpa) })
    };
    let rows: Vec<Value> = [0.02, 0.05, 0.08, 0.12, 0.16, 0.2].into_iter().map(row).collect();
    let body = json!({ "model": "nguyen-2021", "youngs_modulus_mpa": truth.youngs_modulus_mpa, "rows": rows });
    let (status, kept) = post(&running, "/v1/calibrations", body.clone()).await;
    assert_eq!((status, &kept["version"]), (201, &json!(1)), "{kept}");
    for (name, value) in [("c", truth.c), ("a", truth.a), ("b_per_mpa", truth.b_per_mpa)] {
        let found = kept["fit"][name]["value"].as_f64().unwrap();
        assert!((found / value - 1.0).abs() < 1e-6, "{name}: {found} {value}");
    }
    assert_eq!(kept["active_in"], Value::Null);
    let mut short = body;
    short["rows"].as_array_mut().unwrap().truncate(2);
    assert_eq!(post(&running, "/v1/calibrations", short).await.1["errors"][0]["field"], "rows");
    let id = &kept["calibration_id"];
    let (status, done) = post(&running, &format!("/v1/fleets/f/calibrations/{id}/activate"), json!({})).await;
    assert_eq!(status, 200, "{done}");
    let listed = get(&running, "/v1/calibrations?model=nguyen-2021").await;
    assert_eq!(listed["items"][0]["active_in"], "f");
    assert_eq!(
        get(&running, &format!("{WHISKER}/0")).await["condition"],
        "LEARNING",
        "a new calibration must restart learning"
    );
    robot.touch(0, LEARNED + 20).await;
    robot.receipted().await;
    // The next owner of the fleet uses it, too.
    let running = running.again(crate::running::quick(), None).await;
    assert_eq!(get(&running, "/v1/calibrations").await["items"][0]["active_in"], "f");
    running.service.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn the_command_line_shows_and_does_the_same() {
    let running = Running::start().await;
    let mut robot = learned(&running).await;
    let url = format!("http://{}", running.service.http);
    let run = async |arguments: &[&str]| {
        let mut command = tokio::process::Command::new(crate::program::PROGRAM);
        let output = command.args(arguments).env("VIBRISSA_URL", &url).kill_on_drop(true).output().await.unwrap();
        let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        (output.status.success(), out, err)
    };
    let (_, table, _) = run(&["whiskers", "--fleet", "f"]).await;
    assert!(table.lines().count() == 3 && table.contains("f/r/left/1") && table.contains("HEALTHY"), "{table}");
    let (_, lines, _) = run(&["whiskers", "--json"]).await;
    let rows: Vec<Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(rows, *get(&running, "/v1/whiskers").await["items"].as_array().unwrap());
    let (is_done, stdout, _) =
        run(&["setpoint", "f/r/left/1", "--pressure-mpa", "0.05", "--reason", "by hand", "--wait", "0"]).await;
    assert!(is_done && stdout.contains("SETPOINT DONE"), "{stdout}");
    assert_eq!(robot.setpoint().await.0.pressure_mpa, 0.05);
    let (is_done, _, problem) = run(&["setpoint", "f/r/left/1", "--pressure-mpa", "0.5"]).await;
    assert!(!is_done && problem.contains("0 to 0.2 MPa"), "{problem}");
    robot.cut(0, 64.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    let (_, table, _) = run(&["compensations", "--active"]).await;
    assert!(table.contains("f/r/left/0") && table.contains("SELF_COMPENSATION"), "{table}");
    running.service.stop().await;
}
