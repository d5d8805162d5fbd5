//! The migration to one log of events: what waited for webhooks and for Kafka in a database of an earlier version waits on.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};
use sqlx::{AssertSqlSafe, ConnectOptions};
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_supervisor::events::published;
use vibrissa_tests::postgres::{DATABASE, Postgres};

use crate::history::rows;

/// Time of the events that wait for Kafka.
const TIMESTAMP: &str = "2026-11-20T08:00:00.125Z";

fn fixture(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/database-37");
    folder.join(name).display().to_string()
}

/// The events of a transaction in the form of the former outbox: version, robot, whether it is about contacts, JSON.
pub(crate) fn outbox_row(robot: &str, events: &[Value]) -> String {
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let bytes = events.iter().flat_map(|event| {
        let is_contacts = event["type"] == "CONTACTS";
        [&[1][..], &text(robot), &[u8::from(is_contacts)], &text(&event.to_string())].concat()
    });
    bytes.map(|byte| format!("{byte:02x}")).collect()
}

async fn waits_on(address: &DatabaseAddress) {
    let subject = "SELECT r.robot, a.\"array\", w.whisker, w.whisker_id FROM whiskers w \
         JOIN arrays a ON a.array_id = w.array_id JOIN robots r ON r.robot_id = a.robot_id WHERE r.fleet = 'f' \
         ORDER BY w.whisker_id DESC LIMIT 1";
    let (robot, array, whisker, whisker_id) = rows!(address, (String, String, i64, i64), subject).remove(0);
    let event = |kind: &str, name: &str, part: Value| {
        json!({ "type": kind, "version": 1, "timestamp": TIMESTAMP, "fleet": "f", "robot": robot, "array": array,
            "whisker": whisker, name: part })
    };
    // A body of more than 255 bytes.
    let contacts = json!({ "boot_id": "b", "seq": 7, "contacts": vec![json!({ "position": 0, "ratio": 0.8 }); 20] });
    let waiting = [
        event("TRIM", "trim", json!({ "trim_id": 5, "length_before_mm": 70.0 })),
        event("COMPENSATION_APPROVED", "compensation", json!({ "compensation_id": 6 })),
        event("SETPOINT_STATE", "setpoint", json!({ "command_id": "c", "state": "REJECTED" })),
        event("ALARM_RAISED", "alarm", json!({ "kind": "LEAK" })),
        event("CONTACTS", "contacts", contacts.clone()),
    ];
    let is_shared = matches!(address, DatabaseAddress::Postgres(_));
    for (number, events) in [(2, &waiting[2..]), (1, &waiting[..2])] {
        let bytes = outbox_row(&robot, events);
        let blob = if is_shared { format!("decode('{bytes}', 'hex')") } else { format!("x'{bytes}'") };
        let sql = format!(
            "INSERT INTO event_outbox (fleet, shard, epoch, number, events) VALUES ('f', 0, 3, {number}, {blob}) \
             RETURNING number"
        );
        rows!(address, (i64,), AssertSqlSafe(sql.clone()));
    }
    let before = "SELECT event_id, kind, fleet, robot_id FROM webhook_events ORDER BY tx, place, event_id";
    let before = rows!(address, (i64, String, String, i64), before);
    let letters = "SELECT d.webhook_id, e.kind, e.robot_id, e.whisker_id FROM webhook_dead_letters d \
         JOIN webhook_events e ON e.event_id = d.event_id ORDER BY e.tx, e.place, e.event_id, d.webhook_id";
    let letters = rows!(address, (i64, String, i64, Option<i64>), letters);
    let trims = "SELECT t.trim_id, t.length_before_mm FROM webhook_events e JOIN trims t ON t.trim_id = e.number \
         WHERE e.kind = 'TRIM' ORDER BY e.tx, e.place, e.event_id";
    let trims = rows!(address, (i64, f64), trims);
    assert!(!before.is_empty() && !trims.is_empty() && !letters.is_empty());

    let store = Store::open(address, "test").await.unwrap();
    store.prepare().await.unwrap();
    let after = "SELECT event_id, kind, fleet, robot_id FROM events WHERE audience = 'PEOPLE' ORDER BY tx, event_id";
    let after = rows!(address, (i64, String, String, i64), after);
    let subjects = |events: &[(i64, String, String, i64)]| -> Vec<(String, String, i64)> {
        events.iter().map(|(_, kind, fleet, robot_id)| (kind.clone(), fleet.clone(), *robot_id)).collect()
    };
    assert_eq!(subjects(&after), subjects(&before), "the order is kept");
    let numbers =
        |events: &[(i64, String, String, i64)]| -> BTreeSet<i64> { events.iter().map(|event| event.0).collect() };
    assert_eq!(numbers(&after), numbers(&before));
    let dead = "SELECT d.webhook_id, e.kind, e.robot_id, e.whisker_id FROM webhook_dead_letters d \
         JOIN events e ON e.event_id = d.event_id ORDER BY e.tx, e.event_id, d.webhook_id";
    assert_eq!(rows!(address, (i64, String, i64, Option<i64>), dead), letters);
    let data = "SELECT data FROM events WHERE audience = 'PEOPLE' AND kind = 'TRIM' ORDER BY tx, event_id";
    let reported: Vec<(i64, f64)> = rows!(address, (String,), data)
        .iter()
        .map(|(data,)| data.parse::<Value>().unwrap()["trim"].clone())
        .map(|trim| (trim["trim_id"].as_i64().unwrap(), trim["length_before_mm"].as_f64().unwrap()))
        .collect();
    // SQLite writes 15 digits.
    let is_same = |reported: &(i64, f64), trim: &(i64, f64)| reported.0 == trim.0 && (reported.1 - trim.1).abs() < 1e-9;
    assert!(
        reported.len() == trims.len() && reported.iter().zip(&trims).all(|(reported, trim)| is_same(reported, trim)),
        "{reported:?}"
    );

    store.follow_events("f", 1).await.unwrap();
    let events = store.waiting_events("f").await.unwrap().events;
    let documents: Vec<Value> = events.iter().map(|event| published(event).parse().unwrap()).collect();
    let kinds: Vec<&str> = documents.iter().map(|event| event["type"].as_str().unwrap()).collect();
    assert_eq!(kinds, ["TRIM", "COMPENSATION_BEGUN", "SETPOINT_FAILED", "ALARM_RAISED", "CONTACTS"]);
    for event in &documents {
        let data = &event["data"];
        assert_eq!(
            (&event["timestamp"], &data["fleet"], &data["robot"]),
            (&json!(TIMESTAMP), &json!("f"), &json!(robot))
        );
        assert_eq!((&data["array"], &data["whisker"]), (&json!(array), &json!(whisker)), "{event}");
    }
    assert_eq!(documents[0]["data"]["trim"], json!({ "trim_id": 5, "length_before_mm": 70.0 }));
    assert_eq!(documents[1]["data"]["compensation"]["compensation_id"], 6);
    assert_eq!(
        (&documents[3]["data"]["alarm"]["kind"], &documents[4]["data"]["contacts"]),
        (&json!("LEAK"), &contacts)
    );
    let sql = "SELECT event_id FROM events WHERE audience <> 'PEOPLE' AND whisker_id = ".to_owned();
    assert_eq!(rows!(address, (i64,), AssertSqlSafe(format!("{sql}{whisker_id}"))).len(), waiting.len());
    // A new event gets a number that no earlier one has had.
    let newest = before.iter().map(|(event_id, ..)| *event_id).max().unwrap();
    assert!(events.iter().all(|event| event.event_id > newest));
    store.close().await;
}

#[tokio::test]
async fn golden_what_waited_in_sqlite_waits_on() {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("fleet.sqlite3");
    std::fs::copy(fixture("fleet.sqlite3"), &copy).unwrap();
    waits_on(&DatabaseAddress::Sqlite(copy)).await;
}

#[tokio::test]
async fn golden_what_waited_in_postgresql_waits_on() {
    let server = Postgres::start().await;
    let mut restore = server.client("psql");
    restore.args(["-X", "-q", "-d", DATABASE, "-v", "ON_ERROR_STOP=1", "-f", &fixture("fleet.sql")]);
    assert!(restore.status().unwrap().success());
    waits_on(&Postgres::url(server.port()).parse().unwrap()).await;
}
