//! Grouped compensation errors.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::rows::WrittenError;
use crate::served::Served;

/// Newest error of each compensation in each time bucket.
fn newest(errors: &[WrittenError], bucket_us: i64) -> Vec<&WrittenError> {
    let mut newest = BTreeMap::new();
    for error in errors {
        newest.insert((error.row.compensation_id, error.row.recorded_us / bucket_us), error);
    }
    newest.into_values().collect()
}

fn grouped<'a, K: Ord>(
    errors: impl IntoIterator<Item = &'a WrittenError>,
    key: impl Fn(&WrittenError) -> K,
) -> BTreeMap<K, Vec<&'a WrittenError>> {
    let mut groups: BTreeMap<K, Vec<&WrittenError>> = BTreeMap::new();
    for error in errors {
        groups.entry(key(error)).or_default().push(error);
    }
    groups
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let count = values.clone().count();
    (count > 0).then(|| values.sum::<f64>() / count as f64)
}

fn check(item: &Value, group: &[&WrittenError]) {
    assert_eq!(item["compensations"], group.len(), "{item}");
    let close = |field: &str, expected: Option<f64>| match (item[field].as_f64(), expected) {
        (Some(a), Some(b)) => assert!((a - b).abs() < 1e-12, "{field} {item}: {b}"),
        (actual, expected) => assert_eq!(actual, expected, "{field} {item}"),
    };
    close("error", mean(group.iter().map(|one| one.row.error.mean)));
    close("error_low", mean(group.iter().map(|one| one.row.error.low)));
    close("error_high", mean(group.iter().map(|one| one.row.error.high)));
    close("error_with_gain", mean(group.iter().filter_map(|one| Some(one.row.with_gain?.mean))));
    close("air_error", mean(group.iter().filter_map(|one| Some(one.row.air_error?.mean))));
}

async fn groups_are_those_of_the_rows(served: &Served) {
    let errors = &served.written.errors;
    let each = newest(errors, i64::MAX);

    let items = served.items("/v1/errors/by-case").await;
    let cases = grouped(each.iter().copied(), |one| one.case);
    assert_eq!(items.len(), cases.len());
    for (item, (case, group)) in items.iter().zip(&cases) {
        assert_eq!(item["case"], *case);
        check(item, group);
    }

    let items = served.items("/v1/errors/by-whisker?fleet=f").await;
    let whiskers = grouped(each.iter().copied().filter(|one| one.fleet == "f"), |one| (one.robot.clone(), one.target));
    assert_eq!(items.len(), whiskers.len());
    for item in &items {
        let key = (item["robot"].as_str().unwrap().to_owned(), item["whisker"].as_u64().unwrap() as usize);
        check(item, &whiskers[&key]);
    }
    assert!(
        items.windows(2).all(|pair| pair[0]["error"].as_f64() >= pair[1]["error"].as_f64()),
        "the worst must come first"
    );

    for bucket_s in [60, 600, 31_536_000] {
        let items = served.items(&format!("/v1/errors/by-time?bucket_s={bucket_s}")).await;
        let bucket_us = bucket_s * 1_000_000;
        let spans = grouped(newest(errors, bucket_us), |one| one.row.recorded_us / bucket_us);
        assert_eq!(items.len(), spans.len());
        for (item, (span, group)) in items.iter().zip(&spans) {
            assert_eq!(item["at"], vibrissa_store::time::Time(span * bucket_us).to_string());
            check(item, group);
        }
    }
}

async fn ratios_are_those_of_the_rows(served: &Served) {
    let each = newest(&served.written.errors, i64::MAX);
    let items = served.items("/v1/errors/by-ratio").await;
    assert_eq!(items.iter().map(|item| item["ratio"].as_f64().unwrap()).collect::<Vec<_>>(), [0.5, 0.9]);
    for item in &items {
        let bins = each.iter().flat_map(|one| &one.row.bins).filter(|bin| item["ratio"] == bin.ratio);
        assert_eq!(item["compensations"], bins.clone().count());
        assert_eq!(item["contacts"], bins.clone().map(|bin| bin.contacts).sum::<i64>());
        let expected = mean(bins.clone().map(|bin| bin.error.mean)).unwrap();
        assert!((item["error"].as_f64().unwrap() - expected).abs() < 1e-12, "{item}: {expected}");
        let high = mean(bins.map(|bin| bin.error.high)).unwrap();
        assert!((item["error_high"].as_f64().unwrap() - high).abs() < 1e-12, "{item}: {high}");
    }
}

#[tokio::test]
async fn brute_force_groups_are_those_of_the_rows_on_sqlite() {
    let served = Served::sqlite().await;
    groups_are_those_of_the_rows(&served).await;
    ratios_are_those_of_the_rows(&served).await;
}

#[tokio::test]
async fn brute_force_groups_are_those_of_the_rows_on_postgres() {
    let served = Served::postgres().await;
    groups_are_those_of_the_rows(&served).await;
    ratios_are_those_of_the_rows(&served).await;
}
