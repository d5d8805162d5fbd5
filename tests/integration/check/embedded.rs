//! `vibrissa-lab check-robot` without a broker: it starts its own one.

use std::net::{Ipv4Addr, TcpListener};
use std::process::Stdio;

use tokio::io::{AsyncBufReadExt, BufReader};
use tokio::process::{Child, Command};
use vibrissa_simulator::Broker;

use super::{FLEET, robot_of};

fn started(arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lab-under-test"));
    command.args(["check-robot", "--fleet", FLEET, "--robot", "good"]).args(arguments);
    command.env_remove("RUST_LOG").stdout(Stdio::piped()).stderr(Stdio::piped()).kill_on_drop(true).spawn().unwrap()
}

/// Uses the contract's own times and takes half a minute.
#[tokio::test(flavor = "multi_thread")]
async fn a_robot_that_connects_to_its_broker_passes() {
    let mut check = started(&["--mqtt-port", "0", "--json"]);
    let mut lines = BufReader::new(check.stderr.take().unwrap()).lines();
    let line = lines.next_line().await.unwrap().unwrap();
    let address = line.strip_prefix("vibrissa: MQTT on 127.0.0.1:").unwrap_or_else(|| panic!("{line}"));
    let (port, rest) = address.split_once(';').unwrap();
    assert_eq!(rest, " the robot f/good must connect to this address now");
    let broker = Broker::new("127.0.0.1", port.parse().unwrap());
    let (robot, _) = robot_of(&broker, FLEET, "good", None).await;
    let reading = tokio::spawn(async move { while let Ok(Some(_)) = lines.next_line().await {} });
    let ended = check.wait_with_output().await.unwrap();
    reading.await.unwrap();
    let report: serde_json::Value = serde_json::from_slice(&ended.stdout).unwrap();
    let failed = report["findings"].as_array().unwrap().iter().filter(|one| one["outcome"] == "FAIL");
    assert_eq!(failed.collect::<Vec<_>>(), Vec::<&serde_json::Value>::new());
    assert!(ended.status.success());
    // It is the present time, so that the rule of lower epochs can be tested, too.
    assert!(report["epoch"].as_u64().unwrap() > 1_700_000_000_000, "{}", report["epoch"]);
    let stale = report["findings"].as_array().unwrap().iter().find(|one| one["rule"] == "refuse-stale-epoch");
    assert_eq!(stale.map(|one| one["outcome"].as_str()), Some(Some("PASS")), "{report:#}");
    // The robot reaches the broker through the relay.
    let own = report["findings"].as_array().unwrap().iter().find(|one| one["rule"] == "own-level").unwrap();
    assert_eq!(own["outcome"], "PASS", "{own}");
    robot.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_that_does_not_come_is_named_with_the_address() {
    let ended = started(&["--mqtt-port", "0", "--wait", "300ms"]).wait_with_output().await.unwrap();
    let message = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{message}");
    assert!(message.contains("robot f/good did not connect to the broker 127.0.0.1:"), "{message}");
    assert!(message.contains("whisker/v1/f/good/connection with ONLINE"), "{message}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_taken_port_is_told_with_what_to_stop() {
    let other = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = other.local_addr().unwrap().port().to_string();
    let ended = started(&["--mqtt-port", &port]).wait_with_output().await.unwrap();
    let message = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{message}");
    assert!(message.contains("stop the supervisor of this machine first"), "{message}");
    assert!(message.contains(&format!("port {port} on 127.0.0.1 is taken")), "{message}");
}
