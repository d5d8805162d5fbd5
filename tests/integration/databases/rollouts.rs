//! A staged roll-out by the engine on PostgreSQL: it advances without a difference of errors, and rolls a worse change back.

use serde_json::json;
use sqlx::{ConnectOptions, PgConnection};
use vibrissa_core::policy::{Mode, PolicyParams};
use vibrissa_protocol::ArrayType;
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::rollouts::{Errors, Link, done, events, in_order, reaches};
use vibrissa_tests::wait::until_true;

use crate::actions::{owns, supervisor};

const ROBOTS: usize = 84;

async fn number(link: &mut PgConnection, sql: &'static str) -> i64 {
    sqlx::query_scalar(sql).fetch_one(link).await.unwrap()
}

#[tokio::test]
async fn a_roll_out_advances_or_is_rolled_back_by_the_errors_on_postgres() {
    let (broker, server) = (Mosquitto::start(), Postgres::start().await);
    let service = supervisor("a", server.port(), &broker).await;
    let http = service.http;
    until_true("an owner", async || owns(&service)).await;
    let names: Vec<String> = (0..ROBOTS).map(|number| format!("r{number:03}")).collect();
    let mut robots = Vec::new();
    for name in &names {
        robots.push(HandRobot::born(broker.port(), name, array(ArrayType::Type2, &[70.0])).await);
    }
    let mut link = server.connect().connect().await.unwrap();
    let known = "SELECT count(*) FROM whiskers WHERE position IS NOT NULL";
    until_true("all robots", async || number(&mut link, known).await == ROBOTS as i64).await;
    let mut errors = Errors::of(Link::Postgres(Box::new(server.connect().connect().await.unwrap())));
    let policy = policy_body(&PolicyParams { mode: Mode::Advise, ..PolicyParams::default() });
    let body = json!({ "policy": policy, "robots": 4 });

    let worse = &done(http, "/v1/fleets/f/rollouts", body.clone()).await["action_id"];
    let order = in_order(worse, &names);
    errors.write(&order, |at| if at < 5 { 0.5 + 0.01 * at as f64 } else { 0.05 + 0.001 * at as f64 }).await;
    let detail = reaches(http, worse, "state", "ROLLED_BACK").await;
    assert_eq!(events(&detail), ["STARTED", "ROLLED_BACK"], "{detail}");
    let rollout = &detail["rollout"];
    assert_eq!((&rollout["changed_robots"], &rollout["unchanged_robots"]), (&json!(5), &json!(79)), "{detail}");
    assert!((rollout["changed_error"].as_f64().unwrap() - 0.52).abs() < 1e-9, "{detail}");
    assert_eq!(number(&mut link, "SELECT count(*) FROM policies").await, 0);

    // Errors that do not depend on the order in which robots are changed.
    let same = |at: usize| 0.05 + 0.001 * (at * 37 % ROBOTS) as f64;
    let equal = &done(http, "/v1/fleets/f/rollouts", body).await["action_id"];
    errors.write(&names, same).await;
    let detail = reaches(http, equal, "stage", "QUARTER").await;
    assert_eq!(events(&detail), ["STARTED", "ADVANCED"], "{detail}");
    errors.write(&names, same).await;
    let detail = reaches(http, equal, "state", "COMPLETED").await;
    assert_eq!(events(&detail), ["STARTED", "ADVANCED", "COMPLETED"], "{detail}");
    let in_force = service.store.policy("f").await.unwrap().unwrap();
    assert_eq!((in_force.version, in_force.mode.as_str(), json!(in_force.action_id)), (1, "ADVISE", equal.clone()));
    service.stop().await;
}
