//! The overview counts what the lists have.

use serde_json::Value;
use vibrissa_store::time::Time;

use crate::rows::START_US;
use crate::served::Served;

/// Number of rows of a list, which has fewer than a page of 1000.
async fn rows(served: &Served, path: &str) -> usize {
    let joint = if path.contains('?') { '&' } else { '?' };
    served.items(&format!("{path}{joint}limit=1000")).await.len()
}

async fn check(served: &Served, fleet: Option<&str>, from_us: i64) {
    let from = Time(from_us).to_string();
    let fleet_is = fleet.map_or_else(String::new, |fleet| format!("&fleet={fleet}"));
    let overview = served.json(&format!("/v1/overview?from={from}{fleet_is}")).await;
    assert_eq!(overview["from"], from);
    for (name, list) in [
        ("trims", "/v1/trims?"),
        ("setpoints_applied", "/v1/setpoints?state=APPLIED&"),
        ("alarms", "/v1/alarms?"),
        ("whiskers_replaced", "/v1/audit?kind=REPLACED&state=DONE&"),
    ] {
        let expected = rows(served, &format!("{list}from={from}{fleet_is}")).await;
        assert_eq!(overview[name], expected, "{name} {overview}");
    }

    let active = served.items(&format!("/v1/compensations?active=true&limit=1000{fleet_is}")).await;
    let measured: Vec<f64> = active
        .iter()
        .filter(|one| one["compensator_whisker"].is_number() && one["approval"] != "PROPOSED")
        .filter_map(|one| newest_error(served, one["compensation_id"].as_i64().unwrap()))
        .collect();
    assert!(!measured.is_empty());
    let bins = overview["errors"].as_array().unwrap();
    assert_eq!(bins.len(), 11);
    for bin in bins {
        let (from, to) = (bin["error_from"].as_f64().unwrap(), bin["error_to"].as_f64().unwrap_or(f64::INFINITY));
        let expected = measured.iter().filter(|error| (from..to).contains(*error)).count();
        assert_eq!(bin["compensations"], expected, "{bin} {measured:?}");
    }

    let robots = overview["robots"].as_array().unwrap();
    let listed = served.items(&format!("/v1/robots?sort=attention&limit=24{fleet_is}")).await;
    let names =
        |rows: &[Value]| rows.iter().map(|row| (row["fleet"].clone(), row["robot"].clone())).collect::<Vec<_>>();
    assert_eq!(names(robots), names(&listed));
    for robot in robots {
        let (fleet, name) = (robot["fleet"].as_str().unwrap(), robot["robot"].as_str().unwrap());
        let whiskers = served.items(&format!("/v1/whiskers?fleet={fleet}&robot={name}&limit=1000")).await;
        let shown = robot["whiskers"].as_array().unwrap();
        assert_eq!(shown.len(), whiskers.len());
        for (one, expected) in shown.iter().zip(&whiskers) {
            for (field, value) in one.as_object().unwrap() {
                assert_eq!(*value, expected[field], "{field}");
            }
        }
    }
}

/// The error of a compensation that was recorded last.
fn newest_error(served: &Served, compensation_id: i64) -> Option<f64> {
    let own = served.written.errors.iter().filter(|one| one.row.compensation_id == compensation_id);
    own.max_by_key(|one| one.row.recorded_us).map(|one| one.row.error.mean)
}

async fn the_overview_counts_what_the_lists_have(served: &Served) {
    for fleet in [None, Some("f"), Some("g")] {
        for from_us in [START_US, START_US + 2_000_000, START_US + 60_000_000] {
            check(served, fleet, from_us).await;
        }
    }
    // By default the last day counts; the rows are older or lie ahead.
    let overview = served.json("/v1/overview").await;
    assert!(overview["from"].is_string());
    assert_eq!(served.get("/v1/overview?since=24h").await.status, 422);
}

#[tokio::test]
async fn brute_force_the_overview_counts_what_the_lists_have_on_sqlite() {
    the_overview_counts_what_the_lists_have(&Served::sqlite().await).await;
}

#[tokio::test]
async fn brute_force_the_overview_counts_what_the_lists_have_on_postgres() {
    the_overview_counts_what_the_lists_have(&Served::postgres().await).await;
}
