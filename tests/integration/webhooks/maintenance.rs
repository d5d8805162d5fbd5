//! Windows of maintenance: alarms in them are shelved and notify nobody, and those that stand at the end are told.

use serde_json::{Value, json};
use vibrissa_edge::clock::wall_clock;
use vibrissa_store::time::Time;
use vibrissa_supervisor::service::Service;
use vibrissa_tests::wait::until_true;

use crate::receiver::{Manner, Receiver};
use crate::stage::{FAST, Raw, Stage, call, hook};

const HOUR_US: i64 = 3_600_000_000;

/// A time so many hours from now.
fn in_hours(hours: i64) -> String {
    Time(wall_clock().0 as i64 + hours * HOUR_US).to_string()
}

/// Raises an alarm about the robot's first whisker, as a supervisor would.
async fn raise(raw: &mut Raw) {
    let now_us = wall_clock().0;
    let whisker = "FROM whiskers ORDER BY whisker_id LIMIT 1";
    let alarm =
        format!("INSERT INTO alarms (whisker_id, raised_us, kind) SELECT whisker_id, {now_us}, 'LEAK' {whisker}");
    let event = format!(
        "INSERT INTO events (recorded_us, version, kind, audience, word, fleet, robot_id, whisker_id, data) \
         SELECT {now_us}, 2, 'ALARM_RAISED', 'PEOPLE', 'LEAK', 'f', robot_id, whisker_id, '{{}}' {whisker}"
    );
    assert_eq!(raw.run(&alarm).await + raw.run(&event).await, 2);
}

/// Types of the received events: trims, and alarms about the leak.
fn got(receiver: &Receiver) -> Vec<String> {
    let events = receiver.requests().into_iter().map(|request| request.json());
    let events = events.filter(|event| event["type"] == "TRIM" || event["data"]["alarm"]["kind"] == "LEAK");
    events.map(|event| event["type"].as_str().unwrap().to_owned()).collect()
}

async fn leak(service: &Service) -> Value {
    let answer = call(service, "GET", "/v1/alarms?fleet=f&kind=LEAK", None).await;
    assert_eq!(answer.status, 200, "{}", answer.body);
    answer.json()["items"][0].clone()
}

async fn a_maintenance_shelves_and_then_tells(stage: Stage) {
    let receiver = Receiver::start(Manner::Status(204)).await;
    let service = stage.supervisor("a", FAST).await;
    let _robot = stage.robot().await;
    hook(&service, &receiver, json!({ "kinds": ["ALARM_RAISED", "TRIM"] })).await;
    let body = json!({ "fleet": "f", "robot": "r", "until": in_hours(2), "reason": "new belts" });
    let answer = call(&service, "POST", "/v1/maintenance", Some(body)).await;
    assert_eq!(answer.status, 201, "{}", answer.body);
    let window = answer.json();
    assert_eq!((&window["state"], &window["robot"]), (&json!("ACTIVE"), &json!("r")));

    let mut raw = stage.raw().await;
    raise(&mut raw).await;
    raw.trim(1).await;
    until_true("the event after the alarm", async || !got(&receiver).is_empty()).await;
    assert_eq!(got(&receiver), ["TRIM"]);
    let alarm = leak(&service).await;
    assert_eq!((&alarm["state"], &alarm["shelved_reason"]), (&json!("SHELVED"), &json!("new belts")), "{alarm}");
    assert_eq!((&alarm["maintenance_id"], &alarm["shelved_until"]), (&window["maintenance_id"], &window["ends_at"]));
    let robots = call(&service, "GET", "/v1/robots?fleet=f", None).await.json();
    assert_eq!(robots["items"][0]["alarms_shelved"], json!(1), "{robots}");

    let path = format!("/v1/maintenance/{}/end", window["maintenance_id"]);
    let ended = call(&service, "POST", &path, None).await;
    assert_eq!((ended.status, ended.json()["kind"].clone()), (200, json!("MAINTENANCE_END")), "{}", ended.body);
    until_true("the alarm is told", async || got(&receiver).len() >= 2).await;
    assert_eq!(got(&receiver), ["TRIM", "ALARM_RAISED"]);
    let alarm = leak(&service).await;
    assert_eq!((&alarm["state"], &alarm["maintenance_id"]), (&json!("UNACKNOWLEDGED"), &json!(null)), "{alarm}");
    raise(&mut raw).await;
    until_true("a later alarm", async || got(&receiver).len() >= 3).await;
    service.stop().await;
}

#[tokio::test]
async fn a_maintenance_shelves_and_then_tells_on_sqlite() {
    a_maintenance_shelves_and_then_tells(Stage::sqlite().await).await;
}

#[tokio::test]
async fn a_maintenance_shelves_and_then_tells_on_postgresql() {
    a_maintenance_shelves_and_then_tells(Stage::postgres().await).await;
}

/// The end of the first window fell into the second one, and nobody was told at the end of that.
#[tokio::test]
async fn regress_an_alarm_from_before_an_overlapping_maintenance_is_told_at_its_end() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(204)).await;
    let service = stage.supervisor("a", FAST).await;
    let _robot = stage.robot().await;
    hook(&service, &receiver, json!({ "kinds": ["ALARM_RAISED", "TRIM"] })).await;
    let set = async |hours: i64| {
        let body = json!({ "fleet": "f", "until": in_hours(hours), "reason": "new belts" });
        let answer = call(&service, "POST", "/v1/maintenance", Some(body)).await;
        assert_eq!(answer.status, 201, "{}", answer.body);
        answer.json()["maintenance_id"].as_i64().unwrap()
    };
    let end = async |id: i64| {
        let ended = call(&service, "POST", &format!("/v1/maintenance/{id}/end"), None).await;
        assert_eq!(ended.status, 200, "{}", ended.body);
    };
    let mut raw = stage.raw().await;
    let first = set(2).await;
    raise(&mut raw).await;
    let second = set(4).await;
    end(first).await;
    let told = format!("SELECT count(*) FROM maintenance WHERE maintenance_id = {first} AND told_us = ended_us");
    until_true("the end of the first one", async || raw.number(&told).await == 1).await;
    raw.trim(1).await;
    until_true("the event after it", async || !got(&receiver).is_empty()).await;
    assert_eq!(got(&receiver), ["TRIM"], "the second one keeps it");
    end(second).await;
    until_true("the alarm is told", async || got(&receiver).len() >= 2).await;
    assert_eq!(got(&receiver), ["TRIM", "ALARM_RAISED"]);
    service.stop().await;
}

#[tokio::test]
async fn a_planned_or_foreign_maintenance_shelves_nothing_and_a_wrong_one_is_refused() {
    let stage = Stage::sqlite().await;
    let service = stage.supervisor("a", FAST).await;
    let _robot = stage.robot().await;
    raise(&mut stage.raw().await).await;
    let set = async |more: Value| {
        let mut body = json!({ "fleet": "f", "until": in_hours(2), "reason": "x" });
        body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        call(&service, "POST", "/v1/maintenance", Some(body)).await
    };
    let weekly = set(json!({ "from": in_hours(1), "repeats": "WEEKLY" })).await.json();
    assert_eq!((&weekly["state"], &weekly["repeats"]), (&json!("PLANNED"), &json!("WEEKLY")), "{weekly}");
    assert_eq!(set(json!({ "fleet": "g" })).await.status, 404, "there is no such fleet");
    assert_eq!(leak(&service).await["state"], json!("UNACKNOWLEDGED"));
    assert_eq!(set(json!({})).await.status, 201);
    assert_eq!(leak(&service).await["state"], json!("SHELVED"));
    for (more, status, part) in [
        (json!({ "robot": "nobody" }), 404, "robot nobody"),
        (json!({ "until": in_hours(-1) }), 422, "until"),
        (json!({ "from": in_hours(3) }), 422, "until"),
        (json!({ "from": in_hours(1), "until": in_hours(26), "repeats": "DAILY" }), 422, "until"),
        (json!({ "reason": " " }), 422, "reason"),
    ] {
        let answer = set(more.clone()).await;
        assert!(answer.status == status && answer.body.contains(part), "{more}: {} {}", answer.status, answer.body);
    }
    assert_eq!(call(&service, "POST", "/v1/maintenance/999/end", None).await.status, 404);
    let items = call(&service, "GET", "/v1/maintenance", None).await.json()["items"].as_array().unwrap().len();
    assert_eq!(items, 2, "those that were refused are not there");
    service.stop().await;
}
