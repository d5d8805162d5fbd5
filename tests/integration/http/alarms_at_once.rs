//! Acknowledging and shelving of all alarms that meet conditions, on both databases.

use serde_json::{Value, json};
use vibrissa_tests::web::send;

use crate::alarms::storm;
use crate::served::Served;

async fn post(served: &Served, path: &str, headers: &[(&str, &str)], body: Value) -> (u16, Value) {
    let answer = send(served.http, "POST", path, headers, Some(&body)).await.unwrap();
    (answer.status, answer.json())
}

async fn in_state(served: &Served, state: &str) -> usize {
    served.items(&format!("/v1/alarms?fleet=h&state={state}&limit=1000")).await.len()
}

async fn all_shown_are_acknowledged_once_and_each_is_recorded(served: &Served) {
    storm(&served.store, 40, "ROBOT_SILENT", 1_000_000).await;
    let others = served.items("/v1/alarms?fleet=f&state=UNACKNOWLEDGED&limit=1000").await.len();
    let which = json!({ "filter": { "fleet": "h", "kind": "ROBOT_SILENT" } });
    let path = "/v1/alarms/acknowledge";
    // The dry run lists them, and changes nothing.
    let (status, answer) = post(served, path, &[], json!({ "which": which, "dry_run": true })).await;
    assert_eq!((status, &answer["alarms"], &answer["more"]), (200, &json!(40), &json!(false)), "{answer}");
    assert_eq!(answer["items"].as_array().unwrap().len(), 40);
    assert!(answer["items"][0]["hint"].is_string() && answer["action_id"].is_null());
    assert_eq!(in_state(served, "UNACKNOWLEDGED").await, 40);
    // An alarm that was raised after the dry run is left out.
    storm(&served.store, 1, "ROBOT_SILENT", 1).await;
    let which = json!({ "filter": which["filter"], "up_to_alarm_id": answer["newest_alarm_id"] });
    let body = json!({ "which": which, "reason": "a network fault" });
    let key = [("Idempotency-Key", "k1")];
    let (status, done) = post(served, path, &key, body.clone()).await;
    assert_eq!((status, &done["alarms"], &done["dry_run"]), (200, &json!(40), &json!(false)), "{done}");
    assert_eq!((in_state(served, "ACKNOWLEDGED").await, in_state(served, "UNACKNOWLEDGED").await), (40, 1));
    assert_eq!(served.items("/v1/alarms?fleet=f&state=UNACKNOWLEDGED&limit=1000").await.len(), others);
    // Again with the same key: the same answer, and nothing more.
    let (status, again) = post(served, path, &key, body).await;
    assert_eq!((status, &again["action_id"], &again["alarms"]), (200, &done["action_id"], &json!(40)));
    let each = served.items("/v1/audit?kind=ALARM_ACKNOWLEDGE&limit=1000").await;
    assert_eq!(each.len(), 40);
    for entry in &each {
        assert_eq!((&entry["reason"], &entry["fleet"]), (&json!("a network fault"), &json!("h")), "{entry}");
        assert!(entry["alarm_id"].is_number() && entry["robot"].is_string() && entry["array"].is_null());
    }
    assert_eq!(served.items("/v1/audit?kind=ALARMS_ACKNOWLEDGE").await.len(), 1);
}

#[tokio::test]
async fn all_shown_are_acknowledged_once_and_each_is_recorded_on_sqlite() {
    all_shown_are_acknowledged_once_and_each_is_recorded(&Served::sqlite().await).await;
}

#[tokio::test]
async fn all_shown_are_acknowledged_once_and_each_is_recorded_on_postgres() {
    all_shown_are_acknowledged_once_and_each_is_recorded(&Served::postgres().await).await;
}

#[tokio::test]
async fn all_shown_are_shelved_and_unshelved_about_robots_and_whiskers() {
    for served in [Served::sqlite().await, Served::postgres().await] {
        let standing = served.items("/v1/alarms?standing=true&limit=1000").await.len();
        let until = vibrissa_protocol::Timestamp(vibrissa_simulator::clock::now_us() + 3_600_000_000).to_string();
        let shelf = |until: &str, reason: &str| json!({ "until": until, "reason": reason });
        let path = "/v1/alarms/shelve";
        assert_eq!(post(&served, path, &[], shelf(&until, " ")).await.0, 422);
        assert_eq!(post(&served, path, &[], shelf("2020-01-01T00:00:00Z", "x")).await.0, 422);
        let (status, done) = post(&served, path, &[], shelf(&until, "a spare part is on its way")).await;
        assert_eq!((status, &done["alarms"]), (200, &json!(standing)), "{done}");
        assert_eq!(served.items("/v1/alarms/folded?open=true").await, Vec::<Value>::new());
        assert_eq!(served.items("/v1/alarms?state=SHELVED&limit=1000").await.len(), standing);
        for list in ["fleets", "robots", "arrays"] {
            assert!(served.items(&format!("/v1/{list}")).await.iter().all(|one| one["alarms"] == 0), "{list}");
        }
        // Shelved alarms still stand.
        let fleets = served.items("/v1/fleets").await;
        let shelved: i64 = fleets.iter().map(|fleet| fleet["alarms_shelved"].as_i64().unwrap()).sum();
        assert_eq!(shelved, standing as i64);
        let silent = served.items("/v1/robots?connection=SILENT").await;
        assert!(!silent.is_empty() && silent.iter().all(|robot| robot["alarms_shelved"].as_i64() > Some(0)));
        let (status, done) = post(&served, "/v1/alarms/unshelve", &[], json!({})).await;
        assert_eq!((status, &done["alarms"]), (200, &json!(standing)), "{done}");
        assert_eq!(served.items("/v1/alarms?state=UNACKNOWLEDGED&limit=1000").await.len(), standing);
    }
}

#[tokio::test]
async fn one_request_changes_at_most_a_thousand_alarms_and_says_that_there_are_more() {
    for served in [Served::sqlite().await, Served::postgres().await] {
        storm(&served.store, 1100, "ROBOT_SILENT", 1000).await;
        let body = json!({ "which": { "filter": { "fleet": "h" } } });
        for (alarms, more) in [(1000, true), (100, false), (0, false)] {
            let (status, done) = post(&served, "/v1/alarms/acknowledge", &[], body.clone()).await;
            assert_eq!((status, &done["alarms"], &done["more"]), (200, &json!(alarms), &json!(more)), "{done}");
        }
    }
}

#[tokio::test]
async fn conditions_that_do_not_exist_are_refused_and_change_nothing() {
    let served = Served::sqlite().await;
    for which in [json!({ "filter": { "robots": "r1" } }), json!({ "fleet": "f" }), json!({ "up_to_alarm_id": -1 })] {
        let (status, answer) = post(&served, "/v1/alarms/acknowledge", &[], json!({ "which": which })).await;
        assert_eq!(status, 422, "{answer}");
    }
    assert_eq!(served.items("/v1/alarms?state=ACKNOWLEDGED").await, Vec::<Value>::new());
}
