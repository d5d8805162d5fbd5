//! Runs `vibrissa run` as a child process, which a test can kill, freeze or stop.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;

/// Command line and environment, used at each start.
#[derive(Debug, Clone)]
pub struct Launch {
    /// Path of the program.
    pub program: PathBuf,
    /// Arguments of the program.
    pub arguments: Vec<String>,
    /// Additional environment variables.
    pub environment: Vec<(String, String)>,
    /// File to which its standard error is appended.
    pub log: PathBuf,
}

/// A process that may or may not run; killed on drop.
#[derive(Debug)]
pub struct Process {
    launch: Launch,
    running: Option<Child>,
}

impl Process {
    /// Starts the process.
    pub fn start(launch: Launch) -> Self {
        let mut process = Self { launch, running: None };
        process.restart();
        process
    }

    /// Starts the process again after it has ended.
    ///
    /// # Panics
    /// The program cannot be started.
    pub fn restart(&mut self) {
        let launch = &self.launch;
        let log = File::options().create(true).append(true).open(&launch.log).expect("a log");
        let mut child = Command::new(&launch.program)
            .args(&launch.arguments)
            .envs(launch.environment.iter().map(|(name, value)| (name, value)))
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(log)
            .spawn()
            .unwrap_or_else(|problem| panic!("cannot start {}: {problem}", launch.program.display()));
        let lines = BufReader::new(child.stdout.take().expect("piped")).lines();
        // Reading goes on so that a full pipe never blocks the process.
        std::thread::spawn(move || lines.map_while(Result::ok).for_each(drop));
        self.running = Some(child);
    }

    /// Sets the additional environment variables of the next start.
    pub fn set_environment(&mut self, environment: Vec<(String, String)>) {
        self.launch.environment = environment;
    }

    /// Id of the running process.
    ///
    /// # Panics
    /// The process is not running.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.running.as_ref().expect("a running process").id()
    }

    /// Sends a signal to the process: SIGSTOP freezes it, SIGCONT revives it.
    ///
    /// # Panics
    /// The process is not running.
    pub fn signal(&self, signal: Signal) {
        let running = self.running.as_ref().expect("a running process");
        let pid = Pid::from_raw(i32::try_from(running.id()).expect("a process id"));
        kill(pid, signal).expect("our process");
    }

    /// Kills the process without any cleanup.
    ///
    /// # Panics
    /// The process is not running.
    pub fn kill(&mut self) {
        let mut running = self.running.take().expect("a running process");
        running.kill().expect("our process");
        running.wait().expect("our process");
    }

    /// Waits for the process to end, after SIGTERM for instance. None if it still runs after `patience`.
    ///
    /// # Panics
    /// The process is not running.
    pub async fn ended(&mut self, patience: Duration) -> Option<ExitStatus> {
        let deadline = tokio::time::Instant::now() + patience;
        loop {
            if let Some(status) = self.ended_already() {
                return Some(status);
            }
            if tokio::time::Instant::now() > deadline {
                return None;
            }
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
    }

    /// Exit status of the process if it has ended on its own since its last start.
    ///
    /// # Panics
    /// The process is not running.
    pub fn ended_already(&mut self) -> Option<ExitStatus> {
        let status = self.running.as_mut()?.try_wait().expect("our process");
        if status.is_some() {
            self.running = None;
        }
        status
    }

    /// Whether the process was started and, as far as is known, has not ended.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if let Some(running) = &mut self.running {
            // It may have ended already. A frozen process can be killed, too.
            let _ = running.kill();
            let _ = running.wait();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sleeper(folder: &std::path::Path) -> Process {
        Process::start(Launch {
            program: "sleep".into(),
            arguments: vec!["60".to_owned()],
            environment: Vec::new(),
            log: folder.join("log"),
        })
    }

    #[tokio::test]
    async fn it_runs_until_it_is_told_to_end_and_a_frozen_one_can_be_killed() {
        let folder = tempfile::tempdir().unwrap();
        let mut process = sleeper(folder.path());
        assert!(process.ended(Duration::from_millis(50)).await.is_none() && process.is_running());
        process.signal(Signal::SIGTERM);
        assert!(!process.ended(Duration::from_secs(5)).await.unwrap().success());
        assert!(!process.is_running());
        process.restart();
        process.signal(Signal::SIGSTOP);
        process.kill();
        assert!(!process.is_running());
    }
}
