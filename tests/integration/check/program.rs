//! `vibrissa check-robot` as a program, with the contract's own times.

use std::path::Path;
use std::process::Output;

use tempfile::NamedTempFile;
use tokio::process::Command;
use vibrissa_protocol::SupervisorPresence;
use vibrissa_simulator::Broker;
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_tests::mosquitto::Mosquitto;

use super::{FLEET, robot, robot_of, supervisor};

async fn run(broker: &Mosquitto, robot: &str, more: &[&str]) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_vibrissa-under-test"));
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let mut command = Command::new(program);
    command.args(["check-robot", "--broker", &url, "--fleet", FLEET, "--robot", robot]).args(more);
    command.kill_on_drop(true).output().await.unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn the_exit_code_says_whether_a_rule_was_broken() {
    let broker = Mosquitto::start();
    supervisor(&broker, SupervisorPresence::Offline).await;
    let (good, _) = robot(&broker, "good", None).await;
    let (bad, _) = robot(&broker, "bad", Some(Misbehaviour::StatusRetained)).await;
    let (passed, failed) = tokio::join!(run(&broker, "good", &["--json"]), run(&broker, "bad", &[]));

    assert!(passed.status.success(), "{passed:?}");
    let report: serde_json::Value = serde_json::from_slice(&passed.stdout).unwrap();
    println!("{} s", report["seconds"]);
    let outcomes = report["findings"].as_array().unwrap();
    assert!(outcomes.iter().any(|one| one["rule"] == "slew" && one["outcome"] == "PASS"), "{report}");
    assert!(outcomes.iter().all(|one| one["outcome"] != "FAIL"), "{report}");

    assert_eq!(failed.status.code(), Some(1), "{failed:?}");
    let table = String::from_utf8(failed.stdout).unwrap();
    let broken: Vec<&str> = table.lines().filter(|line| line.contains(" FAIL ")).collect();
    assert!(matches!(broken[..], [line] if line.starts_with("not-retained")), "{table}");
    let told = String::from_utf8(failed.stderr).unwrap();
    assert!(told.contains("about") && told.contains("setpoints"), "{told}");
    good.stop().await;
    bad.stop().await;
}

const PASSWORD: &str = "hunter2";

/// A broker in which everybody has a name, and a file with the password of all.
fn guarded(acl: &str) -> (Mosquitto, NamedTempFile) {
    let names = ["vibrissa", "f/r"];
    let builder = names.into_iter().fold(Mosquitto::builder().acl(acl), |builder, name| builder.user(name, PASSWORD));
    let file = NamedTempFile::new().unwrap();
    std::fs::write(file.path(), PASSWORD).unwrap();
    (builder.start(), file)
}

fn robots_broker(broker: &Mosquitto) -> Broker {
    let credentials = Some(("{fleet}/{robot}".to_owned(), PASSWORD.to_owned()));
    Broker { credentials, ..Broker::new("127.0.0.1", broker.port()) }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_the_shipped_access_list_allows_a_supervisor_is_enough() {
    let (broker, password) = guarded(include_str!("../../../deploy/mosquitto/acl"));
    let (robot, _) = robot_of(&robots_broker(&broker), "r", None).await;
    let file = password.path().to_str().unwrap();
    let done = run(&broker, "r", &["--mqtt-username", "vibrissa", "--mqtt-password-file", file]).await;
    let table = String::from_utf8(done.stdout).unwrap();
    assert!(done.status.success(), "{table}{}", String::from_utf8_lossy(&done.stderr));
    // Of restarts nothing can be seen here, and of epochs below 0 neither.
    let untested = |line: &&str| line.contains("SKIPPED") && !line.contains("not tested");
    let skipped: Vec<&str> = table.lines().filter(untested).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(skipped, ["will", "will-retained", "boot-id-new", "seq-from-zero", "refuse-stale-epoch"], "{table}");
    robot.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_broker_that_does_not_let_it_write_is_named() {
    let acl = "user vibrissa\ntopic read whisker/v1/#\npattern readwrite whisker/v1/%u/#\n";
    let (broker, password) = guarded(acl);
    // Without a factsheet, a request for one is the first thing that the check says.
    let (robot, _) = robot_of(&robots_broker(&broker), "r", Some(Misbehaviour::NoFactsheetAtBirth)).await;
    let file = password.path().to_str().unwrap();
    let done = run(&broker, "r", &["--mqtt-username", "vibrissa", "--mqtt-password-file", file]).await;
    let told = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{told}");
    assert!(told.contains("NotAuthorized"), "{told}");
    robot.stop().await;
}
