//! Values that a database refuses, and failures of the database: no error text of the database reaches a client.

use std::net::SocketAddr;

use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde_json::{Value, json};
use sqlx::sqlite::SqliteConnection;
use sqlx::{ConnectOptions, Connection};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::wait::until;
use vibrissa_tests::web::{Answer, ask, send, try_get};

use crate::http_program::HttpProgram;

/// Words that appear only in errors of databases, drivers and statements, in lower case.
const WORDS: [&str; 12] = [
    "sqlx",
    "sqlite",
    "select ",
    "insert ",
    "relation",
    "column",
    "syntax",
    "utf8",
    "encoding",
    "no such table",
    "error returned",
    "os error",
];

fn assert_says_nothing_of_the_database(what: &str, answer: &Answer) {
    let body = answer.body.to_lowercase();
    for word in WORDS {
        assert!(!body.contains(word), "{what} says {word:?}: {}", answer.body);
    }
}

/// The answer to a request, repeated while the rate limit refuses it.
async fn asked(http: SocketAddr, method: &str, path: &str, body: Option<&Value>) -> Answer {
    until("an answer", async || {
        Some(send(http, method, path, &[], body).await.unwrap()).filter(|answer| answer.status != 429)
    })
    .await
}

fn assert_is_refused(what: &str, field: &str, answer: &Answer) {
    assert_eq!(answer.status, 400, "{what}: {}", answer.body);
    let problem = answer.json();
    assert_eq!(problem["type"], "/problems/malformed", "{what}");
    assert_eq!(problem["errors"][0]["field"], field, "{what}: {problem}");
    assert!(problem["detail"].as_str().unwrap().contains("NUL"), "{what}: {problem}");
    assert_says_nothing_of_the_database(what, answer);
}

/// Sends a NUL character in each parameter of every route, in cursors and in bodies.
async fn nul_everywhere(http: SocketAddr) {
    let document: Value = try_get(http, "/openapi.json").await.unwrap().1.parse().unwrap();
    let mut count = 0;
    for (path, methods) in document["paths"].as_object().unwrap() {
        for (method, operation) in methods.as_object().unwrap().iter().filter(|(name, _)| *name != "parameters") {
            let method = method.to_ascii_uppercase();
            let body = operation.get("requestBody").map(|_| json!({}));
            let parts: Vec<&str> = path.split('/').filter(|part| part.starts_with('{')).collect();
            // Numbers and names may be 1; the key of a label begins with a letter.
            let sound = |part: &str| if part == "{key}" { "a" } else { "1" };
            let filled = |nul: Option<&str>| {
                parts.iter().fold(path.clone(), |path, part| {
                    path.replace(part, if Some(*part) == nul { "a%00b" } else { sound(part) })
                })
            };
            for part in &parts {
                let answer = asked(http, &method, &filled(Some(part)), body.as_ref()).await;
                assert_is_refused(&format!("{method} {path} with NUL in {part}"), "path", &answer);
                count += 1;
            }
            let parameters = operation["parameters"].as_array().into_iter().flatten();
            for parameter in parameters.filter(|parameter| parameter["in"] == "query") {
                let name = parameter["name"].as_str().unwrap();
                let answer = asked(http, &method, &format!("{}?{name}=%00", filled(None)), body.as_ref()).await;
                assert_is_refused(&format!("{method} {path} with NUL in {name}"), "query", &answer);
                count += 1;
            }
            if body.is_some() {
                let body = json!({ "reason": "a\0b" });
                let answer = asked(http, &method, &filled(None), Some(&body)).await;
                assert_is_refused(&format!("{method} {path} with NUL in its body"), "reason", &answer);
                count += 1;
            }
        }
    }
    assert!(count > 150, "{count}");

    for (path, sort, descending) in [("whiskers", "robot", false), ("robots", "robot", false), ("alarms", "kind", true)]
    {
        let cursor = json!({ "sort": sort, "descending": descending, "place": { "value": "a\0b", "id": 1 } });
        let cursor = URL_SAFE_NO_PAD.encode(cursor.to_string());
        let answer = asked(http, "GET", &format!("/v1/{path}?cursor={cursor}"), None).await;
        assert_is_refused(&format!("a cursor of {path}"), "cursor", &answer);
    }
    // Names of fields, and deeply nested fields.
    let body = json!({ "model": "m", "youngs_modulus_mpa": 1.0, "rows": [{ "pressure_mpa": 0.1, "a\0b": 1 }] });
    let answer = asked(http, "POST", "/v1/calibrations", Some(&body)).await;
    assert_is_refused("a field's name", "rows[0].a\\u0000b", &answer);
}

#[tokio::test]
async fn regress_a_nul_anywhere_in_a_request_is_refused_on_sqlite() {
    let program = HttpProgram::start(&[]);
    nul_everywhere(program.http).await;
}

#[tokio::test]
async fn regress_a_nul_anywhere_in_a_request_is_refused_on_postgresql() {
    let server = Postgres::start().await;
    let program = HttpProgram::on(&server);
    nul_everywhere(program.http).await;
    assert!(!program.logged().contains("database query failed"), "{}", program.logged());
}

/// Renames a table, so that queries fail, and restores it.
const RENAME: &str = "ALTER TABLE trims RENAME TO others";
const RENAME_BACK: &str = "ALTER TABLE others RENAME TO trims";

/// A list whose table is missing: the client receives a request id, under which the log contains the database's error.
async fn a_table_is_missing(program: &HttpProgram, words: &str) {
    let answer = ask(program.http, "GET", "/v1/trims", &[("X-Request-Id", "the-one-that-fails")]).await.unwrap();
    assert_eq!(answer.status, 503, "{}", answer.body);
    assert_eq!(answer.json()["request_id"], "the-one-that-fails");
    assert_says_nothing_of_the_database("a list", &answer);
    let logged = program.logged();
    let line = logged.lines().find(|line| line.contains("the-one-that-fails"));
    assert!(line.is_some_and(|line| line.contains(words)), "{words}: {logged}");
}

#[tokio::test]
async fn regress_an_error_of_sqlite_is_logged_and_not_told() {
    let program = HttpProgram::start(&[]);
    let mut connection = SqliteConnection::connect(&program.sqlite()).await.unwrap();
    sqlx::raw_sql(RENAME).execute(&mut connection).await.unwrap();
    a_table_is_missing(&program, "no such table").await;
}

#[tokio::test]
async fn regress_an_error_of_postgresql_is_logged_and_not_told() {
    let mut server = Postgres::start().await;
    let program = HttpProgram::on(&server);
    let mut connection = server.connect().connect().await.unwrap();
    sqlx::raw_sql(RENAME).execute(&mut connection).await.unwrap();
    a_table_is_missing(&program, "does not exist").await;
    sqlx::raw_sql(RENAME_BACK).execute(&mut connection).await.unwrap();

    // Nor may the driver's errors about a stopped server reach clients; operators see which operation fails.
    server.kill();
    for path in ["/v1/whiskers", "/v1/setpoints/1", "/v1/events"] {
        let answer = ask(program.http, "GET", path, &[]).await.unwrap();
        assert_eq!(answer.status, 503, "{path}: {}", answer.body);
        assert_says_nothing_of_the_database(path, &answer);
    }
    // The supervisor notices the failure when it renews its leases.
    let answer = until("not ready", async || {
        Some(ask(program.monitoring, "GET", "/readyz", &[]).await.unwrap()).filter(|answer| answer.status == 503)
    })
    .await;
    assert_says_nothing_of_the_database("/readyz", &answer);
    let reasons = answer.json()["reasons"].to_string();
    assert!(reasons.contains("database error: cannot"), "{reasons}");
    server.restart().await;
    until("ready again", async || {
        try_get(program.monitoring, "/readyz").await.ok().filter(|(status, _)| *status == 200)
    })
    .await;
}
