//! The bounds of the log of events, and its order after a restored backup.

use std::time::Duration;

use serde_json::{Value, json};
use vibrissa_store::Store;
use vibrissa_store::webhooks::upkeep::EVENTS_MAX;
use vibrissa_tests::wait::until_true;

use crate::receiver::{Manner, Receiver};
use crate::stage::{FAST, Raw, Stage, call, hook, shown, taken};

/// Writes many events of two kinds at once.
async fn many(raw: &mut Raw, events: i64) {
    let sql = format!(
        "WITH RECURSIVE n (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < {events}) \
         INSERT INTO events (recorded_us, version, audience, data, kind, word, fleet, robot_id) \
         SELECT {}, 2, 'PEOPLE', '{{}}', CASE WHEN i % 2 = 0 THEN 'TRIM' ELSE 'ALARM_RAISED' END, \
         CASE WHEN i % 2 = 0 THEN NULL ELSE 'ERODING' END, 'f', (SELECT min(robot_id) FROM robots) FROM n",
        vibrissa_edge::clock::wall_clock().0
    );
    assert_eq!(raw.run(&sql).await, events as u64);
}

/// Some events of the robot of another fleet, less urgent than a storm's.
async fn of_another_fleet(raw: &mut Raw) {
    let now_us = vibrissa_edge::clock::wall_clock().0;
    for _ in 0..3 {
        let sql = format!(
            "INSERT INTO events (recorded_us, version, audience, data, kind, word, fleet, robot_id) \
             VALUES ({now_us}, 2, 'PEOPLE', '{{}}', 'ALARM_CLEARED', 'ERODING', 'another', 4000000)"
        );
        raw.run(&sql).await;
    }
}

async fn what_is_removed_is_counted(stage: Stage) {
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let more = json!({ "name": "trims", "enabled": false, "kinds": ["TRIM"] });
    let (webhook_id, _) = hook(&service, &receiver, more).await;
    let mut raw = stage.raw().await;
    of_another_fleet(&mut raw).await;
    many(&mut raw, EVENTS_MAX + 1000).await;
    let trims = (EVENTS_MAX + 1000) / 2;
    assert_eq!(shown(&service, webhook_id).await["waiting"], json!(trims));
    service.store.trim_events_for_webhooks(vibrissa_edge::clock::wall_clock().0 as i64).await.unwrap();
    let state = shown(&service, webhook_id).await;
    assert_eq!((&state["waiting"], &state["lost"]), (&json!(trims), &json!(0)), "the urgent ones stay");
    let others = raw.number("SELECT count(*) FROM events WHERE fleet = 'another'").await;
    assert_eq!(others, 3, "a storm takes nothing from another fleet");
    // The urgent ones alone are too many.
    many(&mut raw, EVENTS_MAX + 1000).await;
    service.store.trim_events_for_webhooks(vibrissa_edge::clock::wall_clock().0 as i64).await.unwrap();
    let state = shown(&service, webhook_id).await;
    let (waiting, lost) = (EVENTS_MAX - others, 2 * trims - (EVENTS_MAX - others));
    assert_eq!((&state["waiting"], &state["lost"]), (&json!(waiting), &json!(lost)));
    assert_eq!(raw.number("SELECT count(*) FROM events WHERE audience = 'PEOPLE'").await, EVENTS_MAX);
    // A week later the rest is gone, too.
    let later_us = vibrissa_edge::clock::wall_clock().0 as i64 + 8 * 86_400_000_000;
    service.store.trim_events_for_webhooks(later_us).await.unwrap();
    let state = shown(&service, webhook_id).await;
    assert_eq!((&state["waiting"], &state["lost"]), (&json!(0), &json!(2 * trims)));
    service.stop().await;
}

#[tokio::test]
async fn the_log_is_bounded_and_what_is_removed_is_counted_with_sqlite() {
    what_is_removed_is_counted(Stage::sqlite().await).await;
}

#[tokio::test]
async fn the_log_is_bounded_and_what_is_removed_is_counted_with_postgresql() {
    what_is_removed_is_counted(Stage::postgres().await).await;
}

/// A supervisor died while it held a webhook, and the database's clock was set back by an hour.
async fn regress_a_hold_ends(stage: Stage) {
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    let (webhook_id, _) = hook(&service, &receiver, json!({ "enabled": false })).await;
    let mut raw = stage.raw().await;
    raw.trim(1).await;
    service.stop().await;
    let until_us = vibrissa_edge::clock::wall_clock().0 + 3_600_000_000;
    let sql = format!("UPDATE webhooks SET enabled = TRUE, next_us = 0, holder = 'dead', held_until_us = {until_us}");
    raw.run(&sql).await;
    let store = Store::open(&stage.address, "test").await.unwrap();
    let hold = Duration::from_millis(300);
    assert!(store.due_webhooks("living", hold).await.unwrap().is_empty(), "its owner may be alive");
    let is_due = async || store.due_webhooks("living", hold).await.unwrap() == [webhook_id];
    until_true("the end of the hold", is_due).await;
    let taken_for = Duration::from_secs(600);
    assert!(store.take_webhook_job(webhook_id, "living", taken_for).await.unwrap().is_some());
    // Meanwhile nobody else takes it, also without having watched it.
    let other = Store::open_for_command(&stage.address).await.unwrap();
    assert!(other.due_webhooks("other", hold).await.unwrap().is_empty());
    assert!(other.take_webhook_job(webhook_id, "other", Duration::from_secs(1)).await.unwrap().is_none());
    other.close().await;
    store.close().await;
}

#[tokio::test]
async fn regress_a_hold_ends_although_the_clock_went_back_with_sqlite() {
    regress_a_hold_ends(Stage::sqlite().await).await;
}

#[tokio::test]
async fn regress_a_hold_ends_although_the_clock_went_back_with_postgresql() {
    regress_a_hold_ends(Stage::postgres().await).await;
}

#[tokio::test]
async fn regress_events_of_a_restored_server_come_before_new_ones() {
    let stage = Stage::postgres().await;
    let receiver = Receiver::start(Manner::Status(503)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    hook(&service, &receiver, json!({ "enabled": false })).await;
    let mut raw = stage.raw().await;
    raw.trim(1).await;
    service.stop().await;
    // The server of the dump had counted far more transactions.
    raw.run("UPDATE events SET tx = tx + 1000000000").await;
    raw.run("UPDATE webhooks SET done_tx = done_tx + 1000000000 - 1, enabled = TRUE").await;
    receiver.is(Manner::Status(200));
    let store = Store::open(&stage.address, "test").await.unwrap();
    store.prepare_events().await.unwrap();
    store.close().await;
    raw.trim(2).await;
    let service = stage.supervisor("b", FAST).await;
    assert_eq!(taken(&receiver, 2).await, [1, 2]);
    service.stop().await;
}

#[tokio::test]
async fn regress_a_server_restored_amid_the_transactions_of_its_dump_delivers_no_event_again() {
    let stage = Stage::postgres().await;
    let receiver = Receiver::start(Manner::Status(200)).await;
    let service = stage.supervisor("a", FAST).await;
    stage.robot().await;
    hook(&service, &receiver, json!({})).await;
    let mut raw = stage.raw().await;
    raw.trim(1).await;
    raw.trim(2).await;
    assert_eq!(taken(&receiver, 2).await, [1, 2]);
    service.stop().await;
    // The new server has counted further than at the first event, and not as far as at the second one.
    raw.run("UPDATE events SET tx = tx + 1000000000 WHERE event_id = (SELECT max(event_id) FROM events)").await;
    raw.run(
        "UPDATE webhooks SET done_tx = (SELECT max(tx) FROM events), done_event = (SELECT max(event_id) FROM events)",
    )
    .await;
    let store = Store::open(&stage.address, "test").await.unwrap();
    store.prepare_events().await.unwrap();
    store.close().await;
    raw.trim(3).await;
    let service = stage.supervisor("b", FAST).await;
    assert_eq!(taken(&receiver, 3).await, [1, 2, 3]);
    service.stop().await;
}

#[tokio::test]
async fn the_fifty_first_webhook_of_a_fleet_is_refused_and_another_fleet_has_its_own() {
    let stage = Stage::sqlite().await;
    let service = stage.supervisor("a", FAST).await;
    let asked = async |name: String, fleets: Value| {
        let body = json!({ "name": name, "url": "http://127.0.0.1:1/", "enabled": false, "fleets": fleets });
        call(&service, "POST", "/v1/webhooks", Some(body)).await
    };
    for number in 0..50 {
        let answer = asked(format!("n{number}"), json!(["f"])).await;
        assert_eq!(answer.status, 201, "{number}: {}", answer.body);
    }
    for fleets in [json!(["f"]), json!(["g", "f"])] {
        let answer = asked("more".to_owned(), fleets).await;
        assert!((400..500).contains(&answer.status) && answer.body.contains("50"), "{answer:?}");
    }
    assert_eq!(asked("other".to_owned(), json!(["g"])).await.status, 201, "another fleet");
    service.stop().await;
}
