//! `vibrissa-robot`: the wheel, built and installed in a new environment, as a robot of a real supervisor and broker.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use serde_json::{Value, json};
use vibrissa_tests::installed::crates_fetched;
use vibrissa_tests::python::environment_if_reachable;
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::{ask, send};

use crate::stage::{Stage, TOKEN, project, succeed};

/// Builds the wheel, and installs it in a new environment, once per run; `None` without a network. Returns the programs
/// that build, and the new environment's.
fn installed() -> Option<(PathBuf, PathBuf)> {
    static MADE: OnceLock<Option<(PathBuf, PathBuf)>> = OnceLock::new();
    let make = || {
        let target = Path::new(env!("CARGO_TARGET_TMPDIR"));
        let programs = environment_if_reachable("requirements-python-robot.txt", env!("CARGO_TARGET_TMPDIR"))?;
        let manifest = project().join("robot/python/Cargo.toml");
        if !crates_fetched(&manifest) {
            return None;
        }
        let wheels = tempfile::tempdir().unwrap();
        let mut maturin = Command::new(programs.join("maturin"));
        maturin.args(["build", "--locked", "--quiet", "--profile", "dev", "--manifest-path"]).arg(&manifest);
        maturin.arg("--out").arg(wheels.path()).env("CARGO_TARGET_DIR", target.parent().unwrap().join("robot"));
        succeed(&mut maturin);
        let wheel = std::fs::read_dir(wheels.path()).unwrap().next().unwrap().unwrap().path();
        assert!(wheel.to_str().unwrap().contains("-cp39-abi3-"), "one wheel for all versions: {}", wheel.display());
        let fresh = target.join("venv-robot-wheel");
        succeed(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&fresh));
        let mut pip = Command::new(fresh.join("bin/python"));
        succeed(pip.args(["-m", "pip", "install", "--quiet", "--no-input", "--no-index"]).arg(&wheel));
        Some((programs, fresh.join("bin/python")))
    };
    MADE.get_or_init(make).clone()
}

/// The robot's program.
fn script() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("integration/python/robot.py")
}

#[tokio::test]
async fn the_robot_does_what_its_types_say() {
    let Some((programs, python)) = installed() else { return };
    let source = project().join("robot/python/python/vibrissa_robot");
    for checked in [script(), source] {
        let mut mypy = Command::new(programs.join("mypy"));
        mypy.args(["--strict", "--cache-dir"]).arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("mypy-robot"));
        mypy.arg("--python-executable").arg(&python).arg(checked);
        // Where no file of the checkout hides the installed package.
        succeed(mypy.current_dir(env!("CARGO_TARGET_TMPDIR")));
    }
}

/// States were lost with a connection, a panic was told to nobody, and events that callbacks had taken counted as dropped.
#[test]
fn regress_a_robot_tells_its_states_again_and_hears_the_end_of_its_agent() {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("integration/python/link.py");
    let mut command = Command::new("python3");
    assert_eq!(succeed(command.arg(script).arg(project().join("robot/python/python"))), "ended\n");
}

async fn get(http: SocketAddr, path: &str) -> Value {
    let bearer = format!("Bearer {TOKEN}");
    ask(http, "GET", path, &[("authorization", &bearer)]).await.unwrap().json()
}

/// Runs the robot's program, and sets a pressure by hand once the supervisor has its contacts.
async fn a_robot_in_python(kind: &str) {
    let Some((_, python)) = installed() else { return };
    let stage = Stage::empty().await;
    let config = stage.folder.path().join("agent.toml");
    let text = format!(
        r#"
        fleet = "f"
        robot = "p"
        [broker]
        url = "mqtt://127.0.0.1:{}"
        [outbox]
        file = "outbox"
        [driver]
        silent_s = 1.0
        [[arrays]]
        array = "left"
        type = "TYPE_1"
        whiskers = [
            {{ whisker = 0, length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2, neighbours = [1], place = "DISTANCE" }},
            {{ whisker = 1, length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2, place = "DISTANCE" }},
        ]
        "#,
        stage.mqtt_port
    );
    std::fs::write(&config, text).unwrap();
    let mut command = Command::new(python);
    command.arg(script()).arg(kind).arg(&config);
    let robot = tokio::task::spawn_blocking(move || succeed(&mut command));
    let whisker = "/v1/fleets/f/robots/p/arrays/left/whiskers/1";
    until_true("contacts of the robot", async || get(stage.http, whisker).await["contacts"].as_u64() > Some(20)).await;
    let (bearer, body) = (format!("Bearer {TOKEN}"), json!({ "pressure_mpa": 0.08, "reason": "a test" }));
    let path = format!("{whisker}/setpoint");
    let answer = send(stage.http, "POST", &path, &[("authorization", &bearer)], Some(&body)).await.unwrap();
    assert!(answer.status < 300, "{}", answer.body);
    let applied = until("the setpoint is applied", async || {
        let page = get(stage.http, "/v1/setpoints?fleet=f&robot=p&whisker=1&state=APPLIED").await;
        page["items"].as_array()?.first().cloned()
    })
    .await;
    assert_eq!(applied["pressure_mpa"], 0.08);
    assert_eq!(robot.await.unwrap(), "ended\n");
    // It has said farewell, and did not merely vanish.
    until_true("the farewell", async || get(stage.http, "/v1/fleets/f/robots/p").await["connection"] == "OFFLINE")
        .await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_in_python_applies_a_setpoint() {
    a_robot_in_python("sync").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_in_python_applies_a_setpoint_with_asyncio() {
    a_robot_in_python("async").await;
}
