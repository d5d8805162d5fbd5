//! The end of the document: the supervisor stops, and the check takes its place with a broker at the same address.

use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;
use std::process::Output;

use nix::sys::signal::Signal;
use tokio::process::Command;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::{PATIENCE, until_true};

use super::script::Script;
use crate::program::{LABORATORY, PROGRAM};

/// Two ports on which nothing listens: for MQTT and for HTTP.
fn free_ports() -> [u16; 2] {
    let listeners = [0, 0].map(|port| TcpListener::bind((Ipv4Addr::LOCALHOST, port)).unwrap());
    listeners.map(|listener| listener.local_addr().unwrap().port())
}

fn supervisor(folder: &Path, mqtt: u16, http: u16) -> Process {
    let database = format!("sqlite:{}", folder.join("v.sqlite3").display());
    let (mqtt, http) = (mqtt.to_string(), format!("127.0.0.1:{http}"));
    let arguments = ["run", "--fleet", "f", "--mqtt-port", &mqtt, "--http", &http, "--database-url", &database];
    Process::start(Launch {
        program: PROGRAM.into(),
        arguments: arguments.map(str::to_owned).to_vec(),
        environment: vec![("RUST_LOG".to_owned(), "error".to_owned())],
        log: folder.join("log"),
    })
}

async fn vibrissa(arguments: &[&str], http: u16) -> Output {
    let mut command = Command::new(LABORATORY);
    command.args(arguments).env("VIBRISSA_URL", format!("http://127.0.0.1:{http}")).env("RUST_LOG", "error");
    command.kill_on_drop(true).output().await.unwrap()
}

fn stdout_of(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// Uses the contract's own times and takes half a minute.
#[tokio::test(flavor = "multi_thread")]
async fn the_robot_of_a_stopped_supervisor_comes_to_the_check_and_passes() {
    let folder = tempfile::tempdir().unwrap();
    let [mqtt, http] = free_ports();
    let mut supervisor = supervisor(folder.path(), mqtt, http);
    let _robot = Script::start(mqtt, 1e6);
    // The robot has then seen an epoch of the supervisor, and obeys no lower one.
    let setpoint = ["setpoint", "f/r/left/0", "--pressure-mpa", "0.09"];
    until_true("an applied setpoint", async || {
        let ended = vibrissa(&setpoint, http).await;
        ended.status.success() && stdout_of(&ended).contains("APPLIED at 0.0900 MPa")
    })
    .await;
    supervisor.signal(Signal::SIGTERM);
    assert!(supervisor.ended(PATIENCE).await.expect("the supervisor must end").success());
    let port = mqtt.to_string();
    let checked = vibrissa(&["check-robot", "--fleet", "f", "--robot", "r", "--mqtt-port", &port], http).await;
    assert!(checked.status.success() && stdout_of(&checked).contains(" 0 failed"), "{}", stdout_of(&checked));
}
