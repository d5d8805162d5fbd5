//! Labels of robots: set, removed, filtered, listed and recorded, on both databases.

use serde_json::{Value, json};
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_tests::web::send;

use crate::served::Served;

const OF_R1: &str = "/v1/fleets/f/robots/r1/labels";

async fn put(served: &Served, path: &str, body: Value) -> (u16, Value) {
    let answer = send(served.http, "PUT", path, &[], Some(&body)).await.unwrap();
    (answer.status, answer.json())
}

async fn remove(served: &Served, path: &str) -> (u16, Value) {
    let answer = send(served.http, "DELETE", path, &[], None).await.unwrap();
    (answer.status, answer.json())
}

async fn robots(served: &Served, filter: &str) -> Vec<String> {
    let items = served.items(&format!("/v1/robots?{filter}")).await;
    let mut names: Vec<String> = items
        .iter()
        .map(|one| format!("{}/{}", one["fleet"].as_str().unwrap(), one["robot"].as_str().unwrap()))
        .collect();
    names.sort();
    names
}

async fn labels_are_set_filtered_and_removed(served: &Served) {
    for (robot, key, value) in [
        ("f/robots/r1", "hall", "2"),
        ("f/robots/r2", "hall", "Hall 2"),
        ("g/robots/r1", "hall", "2"),
        ("f/robots/r1", "line", "a=b"),
    ] {
        let (status, answer) =
            put(served, &format!("/v1/fleets/{robot}/labels/{key}"), json!({ "value": value })).await;
        assert_eq!((status, &answer["kind"], &answer["state"]), (200, &json!("LABEL_SET"), &json!("DONE")), "{answer}");
        assert_eq!(answer["parameters"], json!({ "key": key, "value": value }));
    }
    let known = served.json("/v1/fleets/f/robots/r1").await;
    assert_eq!(known["labels"], json!({ "hall": "2", "line": "a=b" }));
    // Each filter, and the robots that have such labels.
    for (filter, expected) in [
        ("label=hall", vec!["f/r1", "f/r2", "g/r1"]),
        ("label=hall%3D2", vec!["f/r1", "g/r1"]),
        ("label=hall%3Dhall%202", vec![]),
        ("label=hall%3DHall%202", vec!["f/r2"]),
        ("label=hall%3D2,line%3Da%3Db", vec!["f/r1"]),
        ("label=hal", vec![]),
        ("label=hall&fleet=g", vec!["g/r1"]),
    ] {
        assert_eq!(robots(served, filter).await, expected, "{filter}");
    }
    let whiskers = served.items("/v1/whiskers?label=line").await;
    assert_eq!(whiskers.len(), 3);
    assert!(whiskers.iter().all(|one| one["robot"] == "r1" && one["labels"]["line"] == "a=b"));
    for list in ["alarms?", "alarms?standing=true&", "alarms/folded?"] {
        let alarms = served.items(&format!("/v1/{list}label=line&limit=1000")).await;
        assert!(!alarms.is_empty(), "{list}");
        assert!(alarms.iter().all(|one| one["fleet"] == "f" && one["robot"] == "r1" && one["labels"]["hall"] == "2"));
    }
    assert!(served.items("/v1/alarms/counts?label=none").await.is_empty());
    let csv = served.get("/v1/robots?format=csv&label=line").await.body;
    assert!(csv.lines().next().unwrap().split(',').any(|name| name == "labels"), "{csv}");
    assert!(csv.contains(r#""{""hall"":""2"",""line"":""a=b""}""#), "{csv}");
    let (status, answer) = remove(served, &format!("{OF_R1}/line")).await;
    assert_eq!((status, &answer["kind"]), (200, &json!("LABEL_REMOVE")), "{answer}");
    assert_eq!(served.json("/v1/fleets/f/robots/r1").await["labels"], json!({ "hall": "2" }));
    assert_eq!(remove(served, &format!("{OF_R1}/line")).await.0, 404);
    assert_eq!(served.items("/v1/audit?kind=LABEL_SET").await.len(), 4);
    assert_eq!(served.items("/v1/audit?kind=LABEL_REMOVE").await.len(), 1);
}

#[tokio::test]
async fn labels_are_set_filtered_and_removed_on_sqlite() {
    labels_are_set_filtered_and_removed(&Served::sqlite().await).await;
}

#[tokio::test]
async fn labels_are_set_filtered_and_removed_on_postgres() {
    labels_are_set_filtered_and_removed(&Served::postgres().await).await;
}

#[tokio::test]
async fn labels_that_are_not_valid_or_too_many_are_refused() {
    let served = Served::to(&AccessOptions::default()).await;
    for (key, value) in [("Hall", "2"), ("hall", ""), ("hall", " 2"), ("hall", "a,b"), ("hall", &"v".repeat(65))] {
        let (status, answer) = put(&served, &format!("{OF_R1}/{key}"), json!({ "value": value })).await;
        assert_eq!(status, 422, "{key} {value}: {answer}");
    }
    assert_eq!(put(&served, "/v1/fleets/f/robots/none/labels/hall", json!({ "value": "2" })).await.0, 404);
    for number in 0..16 {
        assert_eq!(put(&served, &format!("{OF_R1}/k{number}"), json!({ "value": "x" })).await.0, 200);
    }
    let (status, answer) = put(&served, &format!("{OF_R1}/more"), json!({ "value": "x" })).await;
    assert_eq!(status, 409, "{answer}");
    // A refused request leaves no trace.
    assert_eq!(served.items("/v1/audit?kind=LABEL_SET&limit=1000").await.len(), 16);
    for filter in ["label=", "label=Hall", "label=a%3D", "label=a,b,c,d,e,f,g,h,i"] {
        assert_eq!(served.get(&format!("/v1/robots?{filter}")).await.status, 422, "{filter}");
    }
}
