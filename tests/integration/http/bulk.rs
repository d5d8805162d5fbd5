//! Requests for many robots, whiskers and fleets: dry run, digest, entries, limits and stopping, on both databases. Nothing owns
//! the fleets here, so the actions stay pending.

use std::collections::BTreeSet;

use serde_json::{Value, json};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions as _, Connection as _, PgConnection};
use vibrissa_store::DatabaseAddress;
use vibrissa_supervisor::http::access::token::{NewToken, create};
use vibrissa_supervisor::http::access::{AccessOptions, Role, Scope};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::web::send;

use crate::served::Served;

async fn post(served: &Served, path: &str, headers: &[(&str, &str)], body: Value) -> (u16, Value) {
    let answer = send(served.http, "POST", path, headers, Some(&body)).await.unwrap();
    (answer.status, answer.json())
}

async fn progress(served: &Served, action_id: &Value) -> Value {
    served.json(&format!("/v1/bulk-actions/{action_id}")).await
}

async fn whiskers_are_listed_and_then_held_once(served: &Served) {
    let path = "/v1/whiskers/hold";
    let filter = json!({ "fleet": "f", "robot": "r1" });
    let (status, dry) = post(served, path, &[], json!({ "filter": filter, "dry_run": true })).await;
    let all = served.items("/v1/whiskers?fleet=f&robot=r1&held=false").await;
    assert_eq!((status, &dry["subjects"], &dry["more"]), (200, &json!(all.len()), &json!(false)), "{dry}");
    let names = |items: &Value| -> BTreeSet<(String, i64)> {
        let name = |one: &Value| (one["robot"].as_str().unwrap().to_owned(), one["whisker"].as_i64().unwrap());
        items.as_array().unwrap().iter().map(name).collect()
    };
    assert_eq!(names(&dry["items"]), names(&json!(all)));
    assert!(dry["action_id"].is_null());
    assert_eq!(served.items("/v1/bulk-actions").await, Vec::<Value>::new());
    // Other subjects than those of the dry run are refused.
    let others = json!({ "filter": { "fleet": "f" }, "digest": dry["digest"] });
    assert_eq!(post(served, path, &[], others).await.0, 412);
    let body = json!({ "filter": filter, "digest": dry["digest"], "reason": "a look", "per_second": 100 });
    let key = [("Idempotency-Key", "k1")];
    let (status, begun) = post(served, path, &key, body.clone()).await;
    assert_eq!((status, &begun["subjects"], &begun["items"]), (200, &json!(all.len()), &json!([])), "{begun}");
    let (status, again) = post(served, path, &key, body).await;
    assert_eq!((status, &again["action_id"]), (200, &begun["action_id"]));
    let (status, _) = post(served, path, &key, json!({ "filter": {} })).await;
    assert_eq!(status, 409, "the key belongs to another request");
    let detail = progress(served, &begun["action_id"]).await;
    let request = &detail["request"];
    assert_eq!((&request["kind"], &request["fleet"]), (&json!("WHISKERS_HOLD"), &json!("f")), "{detail}");
    assert_eq!((&request["subjects"], &request["pending"]), (&json!(all.len()), &json!(all.len())));
    assert_eq!((&request["parameters"]["which"], &request["reason"]), (&filter, &json!("a look")));
    let parts = served.items(&format!("/v1/audit?parent_id={}", begun["action_id"])).await;
    assert_eq!(names(&json!(parts)), names(&json!(all)));
    assert!(parts.iter().all(|one| one["kind"] == "HOLD" && one["state"] == "PENDING" && one["reason"] == "a look"));
    // Stopped, the rest is refused with the reason.
    let stop = format!("/v1/bulk-actions/{}/stop", begun["action_id"]);
    let (status, stopped) = post(served, &stop, &[], json!({ "reason": "enough" })).await;
    assert_eq!((status, &stopped["request"]["refused"]), (200, &json!(all.len())), "{stopped}");
    assert_eq!(stopped["refusals"], json!([{ "problem": "STOPPED: local stopped the rest", "subjects": all.len() }]));
    assert_eq!(served.items("/v1/audit?kind=BULK_STOP").await.len(), 1);
}

#[tokio::test]
async fn whiskers_are_listed_and_then_held_once_on_sqlite() {
    whiskers_are_listed_and_then_held_once(&Served::sqlite().await).await;
}

#[tokio::test]
async fn whiskers_are_listed_and_then_held_once_on_postgres() {
    whiskers_are_listed_and_then_held_once(&Served::postgres().await).await;
}

/// A release of whiskers fills those again that their robots have vented, whether an operator holds them or not.
#[tokio::test]
async fn regress_whiskers_that_are_vented_and_not_held_are_released_on_both_databases() {
    let vent = "UPDATE alarms SET kind = 'VENTED' WHERE alarm_id IN (SELECT max(alarm_id) FROM alarms WHERE kind = 'LEAK' \
                AND cleared_us IS NULL AND whisker_id IN (SELECT whisker_id FROM whiskers w JOIN robots USING (robot_id) \
                WHERE fleet = 'f' AND NOT w.held))";
    for served in [Served::sqlite().await, Served::postgres().await] {
        match (&served.url, &served.database) {
            (Some(url), _) => {
                let mut link = PgConnection::connect(url).await.unwrap();
                sqlx::query(vent).execute(&mut link).await.unwrap();
            }
            (None, DatabaseAddress::Sqlite(file)) => {
                let mut link = SqliteConnectOptions::new().filename(file).connect().await.unwrap();
                sqlx::query(vent).execute(&mut link).await.unwrap();
            }
            (None, other) => panic!("{other:?}"),
        }
        let alarms = served.items("/v1/alarms?kind=VENTED&standing=true").await;
        let vented = json!({ "fleet": "f", "vented": true });
        let (status, dry) =
            post(&served, "/v1/whiskers/release", &[], json!({ "filter": vented, "dry_run": true })).await;
        assert_eq!((status, &dry["subjects"], alarms.len()), (200, &json!(1), 1), "{dry}");
        for field in ["robot", "array", "whisker"] {
            assert_eq!(dry["items"][0][field], alarms[0][field]);
        }
        // Without the condition the held ones are released, too.
        let held = served.items("/v1/whiskers?held=true&vented=false").await.len();
        let (_, all) = post(&served, "/v1/whiskers/release", &[], json!({ "dry_run": true })).await;
        assert_eq!(all["subjects"], json!(held + 1), "{all}");
    }
}

#[tokio::test]
async fn robots_are_selected_by_label_and_many_waiting_actions_are_too_many() {
    let served = Served::sqlite().await;
    let label = json!({ "value": "2" });
    let set = send(served.http, "PUT", "/v1/fleets/g/robots/r2/labels/hall", &[], Some(&label)).await.unwrap();
    assert_eq!(set.status, 200);
    let (_, dry) =
        post(&served, "/v1/robots/hold", &[], json!({ "filter": { "label": "hall=2" }, "dry_run": true })).await;
    assert_eq!(dry["items"], json!([{ "fleet": "g", "robot": "r2", "array": null, "whisker": null }]));
    let (status, none) = post(&served, "/v1/robots/release", &[], json!({ "filter": { "label": "hall=2" } })).await;
    assert_eq!((status, &none["subjects"], &none["action_id"]), (200, &json!(0), &Value::Null), "it is not held");
    for body in [
        json!({ "per_second": 0 }),
        json!({ "per_second": 101 }),
        json!({ "filter": { "label": "Hall" } }),
        json!({ "digest": "" }),
        json!({ "digest": "0123456789ABCDEF0123456789abcdef", "dry_run": true }),
    ] {
        assert_eq!(post(&served, "/v1/robots/hold", &[], body.clone()).await.0, 422, "{body}");
    }
    // Twelve whiskers each time, and at most 2000 wait.
    let mut held = 0;
    let status = loop {
        let (status, answer) = post(&served, "/v1/whiskers/rebaseline", &[], json!({})).await;
        if status != 200 {
            break status;
        }
        assert_eq!(answer["subjects"], 12, "{answer}");
        held += 12;
        assert!(held <= 2000);
    };
    assert_eq!((status, held), (429, 1992));
}

#[tokio::test]
async fn policies_and_calibrations_are_set_in_the_fleets_that_have_such_robots() {
    for served in [Served::sqlite().await, Served::postgres().await] {
        let policy = policy_body(&vibrissa_core::policy::PolicyParams::default());
        let body = |extra: Value| {
            let mut body = json!({ "policy": policy });
            body.as_object_mut().unwrap().extend(extra.as_object().unwrap().clone());
            body
        };
        let (status, dry) = post(&served, "/v1/policies", &[], body(json!({ "dry_run": true }))).await;
        assert_eq!((status, &dry["subjects"]), (200, &json!(2)), "{dry}");
        let fleets: Vec<&str> =
            dry["items"].as_array().unwrap().iter().map(|one| one["fleet"].as_str().unwrap()).collect();
        assert_eq!(fleets, ["f", "g"]);
        let (status, begun) = post(&served, "/v1/policies", &[], body(json!({ "digest": dry["digest"] }))).await;
        assert_eq!(status, 200, "{begun}");
        let parts = served.items(&format!("/v1/audit?parent_id={}", begun["action_id"])).await;
        assert!(parts.iter().all(|one| one["kind"] == "POLICY" && one["parameters"]["expected_version"] == 0));
        assert_eq!((parts.len(), &parts[0]["robot"]), (2, &Value::Null));
        let mut bad = body(json!({}));
        bad["policy"]["own_role_cost"] = json!(-1);
        let (status, answer) = post(&served, "/v1/policies", &[], bad).await;
        assert_eq!((status, &answer["errors"][0]["field"]), (422, &json!("policy.own_role_cost")), "{answer}");
        assert_eq!(post(&served, "/v1/calibrations/7/activate", &[], json!({})).await.0, 404);
    }
}

#[tokio::test]
async fn a_caller_with_one_fleet_reaches_only_that_fleet_and_an_operator_no_policy() {
    let served = Served::to(&AccessOptions::default()).await;
    let new = NewToken {
        name: "one".to_owned(),
        role: Role::Operator,
        scope: Scope::of(["g".parse().unwrap()]),
        expires_us: i64::MAX,
        created_by: "test".to_owned(),
    };
    let (token, _) = create(&served.store, &new, 0).await.unwrap();
    let bearer = format!("Bearer {token}");
    let headers = [("Authorization", bearer.as_str())];
    let (_, own) = post(&served, "/v1/whiskers/hold", &headers, json!({})).await;
    let free = served.items("/v1/whiskers?fleet=g&held=false").await.len();
    assert!(free > 0 && own["subjects"] == free, "{own}");
    let parts = served.items(&format!("/v1/audit?parent_id={}", own["action_id"])).await;
    assert!(parts.iter().all(|one| one["fleet"] == "g"));
    let (_, all) = post(&served, "/v1/whiskers/hold", &[], json!({ "filter": { "fleet": "f" } })).await;
    let stop = format!("/v1/bulk-actions/{}/stop", all["action_id"]);
    assert_eq!(post(&served, &stop, &headers, json!({})).await.0, 404);
    let policy = json!({ "policy": policy_body(&vibrissa_core::policy::PolicyParams::default()) });
    assert_eq!(post(&served, "/v1/policies", &headers, policy).await.0, 403);
}
