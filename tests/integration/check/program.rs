//! Runs `vibrissa-lab check-robot` as a program with the contract's own times.

use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Output;

use tempfile::NamedTempFile;
use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::net::unix::pipe;
use tokio::process::Command;
use vibrissa_lab::check::{Action, Spot};
use vibrissa_protocol::rules::Visible;
use vibrissa_protocol::{Name, Rule};
use vibrissa_simulator::Broker;
use vibrissa_simulator::places::Places;
use vibrissa_simulator::scenario::Misbehaviour;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};

use super::helper::Helper;
use super::{FLEET, robot_of, scenario_of};

async fn run(broker: &Mosquitto, robot: &str, password: &NamedTempFile, more: &[&str]) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_lab-under-test"));
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
    // Without help, restarts, setpoints of an epoch below 0, and all that needs somebody cannot be tested here.
    let untested = |rule: &Rule| rule.visible() != Visible::Talking || *rule == Rule::RefuseStaleEpoch;
    assert_eq!(outcomes("SKIPPED"), Rule::ALL.iter().copied().filter(untested).collect::<Vec<_>>());
    let reason = |rule: Rule| {
        let mut findings = report["findings"].as_array().unwrap().iter();
        findings.find(|one| one["rule"] == rule.id()).unwrap()["seen"].as_str().unwrap().to_owned()
    };
    for (rule, option) in [(Rule::Will, "--restart"), (Rule::Farewell, "--assisted"), (Rule::OwnLevel, "--relay")] {
        assert!(reason(rule).contains(option), "{}", reason(rule));
    }

    assert_eq!(failed.status.code(), Some(1), "{failed:?}");
    let table = String::from_utf8(failed.stdout).unwrap();
    let broken: Vec<&str> = table.lines().filter(|line| line.contains(" FAIL ")).collect();
    assert!(matches!(broken[..], [line] if line.starts_with("not-retained")), "{table}");
    let message = String::from_utf8(failed.stderr).unwrap();
    assert!(message.contains("about") && message.contains("setpoints"), "{message}");
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
    let message = String::from_utf8(done.stderr).unwrap();
    assert_eq!(done.status.code(), Some(1), "{message}");
    assert!(message.contains("this user may not do it"), "{message}");
    robot.stop().await;
}

/// The action of an assistant's arguments.
fn action(arguments: &str) -> Action {
    let (word, spot) = arguments.split_once(' ').map_or((arguments, None), |(word, spot)| (word, Some(spot)));
    let spot = || {
        let (array, whisker) = spot.unwrap().split_once('/').unwrap();
        Spot { array: Name::new(array).unwrap(), whisker: whisker.parse().unwrap() }
    };
    match word {
        "cut-power" => Action::CutPower,
        "close-supply" => Action::CloseSupply(spot()),
        "open-supply" => Action::OpenSupply(spot()),
        "touch" => Action::Touch,
        "rest" => Action::Rest,
        "stop" => Action::Stop,
        "start" => Action::Start,
        "touch-place" => Action::TouchPlace(spot()),
        _ => panic!("{arguments}"),
    }
}

/// An assistant writes its arguments into a pipe, and the test acts. The robot reaches the broker through the relay.
#[tokio::test(flavor = "multi_thread")]
async fn with_an_assistant_and_a_relay_no_rule_is_skipped() {
    let (broker, password) = guarded(include_str!("../../../deploy/mosquitto/acl"));
    let folder = tempfile::tempdir().unwrap();
    let (pipe, script) = (folder.path().join("pipe"), folder.path().join("assistant"));
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    std::fs::write(&script, format!("#!/bin/sh\necho \"$*\" >> {}\n", pipe.display())).unwrap();
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o700)).unwrap();
    let actions = pipe::OpenOptions::new().read_write(true).open_receiver(&pipe).unwrap();
    let mut actions = BufReader::new(actions).lines();

    let relay = format!("127.0.0.1:{}", free_port());
    let port = relay.rsplit_once(':').unwrap().1.parse().unwrap();
    let robots = Broker { port, ..robots_broker(&broker) };
    let script = script.to_str().unwrap();
    let more = ["--json", "--relay", &relay, "--assistant", script, "--silence", "13s", "--epoch", "7"];
    let checking = run(&broker, "good", &password, &more);
    let helping = async {
        let mut scenario = scenario_of(FLEET, "good", None);
        scenario.behaviour.places = Places::EstimatedRatio;
        let mut helper = Helper::of(scenario, robots).await;
        loop {
            let Ok(Some(line)) = actions.next_line().await else { break };
            helper.act(action(&line)).await;
        }
    };
    let checked = tokio::select! {
        checked = checking => checked,
        () = helping => unreachable!("the pipe stays open"),
    };
    let report: serde_json::Value = serde_json::from_slice(&checked.stdout).unwrap();
    let others = report["findings"].as_array().unwrap().iter().filter(|one| one["outcome"] != "PASS");
    assert_eq!(others.collect::<Vec<_>>(), Vec::<&serde_json::Value>::new());
    assert!(checked.status.success());
}
