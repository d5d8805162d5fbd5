//! Runs the queries of Grafana's alerts on a database with the real schema.

use std::collections::BTreeSet;

use serde_json::Value;
use sqlx::postgres::{PgConnection, PgRow};
use sqlx::{AssertSqlSafe, Column, ConnectOptions, Row, TypeInfo};
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_tests::postgres::Postgres;

use super::{list, named_alerts, text};

/// Three robots with four healthy whiskers each (numbers 1 to 4, 5 to 8 and 9 to 12): one is ONLINE, one OFFLINE, one silent.
const HEALTHY: &str = r#"
INSERT INTO robots (fleet, robot, connection) VALUES ('paint', 'crawler', 'ONLINE'), ('paint', 'away', 'OFFLINE'),
    ('paint', 'silent', 'ONLINE');
INSERT INTO arrays (robot_id, "array", array_type) SELECT robot_id, 'left', 'TYPE_1' FROM robots ORDER BY robot_id;
INSERT INTO whiskers (array_id, robot_id, whisker, position, x_mm, y_mm, model, whole_length_mm, nominal_pressure_mpa,
    pressure_max_mpa, length_mm, length_sd_mm, condition, setpoint_mpa, heard_us)
SELECT array_id, robot_id, n, n, 0, 0, 'nguyen-2021', 70, 0.1, 0.2, 70, 0.2, 'HEALTHY', 0.1, clock_us()
FROM arrays, generate_series(0, 3) n ORDER BY array_id, n;
INSERT INTO alarms (whisker_id, raised_us, cleared_us, kind) VALUES
    (1, 1, 2, 'UNCOMPENSATED'), (1, 1, 2, 'SETPOINT_FAILED'), (4, 1, NULL, 'ARRAY_SHIFT');
INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, target_pressure_mpa,
    compensator_whisker_id, compensation_case, decided_us, ended_us)
VALUES (1, 1, 1, 70, 0.1, 1, 'SELF_COMPENSATION', 1, NULL), (2, 1, 3, 70, 0.1, 3, 'SELF_COMPENSATION', 1, 2);
INSERT INTO compensation_errors (compensation_id, recorded_us, contacts, bins, error, error_low, error_high)
VALUES (1, 1, 100, 3, 0.7, 0.6, 0.8), (1, 2, 200, 4, 0.6, 0.49, 0.7), (2, 1, 100, 3, 0.7, 0.6, 0.8);
UPDATE whiskers SET condition = 'ERODING', contacts_left_high = 9000 WHERE whisker_id = 3;
UPDATE whiskers SET fault = 'STALE', heard_us = 1 WHERE robot_id IN (2, 3);
INSERT INTO alarms (robot_id, raised_us, kind) VALUES (3, 1, 'ROBOT_SILENT');
"#;

/// For each alert of Grafana: SQL that triggers it for the whisker `crawler/left/1`, and the kind of alarm that shelves
/// it, if any.
const BREAKS: [(&str, &str, Option<&str>); 5] = [
    (
        "WhiskerUncompensated",
        "INSERT INTO alarms (whisker_id, raised_us, kind) VALUES (2, clock_us(), 'UNCOMPENSATED')",
        Some("UNCOMPENSATED"),
    ),
    (
        "WhiskerSetpointFailed",
        "INSERT INTO alarms (whisker_id, raised_us, kind) VALUES (2, clock_us(), 'SETPOINT_FAILED')",
        Some("SETPOINT_FAILED"),
    ),
    (
        "WhiskerCompensationErrorHigh",
        "INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, target_pressure_mpa, \
         compensator_whisker_id, compensation_case, decided_us) VALUES (3, 1, 2, 70, 0.1, 2, 'SELF_COMPENSATION', 3); \
         INSERT INTO compensation_errors (compensation_id, recorded_us, contacts, bins, error, error_low, error_high) \
         VALUES (3, 1, 100, 3, 0.2, 0.1, 0.3), (3, 2, 200, 4, 0.6, 0.51, 0.7)",
        None,
    ),
    ("WhiskerUnheard", "UPDATE whiskers SET fault = 'STALE', heard_us = 1 WHERE whisker_id = 2", Some("STALE")),
    (
        "WhiskerErodingAway",
        "UPDATE whiskers SET condition = 'ERODING', contacts_left_high = 1999 WHERE whisker_id = 2",
        Some("ERODING"),
    ),
];

/// The whiskers that an alert's query returns. Also checks the columns that Grafana requires.
async fn asked(link: &mut PgConnection, rule: &Value) -> Vec<String> {
    let data: Vec<&Value> = list(&rule["data"]).collect();
    let [query, threshold] = data[..] else { panic!("a query and a threshold: {data:?}") };
    assert_eq!((text(&query["refId"]), text(&query["datasourceUid"])), ("A", "postgresql"));
    assert_eq!((text(&threshold["refId"]), text(&threshold["model"]["expression"])), ("C", "A"));
    assert_eq!(text(&rule["condition"]), "C");
    let sql = text(&query["model"]["rawSql"]).to_owned();
    assert!(!sql.contains('$'), "Grafana would replace a variable");
    let rows = sqlx::raw_sql(AssertSqlSafe(sql)).fetch_all(link).await.unwrap();
    for row in &rows {
        let kinds: Vec<&str> = row.columns().iter().map(|column| column.type_info().name()).collect();
        assert_eq!(
            kinds.iter().filter(|kind| **kind != "TEXT").collect::<Vec<_>>(),
            [&"FLOAT8"],
            "expected one column with a number"
        );
    }
    let part = |row: &PgRow, name: &str| row.get::<String, _>(name);
    rows.iter().map(|row| ["fleet", "robot", "array", "whisker"].map(|name| part(row, name)).join("/")).collect()
}

#[tokio::test]
async fn grafana_is_told_of_the_one_broken_whisker_and_of_no_healthy_one() {
    let server = Postgres::start().await;
    let address: DatabaseAddress = Postgres::url(server.port()).parse().unwrap();
    Store::open(&address, "test").await.unwrap().prepare().await.unwrap();
    let mut link = server.connect().connect().await.unwrap();
    sqlx::raw_sql(HEALTHY).execute(&mut link).await.unwrap();
    let rules = named_alerts();
    let alerts: BTreeSet<&str> = rules.keys().map(String::as_str).collect();
    assert_eq!(alerts, BREAKS.iter().map(|(alert, ..)| *alert).collect::<BTreeSet<_>>());
    for (alert, broken, shelf) in BREAKS {
        let rule = &rules[alert];
        assert!(asked(&mut link, rule).await.is_empty(), "{alert}");
        sqlx::raw_sql(broken).execute(&mut link).await.unwrap();
        assert_eq!(asked(&mut link, rule).await, ["paint/crawler/left/1"], "{alert}");
        let Some(kind) = shelf else { continue };
        for (until, count) in [("clock_us() + 1000000000", 0), ("clock_us() - 1", 1)] {
            let shelve = format!(
                "INSERT INTO alarm_shelves (whisker_id, kind, shelved_us, until_us, shelved_by, reason) \
                 VALUES (2, '{kind}', 0, {until}, 'somebody', 'known')"
            );
            sqlx::raw_sql(AssertSqlSafe(shelve)).execute(&mut link).await.unwrap();
            assert_eq!(asked(&mut link, rule).await.len(), count, "{alert}, shelved until {until}");
        }
    }
    // A robot that has vented a whisker by itself: Prometheus' alert of the pair tells of it, too.
    let vented = "INSERT INTO alarms (whisker_id, raised_us, kind) VALUES (3, clock_us(), 'VENTED')";
    sqlx::raw_sql(vented).execute(&mut link).await.unwrap();
    let told = asked(&mut link, &rules["WhiskerSetpointFailed"]).await;
    assert!(told.contains(&"paint/crawler/left/2".to_owned()), "{told:?}");
}
