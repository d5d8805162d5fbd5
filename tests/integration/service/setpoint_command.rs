//! `vibrissa setpoint` waits for the robot, and its exit code says whether the pressure was applied.

use serde_json::Value;
use vibrissa_protocol::{ArrayType, SetpointError, SetpointOutcome};
use vibrissa_tests::robot::{HandRobot, array};

use crate::program::PROGRAM;
use crate::running::{LEARNED, Running};

/// Exit code, standard output and standard error of `vibrissa setpoint f/r/left/0`.
async fn setpoint(running: &Running, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = tokio::process::Command::new(PROGRAM);
    command.args(["setpoint", "f/r/left/0"]).args(arguments);
    command.env("VIBRISSA_URL", format!("http://{}", running.service.http));
    let output = command.kill_on_drop(true).output().await.unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    (output.status.code(), out, err)
}

async fn robot(running: &Running) -> HandRobot {
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.touch(0, LEARNED + 20).await;
    robot.receipted().await;
    robot
}

/// Answers the next setpoint with these states.
async fn answer(robot: &mut HandRobot, states: &[(SetpointOutcome, Option<SetpointError>)]) {
    let (setpoint, _) = robot.setpoint().await;
    for (state, error) in states {
        robot.answer(&setpoint, *state, *error).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn it_tells_each_state_and_ends_when_the_robot_has_applied_the_pressure() {
    let running = Running::start().await;
    let mut robot = robot(&running).await;
    let applied =
        [(SetpointOutcome::Received, None), (SetpointOutcome::Applying, None), (SetpointOutcome::Applied, None)];
    let (ended, ()) = tokio::join!(setpoint(&running, &["--pressure-mpa", "0.05"]), answer(&mut robot, &applied));
    let (code, output, problem) = ended;
    assert_eq!(code, Some(0), "{output}{problem}");
    let lines: Vec<&str> = output.lines().collect();
    assert!(lines[0].contains("SETPOINT DONE"), "{output}");
    assert!(lines[1].ends_with(": 0.0500 MPa sent, waiting for the robot"), "{output}");
    assert_eq!(lines[2..], ["RECEIVED", "APPLYING", "APPLIED at 0.0500 MPa"]);
    // The whisker holds the pressure already, so the supervisor sends nothing.
    let (code, output, problem) = setpoint(&running, &["--pressure-mpa", "0.05"]).await;
    assert_eq!(code, Some(0), "{output}{problem}");
    assert!(output.contains("no setpoint was necessary"), "{output}");
    // The release leads back to the pressure of the factsheet.
    let (ended, ()) = tokio::join!(setpoint(&running, &["--release", "--json"]), answer(&mut robot, &applied));
    let (code, output, problem) = ended;
    assert_eq!(code, Some(0), "{output}{problem}");
    let rows: Vec<Value> = output.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((&rows[0]["kind"], &rows[0]["state"]), (&"RELEASE".into(), &"DONE".into()));
    assert_eq!((&rows[1]["reason"], &rows[1]["state"]), (&"RELEASE".into(), &"APPLIED".into()));
    assert!(problem.contains("waiting for the robot") && problem.contains("APPLYING"), "{problem}");
    running.service.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_pressure_that_the_robot_did_not_take_is_no_success() {
    let running = Running::start().await;
    let mut robot = robot(&running).await;
    let rejected = [(SetpointOutcome::Rejected, Some(SetpointError::OutOfRange))];
    let (ended, ()) = tokio::join!(setpoint(&running, &["--pressure-mpa", "0.06"]), answer(&mut robot, &rejected));
    let (code, output, problem) = ended;
    assert_eq!(code, Some(3), "{output}{problem}");
    assert!(output.contains("\nREJECTED (OUT_OF_RANGE)\n"), "{output}");
    assert!(problem.contains("f/r/left/0 has not applied 0.0600 MPa: its setpoint is REJECTED"), "{problem}");
    // The robot takes it, and never reaches it.
    let received = [(SetpointOutcome::Received, None)];
    let waiting = ["--pressure-mpa", "0.07", "--wait", "2"];
    let (ended, ()) = tokio::join!(setpoint(&running, &waiting), answer(&mut robot, &received));
    let (code, output, problem) = ended;
    assert_eq!(code, Some(3), "{output}{problem}");
    assert!(problem.contains("its setpoint is RECEIVED after 2 s; follow it at /v1/setpoints/"), "{problem}");
    // A caller that does not want to wait gets the answer of the supervisor alone.
    let (code, output, problem) = setpoint(&running, &["--pressure-mpa", "0.08", "--wait", "0"]).await;
    assert_eq!(code, Some(0), "{output}{problem}");
    assert!(output.contains("SETPOINT DONE") && !output.contains("waiting for the robot"), "{output}");
    running.service.stop().await;
}
