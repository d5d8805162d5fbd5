//! The helper of `check-robot --assistant`: a program that is run for each action.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::check::{Action, Progress};

/// Tells the progress of a check, and runs the assistant if there is one.
#[derive(Debug, Clone)]
pub(super) struct Helper {
    assistant: Option<PathBuf>,
}

impl Helper {
    pub(super) fn new(assistant: Option<PathBuf>) -> Self {
        Self { assistant }
    }

    /// Takes the progress of a check.
    pub(super) fn tell(&self, progress: &Progress) {
        eprintln!("vibrissa: {progress}");
        if let (Progress::Act(action, _), Some(assistant)) = (progress, &self.assistant) {
            start(assistant, action);
        }
    }
}

/// Runs the assistant beside the check, which sees the effect of the action in the robot's messages.
fn start(assistant: &Path, action: &Action) {
    let mut command = Command::new(assistant);
    command.arg(action.word()).args(action.spot().map(ToString::to_string));
    // Standard output has only the report.
    let child = command.stdin(Stdio::null()).stdout(Stdio::null()).spawn();
    let (program, word) = (assistant.display().to_string(), action.word());
    let mut child = match child {
        Ok(child) => child,
        Err(problem) => return eprintln!("vibrissa: the assistant {program} cannot be started for {word}: {problem}"),
    };
    std::thread::spawn(move || match child.wait() {
        Ok(status) if status.success() => {}
        Ok(status) => eprintln!("vibrissa: the assistant {program} failed at {word}: {status}"),
        Err(problem) => eprintln!("vibrissa: the assistant {program} failed at {word}: {problem}"),
    });
}
