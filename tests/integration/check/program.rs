//! `vibrissa check-robot` as a program, with the contract's own times.

use std::path::Path;
use std::process::Output;

use tokio::process::Command;
use vibrissa_protocol::SupervisorPresence;
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_tests::mosquitto::Mosquitto;

use super::{FLEET, robot, supervisor};

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
