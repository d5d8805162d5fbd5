//! Aggregates of a whisker by minute and hour.

use serde_json::Value;
use vibrissa_store::Resolution;
use vibrissa_store::batch::RollupRow;
use vibrissa_store::time::Time;
use vibrissa_tests::web::ask;

use crate::rows::{HOURS, MINUTES, START_US, rollups};
use crate::served::Served;

const HISTORY: &str = "/v1/fleets/f/robots/r1/arrays/left/whiskers/1/history";

fn same(item: &Value, row: &RollupRow) {
    let number = |number: Option<f32>| number.map_or(Value::Null, |number| f64::from(number).into());
    assert_eq!(item["start_at"], Time(row.start_us).to_string());
    for (name, count) in ["contacts_used", "contacts_learning", "contacts_unused"].into_iter().zip(row.contacts) {
        assert_eq!(item[name], count, "{name}");
    }
    let residual = ["residual_mean", "residual_sd", "residual_min", "residual_max"].into_iter().zip(row.residual);
    let others = [
        ("sensitivity_per_mm", row.sensitivity_per_mm),
        ("ratio", row.ratio),
        ("length_mm", row.length_mm),
        ("length_sd_mm", row.length_sd_mm),
        ("length_mean_mm", row.length_mean_mm),
        ("pressure_mpa", row.pressure_mpa),
        ("temperature_c", row.temperature_c),
        ("compensation_error", row.compensation_error),
    ];
    for (name, value) in residual.chain(others) {
        assert_eq!(item[name], number(value), "{name}");
    }
}

async fn history_is_what_was_written(served: &Served) {
    let written = rollups(&[0, 1, 2]);
    for (resolution, count) in [("minute", MINUTES), ("hour", HOURS)] {
        let query = format!("{HISTORY}?resolution={resolution}");
        let all = served.all(&format!("{query}&order=ascending&limit=50")).await;
        let rows = written.iter().filter(|row| row.whisker_id == 1);
        let rows: Vec<_> = rows.filter(|row| (row.resolution == Resolution::Hour) == (resolution == "hour")).collect();
        assert_eq!((all.len(), rows.len()), (count as usize, count as usize));
        all.iter().zip(&rows).for_each(|(item, row)| same(item, row));
        // Newest first unless the request says otherwise.
        let newest = served.items(&format!("{query}&limit=3")).await;
        assert_eq!(newest, all.iter().rev().take(3).cloned().collect::<Vec<_>>());
        let within = served.items(&format!("{query}&from=2026-11-21T09:00:00Z&to=2026-11-21T10:00:00Z")).await;
        let is_within =
            |item: &&Value| ("2026-11-21T09".."2026-11-21T10").contains(&item["start_at"].as_str().unwrap());
        assert_eq!(within, all.iter().rev().filter(is_within).cloned().collect::<Vec<_>>());
        assert_eq!(within.len(), if resolution == "minute" { 60 } else { 1 });
    }
    assert_eq!(Time(START_US).to_string(), "2026-11-21T08:00:00.000Z");
    assert_eq!(served.items(HISTORY).await.len() as i64, HOURS, "hours are the default");
    for (query, status) in [("?resolution=day", 422), ("?from=yesterday", 422), ("?cursor=x", 422)] {
        let answer = ask(served.http, "GET", &format!("{HISTORY}{query}"), &[]).await.unwrap();
        assert_eq!(answer.status, status, "{query}");
    }
    let nobody = ask(served.http, "GET", &HISTORY.replace("/1/", "/9/"), &[]).await.unwrap();
    assert_eq!(nobody.status, 404);
}

#[tokio::test]
async fn history_is_what_was_written_on_sqlite() {
    history_is_what_was_written(&Served::sqlite().await).await;
}

#[tokio::test]
async fn history_is_what_was_written_on_postgres() {
    history_is_what_was_written(&Served::postgres().await).await;
}
