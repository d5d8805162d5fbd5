//! Contacts over time.

use std::collections::BTreeMap;

use serde_json::Value;
use vibrissa_store::batch::ContactRow;
use vibrissa_store::time::Time;
use vibrissa_tests::web::Answer;

use crate::rows::{CONTACTS, START_US};
use crate::served::Served;

const WHISKER: &str = "/v1/fleets/f/robots/r1/arrays/left/whiskers/0";

fn close(a: &Value, b: f64, what: &str) {
    let a = a.as_f64().unwrap_or_else(|| panic!("{what} is {a}"));
    assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-6), "{what}: {a} is not {b}");
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count() as f64
}

/// Rows grouped into equal time spans, as the OpenAPI document defines them.
fn expected(rows: &[ContactRow], points: i64) -> BTreeMap<i64, Vec<&ContactRow>> {
    let (first, last) = (rows[0].t_us, rows[rows.len() - 1].t_us);
    let span_us = (last - first) / points + 1;
    let mut spans: BTreeMap<i64, Vec<&ContactRow>> = BTreeMap::new();
    for row in rows {
        spans.entry(first + (row.t_us - first) / span_us * span_us).or_default().push(row);
    }
    spans
}

async fn means_are_those_of_the_rows(served: &Served) {
    let rows = &served.written.contacts;
    let to = "2026-12-01T00:00:00Z";
    for points in [1, 7, 100, 2000] {
        let answer =
            served.json(&format!("{WHISKER}/contacts?from=2026-11-21T00:00:00Z&to={to}&points={points}")).await;
        assert_eq!(answer["total"], CONTACTS);
        let items = answer["items"].as_array().unwrap();
        let spans = expected(rows, points);
        assert_eq!(items.len(), spans.len(), "{points} points");
        assert!(items.len() as i64 <= points && answer["bucket_s"].as_f64().unwrap() > 0.0);
        for (item, (at_us, rows)) in items.iter().zip(&spans) {
            assert_eq!(item["at"], Time(*at_us).to_string());
            assert_eq!(item["contacts"], rows.len());
            close(&item["ratio"], mean(rows.iter().filter_map(|row| row.ratio)), "ratio");
            close(&item["strain"], mean(rows.iter().map(|row| row.strain)), "strain");
            close(&item["length_mm"], mean(rows.iter().map(|row| row.length_mm)), "length");
            close(&item["pressure_mpa"], mean(rows.iter().map(|row| row.pressure_mpa)), "pressure");
            close(&item["temperature_c"], mean(rows.iter().map(|row| row.temperature_c)), "temperature");
            let felt = rows.iter().filter(|row| row.deflection_mm > 0.0).map(|row| row.strain / row.deflection_mm);
            close(&item["sensitivity_per_mm"], mean(felt), "sensitivity");
            let residuals = rows.iter().filter_map(|row| row.residual);
            if residuals.clone().next().is_some() {
                close(&item["residual"], mean(residuals), "residual");
            } else {
                assert!(item["residual"].is_null());
            }
        }
    }
}

#[tokio::test]
async fn brute_force_means_are_those_of_the_rows_on_sqlite() {
    means_are_those_of_the_rows(&Served::sqlite().await).await;
}

#[tokio::test]
async fn brute_force_means_are_those_of_the_rows_on_postgres() {
    means_are_those_of_the_rows(&Served::postgres().await).await;
}

#[tokio::test]
async fn few_contacts_are_told_one_by_one() {
    for served in [Served::sqlite().await, Served::postgres().await] {
        let rows = &served.written.contacts;
        let newest = served.json(&format!("{WHISKER}/lengths")).await;
        assert_eq!((&newest["total"], &newest["bucket_s"]), (&500.into(), &Value::Null));
        let items = newest["items"].as_array().unwrap();
        assert_eq!(items.len(), 500);
        for (item, row) in items.iter().zip(&rows[rows.len() - 500..]) {
            close(&item["length_mm"], row.length_mm, "length");
            close(&item["length_low_mm"], row.length_mm - 1.959_963_984_540_054 * 0.25, "low");
        }
        let minute = format!("{WHISKER}/contacts?from=2026-11-21T08:00:10Z&to=2026-11-21T08:01:10Z");
        let minute = served.json(&minute).await;
        let within = rows.iter().filter(|row| (10_000_000..70_000_000).contains(&(row.t_us - START_US))).count();
        assert_eq!((&minute["total"], minute["items"].as_array().unwrap().len()), (&within.into(), within));
        assert!(within > 100 && minute["bucket_s"].is_null());
    }
}

#[tokio::test]
async fn times_of_nothing_are_empty_and_long_ones_are_cut() {
    let served = Served::sqlite().await;
    for (from, to) in
        [("2026-11-21T09:30:00Z", "2026-11-21T09:00:00Z"), ("0001-01-01T00:00:00Z", "0002-01-01T00:00:00Z")]
    {
        let answer = served.json(&format!("{WHISKER}/contacts?from={from}&to={to}")).await;
        assert_eq!((&answer["total"], &answer["items"]), (&0.into(), &Value::Array(Vec::new())));
    }
    let answer = served.json(&format!("{WHISKER}/contacts?from=0001-01-01T00:00:00Z&to=9999-12-31T23:59:59Z")).await;
    assert_eq!(answer["total"], CONTACTS);
    assert_eq!(
        answer["from"].as_str().unwrap().get(..10),
        Some("2026-10-21"),
        "the range must begin 31 days before the newest contact"
    );
    let untouched = served.json("/v1/fleets/f/robots/r1/arrays/left/whiskers/2/contacts").await;
    assert_eq!((&untouched["total"], &untouched["from"]), (&0.into(), &Value::Null));
}

#[tokio::test]
async fn each_contact_and_length_is_on_one_page_of_its_list() {
    for served in [Served::sqlite().await, Served::postgres().await] {
        let rows = &served.written.contacts;
        let pages = served.all(&format!("{WHISKER}/contacts/each?limit=700&order=ascending")).await;
        assert_eq!(pages.len(), rows.len());
        for (item, row) in pages.iter().zip(rows) {
            assert_eq!(item["at"], Time(row.t_us).to_string());
            assert_eq!(item["received_at"], Time(row.received_us).to_string());
            close(&item["strain"], row.strain, "strain");
            close(&item["length_mm"], row.length_mm, "length");
            assert_eq!((item["ratio"].as_f64(), item["residual"].as_f64()), (row.ratio, row.residual));
        }
        // Contacts of one moment are on different pages, and none is left out or told twice.
        let lengths = served.all(&format!("{WHISKER}/lengths/each?limit=1000")).await;
        let newest_first: Vec<_> = lengths.iter().map(|item| item["at"].clone()).collect();
        assert_eq!(newest_first, pages.iter().rev().map(|item| item["at"].clone()).collect::<Vec<_>>());
        for (item, row) in lengths.iter().zip(rows.iter().rev()) {
            close(&item["length_high_mm"], row.length_mm + 1.959_963_984_540_054 * 0.25, "high");
        }
        let minute = "from=2026-11-21T08:00:10Z&to=2026-11-21T08:01:10Z";
        let within = rows.iter().filter(|row| (10_000_000..70_000_000).contains(&(row.t_us - START_US))).count();
        assert_eq!(served.all(&format!("{WHISKER}/contacts/each?{minute}&limit=50")).await.len(), within);
        for (list, name) in [("contacts", "contacts.csv"), ("lengths", "lengths.csv")] {
            let csv = served.get(&format!("{WHISKER}/{list}/each?limit=1&format=csv")).await;
            assert_eq!(csv.headers["content-disposition"], format!("attachment; filename=\"{name}\""));
        }
        let other = pages_of_another_order(&served).await;
        assert_eq!((other.status, &other.json()["errors"][0]["field"]), (422, &"cursor".into()));
    }
}

/// The answer to a cursor of the list in the other order.
async fn pages_of_another_order(served: &Served) -> Answer {
    let page = served.json(&format!("{WHISKER}/contacts/each?limit=1")).await;
    let cursor = page["next_cursor"].as_str().unwrap();
    served.get(&format!("{WHISKER}/contacts/each?order=ascending&cursor={cursor}")).await
}
