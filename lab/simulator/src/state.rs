//! The state file: the true state of a fleet's robots, for the next process.
//!
//! It is written when something happens to a robot, every [`EVERY`] for wear and pressures, and at the end. Each
//! write replaces the whole file atomically, by a rename.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tokio::sync::Notify;
use tokio::time::timeout;

use crate::random::digest;
use crate::robot::RobotState;
use crate::robot_handle::RobotHandle;
use crate::scenario::Scenario;

/// Greatest age of wear and pressures in the file: this much of them is lost if the process is killed.
pub const EVERY: Duration = Duration::from_secs(5);

/// Version of the file's format.
const VERSION: u64 = 1;
/// Every state file begins so.
const HEAD: &[u8] = b"{\n  \"version\": ";

/// Why a state file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum StateError {
    /// The file exists but cannot be read.
    #[error("cannot read the state file {}: {problem}", path.display())]
    Unreadable {
        /// Path of the state file.
        path: PathBuf,
        /// The error of the operating system.
        problem: std::io::Error,
    },
    /// The file cannot be written.
    #[error("cannot write the state file {}: {problem}", path.display())]
    Unwritable {
        /// Path of the state file.
        path: PathBuf,
        /// The error of the operating system.
        problem: std::io::Error,
    },
    /// The file has an invalid format or an invalid value.
    #[error("the state file {} is damaged: {problem}; remove it to start again with whole whiskers", path.display())]
    Damaged {
        /// Path of the state file.
        path: PathBuf,
        /// The invalid part and its place in the file.
        problem: String,
    },
    /// The file was written by another version of the program.
    #[error(
        "the state file {} has version {version}, but this program reads version {}: use the program that wrote it, or \
         remove the file to start again with whole whiskers", path.display(), VERSION
    )]
    OtherVersion {
        /// Path of the state file.
        path: PathBuf,
        /// The file's version.
        version: u64,
    },
    /// The file belongs to other robots, or to the same ones with other whiskers or events.
    #[error(
        "the state file {} belongs to another scenario (fleet {fleet}, seed {seed}), or the scenario was changed: give \
         another file with --state-file, or remove this one to start again with whole whiskers", path.display()
    )]
    OtherScenario {
        /// Path of the state file.
        path: PathBuf,
        /// Fleet in the file.
        fleet: String,
        /// Seed in the file.
        seed: u64,
    },
}

/// Content of the file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    version: u64,
    fleet: String,
    seed: u64,
    /// Hash of the robots, their whiskers as installed, and the events.
    scenario: String,
    robots: Vec<RobotState>,
}

/// The part that files of all versions share.
#[derive(Debug, Deserialize)]
struct Head {
    version: u64,
}

/// State file of a scenario.
#[derive(Debug, Clone)]
pub(crate) struct StateFile {
    path: PathBuf,
    fleet: String,
    seed: u64,
    scenario: String,
    robots: usize,
}

impl StateFile {
    pub(crate) fn new(path: &Path, scenario: &Scenario) -> Self {
        // Behaviour and noise may change: they are not part of the whiskers' state.
        let built = format!("{:?}", (scenario.calibration_error, &scenario.robots));
        Self {
            path: path.to_owned(),
            fleet: scenario.fleet.to_string(),
            seed: scenario.seed,
            scenario: format!("{:016x}", digest(&built)),
            robots: scenario.robots.len(),
        }
    }

    /// States of the robots in the order of the scenario; `None` if there is no file yet.
    pub(crate) fn read(&self) -> Result<Option<Vec<RobotState>>, StateError> {
        let path = || self.path.clone();
        let text = match std::fs::read_to_string(&self.path) {
            Ok(text) => text,
            Err(problem) if problem.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(problem) => return Err(StateError::Unreadable { path: path(), problem }),
        };
        let damaged = |problem: serde_json::Error| self.unfit(problem.to_string());
        let Head { version } = serde_json::from_str(&text).map_err(damaged)?;
        if version != VERSION {
            return Err(StateError::OtherVersion { path: path(), version });
        }
        let content: Content = serde_json::from_str(&text).map_err(damaged)?;
        if (&content.fleet, content.seed, &content.scenario) != (&self.fleet, self.seed, &self.scenario) {
            return Err(StateError::OtherScenario { path: path(), fleet: content.fleet, seed: content.seed });
        }
        if content.robots.len() != self.robots {
            return Err(self.unfit(format!("{} robots instead of {}", content.robots.len(), self.robots)));
        }
        Ok(Some(content.robots))
    }

    /// The error for a file with an invalid value.
    pub(crate) fn unfit(&self, problem: String) -> StateError {
        StateError::Damaged { path: self.path.clone(), problem }
    }

    /// Writes the current true state of the robots.
    pub(crate) fn write(&self, robots: &[RobotHandle]) -> Result<(), StateError> {
        let content = Content {
            version: VERSION,
            fleet: self.fleet.clone(),
            seed: self.seed,
            scenario: self.scenario.clone(),
            robots: robots.iter().map(|robot| robot.with(|robot| robot.state())).collect(),
        };
        let unwritable = |problem| StateError::Unwritable { path: self.path.clone(), problem };
        let text = serde_json::to_string_pretty(&content).map_err(|problem| unwritable(problem.into()))?;
        replace(&self.path, &text).map_err(unwritable)
    }

    /// Writes the file when something happens and at regular intervals, until the task is aborted.
    pub(crate) async fn keep(self, robots: Vec<RobotHandle>, changed: Arc<Notify>) {
        let mut is_failing = false;
        loop {
            // Both the interval and an event lead to a write.
            let _ = timeout(EVERY, changed.notified()).await;
            // On this thread, so that no write is in progress once this task has ended.
            let written = self.write(&robots);
            if let (Err(error), false) = (&written, is_failing) {
                tracing::error!(%error, "cannot write the state file, a restart would lose all later changes");
            }
            is_failing = written.is_err();
        }
    }
}

/// Replaces a file atomically and durably.
fn replace(path: &Path, text: &str) -> std::io::Result<()> {
    let mut name = path.as_os_str().to_owned();
    name.push(".new");
    let new = PathBuf::from(name);
    // A file that an earlier process has left. A link or the file of somebody else stays, and the write fails.
    let is_left = std::fs::symlink_metadata(&new).is_ok_and(|found| found.is_file())
        && std::fs::read(&new).is_ok_and(|bytes| bytes.is_empty() || bytes.starts_with(HEAD));
    if is_left {
        std::fs::remove_file(&new)?;
    }
    let mut file = File::create_new(&new)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()?;
    std::fs::rename(&new, path)?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_a_new_file_replaces_no_file_of_somebody_else() {
        let folder = std::env::temp_dir().join(format!("vibrissa-state-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (path, new, victim) = (folder.join("state"), folder.join("state.new"), folder.join("victim"));
        std::fs::write(&victim, "keep me").unwrap();
        std::os::unix::fs::symlink(&victim, &new).unwrap();
        assert!(replace(&path, "x").is_err());
        std::fs::remove_file(&new).unwrap();
        std::fs::write(&new, "keep me").unwrap();
        assert!(replace(&path, "x").is_err());
        assert_eq!(
            (std::fs::read(&victim).unwrap(), std::fs::read(&new).unwrap()),
            (b"keep me".into(), b"keep me".into())
        );
        for left in [&b""[..], HEAD] {
            std::fs::write(&new, left).unwrap();
            replace(&path, "x").unwrap();
        }
        assert_eq!((std::fs::read(&path).unwrap(), new.exists()), (b"x".into(), false));
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
