//! Lists as CSV: the same rows as in JSON, whole lists as a stream, and no formulas.

use serde_json::Value;
use vibrissa_store::actions::NewAction;
use vibrissa_tests::web::{Answer, ask};

use crate::document::{Document, get_operations};
use crate::served::Served;

/// Column names and rows of a CSV answer.
fn parsed(answer: &Answer) -> (Vec<String>, Vec<Vec<String>>) {
    assert_eq!(answer.status, 200, "{}", answer.body);
    assert_eq!(answer.headers["content-type"], "text/csv; charset=utf-8; header=present");
    assert!(!answer.body.replace("\r\n", "").contains('\r'), "each line ends with CRLF");
    let mut reader = csv::Reader::from_reader(answer.body.as_bytes());
    let texts = |record: &csv::StringRecord| record.iter().map(ToOwned::to_owned).collect::<Vec<_>>();
    (texts(reader.headers().unwrap()), reader.records().map(|record| texts(&record.unwrap())).collect())
}

/// The text of a JSON value in CSV.
fn text(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Each list of the document, with names in its path.
async fn lists(served: &Served) -> Vec<String> {
    let document = Document::of(served).await;
    let is_list = |operation: &Value| operation["responses"]["200"]["content"].get("text/csv").is_some();
    let lists = get_operations(&document.0).filter(|(_, operation)| is_list(operation));
    let filled = |path: &str| {
        let values = [("{fleet}", "f"), ("{robot}", "r1"), ("{array}", "left"), ("{whisker}", "0")];
        values.into_iter().fold(path.to_owned(), |path, (name, value)| path.replace(name, value))
    };
    lists.map(|(path, _)| filled(path)).collect()
}

async fn every_list_has_the_same_rows_as_csv(served: &Served) {
    let lists = lists(served).await;
    assert!(lists.len() >= 15, "{lists:?}");
    for path in lists {
        let items = served.all(&format!("{path}?limit=1000")).await;
        let (columns, rows) = parsed(&served.get(&format!("{path}?format=csv")).await);
        assert!(columns.len() > 3, "{path}: {columns:?}");
        assert_eq!(rows.len(), items.len(), "{path}");
        for (row, item) in rows.iter().zip(&items) {
            let item = item.as_object().unwrap();
            assert!(item.keys().all(|name| columns.contains(name)), "{path}: {columns:?}");
            for (name, cell) in columns.iter().zip(row) {
                assert_eq!(*cell, text(&item[name]), "{path}: {name}");
            }
        }
    }
}

#[tokio::test]
async fn every_list_has_the_same_rows_as_csv_on_sqlite() {
    every_list_has_the_same_rows_as_csv(&Served::sqlite().await).await;
}

#[tokio::test]
async fn every_list_has_the_same_rows_as_csv_on_postgres() {
    every_list_has_the_same_rows_as_csv(&Served::postgres().await).await;
}

#[tokio::test]
async fn pages_of_csv_are_linked_and_the_header_accept_chooses_the_format() {
    let served = Served::sqlite().await;
    let whole = parsed(&served.get("/v1/whiskers?format=csv").await);
    let mut path = "/v1/whiskers?limit=5&sort=length_mm".to_owned();
    let mut rows = Vec::new();
    loop {
        let page = ask(served.http, "GET", &path, &[("Accept", "text/csv")]).await.unwrap();
        assert_eq!(page.headers["content-disposition"], "attachment; filename=\"whiskers.csv\"");
        rows.extend(parsed(&page).1);
        let Some(link) = page.headers.get("link") else { break };
        let query = link.strip_prefix('<').unwrap().strip_suffix(">; rel=\"next\"").unwrap();
        path = format!("/v1/whiskers{query}");
    }
    assert_eq!(rows.len(), whole.1.len());
    let at = whole.0.iter().position(|name| name == "length_mm").unwrap();
    assert!(rows.iter().map(|row| row[at].parse::<f64>().unwrap()).is_sorted());
    let json = ask(served.http, "GET", "/v1/whiskers?format=json", &[("Accept", "text/csv")]).await.unwrap();
    assert_eq!(json.headers["content-type"], "application/json");
    let refused = served.get("/v1/whiskers?format=xlsx").await;
    assert_eq!((refused.status, refused.json()["errors"][0]["field"].as_str()), (422, Some("format")));
}

fn action(reason: String) -> NewAction {
    NewAction {
        fleet: Some("f".to_owned()),
        robot: None,
        array: None,
        whisker: None,
        compensation_id: None,
        alarm_id: None,
        kind: "HOLD".to_owned(),
        parameters: "{}".to_owned(),
        reason: Some(reason),
        actor: "local".to_owned(),
        role: "ADMIN".to_owned(),
        request_id: "q".to_owned(),
        idempotency_key: None,
        asked_us: 1,
        expires_us: 2,
    }
}

#[tokio::test]
async fn a_long_list_follows_in_one_answer_and_texts_are_no_formulas() {
    let served = Served::sqlite().await;
    let many = 2100;
    for number in 0..many {
        served.store.ask(&action(format!("={number}+1"))).await.unwrap();
    }
    let (columns, rows) = parsed(&served.get("/v1/audit?format=csv&order=ascending&fleet=f").await);
    let at = columns.iter().position(|name| name == "reason").unwrap();
    let reasons: Vec<&str> =
        rows.iter().map(|row| row[at].as_str()).filter(|reason| reason.starts_with("'=")).collect();
    let expected: Vec<String> = (0..many).map(|number| format!("'={number}+1")).collect();
    assert_eq!(reasons, expected);
}
