//! The program with its pipes, and the robot's node.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Output, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Duration;

use serde_json::Value;
use vibrissa_tests::installed::crates_fetched;
use vibrissa_tests::python::environment_if_reachable;

/// Time limit for a message.
const PATIENCE: Duration = Duration::from_secs(30);
/// Tests that use a domain.
const TESTS: u32 = 9;
/// Domains whose ports are below those that Linux gives to clients.
const DOMAINS: u32 = 100;
pub(crate) const NAMESPACE: &str = "/crawler";

/// A running program whose output is read as lines of JSON. It is killed on drop.
pub(crate) struct Talking {
    pub(crate) child: Child,
    input: Option<ChildStdin>,
    lines: Receiver<Value>,
    pub(crate) errors: Receiver<String>,
}

impl Talking {
    fn start(command: &mut Command) -> Self {
        let piped = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = piped.spawn().unwrap();
        let read = |stream: Box<dyn Read + Send>| {
            let (send, receive) = channel::<String>();
            let lines = BufReader::new(stream).lines();
            thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| send.send(line)));
            receive
        };
        let (output, errors) = (child.stdout.take().unwrap(), child.stderr.take().unwrap());
        let (texts, errors) = (read(Box::new(output)), read(Box::new(errors)));
        let (send, lines) = channel();
        thread::spawn(move || texts.iter().try_for_each(|line| send.send(serde_json::from_str(&line).unwrap())));
        Self { input: child.stdin.take(), child, lines, errors }
    }

    /// Waits for a line of which the function makes something.
    pub(crate) fn hear<T>(&self, what: &str, mut choose: impl FnMut(&Value) -> Option<T>) -> T {
        loop {
            let line = self.lines.recv_timeout(PATIENCE);
            let line = line.unwrap_or_else(|_| panic!("no {what}; {:?}", self.errors.try_iter().collect::<Vec<_>>()));
            if let Some(chosen) = choose(&line) {
                return chosen;
            }
        }
    }

    pub(crate) fn say(&mut self, line: &str) {
        writeln!(self.input.as_mut().unwrap(), "{line}").unwrap();
    }

    /// Closes its input.
    pub(crate) fn hang_up(&mut self) {
        self.input = None;
    }
}

impl Drop for Talking {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn project() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// Runs cargo in the workspace of the program.
fn cargo(arguments: &[&str]) -> Output {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().join("ros2");
    let mut command = Command::new(env!("CARGO"));
    command.args(arguments).args(["--locked", "--quiet", "--manifest-path"]);
    command.arg(project().join("robot/ros2/Cargo.toml")).env("CARGO_TARGET_DIR", target).output().unwrap()
}

/// The program, built once per run after its unit tests; `None` if its crates cannot be fetched.
fn built() -> Option<PathBuf> {
    static BUILT: OnceLock<Option<PathBuf>> = OnceLock::new();
    let build = || {
        if !crates_fetched(&project().join("robot/ros2/Cargo.toml")) {
            return None;
        }
        for verb in ["build", "test"] {
            let output = cargo(&[verb]);
            let [said, problems] =
                [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
            assert!(output.status.success(), "cargo {verb}: {said}{problems}");
        }
        Some(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().join("ros2/debug/vibrissa-ros2"))
    };
    BUILT.get_or_init(build).clone()
}

/// Where the parts of a test meet: the domain is the test's own.
pub(crate) struct Stage {
    program: PathBuf,
    python: PathBuf,
    domain: String,
}

impl Stage {
    /// The stage of the test with this number, below [`TESTS`]; `None`, with a line on standard error, if something cannot be
    /// fetched. Another run on this machine most likely has other domains.
    pub(crate) fn make(test: u32) -> Option<Self> {
        let domain = std::process::id() % (DOMAINS / TESTS) * TESTS + test % TESTS;
        let programs = environment_if_reachable("requirements-ros2.txt", env!("CARGO_TARGET_TMPDIR"))?;
        Some(Self { program: built()?, python: programs.join("python"), domain: domain.to_string() })
    }

    /// The command with which an agent starts the program.
    pub(crate) fn command(&self) -> Vec<String> {
        let program = self.program.display().to_string();
        let words = ["--localhost", "--domain", &self.domain, "--namespace", NAMESPACE, "--pressures", "absolute"];
        std::iter::once(program).chain(words.map(str::to_owned)).collect()
    }

    /// Starts the program as the agent would.
    pub(crate) fn bridge(&self, arguments: &[&str]) -> Talking {
        let mut command = Command::new(&self.program);
        command.args(["--localhost", "--namespace", NAMESPACE, "--robot", "crawler"]).args(arguments);
        // The peer carries services as Cyclone DDS does.
        let environment = [("ROS_DOMAIN_ID", self.domain.as_str()), ("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")];
        Talking::start(command.envs(environment))
    }

    /// Starts the program as a launch file would.
    pub(crate) fn launched(&self, arguments: &[&str]) -> Talking {
        let mut command = Command::new(&self.program);
        let environment = [("ROS_DOMAIN_ID", self.domain.as_str()), ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")];
        Talking::start(command.arg("--ros-args").args(arguments).envs(environment))
    }

    /// Starts the robot's node.
    pub(crate) fn peer(&self, arguments: &[&str]) -> Talking {
        let mut command = Command::new(&self.python);
        command.arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("integration/ros2/peer.py"));
        Talking::start(command.args([NAMESPACE, &self.domain]).args(arguments))
    }
}
