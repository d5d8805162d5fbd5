//! Staged roll-outs: requests, and measured errors of robots as if they came from contacts.

use std::net::SocketAddr;

use serde_json::{Value, json};
use sqlx::{PgConnection, SqliteConnection};
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::rollout::place;
use vibrissa_core::units::Megapascal;
use vibrissa_simulator::clock::now_us;

use crate::wait::until;
use crate::web::{send, try_get};

/// Status and JSON of the answer to a request with a body.
///
/// # Panics
/// The service does not answer.
pub async fn ask(http: SocketAddr, method: &str, path: &str, body: Value) -> (u16, Value) {
    let answer = send(http, method, path, &[], Some(&body)).await.expect("an answer");
    (answer.status, answer.json())
}

/// The answer to a POST that must succeed.
///
/// # Panics
/// It does not.
pub async fn done(http: SocketAddr, path: &str, body: Value) -> Value {
    let (status, answer) = ask(http, "POST", path, body).await;
    assert_eq!(status, 200, "{path}: {answer}");
    answer
}

/// The roll-out with its events.
///
/// # Panics
/// It is unknown.
pub async fn read(http: SocketAddr, id: &Value) -> Value {
    let (status, body) = try_get(http, &format!("/v1/rollouts/{id}")).await.expect("an answer");
    assert_eq!(status, 200, "{body}");
    serde_json::from_str(&body).expect("JSON")
}

/// The roll-out once its state or stage is as expected.
pub async fn reaches(http: SocketAddr, id: &Value, field: &str, word: &str) -> Value {
    until(&format!("{field} {word}"), async || {
        let detail = read(http, id).await;
        Some(detail).filter(|detail| detail["rollout"][field] == word)
    })
    .await
}

/// The kinds of the events, the oldest first.
///
/// # Panics
/// There are none.
#[must_use]
pub fn events(detail: &Value) -> Vec<&str> {
    let events = detail["events"].as_array().expect("events");
    events.iter().rev().map(|event| event["event"].as_str().expect("a word")).collect()
}

/// The names that a roll-out changes first, of these.
///
/// # Panics
/// The number of the roll-out is none.
#[must_use]
pub fn in_order(id: &Value, names: &[String]) -> Vec<String> {
    let seed = id.as_u64().expect("a number");
    let mut names = names.to_vec();
    names.sort_by_key(|name| place(seed, name));
    names
}

/// A calibration with the numbers of the paper's whiskers, as another version; its number.
///
/// # Panics
/// The service refuses it.
pub async fn uploaded(http: SocketAddr) -> Value {
    let model = Model::nguyen_2021(Formulation::Published);
    let truth = *model.calibration();
    let row = |pressure_mpa: f64| {
        let k2 = truth.c + truth.a * (-truth.b_per_mpa * pressure_mpa).exp();
        let pressure = Megapascal::new(pressure_mpa).expect("a pressure");
        json!({ "pressure_mpa": pressure_mpa, "strain": model.axial_strain(pressure).ratio(),
                "elongation_mm": truth.elongation_gain_mm * pressure_mpa / (k2 * truth.youngs_modulus_mpa) })
    };
    let rows: Vec<Value> = [0.02, 0.05, 0.08, 0.12, 0.16, 0.2].into_iter().map(row).collect();
    let body = json!({ "model": "nguyen-2021", "youngs_modulus_mpa": truth.youngs_modulus_mpa, "rows": rows });
    let (status, answer) = ask(http, "POST", "/v1/calibrations", body).await;
    assert_eq!(status, 201, "{answer}");
    answer["calibration_id"].clone()
}

/// A connection to the database of the service.
#[derive(Debug)]
pub enum Link {
    /// To a file of SQLite.
    Sqlite(Box<SqliteConnection>),
    /// To a PostgreSQL.
    Postgres(Box<PgConnection>),
}

/// Writes a decision of each robot with its measured error, as if it came from contacts.
#[derive(Debug)]
pub struct Errors {
    link: Link,
    next: i64,
}

const DECISION: &str = "INSERT INTO compensations (compensation_id, robot_id, target_whisker_id, target_length_mm, \
     target_pressure_mpa, compensator_whisker_id, decided_us) SELECT $1, w.robot_id, whisker_id, 65, 0.1, whisker_id, $2 \
     FROM whiskers w JOIN robots r ON r.robot_id = w.robot_id WHERE robot = $3 LIMIT 1";
const ERROR: &str = "INSERT INTO compensation_errors (compensation_id, recorded_us, contacts, bins, error, error_low, \
     error_high) VALUES ($1, $2, 100, 5, $3, 0, 1)";

impl Errors {
    /// Writes through this connection.
    #[must_use]
    pub fn of(link: Link) -> Self {
        Self { link, next: 9_000_000_000_000_000 }
    }

    /// Writes an error of each robot, all in one transaction: a comparison meanwhile must not see a part of them.
    ///
    /// # Panics
    /// The database refuses it.
    pub async fn write(&mut self, robots: &[String], error: impl Fn(usize) -> f64) {
        let now_us = now_us() as i64;
        macro_rules! insert {
            ($link:expr, $begin:literal) => {{
                sqlx::query($begin).execute(&mut **$link).await.expect("a transaction");
                for (at, robot) in robots.iter().enumerate() {
                    self.next += 1;
                    let decision = sqlx::query(DECISION).bind(self.next).bind(now_us).bind(robot);
                    decision.execute(&mut **$link).await.expect("a decision");
                    let error = sqlx::query(ERROR).bind(self.next).bind(now_us).bind(error(at));
                    error.execute(&mut **$link).await.expect("an error");
                }
                sqlx::query("COMMIT").execute(&mut **$link).await.expect("a commit");
            }};
        }
        match &mut self.link {
            Link::Sqlite(link) => insert!(link, "BEGIN IMMEDIATE"),
            Link::Postgres(link) => insert!(link, "BEGIN"),
        }
    }
}
