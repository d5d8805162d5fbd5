//! A supervisor process with a robot that has touched things, and virtual environments with our packages.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use tempfile::TempDir;
use vibrissa_protocol::ArrayType;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::python::environment_if_reachable;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::try_get;

pub(crate) const TOKEN: &str = "a-token-of-more-than-32-characters-for-the-test";
/// Contacts until a whisker counts as learned.
const LEARNED: usize = 60;

/// Folder of the checkout.
pub(crate) fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// A supervisor of fleet `f`, and perhaps its robot `r` with two whiskers.
pub(crate) struct Stage {
    pub(crate) http: SocketAddr,
    pub(crate) mqtt_port: u16,
    pub(crate) folder: TempDir,
    _robot: Option<HandRobot>,
    _process: Process,
    _broker: Mosquitto,
}

impl Stage {
    /// With the robot.
    pub(crate) async fn start() -> Self {
        let mut stage = Self::empty().await;
        let mut robot = HandRobot::born(stage.mqtt_port, "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
        for whisker in [0, 1] {
            robot.touch(whisker, LEARNED + 20).await;
        }
        robot.receipted().await;
        stage._robot = Some(robot);
        stage
    }

    /// Without a robot.
    pub(crate) async fn empty() -> Self {
        let (broker, folder) = (Mosquitto::start(), tempfile::tempdir().unwrap());
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let token = folder.path().join("token");
        std::fs::write(&token, TOKEN).unwrap();
        let arguments = [
            "run".to_owned(),
            "--fleet=f".to_owned(),
            format!("--http={http}"),
            format!("--http-token-file={}", token.display()),
            format!("--mqtt-url=mqtt://127.0.0.1:{}", broker.port()),
            format!("--detection-cold-start-contacts={LEARNED}"),
            format!("--database-url=sqlite:{}", folder.path().join("v.sqlite3").display()),
        ];
        let process = Process::start(Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.into(),
            environment: Vec::new(),
            log: folder.path().join("log"),
        });
        until_true("the program answers", async || try_get(http, "/livez").await.is_ok()).await;
        Self { http, mqtt_port: broker.port(), folder, _robot: None, _process: process, _broker: broker }
    }
}

/// An environment with the wheel of `vibrissa-client`, generated and built once per run; `None` without a network.
pub(crate) fn client_environment() -> Option<PathBuf> {
    static MADE: OnceLock<Option<PathBuf>> = OnceLock::new();
    let make = || {
        let target = env!("CARGO_TARGET_TMPDIR");
        let generator = environment_if_reachable("../python/client/requirements-generate.txt", target)?;
        let programs = environment_if_reachable("requirements-python-client.txt", target)?;
        let wheels = tempfile::tempdir().unwrap();
        let mut generate = Command::new(generator.join("python"));
        generate.arg(project().join("python/client/generate")).arg("--wheel").arg(wheels.path());
        succeed(generate.args(["--program", env!("CARGO_BIN_EXE_vibrissa-under-test")]));
        let wheel = std::fs::read_dir(wheels.path()).unwrap().next().unwrap().unwrap().path();
        let mut pip = Command::new(programs.join("python"));
        pip.args(["-m", "pip", "install", "--quiet", "--no-input", "--no-deps"]);
        // Without the network: everything that it needs is in the environment.
        succeed(pip.args(["--no-index", "--force-reinstall"]).arg(&wheel));
        Some(programs)
    };
    MADE.get_or_init(make).clone()
}

/// Runs a command that must succeed; returns its standard output.
pub(crate) fn succeed(command: &mut Command) -> String {
    let Output { status, stdout, stderr } = command.stdin(Stdio::null()).output().unwrap();
    let (stdout, stderr) = (String::from_utf8_lossy(&stdout), String::from_utf8_lossy(&stderr));
    assert!(status.success(), "{command:?}: {stdout}{stderr}");
    stdout.into_owned()
}

/// A program of this folder, in an environment.
pub(crate) fn program(programs: &Path, name: &str, http: SocketAddr) -> Command {
    let mut command = Command::new(programs.join("python"));
    command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("integration/python").join(name));
    command.env("VIBRISSA_URL", format!("http://{http}")).env("VIBRISSA_TOKEN", TOKEN);
    command
}
