//! Runs `vibrissa run` as a separate process, which can be killed.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;

use vibrissa_tests::wait::{self, PATIENCE};

use crate::running::LEARNED;

/// Path of the program.
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_vibrissa-under-test");
/// Path of the program of the laboratory.
pub(crate) const LABORATORY: &str = env!("CARGO_BIN_EXE_lab-under-test");

/// A running program, killed on drop.
pub(crate) struct Program {
    process: Child,
    pub(crate) http: SocketAddr,
}

/// How a test ends the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// SIGTERM: the program stops in an orderly way.
    Terminated,
    /// SIGKILL: the program stops at once.
    Killed,
}

impl Program {
    /// Starts a supervisor of fleet `f` and waits until it prints its HTTP address.
    pub(crate) fn start(database: &Path, broker_port: u16) -> Self {
        Self::start_in(database, broker_port, &[])
    }

    /// The same with additional environment variables.
    pub(crate) fn start_in(database: &Path, broker_port: u16, environment: &[(&str, &str)]) -> Self {
        let mut process = Command::new(PROGRAM)
            .args(["run", "--fleet", "f", "--http", "127.0.0.1:0"])
            .arg("--mqtt-url")
            .arg(format!("mqtt://127.0.0.1:{broker_port}"))
            .arg("--database-url")
            .arg(format!("sqlite:{}", database.display()))
            .args(["--detection-cold-start-contacts", &LEARNED.to_string()])
            .env("RUST_LOG", "error")
            .envs(environment.iter().copied())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let (said, says) = mpsc::channel();
        std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| said.send(line)));
        let line = says.recv_timeout(PATIENCE).expect("the program does not print its address");
        let http = line.rsplit_once("http://").unwrap_or_else(|| panic!("no address: {line}")).1.parse().unwrap();
        Self { process, http }
    }

    /// Ends the program and waits for its exit.
    pub(crate) async fn end(mut self, ending: Ending) {
        match ending {
            Ending::Killed => self.process.kill().unwrap(),
            Ending::Terminated => {
                let signal = Command::new("kill").args(["-TERM", &self.process.id().to_string()]).status();
                assert!(signal.unwrap().success());
            }
        }
        let status = wait::until("the program's end", async || self.process.try_wait().unwrap()).await;
        assert_eq!(status.success(), ending == Ending::Terminated, "{status}");
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
