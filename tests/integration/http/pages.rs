//! Paging, sorting and filters of lists.

use serde_json::Value;

use crate::document::{Document, get_operations};
use crate::served::Served;

/// Whether the items are in order of a column; items without it are ignored.
fn sorted_by(items: &[Value], column: &str, descending: bool) -> bool {
    let value = |item: &Value| item.get(column).cloned();
    let is_in_order = |a: &Value, b: &Value| match (a, b) {
        (Value::String(a), Value::String(b)) => a <= b,
        (a, b) => a.as_f64() <= b.as_f64(),
    };
    items.windows(2).all(|pair| match (value(&pair[0]), value(&pair[1])) {
        (Some(a), Some(b)) => {
            if descending {
                is_in_order(&b, &a)
            } else {
                is_in_order(&a, &b)
            }
        }
        _ => true,
    })
}

/// For each list, sort and order: all pages together are the whole list in order, with each row once.
async fn pages_are_the_list(served: &Served) {
    let document = Document::of(served).await;
    let mut lists = 0;
    for (path, operation) in get_operations(&document.0) {
        let Some(sorts) = document.words(operation, "sort") else { continue };
        // No operator actions were written, so their list is empty.
        if path.contains('{') || served.items(path).await.is_empty() {
            continue;
        }
        lists += 1;
        for sort in sorts {
            for order in ["ascending", "descending"] {
                let query = format!("{path}?sort={sort}&order={order}");
                let whole = served.items(&format!("{query}&limit=1000")).await;
                assert!(whole.len() >= 2 && whole.len() < 1000, "{query}: {} rows", whole.len());
                assert!(sorted_by(&whole, &sort, order == "descending"), "{query}");
                for limit in [1, 2, 7] {
                    assert_eq!(served.all(&format!("{query}&limit={limit}")).await, whole, "{query} by {limit}");
                }
            }
        }
        let mut rows: Vec<String> = served.all(&format!("{path}?limit=5")).await.iter().map(Value::to_string).collect();
        let count = rows.len();
        rows.sort();
        rows.dedup();
        assert_eq!(rows.len(), count, "{path}: every row must appear once");
    }
    assert!(lists >= 10, "some lists were skipped");
}

#[tokio::test]
async fn property_pages_are_the_list_on_sqlite() {
    pages_are_the_list(&Served::sqlite().await).await;
}

#[tokio::test]
async fn property_pages_are_the_list_on_postgres() {
    pages_are_the_list(&Served::postgres().await).await;
}

/// Path of a list, its filter, and the condition that remaining items satisfy.
type Filtered = (&'static str, &'static str, Box<dyn Fn(&Value) -> bool>);

/// Filters return the items that satisfy their condition, and no others.
async fn filters_keep_what_they_name(served: &Served) {
    let is = |field: &'static str, value: Value| move |item: &Value| item[field] == value;
    let at = "2026-11-21T08:00:02.000Z";
    let cases: [Filtered; 19] = [
        ("robots", "fleet=f", Box::new(is("fleet", "f".into()))),
        ("robots", "connection=SILENT", Box::new(is("connection", "SILENT".into()))),
        ("robots", "connection=OFFLINE", Box::new(is("connection", "OFFLINE".into()))),
        ("arrays", "robot=r2", Box::new(is("robot", "r2".into()))),
        ("whiskers", "faulty=true", Box::new(|item| !item["fault"].is_null())),
        ("trims", "whisker=1", Box::new(is("whisker", 1.into()))),
        ("trims", "from=2026-11-21T08:00:02Z", Box::new(move |item| item["detected_at"].as_str().unwrap() >= at)),
        ("trims", "to=2026-11-21T09:00:02%2B01:00", Box::new(move |item| item["detected_at"].as_str().unwrap() < at)),
        ("compensations", "active=true", Box::new(|item| item["ended_at"].is_null())),
        ("compensations", "case=SHORTER_FOR_LONGER", Box::new(is("case", "SHORTER_FOR_LONGER".into()))),
        ("compensations", "compensator_whisker=2", Box::new(is("compensator_whisker", 2.into()))),
        ("setpoints", "whisker=2", Box::new(is("whisker", 2.into()))),
        ("touch-tests", "whisker=2", Box::new(is("whisker", 2.into()))),
        ("touch-tests", "state=REJECTED", Box::new(is("error", "NOT_READY".into()))),
        ("touch-tests", "robot=r2", Box::new(is("robot", "r2".into()))),
        (
            "touch-tests",
            "from=2026-11-21T08:00:02Z",
            Box::new(move |item| item["requested_at"].as_str().unwrap() >= at),
        ),
        ("errors", "whisker=2", Box::new(is("target_whisker", 2.into()))),
        ("health-changes", "kind=FAULT", Box::new(is("kind", "FAULT".into()))),
        ("alarms", "standing=true", Box::new(is("standing", true.into()))),
    ];
    for (list, filter, expected) in cases {
        let all = served.items(&format!("/v1/{list}?limit=1000")).await;
        let kept = served.items(&format!("/v1/{list}?limit=1000&{filter}")).await;
        assert_eq!(kept, all.iter().filter(|item| expected(item)).cloned().collect::<Vec<_>>(), "{list} {filter}");
        assert!(!kept.is_empty() && kept.len() < all.len(), "{list} {filter}: {} of {}", kept.len(), all.len());
    }
}

#[tokio::test]
async fn filters_keep_what_they_name_on_sqlite() {
    filters_keep_what_they_name(&Served::sqlite().await).await;
}

#[tokio::test]
async fn filters_keep_what_they_name_on_postgres() {
    filters_keep_what_they_name(&Served::postgres().await).await;
}

#[tokio::test]
async fn regress_whiskers_are_found_by_their_model() {
    let served = Served::sqlite().await;
    let whiskers = served.items("/v1/whiskers?limit=1000").await;
    assert_eq!(served.items("/v1/whiskers?limit=1000&model=nguyen-2021").await, whiskers);
    assert_eq!(served.items("/v1/whiskers?model=nguyen").await, Vec::<Value>::new());
}

/// Counts of fleets, robots and arrays agree with the lists of whiskers and alarms.
#[tokio::test]
async fn brute_force_counts_are_those_of_the_lists() {
    for served in [Served::sqlite().await, Served::postgres().await] {
        let whiskers = served.items("/v1/whiskers?limit=1000").await;
        let alarms = served.items("/v1/alarms?limit=1000&standing=true").await;
        for (list, keys) in
            [("fleets", &["fleet"][..]), ("robots", &["fleet", "robot"]), ("arrays", &["fleet", "robot", "array"])]
        {
            for one in served.items(&format!("/v1/{list}")).await {
                let is_of = |item: &&Value| keys.iter().all(|key| item[key] == one[key]);
                let count =
                    |keep: &dyn Fn(&Value) -> bool| whiskers.iter().filter(is_of).filter(|item| keep(item)).count();
                assert_eq!(one["whiskers"], count(&|_| true), "{one}");
                let is_faulty = |item: &Value| !item["fault"].is_null();
                assert_eq!(one["whiskers_trimmed"], count(&|item| item["condition"] == "TRIMMED"), "{one}");
                let is_unserved = |item: &Value| item["condition"] == "TRIMMED" && item["compensated_by"].is_null();
                assert_eq!(one["whiskers_uncompensated"], count(&is_unserved), "{one}");
                let is_well = |item: &Value| item["condition"] == "HEALTHY" && item["fault"].is_null();
                assert_eq!(one["whiskers_healthy"], count(&is_well), "{one}");
                assert_eq!(one["whiskers_faulty"], count(&|item| is_faulty(item) && !is_unserved(item)), "{one}");
                let is_served = |item: &Value| item["condition"] == "TRIMMED" && !is_unserved(item) && !is_faulty(item);
                assert_eq!(one["whiskers_compensated"], count(&is_served), "{one}");
                let states = ["healthy", "learning", "worn", "compensated", "uncompensated", "faulty"];
                let sum: i64 = states.iter().map(|state| one[format!("whiskers_{state}")].as_i64().unwrap()).sum();
                assert_eq!(one["whiskers"], sum, "each whisker is in one count: {one}");
                assert_eq!(one["alarms"], alarms.iter().filter(is_of).count(), "{one}");
            }
        }
        let fleet = served.json("/v1/fleets/f").await;
        assert_eq!((&fleet["supervised"], &fleet["holder"]), (&true.into(), &"supervisor a".into()));
        assert_eq!([&fleet["robots"], &fleet["robots_online"], &fleet["robots_silent"]], [2, 0, 1], "r1 is silent");
    }
}
