//! Receivers that fail: retries, dead letters, and other targets that do not wait for them.

use serde_json::json;
use vibrissa_tests::wait::until_true;

use crate::receiver::{Manner, Receiver, Request};
use crate::stage::{FAST, Stage, call, hook, shown, taken};

#[tokio::test]
async fn dead_letters_are_shown_and_delivered_again() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Status(500)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let (webhook_id, _) = hook(&service, &receiver, json!({})).await;
    let mut raw = stage.raw().await;
    for trim_id in 1..=3 {
        raw.trim(trim_id).await;
    }
    let dead = async || shown(&service, webhook_id).await["dead_letters"].as_i64().unwrap();
    until_true("three dead letters", async || dead().await == 3).await;
    let tried: Vec<i64> = receiver.requests().iter().map(Request::event_id).collect();
    assert_eq!(tried.len(), 9, "each event is tried three times: {tried:?}");
    assert!(tried.is_sorted(), "an event waits for the one before: {tried:?}");
    let same = |request: &Request| (request.headers["webhook-id"].clone(), request.body.clone());
    let requests = receiver.requests();
    assert!(requests.chunks(3).all(|of| of.iter().all(|one| same(one) == same(&of[0]))), "attempts are the same");
    let state = shown(&service, webhook_id).await;
    assert_eq!((&state["state"], &state["last_problem"]), (&json!("FAILING"), &json!("answered 500")));
    assert_eq!((&state["waiting"], &state["failed"]), (&json!(0), &json!(9)));

    let path = format!("/v1/webhooks/{webhook_id}/dead-letters");
    let letters = call(&service, "GET", &path, None).await.json();
    let letters = letters["items"].as_array().unwrap().clone();
    assert_eq!((&letters[0]["attempts"], &letters[0]["status"]), (&json!(3), &json!(500)));
    assert_eq!(letters[0]["event"], requests[0].json());
    receiver.is(Manner::Status(200));
    let again = json!({ "event_ids": [letters[1]["event_id"], letters[0]["event_id"]] });
    let answer = call(&service, "POST", &format!("{path}/redeliver"), Some(again)).await;
    assert_eq!((answer.status, answer.json()["dead_letters"].clone()), (200, json!(2)));
    let ids = taken(&receiver, 2).await;
    assert_eq!(ids, [letters[0]["event_id"].as_i64().unwrap(), letters[1]["event_id"].as_i64().unwrap()]);
    until_true("one dead letter is left", async || dead().await == 1).await;
    let answer = call(&service, "POST", &format!("{path}/discard"), None).await;
    assert_eq!((answer.status, answer.json()["dead_letters"].clone()), (200, json!(1)));
    assert_eq!(dead().await, 0);
    raw.trim(4).await;
    taken(&receiver, 3).await;
    assert_eq!(shown(&service, webhook_id).await["state"], "WORKING");
    let counted = [
        "vibrissa_webhook_attempts_total{outcome=\"DELIVERED\"} 3",
        "vibrissa_webhook_attempts_total{outcome=\"FAILED\"} 6",
        "vibrissa_webhook_attempts_total{outcome=\"DEAD\"} 3",
    ];
    // An attempt is counted after its answer.
    until_true("all attempts counted", async || {
        let metrics = String::from_utf8(service.metrics.text().unwrap()).unwrap();
        counted.iter().all(|line| metrics.contains(line))
    })
    .await;
    service.stop().await;
}

#[tokio::test]
async fn a_target_that_never_answers_delays_no_other_one() {
    let stage = Stage::sqlite().await;
    let (silent, quick) = (Receiver::start(Manner::Silent).await, Receiver::start(Manner::Status(200)).await);
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    hook(&service, &silent, json!({ "name": "silent" })).await;
    hook(&service, &quick, json!({ "name": "quick" })).await;
    let mut raw = stage.raw().await;
    raw.trim(1).await;
    until_true("the silent one is asked", async || silent.requests().len() == 1).await;
    raw.trim(2).await;
    taken(&quick, 2).await;
    assert_eq!(silent.requests().len(), 1, "its ten seconds have not passed yet");
    service.stop().await;
}

#[tokio::test]
async fn a_redirect_is_a_failure_and_is_not_followed() {
    let stage = Stage::sqlite().await;
    let receiver = Receiver::start(Manner::Redirect).await;
    let service = stage.supervisor("a", FAST).await;
    let (webhook_id, _) = hook(&service, &receiver, json!({})).await;
    let answer = call(&service, "POST", &format!("/v1/webhooks/{webhook_id}/test"), None).await.json();
    assert_eq!((&answer["delivered"], &answer["status"]), (&json!(false), &json!(302)));
    assert_eq!(answer["problem"], "answered 302: redirects are not followed");
    assert_eq!(receiver.requests().len(), 1);
    service.stop().await;
}
