//! The timeline and the statistics of alarms, on both databases.

use serde_json::{Value, json};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::events::EventKind;
use vibrissa_protocol::Name;
use vibrissa_store::batch::{EventRow, Record, RobotAlarmClearedRow, RobotAlarmRow};
use vibrissa_store::time::Time;
use vibrissa_store::{Batch, Store, Supervisor};
use vibrissa_tests::web::send;

use crate::rows::START_US;
use crate::served::Served;

const MINUTE_US: i64 = 60_000_000;

async fn both() -> [Served; 2] {
    [Served::sqlite().await, Served::postgres().await]
}

/// Writes a batch about two robots of fleet `t`, which `make` builds from their numbers.
async fn write(store: &Store, make: impl FnOnce([i64; 2]) -> Batch) {
    let fleet = Name::new("t").unwrap();
    let supervisor = Supervisor {
        id: "t".into(),
        name: "supervisor t".to_owned(),
        fleets: vec![fleet.clone()],
        time_to_live: std::time::Duration::from_secs(600),
    };
    let mut writer = store.writer();
    writer.sign_in(&supervisor, &[]).await.unwrap();
    let lease = writer.acquire(&supervisor, &fleet).await.unwrap().unwrap();
    let mut ids = [0; 2];
    for (id, name) in ids.iter_mut().zip(["one", "two"]) {
        *id = writer.register(&lease, (name, "b"), 1_000_000).await.unwrap().unwrap().robot_id;
    }
    writer.commit(&lease, &make(ids)).await.unwrap();
}

/// Time of a minute after a start, as the API takes it.
fn after(start_us: i64, minute: i64) -> String {
    Time(start_us + minute * MINUTE_US).to_string()
}

fn at(minute: i64) -> String {
    after(START_US, minute)
}

fn kinds(items: &[Value]) -> Vec<&str> {
    items.iter().map(|item| item["kind"].as_str().unwrap()).collect()
}

#[tokio::test]
async fn the_timeline_is_what_happened_between_two_times_with_the_actions_of_people() {
    for served in both().await {
        let event = |kind, robot_id, minute: i64| EventRow::new(kind, START_US + minute * MINUTE_US).of_robot(robot_id);
        let events = |[one, two]: [i64; 2]| {
            let policy = EventRow::new(EventKind::Policy, START_US + 4 * MINUTE_US);
            let contacts = event(EventKind::Contacts, one, 2);
            let trim = EventRow { data: r#"{"trim":{"trim_id":7}}"#.to_owned(), ..event(EventKind::Trim, one, 1) };
            vec![trim, contacts, event(EventKind::FaultChanged, two, 3), policy]
        };
        write(&served.store, |ids| Batch { events: events(ids), ..Batch::default() }).await;
        let span = format!("/v1/timeline?fleet=t&from={}&to={}", at(0), at(5));
        let all = served.items(&span).await;
        assert_eq!(kinds(&all), ["POLICY", "FAULT_CHANGED", "TRIM"], "the newest first, without contacts");
        assert_eq!((&all[2]["robot"], &all[2]["data"]["trim"]["trim_id"]), (&json!("one"), &json!(7)));
        assert_eq!([&all[0]["robot"], &all[0]["actor"]], [&Value::Null; 2]);
        // By cursor, one row for each page.
        assert_eq!(served.all(&format!("{span}&limit=1")).await, all);
        assert_eq!(kinds(&served.items(&format!("{span}&robot=two")).await), ["FAULT_CHANGED"]);
        assert_eq!(kinds(&served.items(&format!("{span}&kind=TRIM")).await), ["TRIM"]);
        // The begin is inclusive and the end is not.
        let part = format!("/v1/timeline?fleet=t&from={}&to={}", at(1), at(3));
        assert_eq!(kinds(&served.items(&part).await), ["TRIM"]);
        // The end decides about the default of the begin: a day before it.
        assert_eq!(served.items(&format!("/v1/timeline?fleet=t&to={}", at(5))).await, all);
        assert!(served.items(&format!("/v1/timeline?fleet=t&to={}", at(5 + 24 * 60))).await.is_empty());

        // An action of a person, once, with the reason.
        let body = json!({ "text": "A look at it" });
        let note = send(served.http, "POST", "/v1/fleets/t/robots/one/notes", &[], Some(&body)).await.unwrap();
        assert_eq!(note.status, 201, "{}", note.body);
        let acted = served.items("/v1/timeline?fleet=t&kind=ACTION&actor=local").await;
        let [action] = &acted[..] else { panic!("one action: {acted:?}") };
        assert_eq!([&action["word"], &action["robot"], &action["state"]], ["NOTE_ADD", "one", "DONE"]);
        assert_eq!(served.items("/v1/timeline?fleet=t&action=NOTE_ADD").await, acted);
        assert!(served.items("/v1/timeline?fleet=t&action=HOLD").await.is_empty());
        assert!(served.items("/v1/timeline?fleet=t&actor=somebody").await.is_empty());
        let csv = served.get("/v1/timeline?fleet=t&kind=ACTION&format=csv").await.body;
        assert!(csv.lines().count() == 2 && csv.contains("NOTE_ADD"), "{csv}");
    }
}

#[tokio::test]
async fn statistics_of_alarms_count_each_alarm_once() {
    // Three days ago, because one number is about alarms that have stood for more than a day.
    let start_us = wall_clock().0 as i64 - 3 * 24 * 60 * MINUTE_US;
    let at = |minute| after(start_us, minute);
    for served in both().await {
        // Robot one is silent at the minutes 0, 4 and 8, for one, two and three minutes, and at 30 for good. Robot two
        // is silent once, at 9, for ten minutes.
        let alarms = |[one, two]: [i64; 2]| {
            let raised = |robot_id, minute: i64| {
                let raised_us = start_us + minute * MINUTE_US;
                Record::RobotAlarm(RobotAlarmRow { robot_id, raised_us, kind: "ROBOT_SILENT" })
            };
            let cleared = |robot_id, minute: i64| {
                let cleared_us = start_us + minute * MINUTE_US;
                Record::RobotAlarmCleared(RobotAlarmClearedRow { robot_id, cleared_us, kind: "ROBOT_SILENT" })
            };
            vec![
                raised(one, 0),
                cleared(one, 1),
                raised(one, 4),
                cleared(one, 6),
                raised(one, 8),
                cleared(one, 11),
                raised(two, 9),
                cleared(two, 19),
                raised(one, 30),
            ]
        };
        for record in {
            let mut all = Vec::new();
            write(&served.store, |ids| {
                all = alarms(ids);
                Batch::default()
            })
            .await;
            all
        } {
            write(&served.store, |_| Batch { records: vec![record], ..Batch::default() }).await;
        }
        let span = format!("/v1/alarms/statistics?fleet=t&from={}&to={}", at(0), at(60));
        let found = served.json(&span).await;
        assert_eq!(
            [&found["alarms"], &found["cleared"], &found["standing"]],
            [&json!(5), &json!(4), &json!(1)],
            "{found}"
        );
        assert_eq!((&found["alarms_per_hour"], &found["floods"]), (&json!(5.0), &json!(0)));
        // Four alarms are over, after 60, 120, 180 and 600 s.
        assert_eq!((&found["median_duration_s"], &found["longest_duration_s"]), (&json!(150.0), &json!(600.0)));
        let levels: i64 = found["levels"].as_array().unwrap().iter().map(|one| one["alarms"].as_i64().unwrap()).sum();
        assert_eq!(levels, 5);
        let top = found["top"].as_array().unwrap();
        let counts: Vec<_> =
            top.iter().map(|one| (one["robot"].as_str().unwrap(), one["alarms"].as_i64().unwrap())).collect();
        assert_eq!(counts, [("one", 4), ("two", 1)]);
        // The third alarm of robot one came within eight minutes of its first one.
        let chattering = found["chattering"].as_array().unwrap();
        assert_eq!(
            (chattering.len(), &chattering[0]["robot"], &chattering[0]["chattering"]),
            (1, &json!("one"), &json!(1))
        );
        let stale = found["stale"].as_array().unwrap();
        assert_eq!((stale.len(), &found["standing_over_a_day"]), (1, &json!(1)));
        assert_eq!(stale[0]["raised_at"], at(30).as_str());
        // A span that ends before its begin is empty, as in lists.
        let empty = served.json(&format!("/v1/alarms/statistics?from={}&to={}", at(1), at(0))).await;
        assert_eq!([&empty["alarms"], &empty["alarms_per_hour"]], [&json!(0), &json!(0.0)]);
    }
}
