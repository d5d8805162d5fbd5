//! The board says of each robot what the lists say.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::served::Served;

/// The state of a robot by its row in the list of robots.
fn state_of(robot: &Value) -> &str {
    let connection = robot["connection"].as_str().unwrap();
    let has = |name: &str| robot[name].as_i64().unwrap() > 0;
    let states = [
        (connection != "ONLINE", connection),
        (has("whiskers_uncompensated"), "UNCOMPENSATED"),
        (has("whiskers_faulty"), "FAULTY"),
        (has("alarms"), "ALARM"),
        (has("whiskers_worn"), "WORN"),
        (has("whiskers_compensated"), "COMPENSATED"),
        (has("whiskers_learning"), "LEARNING"),
    ];
    states.into_iter().find(|(is, _)| *is).map_or("HEALTHY", |(_, state)| state)
}

/// How urgent a whisker is by its row in the list of whiskers; `None` if it is sound.
fn urgency(whisker: &Value) -> Option<u8> {
    let is_trimmed = whisker["condition"] == "TRIMMED";
    let is_silent = whisker["fault"] == "STALE" && whisker["connection"] != "ONLINE";
    match whisker["condition"].as_str().unwrap() {
        "TRIMMED" if whisker["compensated_by"].is_null() => Some(0),
        "HEALTHY" | "LEARNING" if is_silent => None,
        _ if whisker["fault"].is_string() => Some(1),
        "HEALTHY" | "LEARNING" => None,
        _ if is_trimmed => Some(3),
        _ => Some(2),
    }
}

fn name(row: &Value) -> [String; 2] {
    ["fleet", "robot"].map(|name| row[name].as_str().unwrap().to_owned())
}

async fn check(served: &Served, asked: &str) {
    let board = served.json(&format!("/v1/board?{asked}")).await;
    let robots = served.items(&format!("/v1/robots?limit=1000&{asked}")).await;
    let mut expected: Vec<_> = robots.iter().map(|row| (name(row), state_of(row).to_owned())).collect();
    expected.sort();
    let shown = board["robots"].as_array().unwrap();
    let found: Vec<_> = shown.iter().map(|row| (name(row), row["state"].as_str().unwrap().to_owned())).collect();
    assert_eq!(found, expected, "{asked}");

    let mut groups: BTreeMap<String, BTreeMap<String, u64>> = BTreeMap::new();
    for ([fleet, _], state) in &expected {
        *groups.entry(fleet.clone()).or_default().entry(state.clone()).or_default() += 1;
    }
    let groups: Vec<Value> = groups
        .into_iter()
        .map(|(group, states)| json!({ "group": group, "robots": states.values().sum::<u64>(), "states": states }))
        .collect();
    assert_eq!(board["groups"], json!(groups), "{asked}");
    for robot in shown {
        let group = robot["group"].as_u64().unwrap();
        assert_eq!(groups[usize::try_from(group).unwrap()]["group"], robot["fleet"], "{robot}");
    }

    let whiskers = served.items(&format!("/v1/whiskers?limit=1000&{asked}")).await;
    let lost = |row: &Value| row["whole_length_mm"].as_f64().unwrap() - row["length_mm"].as_f64().unwrap();
    let mut expected: Vec<(u8, f64, &Value)> =
        whiskers.iter().filter_map(|row| urgency(row).map(|urgency| (urgency, lost(row), row))).collect();
    // The list is in the order of the numbers of the whiskers, and this order is stable.
    expected.sort_by(|one, other| one.0.cmp(&other.0).then(other.1.total_cmp(&one.1)));
    let found = board["whiskers"].as_array().unwrap();
    assert!(!found.is_empty() && found.len() == expected.len().min(50), "{asked}: {found:?}");
    for (row, (_, lost, whisker)) in found.iter().zip(&expected) {
        for field in ["fleet", "robot", "array", "whisker", "connection", "condition", "fault", "compensated_by"] {
            assert_eq!(row[field], whisker[field], "{asked} {field}: {row}");
        }
        assert!((row["lost_mm"].as_f64().unwrap() - lost).abs() < 1e-9, "{row}");
        let error = match row["compensated_by"].as_i64() {
            Some(id) => served.json(&format!("/v1/compensations/{id}")).await["measured_error"].clone(),
            None => Value::Null,
        };
        assert_eq!(row["error"], error, "{row}");
    }
    let overview = served.json(&format!("/v1/overview?{asked}")).await;
    assert_eq!(board["errors"], overview["errors"], "{asked}");
}

async fn the_board_says_what_the_lists_say(served: &Served) {
    for asked in ["", "fleet=f", "fleet=g"] {
        check(served, asked).await;
    }
    // A state names fewer robots and their whiskers, and the numbers of the groups stay.
    let all = served.json("/v1/board").await;
    let states: Vec<&str> =
        all["robots"].as_array().unwrap().iter().map(|row| row["state"].as_str().unwrap()).collect();
    let board = served.json(&format!("/v1/board?state={}", states[0])).await;
    assert_eq!(board["groups"], all["groups"]);
    let named = board["robots"].as_array().unwrap();
    assert_eq!(named.len(), states.iter().filter(|state| **state == states[0]).count());
    let is_of_named = |row: &Value| named.iter().any(|one| name(one) == name(row));
    assert!(board["whiskers"].as_array().unwrap().iter().all(is_of_named), "{board}");
    // By a label that no robot has, all of them are in the group without a name.
    let by = served.json("/v1/board?by=hall").await;
    assert_eq!(by["groups"].as_array().unwrap().len(), 1);
    assert_eq!(by["groups"][0]["group"], Value::Null);
    assert_eq!(by["groups"][0]["robots"], json!(states.len()));
    let searched = served.json("/v1/board?q=no-robot-has-this-name").await;
    assert_eq!(searched["robots"], json!([]));
    assert_eq!(served.get("/v1/board?state=UNKNOWN").await.status, 422);
    assert_eq!(served.get("/v1/board?by=Hall").await.status, 422);
}

#[tokio::test]
async fn brute_force_the_board_says_what_the_lists_say_on_sqlite() {
    the_board_says_what_the_lists_say(&Served::sqlite().await).await;
}

#[tokio::test]
async fn brute_force_the_board_says_what_the_lists_say_on_postgres() {
    the_board_says_what_the_lists_say(&Served::postgres().await).await;
}
