//! Staged roll-outs of a fleet with several shards.

use std::collections::BTreeSet;
use std::net::SocketAddr;

use nix::sys::signal::Signal;
use serde_json::json;
use vibrissa_core::policy::{Mode, PolicyParams};
use vibrissa_edge::shard::robot_hash;
use vibrissa_protocol::ArrayType;
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::rollouts::{Errors, Link, done, events, in_order, reaches, read, uploaded};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

use crate::supervisors::{Replica, Stage};

const SHARDS: u32 = 4;
/// Contacts until a whisker counts as learned.
const LEARNED: usize = 60;
const ARGUMENTS: [&str; 4] = ["--fleet-shards", "4", "--detection-cold-start-contacts", "60"];

/// Starts two supervisors with two of four shards each.
async fn two_supervisors(stage: &Stage) -> (Replica, Replica) {
    let (a, b) = (stage.replica_with("a", "f", 1.0, &ARGUMENTS), stage.replica_with("b", "f", 1.0, &ARGUMENTS));
    until_true("two shards each", async || (stage.count_of("a").await, stage.count_of("b").await) == (2, 2)).await;
    (a, b)
}

/// Robots in all shards with whiskers of these lengths, which have learned.
async fn robots(stage: &Stage, count: u32, lengths_mm: &[f64]) -> (Vec<HandRobot>, Vec<String>) {
    let names: Vec<String> = (0..count).map(|number| format!("r{number}")).collect();
    let shards: BTreeSet<u32> = names.iter().map(|name| robot_hash("f", name) % SHARDS).collect();
    assert_eq!(shards.len(), SHARDS as usize, "robots in each shard");
    let mut robots = Vec::new();
    for name in &names {
        let kind = if lengths_mm.len() > 1 { ArrayType::Type1 } else { ArrayType::Type2 };
        let mut robot = HandRobot::born(stage.broker_port(), name, array(kind, lengths_mm)).await;
        for whisker in 0..lengths_mm.len() {
            robot.touch(whisker as u16, LEARNED + 20).await;
        }
        robots.push(robot);
    }
    let whiskers = i64::from(count) * lengths_mm.len() as i64;
    let learned = "SELECT count(*) FROM whiskers WHERE condition <> 'LEARNING'";
    until_true("learned whiskers", async || stage.number(learned).await == whiskers).await;
    (robots, names)
}

fn sorted(names: &[String]) -> Vec<String> {
    let mut names = names.to_vec();
    names.sort();
    names
}

/// Waits until exactly these robots have whiskers that learn.
async fn learn(stage: &Stage, names: &[String]) {
    let sql = "SELECT robot FROM whiskers JOIN robots USING (robot_id) WHERE condition = 'LEARNING' ORDER BY robot";
    let expected = sorted(names);
    until_true("the changed robots relearn", async || stage.texts(sql).await == expected).await;
}

/// Waits until all shards have followed so many stages.
async fn followed(stage: &Stage, stages: i64) {
    let sql = "SELECT count(*) FROM actions WHERE kind = 'ROLLOUT_STAGE' AND state = 'DONE'";
    let expected = stages * i64::from(SHARDS - 1);
    until_true("the stage in all shards", async || stage.number(sql).await == expected).await;
}

#[tokio::test]
async fn each_stage_reaches_the_robots_of_all_shards_also_after_a_takeover() {
    let stage = Stage::new().await;
    let (a, b) = two_supervisors(&stage).await;
    let (mut robots, names) = robots(&stage, 12, &[70.0]).await;
    let calibration_id = uploaded(a.http()).await;
    let body = json!({ "calibration_id": calibration_id, "reason": "new gauges" });
    let id = done(a.http(), "/v1/fleets/f/rollouts", body).await["action_id"].clone();
    let order = in_order(&id, &names);
    // 5 % of twelve robots are one, 25 % are three.
    followed(&stage, 1).await;
    learn(&stage, &order[..1]).await;
    // Its whisker has learned when the next stage begins, which must not make it learn again.
    let changed = names.iter().position(|name| *name == order[0]).unwrap();
    robots[changed].touch(0, LEARNED + 20).await;
    learn(&stage, &[]).await;
    done(a.http(), &format!("/v1/rollouts/{id}/advance"), json!({})).await;
    followed(&stage, 2).await;
    learn(&stage, &order[1..3]).await;

    // The owner of two further shards misses the last stage: those who take these shards over follow it.
    let first = stage.texts("SELECT holder FROM leases WHERE shard = 0").await.remove(0);
    let (owner, frozen) = if first == "a" { (&a, &b) } else { (&b, &a) };
    frozen.signal(Signal::SIGSTOP);
    done(owner.http(), &format!("/v1/rollouts/{id}/advance"), json!({})).await;
    followed(&stage, 3).await;
    learn(&stage, &order[1..]).await;
    frozen.signal(Signal::SIGCONT);
    let told = read(owner.http(), &id).await;
    assert_eq!(events(&told), ["STARTED", "ADVANCED", "COMPLETED"], "{told}");
    assert_eq!(stage.number("SELECT count(*) FROM active_calibrations").await, 1);
}

/// The versions of the policy that the shards of a supervisor show.
async fn versions(http: SocketAddr) -> Vec<String> {
    let (_, text) = try_get(http, "/metrics").await.unwrap();
    let lines = text.lines().filter(|line| line.starts_with("vibrissa_policy_version{") && line.contains("shard="));
    lines.map(|line| line.rsplit(' ').next().unwrap().to_owned()).collect()
}

#[tokio::test]
async fn changed_robots_of_all_shards_follow_the_new_policy_through_a_restart_until_it_is_in_force() {
    let stage = Stage::new().await;
    let mut a = stage.replica_with("a", "f", 1.0, &ARGUMENTS);
    until_true("all shards", async || stage.count_of("a").await == SHARDS as usize).await;
    let (mut robots, names) = robots(&stage, 12, &[70.0, 65.0]).await;
    let advise = policy_body(&PolicyParams { mode: Mode::Advise, ..PolicyParams::default() });
    // The further shards do not follow before the supervisor ends.
    stage
        .execute(
            "CREATE FUNCTION late() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN NEW.not_before_us = 9000000000000000; \
             RETURN NEW; END $$; CREATE TRIGGER late BEFORE INSERT ON actions FOR EACH ROW \
             WHEN (NEW.kind = 'ROLLOUT_STAGE') EXECUTE FUNCTION late()",
        )
        .await;
    let id = done(a.http(), "/v1/fleets/f/rollouts", json!({ "policy": advise })).await["action_id"].clone();
    done(a.http(), &format!("/v1/rollouts/{id}/advance"), json!({})).await;
    a.kill();
    a.restart();
    until_true("all shards again", async || stage.count_of("a").await == SHARDS as usize).await;
    stage
        .execute("DROP TRIGGER late ON actions; UPDATE actions SET not_before_us = 0 WHERE kind = 'ROLLOUT_STAGE'")
        .await;
    followed(&stage, 2).await;
    for robot in &mut robots {
        robot.cut(0, 54.0);
        robot.touch(0, 80).await;
    }
    // 25 % of twelve robots are three.
    let changed = &in_order(&id, &names)[..3];
    let approvals = "SELECT robot || ' ' || approval FROM compensations JOIN robots USING (robot_id) ORDER BY robot";
    let word = |name: &String| if changed.contains(name) { "PROPOSED" } else { "AUTOMATIC" };
    let expected = sorted(&names).iter().map(|name| format!("{name} {}", word(name))).collect::<Vec<_>>();
    until_true("a decision of each robot", async || stage.texts(approvals).await.len() == names.len()).await;
    assert_eq!(stage.texts(approvals).await, expected);

    done(a.http(), &format!("/v1/rollouts/{id}/advance"), json!({})).await;
    followed(&stage, 3).await;
    assert_eq!(versions(a.http()).await, vec!["1"; SHARDS as usize]);
    let tag = [("If-Match", "\"1\"")];
    let automatic = policy_body(&PolicyParams::default());
    let put = send(a.http(), "PUT", "/v1/fleets/f/policy", &tag, Some(&automatic)).await.unwrap();
    assert_eq!(put.status, 200, "{}", put.body);
    until_true("the next policy in all shards", async || versions(a.http()).await == ["2", "2", "2", "2"]).await;
}

#[tokio::test]
async fn the_errors_of_all_shards_decide_and_a_worse_change_is_taken_back_in_all() {
    let stage = Stage::new().await;
    let (a, _b) = two_supervisors(&stage).await;
    let (_robots, names) = robots(&stage, 84, &[70.0]).await;
    let calibration_id = uploaded(a.http()).await;
    let body = json!({ "calibration_id": calibration_id, "robots": 4 });
    let id = done(a.http(), "/v1/fleets/f/rollouts", body).await["action_id"].clone();
    let order = in_order(&id, &names);
    followed(&stage, 1).await;
    // 5 % of 84 robots are five, in several shards.
    learn(&stage, &order[..5]).await;
    let shards: BTreeSet<u32> = order[..5].iter().map(|name| robot_hash("f", name) % SHARDS).collect();
    assert!(shards.len() > 1, "{shards:?}");
    let mut errors = Errors::of(Link::Postgres(Box::new(stage.link().await)));
    errors.write(&order, |at| if at < 5 { 0.5 + 0.01 * at as f64 } else { 0.05 + 0.001 * at as f64 }).await;
    let told = reaches(a.http(), &id, "state", "ROLLED_BACK").await;
    assert_eq!(events(&told), ["STARTED", "ROLLED_BACK"], "{told}");
    let rollout = &told["rollout"];
    assert_eq!((&rollout["changed_robots"], &rollout["unchanged_robots"]), (&json!(5), &json!(79)), "{told}");
    followed(&stage, 2).await;
    assert_eq!(stage.number("SELECT count(*) FROM active_calibrations").await, 0);
    // The whiskers of the changed robots learn again, at the fleet's calibration; the others never did.
    learn(&stage, &order[..5]).await;
    let by = "SELECT DISTINCT actor FROM actions WHERE kind = 'ROLLOUT_STAGE' AND parameters LIKE '%ROLLED_BACK%'";
    assert_eq!(stage.texts(by).await, ["supervisor"]);
}
