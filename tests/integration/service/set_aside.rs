//! Unreadable items in the database are set aside: each reader reads the next item, and a robot with a damaged row stops no other.

use std::net::SocketAddr;

use serde_json::Value;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{AssertSqlSafe, ConnectOptions as _};
use vibrissa_protocol::ArrayType;
use vibrissa_store::events::Position;
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::try_get;

use crate::running::{Running, database_in, quick};
use crate::web;

/// A byte that no text in UTF-8 has.
const BAD: &str = "CAST(x'ff' AS TEXT)";
/// Robots with damaged rows, in the order of their numbers, and one without, which comes last.
const ROBOTS: [&str; 7] = ["name", "number", "head", "whisker", "boot", "newer", "whole"];

async fn run(link: &mut SqliteConnection, sql: &str) {
    let changed = sqlx::query(AssertSqlSafe(sql.replace("BAD", BAD))).execute(link).await;
    assert!(changed.unwrap_or_else(|problem| panic!("{sql}: {problem}")).rows_affected() > 0, "{sql}");
}

/// Damages rows of each reader; the statement after each damage is the next item, which must be read.
const PLANTED: [&str; 30] = [
    // Robots, whiskers, boots.
    "UPDATE robots SET robot = BAD WHERE robot = 'name'",
    "UPDATE robots SET journal_number = 'x' WHERE robot = 'number'",
    "UPDATE robots SET state = x'ff' WHERE robot = 'head'",
    "UPDATE whiskers SET state = x'ff' WHERE robot_id = (SELECT robot_id FROM robots WHERE robot = 'whisker')",
    "UPDATE boots SET boot_id = BAD WHERE robot_id = (SELECT robot_id FROM robots WHERE robot = 'boot')",
    // Version 64: newer than this program, and not so much that it is damage.
    "UPDATE robots SET state = CAST(x'4000' || substr(state, 3) AS BLOB) WHERE robot = 'newer'",
    // Journal.
    "INSERT INTO journal (fleet, number, entries) VALUES ('f', 1000001, x'ff')",
    // Actions: one without text, one of whose parameters are no JSON, and one to execute.
    "INSERT INTO actions (fleet, robot, kind, parameters, reason, actor, role, request_id, asked_us, expires_us, state) \
     VALUES ('f', 'whole', 'NOTHING', '{}', BAD, 'a', 'ADMIN', 'q', 1, 9000000000000000, 'PENDING')",
    "INSERT INTO actions (fleet, robot, kind, parameters, actor, role, request_id, asked_us, expires_us, state) \
     VALUES ('f', 'whole', 'HOLD', '{', 'a', 'ADMIN', 'q', 1, 9000000000000000, 'PENDING')",
    "INSERT INTO actions (fleet, robot, kind, parameters, actor, role, request_id, asked_us, expires_us, state) \
     VALUES ('f', 'whole', 'HOLD', '{}', 'a', 'ADMIN', 'q', 1, 9000000000000000, 'PENDING')",
    // Policy, calibrations, roll-out, allowed robots.
    "INSERT INTO policies (fleet, version, mode, objective, longer_for_shorter, predicted_error_max, own_role_cost, \
     change_margin, changed_us, changed_by, action_id) VALUES ('f', 3, 'ADVISE', 'TIP', 'NEVER', 'x', 0, 0, 1, 'a', 1)",
    "INSERT INTO calibrations (calibration_id, model, version, measurements, fit, calibration, uploaded_us, uploaded_by) \
     VALUES (1, 'm', 1, '', '', BAD, 1, 'a'), (2, 'n', 1, '', '', 'no JSON', 1, 'a')",
    "INSERT INTO active_calibrations (fleet, model, calibration_id, activated_us, activated_by) \
     VALUES ('f', 'm', 1, 1, 'a'), ('f', 'n', 2, 1, 'a')",
    "INSERT INTO rollouts (rollout_id, fleet, kind, change, state, stage, place_max, level, robots, looks, changed_robots, \
     unchanged_robots, started_us, stage_us, updated_us, started_by) \
     VALUES (1, 'f', 'POLICY', BAD, 'RUNNING', 'FEW', 1, 0.1, 1, 0, 0, 0, 1, 1, 1, 'a')",
    "INSERT INTO allowed_robots (fleet, version, robots, changed_us, changed_by, action_id) VALUES ('f', 1, \
     CAST(x'ff0a' || 'number' || x'0a' || 'head' || x'0a' || 'whisker' || x'0a' || 'boot' || x'0a' || 'newer' || x'0a' || 'whole' \
     AS TEXT), 1, 'a', 1)",
    // Webhooks: a target, events and dead letters, each before a whole one.
    "INSERT INTO webhooks (name, url, level, enabled, secret, created_us, changed_us, changed_by, done_tx, done_event) \
     VALUES (BAD, 'http://h/', 'INFO', 1, x'00', 1, 1, 'a', 0, 0)",
    "INSERT INTO webhooks (name, url, level, enabled, secret, created_us, changed_us, changed_by, done_tx, done_event) \
     VALUES ('w', 'http://192.0.2.1/', 'INFO', 1, x'00', 1, 1, 'a', 0, 0)",
    "UPDATE webhooks SET done_event = 9000000",
    "INSERT INTO events (event_id, recorded_us, version, kind, audience, fleet, robot_id, data) \
     SELECT 9000001, 1, 2, 'TRIM', 'PEOPLE', BAD, max(robot_id), '{}' FROM robots",
    "INSERT INTO events (event_id, recorded_us, version, kind, audience, fleet, robot_id, data) \
     SELECT 9000002, 1, 2, 'TRIM', 'PEOPLE', 'f', max(robot_id), '{}' FROM robots",
    "INSERT INTO events (event_id, recorded_us, version, kind, audience, fleet, robot_id, data) \
     SELECT 9000003, 1, 2, 'TRIM', 'PEOPLE', 'f', max(robot_id), '{}' FROM robots",
    "INSERT INTO webhook_dead_letters (webhook_id, event_id, attempts, dead_us, problem, again) \
     SELECT webhook_id, 9000001, 1, 1, 'p', 1 FROM webhooks WHERE name = 'w'",
    "INSERT INTO webhook_dead_letters (webhook_id, event_id, attempts, dead_us, problem, again) \
     SELECT webhook_id, 9000002, 1, 1, 'p', 1 FROM webhooks WHERE name = 'w'",
    // Windows of maintenance: one without a reason, one that repeats after no time, and one that holds.
    "INSERT INTO maintenance (fleet, begins_us, lasts_us, told_us, reason, set_by, set_us) VALUES ('f', 0, 1, 1, BAD, 'a', 1)",
    "INSERT INTO maintenance (fleet, begins_us, lasts_us, repeat_us, told_us, reason, set_by, set_us) \
     VALUES ('f', -9000000000000000000, 9000000000000000000, 0, 9000000000000000000, 'r', 'a', 1)",
    "INSERT INTO maintenance (fleet, begins_us, lasts_us, told_us, reason, set_by, set_us) \
     VALUES ('g', 0, 9000000000000000, 1, 'r', 'a', 1)",
    // Tokens: a hash that is a number, and a name that is no text.
    "INSERT INTO api_tokens (token_id, name, role, secret_hash, created_us, created_by, expires_us) \
     VALUES ('number', 'n', 'VIEWER', 7, 1, 'a', 9000000000000000)",
    "INSERT INTO api_tokens (token_id, name, role, secret_hash, created_us, created_by, expires_us) \
     VALUES ('name', BAD, 'VIEWER', zeroblob(32), 1, 'a', 9000000000000000)",
    // Events for live pages alone.
    "INSERT INTO events (recorded_us, version, kind, audience, fleet, data) VALUES (1, 2, 'ACTION', 'PROGRAMS', BAD, '{}')",
    "INSERT INTO events (recorded_us, version, kind, audience, fleet, data) VALUES (1, 2, 'POLICY', 'PROGRAMS', 'f', '{}')",
];

async fn born(port: u16, name: &str) -> HandRobot {
    HandRobot::born(port, name, array(ArrayType::Type1, &[70.0, 65.0])).await
}

#[tokio::test]
async fn regress_an_unreadable_item_stops_no_reader() {
    let running = Running::start().await;
    for name in ROBOTS {
        let mut robot = born(running.port(), name).await;
        robot.touch(0, 2).await;
        robot.receipted().await;
    }
    let folder = running.stop().await;
    let path = database_in(&folder);
    let mut link = SqliteConnectOptions::new().filename(&path).connect().await.unwrap();
    for sql in PLANTED {
        run(&mut link, sql).await;
    }
    let newer: Vec<u8> =
        sqlx::query_scalar("SELECT state FROM robots WHERE robot = 'newer'").fetch_one(&mut link).await.unwrap();
    the_database_goes_on(&DatabaseAddress::Sqlite(path)).await;

    let running = Running::on(folder, quick(), None).await;
    for name in ["whole", "number", "head", "whisker", "boot"] {
        let mut robot = born(running.port(), name).await;
        robot.restart();
        robot.birth().await;
        robot.settle().await;
        robot.touch(0, 2).await;
        robot.receipted().await;
    }
    until_true("answers to the actions", async || {
        let states = "SELECT state || coalesce(substr(problem, 1, 6), '') FROM actions ORDER BY action_id";
        running.database.texts(states).await == ["REFUSEDUNREAD", "REFUSEDMALFOR", "DONE"]
    })
    .await;
    let readyz: Value = web::json(running.service.http, "/readyz").await;
    let notices = readyz["notices"].to_string();
    for named in [
        "of robots: column robot is no text in UTF-8",
        "of robots: column journal_number has a value of another type",
        "of boots: column boot_id",
        "the row action_id = 1 of actions: column reason",
        "the row version = 3 of policies: column predicted_error_max",
        "the row maintenance_id = 1 of maintenance: column reason",
        "the row calibration_id = 1 of calibrations",
        "the row rollout_id = 1 of rollouts",
        "the row version = 1 of allowed_robots",
        "stored items cannot be read",
        "the state of 1 robots (newer)",
    ] {
        assert!(notices.contains(named) || notices.contains("further rows"), "{named} in {notices}");
    }
    assert!(running.metric("vibrissa_rows_set_aside_total").await >= 8.0);
    for reader in ["CALIBRATION", "CHECKPOINT", "JOURNAL"] {
        let name = format!("vibrissa_items_set_aside_total{{fleet=\"f\",reader=\"{reader}\"}}");
        assert!(running.metric(&name).await >= 1.0, "{reader}");
    }
    // A damaged policy can be replaced.
    assert_eq!(web::json(running.service.http, "/v1/fleets/f/policy").await["version"], 3);
    // The pages and lists show the other rows.
    every_page_answers(running.service.http).await;
    assert_eq!(running.list("robots").await.len(), ROBOTS.len() - 1);
    assert_eq!(running.list("audit").await.len(), 1, "the texts of one action, the parameters of another are damaged");
    // What a newer program has written waits for it.
    let mut robot = HandRobot::connect(running.port(), "newer", array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.birth().await;
    until_true("a refusal", async || running.metrics().await.refused().get("newer_state").is_some_and(|&n| n > 0.0))
        .await;
    let folder = running.stop().await;
    let mut link = SqliteConnectOptions::new().filename(database_in(&folder)).connect().await.unwrap();
    let kept: Vec<u8> =
        sqlx::query_scalar("SELECT state FROM robots WHERE robot = 'newer'").fetch_one(&mut link).await.unwrap();
    assert_eq!(kept, newer);
}

/// All routes that read something of the fleet, its damaged robots, or the service.
async fn every_page_answers(http: SocketAddr) {
    let document = web::json(http, "/openapi.json").await;
    let mut read = 0;
    for path in document["paths"].as_object().unwrap().iter().filter(|(_, route)| route.get("get").is_some()) {
        let path = path.0.replace("{fleet}", "f").replace("{array}", "left").replace("{whisker}", "0");
        for robot in ["whole", "boot", "whisker"] {
            let path = path.replace("{robot}", robot);
            // Others need a number, or do not end.
            if path.contains('{') || path.ends_with("/events") || path.starts_with("/auth") {
                break;
            }
            let (status, body) = try_get(http, &path).await.unwrap();
            assert!(status < 500, "{path}: {status} {body}");
            read += usize::from(status == 200);
        }
    }
    assert!(read > 60, "{read} pages");
}

/// Webhooks and the log of events, without a supervisor that would deliver.
async fn the_database_goes_on(address: &DatabaseAddress) {
    let store = Store::open(address, "test").await.unwrap();
    let webhooks = store.webhooks().await.unwrap();
    assert_eq!(webhooks.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["w"]);
    let id = webhooks[0].webhook_id;
    assert_eq!(store.webhook_queues(&webhooks).await.unwrap()[0].waiting, 2);
    let (letters, holder, hold) = (store.dead_letters(id).await.unwrap(), "test", std::time::Duration::from_secs(1));
    assert_eq!(letters.iter().map(|(letter, _)| letter.event_id).collect::<Vec<_>>(), [9_000_002]);
    let job = store.take_webhook_job(id, holder, hold).await.unwrap().unwrap();
    assert_eq!((job.event.event_id, job.is_again), (9_000_002, true), "the dead letter after the damaged one");
    let outcome = vibrissa_store::webhooks::queue::Outcome::Delivered { status: 200 };
    assert!(store.finish_webhook_job(&job, holder, &outcome).await.unwrap());
    let job = store.take_webhook_job(id, holder, hold).await.unwrap().unwrap();
    assert_eq!((job.event.event_id, job.is_again), (9_000_002, false), "the event after the damaged one");
    assert_eq!(store.webhook(id).await.unwrap().unwrap().lost, 1);
    assert_eq!(store.maintenance().await.unwrap().len(), 2);
    store.tell_after_maintenance(2).await.unwrap();
    assert_eq!(store.tokens(0).await.unwrap().len(), 0);
    assert_eq!(store.credential_hashes(1, 9).await.unwrap(), [[0; 32]]);
    let events = store.events_after(Position::default()).await.unwrap();
    let newest: Vec<Option<&str>> =
        events.iter().rev().take(2).map(|(_, event)| event.as_ref().map(|one| one.kind.as_str())).collect();
    assert_eq!(newest, [Some("POLICY"), None]);
    store.release_webhooks(holder).await.unwrap();
    assert!(store.set_aside().count() >= 3);
    store.close().await;
}
