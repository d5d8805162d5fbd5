//! Runs `vibrissa check-robot` as a program with the contract's own times.

use std::path::Path;
use std::process::Output;

use tempfile::NamedTempFile;
use tokio::process::Command;
use vibrissa_protocol::Rule;
use vibrissa_simulator::Broker;
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_tests::mosquitto::Mosquitto;

use super::{FLEET, robot_of};

async fn run(broker: &Mosquitto, robot: &str, password: &NamedTempFile, more: &[&str]) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_vibrissa-under-test"));
    let url = format!("mqtt://127.0.0.1:{}", broker.port());
    let mut command = Command::new(program);
    command.args(["check-robot", "--broker", &url, "--fleet", FLEET, "--robot", robot]).args(more);
    command.args(["--mqtt-username", "vibrissa", "--mqtt-password-file"]).arg(password.path());
    command.kill_on_drop(true).output().await.unwrap()
}

const PASSWORD: &str = "hunter2";

/// A broker in which every robot has a user, and a file with the common password.
fn guarded(acl: &str) -> (Mosquitto, NamedTempFile) {
    let names = ["vibrissa", "f/r", "f/good", "f/bad"];
    let builder = names.into_iter().fold(Mosquitto::builder().acl(acl), |builder, name| builder.user(name, PASSWORD));
    let file = NamedTempFile::new().unwrap();
    std::fs::write(file.path(), PASSWORD).unwrap();
    (builder.start(), file)
}

fn robots_broker(broker: &Mosquitto) -> Broker {
    let credentials = Some(("{fleet}/{robot}".to_owned(), PASSWORD.to_owned()));
    Broker { credentials, ..Broker::new("127.0.0.1", broker.port()) }
}

/// The shipped access list must be sufficient for a check.
#[tokio::test(flavor = "multi_thread")]
async fn the_exit_code_says_whether_a_rule_was_broken() {
    let (broker, password) = guarded(include_str!("../../../deploy/mosquitto/acl"));
    let robots = robots_broker(&broker);
    let (good, _) = robot_of(&robots, FLEET, "good", None).await;
    let (bad, _) = robot_of(&robots, FLEET, "bad", Some(Misbehaviour::StatusRetained)).await;
    let (passed, failed) =
        tokio::join!(run(&broker, "good", &password, &["--json"]), run(&broker, "bad", &password, &[]));

    assert!(passed.status.success(), "{passed:?}");
    let report: serde_json::Value = serde_json::from_slice(&passed.stdout).unwrap();
    println!("{} s", report["seconds"]);
    let outcomes = |outcome: &str| {
        let findings = report["findings"].as_array().unwrap().iter().filter(|one| one["outcome"] == outcome);
        findings.map(|one| Rule::from_id(one["rule"].as_str().unwrap()).unwrap()).collect::<Vec<_>>()
    };
    assert_eq!(outcomes("FAIL"), []);
    // Restarts, and setpoints of an epoch below 0, cannot be tested here.
    let skipped: Vec<Rule> = outcomes("SKIPPED").into_iter().filter(|rule| rule.is_testable()).collect();
    let unseen = [Rule::Will, Rule::WillRetained, Rule::BootIdNew, Rule::SeqFromZero, Rule::RefuseStaleEpoch];
    assert_eq!(skipped, unseen);

    assert_eq!(failed.status.code(), Some(1), "{failed:?}");
    let table = String::from_utf8(failed.stdout).unwrap();
    let broken: Vec<&str> = table.lines().filter(|line| line.contains(" FAIL ")).collect();
    assert!(matches!(broken[..], [line] if line.starts_with("not-retained")), "{table}");
    let told = String::from_utf8(failed.stderr).unwrap();
    assert!(told.contains("about") && told.contains("setpoints"), "{told}");
    good.stop().await;
    bad.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_broker_that_does_not_let_it_write_is_named() {
    let acl = "user vibrissa\ntopic read whisker/v1/#\npattern readwrite whisker/v1/%u/#\n";
    let (broker, password) = guarded(acl);
    // Without a factsheet the check's first message is a request for one.
    let (robot, _) = robot_of(&robots_broker(&broker), FLEET, "r", Some(Misbehaviour::NoFactsheetAtBirth)).await;
    let done = run(&broker, "r", &password, &[]).await;
    let told = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{told}");
    assert!(told.contains("NotAuthorized"), "{told}");
    robot.stop().await;
}
