//! `vibrissa export`: DuckDB and the MCAP library read the same rows as the API returns.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::{Map, Value, json};
use vibrissa_protocol::Timestamp;
use vibrissa_tests::python::environment;

use crate::rows::{CONTACTS, START_US};
use crate::served::Served;

/// Runs `vibrissa export` in a folder.
fn export(folder: &Path, arguments: &[&str]) -> Output {
    let mut program = Command::new(env!("CARGO_BIN_EXE_vibrissa-under-test"));
    program.arg("export").args(arguments).current_dir(folder).env_remove("RUST_LOG").output().unwrap()
}

fn summary(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Content of a file by Python's libraries.
fn read(path: &Path) -> Value {
    let python = environment("requirements-export.txt", env!("CARGO_TARGET_TMPDIR")).join("python");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/integration/http/read_export.py");
    let output = Command::new(python).arg(script).arg(path).output().unwrap();
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&output.stderr)))
}

/// A row of the API as the export names and writes it.
fn as_exported(row: &Value) -> Map<String, Value> {
    let cell = |(name, value): (&String, &Value)| {
        let name = if name == "case" { "compensation_case" } else { name };
        let is_time = name.ends_with("_at");
        let time = value.as_str().filter(|_| is_time).map(|text| json!(text.parse::<Timestamp>().unwrap().0));
        (name.to_owned(), time.unwrap_or_else(|| value.clone()))
    };
    row.as_object().unwrap().iter().map(cell).collect()
}

/// Rows in an order that both sides share, with times in ms as in the API.
fn sorted(rows: Vec<Map<String, Value>>) -> Vec<String> {
    let cell = |(name, value): (String, Value)| {
        let value = match value.as_f64() {
            Some(us) if name.ends_with("_at") => json!((us / 1000.0).floor()),
            // DuckDB returns whole numbers of a CSV column with decimals as floating-point numbers.
            Some(number) => json!(number),
            None => value,
        };
        (name, value)
    };
    let text = |row: Map<String, Value>| Value::Object(row.into_iter().map(cell).collect()).to_string();
    let mut rows: Vec<String> = rows.into_iter().map(text).collect();
    rows.sort();
    rows
}

fn rows(content: &Value) -> Vec<Map<String, Value>> {
    content["rows"].as_array().unwrap().iter().map(|row| row.as_object().unwrap().clone()).collect()
}

/// All minutes of a fleet by the API.
async fn minutes(served: &Served) -> Vec<Map<String, Value>> {
    let mut all = Vec::new();
    for whisker in served.all("/v1/whiskers?fleet=f").await {
        let text = |name: &str| whisker[name].as_str().unwrap().to_owned();
        let (robot, array, number) = (text("robot"), text("array"), &whisker["whisker"]);
        let path = format!("/v1/fleets/f/robots/{robot}/arrays/{array}/whiskers/{number}/history");
        for minute in served.all(&format!("{path}?resolution=minute&limit=1000")).await {
            let mut row = as_exported(&minute);
            for name in ["fleet", "robot", "array", "whisker"] {
                row.insert(name.to_owned(), whisker[name].clone());
            }
            all.push(row);
        }
    }
    all
}

async fn files_have_the_rows_of_the_api(served: &Served) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let database = served.database.to_string();
    let of_api = |path: &'static str| async move { served.all(path).await.iter().map(as_exported).collect::<Vec<_>>() };
    let expected = [
        ("minutes", minutes(served).await),
        ("decisions", of_api("/v1/compensations?fleet=f&limit=1000").await),
        ("errors", of_api("/v1/errors?fleet=f&limit=1000").await),
    ];
    for (table, expected) in expected {
        assert!(!expected.is_empty(), "{table}");
        for format in ["parquet", "csv"] {
            let file = format!("{table}.{format}");
            let arguments = [table, "--fleet", "f", &format!("--{format}"), &file, "--database-url", &database];
            let line = summary(&export(folder.path(), &arguments));
            assert!(line.starts_with(&format!("{file}: {} rows of {table}", expected.len())), "{line}");
            let content = read(&at(&file));
            let (found, expected) = (sorted(rows(&content)), sorted(expected.clone()));
            let differs = found.iter().zip(&expected).find(|(found, expected)| found != expected);
            assert_eq!((found.len(), differs), (expected.len(), None), "{file}");
        }
    }
    let line =
        summary(&export(folder.path(), &["contacts", "--parquet", "contacts.parquet", "--database-url", &database]));
    let content = read(&at("contacts.parquet"));
    let types = &content["types"];
    assert_eq!([&types["at"], &types["strain"], &types["whisker"]], ["TIMESTAMP WITH TIME ZONE", "DOUBLE", "BIGINT"]);
    let all = rows(&content);
    assert!(line.contains(&format!("{} rows", all.len())), "{line}");
    let of_first = |row: &&Map<String, Value>| {
        (&row["fleet"], &row["robot"], &row["whisker"]) == (&json!("f"), &json!("r1"), &json!(0))
    };
    let mut first: Vec<(i64, f64, f64)> = all
        .iter()
        .filter(of_first)
        .map(|row| (row["at"].as_i64().unwrap(), row["strain"].as_f64().unwrap(), row["length_mm"].as_f64().unwrap()))
        .collect();
    first.sort_by_key(|row| row.0);
    let written = &served.written.contacts;
    let id = written[0].whisker_id;
    let mut expected: Vec<(i64, f64, f64)> =
        written.iter().filter(|row| row.whisker_id == id).map(|row| (row.t_us, row.strain, row.length_mm)).collect();
    expected.sort_by_key(|row| row.0);
    assert_eq!(first.len() as i64, CONTACTS);
    assert_eq!(first, expected);
    between(served, folder.path(), &all);
}

/// `--from` includes its time, `--to` excludes it.
fn between(served: &Served, folder: &Path, all: &[Map<String, Value>]) {
    let times: Vec<i64> = all.iter().map(|row| row["at"].as_i64().unwrap()).collect();
    let day_us = 86_400_000_000;
    let day = |days: i64| Timestamp((START_US + days * day_us) as u64).to_string()[..10].to_owned();
    let (from, to) = (day(0), day(1));
    let begin = START_US / day_us * day_us;
    let expected = times.iter().filter(|&&at| (begin..begin + day_us).contains(&at)).count();
    let database = served.database.to_string();
    let arguments = ["contacts", "--from", &from, "--to", &to, "--csv", "day.csv", "--database-url", &database];
    let line = summary(&export(folder, &arguments));
    assert!(line.starts_with(&format!("day.csv: {expected} rows")), "{line}");
    let again = export(folder, &arguments);
    assert!(!again.status.success() && String::from_utf8_lossy(&again.stderr).contains("exists already"));
    let mut names: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.retain(|name| name.to_string_lossy().contains("partial"));
    assert_eq!(names, Vec::<PathBuf>::new());
}

#[tokio::test(flavor = "multi_thread")]
async fn files_have_the_rows_of_the_api_on_sqlite() {
    files_have_the_rows_of_the_api(&Served::sqlite().await).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn files_have_the_rows_of_the_api_on_postgres() {
    files_have_the_rows_of_the_api(&Served::postgres().await).await;
}

#[test]
fn a_recording_becomes_an_mcap_file_with_schemas() {
    let folder = tempfile::tempdir().unwrap();
    let lines = [
        r#"{"received_us":1795248000000001,"topic":"whisker/v1/lab/crawler/contacts","payload":{"seq":1,"contacts":[]}}"#,
        r#"{"received_us":1795248000000002,"topic":"whisker/v1/lab/crawler/status","payload":{"whiskers":[]}}"#,
        r#"{"received_us":1795248000000003,"topic":"whisker/v1/lab/crawler/contacts","payload":{"seq":2,"contacts":[]}}"#,
        r#"{"received_us":1795248000000004,"topic":"whisker/v1/lab/crawler/other","payload":{"a":1}}"#,
        r#"{"received_us":1795248000000005,"topic":"whisker/v1/lab/crawler/contacts","payload":"text"}"#,
        "no JSON",
    ];
    std::fs::write(folder.path().join("lab.jsonl"), lines.join("\n")).unwrap();
    let output = export(folder.path(), &["--mcap", "lab.jsonl", "lab.mcap"]);
    assert_eq!(summary(&output), "lab.mcap: 4 messages converted\n");
    assert!(String::from_utf8_lossy(&output.stderr).contains("2 lines without a JSON object were left out"));
    let messages = read(&folder.path().join("lab.mcap"));
    let messages = messages.as_array().unwrap();
    assert_eq!(messages.len(), 4);
    for (message, line) in messages.iter().zip(lines) {
        let line: Value = serde_json::from_str(line).unwrap();
        assert_eq!((&message["topic"], &message["data"]), (&line["topic"], &line["payload"]));
        assert_eq!(message["time_ns"].as_u64().unwrap(), line["received_us"].as_u64().unwrap() * 1000);
        assert_eq!(message["encoding"], "json");
    }
    let schema: Value = serde_json::from_str(include_str!("../../../docs/schemas/contacts.json")).unwrap();
    assert_eq!(
        messages[0]["schema"],
        json!({ "name": "contacts", "encoding": "jsonschema", "title": schema["title"] })
    );
    assert_eq!((&messages[1]["schema"]["name"], &messages[3]["schema"]), (&json!("status"), &Value::Null));
    let missing = export(folder.path(), &["--mcap", "nothing.jsonl", "x.mcap"]);
    assert!(String::from_utf8_lossy(&missing.stderr).contains("cannot read nothing.jsonl"));
    let both = export(folder.path(), &["errors", "--mcap", "lab.jsonl", "x.mcap"]);
    assert_eq!(both.status.code(), Some(2));
}
