//! Staged roll-outs: which robots get the change, and what follows from the errors of changed and unchanged robots.

use serde_json::{Value, json};
use sqlx::ConnectOptions;
use sqlx::sqlite::SqliteConnectOptions;
use vibrissa_core::policy::{Mode, PolicyParams};
use vibrissa_protocol::{ArrayType, SetpointReason};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::rollouts::{Errors, Link, ask, done, events, in_order, reaches, read, uploaded};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

use crate::program::{Ending, Program};
use crate::running::{LEARNED, Running, database_in};

fn policy(mode: Mode) -> Value {
    policy_body(&PolicyParams { mode, ..PolicyParams::default() })
}

/// A service with many robots of one whisker each.
async fn many(robots: usize) -> (Running, Vec<HandRobot>, Vec<String>) {
    let running = Running::start().await;
    let names: Vec<String> = (0..robots).map(|number| format!("r{number:03}")).collect();
    let mut all = Vec::new();
    for name in &names {
        all.push(HandRobot::born(running.port(), name, array(ArrayType::Type2, &[70.0])).await);
    }
    let known = "SELECT count(*) FROM whiskers WHERE position IS NOT NULL";
    until_true("all robots", async || running.database.number(known).await == robots as i64).await;
    (running, all, names)
}

#[tokio::test]
async fn changed_robots_follow_the_new_policy_and_the_others_the_old_one_until_it_is_rolled_back() {
    let running = Running::start().await;
    let http = running.service.http;
    let names = ["one".to_owned(), "two".to_owned()];
    let mut robots = Vec::new();
    for name in &names {
        let mut robot = HandRobot::born(running.port(), name, array(ArrayType::Type1, &[70.0, 65.0])).await;
        for whisker in [0, 1] {
            robot.touch(whisker, LEARNED + 20).await;
        }
        robot.receipted().await;
        robots.push(robot);
    }
    let id = &done(http, "/v1/fleets/f/rollouts", json!({ "policy": policy(Mode::Advise), "reason": "try it" })).await
        ["action_id"];
    let detail = read(http, id).await;
    assert_eq!(
        (&detail["rollout"]["stage"], &detail["rollout"]["state"]),
        (&json!("FEW"), &json!("RUNNING")),
        "{detail}"
    );
    let changed = &in_order(id, &names)[0];
    for robot in &mut robots {
        robot.cut(0, 54.0);
        robot.touch(0, 80).await;
        robot.receipted().await;
    }
    let approvals = "SELECT robot || ' ' || approval FROM compensations JOIN robots USING (robot_id) ORDER BY robot";
    let expected: Vec<String> =
        names.iter().map(|name| format!("{name} {}", if name == changed { "PROPOSED" } else { "AUTOMATIC" })).collect();
    assert_eq!(running.database.texts(approvals).await, expected);
    // Meanwhile nothing else changes the policy.
    let tag = [("If-Match", "\"0\"")];
    let put = send(http, "PUT", "/v1/fleets/f/policy", &tag, Some(&policy(Mode::Automatic))).await.unwrap();
    assert!(put.status == 409 && put.body.contains("complete it or roll it back"), "{}", put.body);
    assert_eq!(ask(http, "POST", "/v1/fleets/f/rollouts", json!({ "policy": policy(Mode::Advise) })).await.0, 409);
    // Back to the old policy, the next decision needs no approval.
    done(http, &format!("/v1/rollouts/{id}/roll_back"), json!({ "reason": "not wanted" })).await;
    let robot = robots.iter_mut().zip(&names).find(|(_, name)| *name == changed).unwrap().0;
    assert!(robot.setpoints_left().is_empty());
    robot.cut(0, 48.0);
    robot.touch(0, 80).await;
    robot.receipted().await;
    let (setpoint, _) = robot.setpoint().await;
    assert_eq!(setpoint.reason, SetpointReason::ShorterForLonger);
    let detail = read(http, id).await;
    assert_eq!(
        (events(&detail), &detail["events"][0]["detail"]),
        (vec!["STARTED", "ROLLED_BACK"], &json!("not wanted"))
    );
    assert_eq!(running.database.number("SELECT count(*) FROM policies").await, 0);
    assert_eq!(running.metric(r#"vibrissa_rollout_events_total{event="ROLLED_BACK",fleet="f"}"#).await, 1.0);
    running.service.stop().await;
}

#[tokio::test]
async fn without_a_difference_the_stages_follow_and_the_change_comes_into_force() {
    let (running, _robots, names) = many(84).await;
    let http = running.service.http;
    let body = json!({ "policy": policy(Mode::Advise), "robots": 4 });
    let id = &done(http, "/v1/fleets/f/rollouts", body).await["action_id"];
    let mut errors = Errors::of(link(&running).await);
    // Errors that do not depend on the order in which robots are changed.
    let same = |at: usize| 0.05 + 0.001 * (at * 37 % 84) as f64;
    errors.write(&names, same).await;
    let rollout = reaches(http, id, "stage", "QUARTER").await;
    assert_eq!(events(&rollout), ["STARTED", "ADVANCED"], "{rollout}");
    assert_eq!(rollout["events"][0]["actor"], "supervisor");
    let detail = rollout["events"][0]["detail"].as_str().unwrap();
    assert!(detail.contains("of 5 changed robots") && detail.contains("of 79 unchanged ones"), "{detail}");
    assert_eq!(running.metric(r#"vibrissa_rollout_stage{fleet="f"}"#).await, 2.0);
    errors.write(&names, same).await;
    let rollout = reaches(http, id, "state", "COMPLETED").await;
    assert_eq!(events(&rollout), ["STARTED", "ADVANCED", "COMPLETED"], "{rollout}");
    let in_force = running.service.store.policy("f").await.unwrap().unwrap();
    assert_eq!((in_force.version, in_force.mode.as_str(), json!(in_force.action_id)), (1, "ADVISE", id.clone()));
    running.service.stop().await;
}

#[tokio::test]
async fn a_worse_change_is_rolled_back_by_the_errors_and_a_paused_one_waits() {
    let (running, _robots, names) = many(84).await;
    let http = running.service.http;
    let body = json!({ "policy": policy(Mode::Advise), "robots": 4 });
    let id = &done(http, "/v1/fleets/f/rollouts", body).await["action_id"];
    done(http, &format!("/v1/rollouts/{id}/pause"), json!({})).await;
    let mut errors = Errors::of(link(&running).await);
    let order = in_order(id, &names);
    errors.write(&order, |at| if at < 5 { 0.5 + 0.01 * at as f64 } else { 0.05 + 0.001 * at as f64 }).await;
    // Two comparisons would have come by now.
    tokio::time::sleep(std::time::Duration::from_secs(11)).await;
    assert_eq!(read(http, id).await["rollout"]["state"], "PAUSED");
    done(http, &format!("/v1/rollouts/{id}/resume"), json!({})).await;
    let detail = reaches(http, id, "state", "ROLLED_BACK").await;
    assert_eq!(events(&detail), ["STARTED", "PAUSED", "RESUMED", "ROLLED_BACK"], "{detail}");
    let rollout = &detail["rollout"];
    assert!(rollout["probability"].as_f64().unwrap() < 0.05 / 6.0, "{detail}");
    assert_eq!((&rollout["changed_robots"], &rollout["unchanged_robots"]), (&json!(5), &json!(79)));
    assert!((rollout["changed_error"].as_f64().unwrap() - 0.52).abs() < 1e-9, "{detail}");
    assert_eq!(running.database.number("SELECT count(*) FROM policies").await, 0);
    let late = ask(http, "POST", &format!("/v1/rollouts/{id}/advance"), json!({})).await;
    assert_eq!(late.0, 409, "{late:?}");
    running.service.stop().await;
}

#[tokio::test]
async fn a_roll_out_survives_the_death_of_its_supervisor() {
    let broker = Mosquitto::start();
    let folder = tempfile::tempdir().unwrap();
    let program = Program::start(&database_in(&folder), broker.port());
    let mut robots = Vec::new();
    for name in ["one", "two", "three", "four"] {
        let mut robot = HandRobot::born(broker.port(), name, array(ArrayType::Type1, &[70.0, 65.0])).await;
        robot.touch(0, 5).await;
        robot.receipted().await;
        robots.push(robot);
    }
    let id = done(program.http, "/v1/fleets/f/rollouts", json!({ "policy": policy(Mode::Advise) })).await["action_id"]
        .clone();
    done(program.http, &format!("/v1/rollouts/{id}/pause"), json!({})).await;
    let before = read(program.http, &id).await;
    program.end(Ending::Killed).await;
    let program = Program::start(&database_in(&folder), broker.port());
    assert_eq!(read(program.http, &id).await, before);
    let stage = async |expected: &str| {
        let (_, text) = try_get(program.http, "/metrics").await.unwrap();
        text.contains(&format!("vibrissa_rollout_stage{{fleet=\"f\"}} {expected}"))
    };
    for (state, expected) in [("QUARTER", "2"), ("ALL", "0")] {
        let advance = format!("/v1/rollouts/{id}/advance");
        until_true("the new owner advances it", async || ask(program.http, "POST", &advance, json!({})).await.0 == 200)
            .await;
        assert_eq!(read(program.http, &id).await["rollout"]["stage"], state);
        assert!(stage(expected).await, "{state}");
    }
    let (_, policy) = try_get(program.http, "/v1/fleets/f/policy").await.unwrap();
    let policy: Value = serde_json::from_str(&policy).unwrap();
    assert_eq!((&policy["version"], &policy["mode"]), (&json!(1), &json!("ADVISE")));
    program.end(Ending::Terminated).await;
}

/// A connection to the database beside the service.
async fn link(running: &Running) -> Link {
    let options = SqliteConnectOptions::new().filename(database_in(running.folder()));
    Link::Sqlite(Box::new(options.busy_timeout(std::time::Duration::from_secs(10)).connect().await.unwrap()))
}

#[tokio::test]
async fn a_calibration_is_relearned_by_the_changed_robots_alone_until_it_is_in_force() {
    let running = Running::start().await;
    let names: Vec<String> = ["a", "b", "c", "d", "e", "f"].map(ToOwned::to_owned).to_vec();
    let mut robots = Vec::new();
    for name in &names {
        let mut robot = HandRobot::born(running.port(), name, array(ArrayType::Type2, &[70.0])).await;
        robot.touch(0, LEARNED + 20).await;
        robot.receipted().await;
        robots.push(robot);
    }
    let calibration_id = uploaded(running.service.http).await;
    let body = json!({ "calibration_id": calibration_id, "reason": "new gauges" });
    let id = done(running.service.http, "/v1/fleets/f/rollouts", body).await["action_id"].clone();
    let order = in_order(&id, &names);
    let learning =
        "SELECT robot FROM whiskers JOIN robots USING (robot_id) WHERE condition = 'LEARNING' ORDER BY robot";
    let sorted = |names: &[String]| {
        let mut names = names.to_vec();
        names.sort();
        names
    };
    // 5 % of six robots are one, 25 % are two.
    assert_eq!(running.database.texts(learning).await, sorted(&order[..1]));
    let active = "SELECT count(*) FROM active_calibrations";
    assert_eq!(running.database.number(active).await, 0);
    let running = running.again(crate::running::quick(), None).await;
    assert_eq!(running.database.texts(learning).await, sorted(&order[..1]), "a takeover changes nothing");
    let http = running.service.http;
    done(http, &format!("/v1/rollouts/{id}/advance"), json!({})).await;
    assert_eq!(running.database.texts(learning).await, sorted(&order[..2]));
    let activate = format!("/v1/fleets/f/calibrations/{calibration_id}/activate");
    assert_eq!(ask(http, "POST", &activate, json!({})).await.0, 409);
    done(http, &format!("/v1/rollouts/{id}/advance"), json!({})).await;
    assert_eq!(running.database.texts(learning).await, sorted(&names));
    assert_eq!(running.database.number(active).await, 1);
    let detail = read(http, &id).await;
    assert_eq!(
        (&detail["rollout"]["state"], events(&detail)),
        (&json!("COMPLETED"), vec!["STARTED", "ADVANCED", "COMPLETED"])
    );
    running.service.stop().await;
}
