//! Windows of maintenance without a supervisor, and requests that are repeated.

use serde_json::{Value, json};
use vibrissa_simulator::clock::now_us;
use vibrissa_store::time::Time;
use vibrissa_tests::web::{Answer, send};

use crate::served::Served;

const HOUR_US: i64 = 3_600_000_000;

/// Sets a daily window of an hour, so many hours from now.
async fn set(served: &Served, fleet: &str, reason: &str, hours: i64, key: &str) -> Answer {
    let from_us = now_us() as i64 + hours * HOUR_US;
    let body = json!({ "fleet": fleet, "from": Time(from_us), "until": Time(from_us + HOUR_US), "repeats": "DAILY",
                       "reason": reason });
    post(served, &body, key).await
}

async fn post(served: &Served, body: &Value, key: &str) -> Answer {
    send(served.http, "POST", "/v1/maintenance", &[("Idempotency-Key", key)], Some(body)).await.unwrap()
}

#[tokio::test]
async fn regress_a_repeated_request_for_maintenance_has_its_own_window() {
    let served = Served::sqlite().await;
    let body = |hours: i64| {
        let from_us = now_us() as i64 + hours * HOUR_US;
        json!({ "fleet": "f", "from": Time(from_us), "until": Time(from_us + HOUR_US), "repeats": "DAILY",
                "reason": "cleaning" })
    };
    let (morning, evening) = (body(8), body(20));
    let first = post(&served, &morning, "a").await;
    assert_eq!(first.status, 201, "{}", first.body);
    let second = post(&served, &evening, "b").await;
    for (body, key, set) in [(&morning, "a", first), (&evening, "b", second)] {
        assert_eq!(post(&served, body, key).await.json()["maintenance_id"], set.json()["maintenance_id"]);
    }
    assert_eq!(post(&served, &evening, "a").await.status, 409, "the key of another window");
}

#[tokio::test]
async fn regress_maintenance_of_an_unknown_fleet_is_refused() {
    let served = Served::sqlite().await;
    let refused = set(&served, "hall1", "belts", 1, "a").await;
    assert_eq!(refused.status, 404, "{}", refused.body);
    assert!(refused.body.contains("hall1"), "{}", refused.body);
}

async fn letters_beyond_ascii_are_found_in_both_cases(served: &Served) {
    let set = set(served, "f", "\u{dc}bergabe, Halle 2 (S\u{dc}D)", 1, "a").await;
    assert_eq!(set.status, 201, "{}", set.body);
    for text in ["%C3%9Cbergabe", "%C3%BCbergabe", "%C3%9CBERGABE,", "halle%202%20(s%C3%BCd)", "HALLE"] {
        assert_eq!(served.items(&format!("/v1/audit?q={text}")).await.len(), 1, "{text}");
    }
    for text in ["abergabe", "ubergabe", "%C3%BCbergabe.", "%C3%BCbergabe*"] {
        assert_eq!(served.items(&format!("/v1/audit?q={text}")).await.len(), 0, "{text}");
    }
}

#[tokio::test]
async fn regress_letters_beyond_ascii_are_found_in_both_cases_on_sqlite() {
    letters_beyond_ascii_are_found_in_both_cases(&Served::sqlite().await).await;
}

#[tokio::test]
async fn regress_letters_beyond_ascii_are_found_in_both_cases_on_postgres() {
    letters_beyond_ascii_are_found_in_both_cases(&Served::postgres().await).await;
}

#[tokio::test]
async fn regress_a_repeated_change_of_the_allow_list_is_the_first_one() {
    let served = Served::sqlite().await;
    let path = "/v1/fleets/f/allowed-robots";
    let headers = [("If-Match", "\"0\""), ("Idempotency-Key", "k")];
    let put = async |robot: &str| {
        send(served.http, "PUT", path, &headers, Some(&json!({ "robots": [robot] }))).await.unwrap()
    };
    let (first, again) = (put("r1").await, put("r1").await);
    assert_eq!((first.status, again.status), (200, 200), "{}", again.body);
    assert_eq!(first.json()["action_id"], again.json()["action_id"]);
    assert_eq!(put("r2").await.status, 409, "the key of another list");
    let late = send(served.http, "PUT", path, &headers[..1], Some(&json!({ "robots": ["r1"] }))).await.unwrap();
    assert_eq!(late.status, 412, "{}", late.body);
}
