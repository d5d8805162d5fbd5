//! The end of the program: its exit code, and the text of its error.

use std::io::ErrorKind;
use std::process::ExitCode;

use vibrissa_protocol::plain;
use vibrissa_store::StoreError;
use vibrissa_store::backup::BackupError;
use vibrissa_supervisor::outgoing;

use super::stop::{EXIT_CODE, Stopped};

/// The exit code of a command's result. An error is printed on standard error.
pub fn exit_code(result: anyhow::Result<ExitCode>) -> ExitCode {
    match result {
        Ok(code) => code,
        // The reader of the output has closed the pipe, as in `vibrissa metrics | head`.
        Err(problem) if is_broken_pipe(&problem) => ExitCode::SUCCESS,
        Err(problem) if problem.is::<Stopped>() => {
            eprintln!("vibrissa: {problem}");
            ExitCode::from(EXIT_CODE)
        }
        Err(problem) => {
            eprintln!("vibrissa: {}", problem_text(&problem));
            ExitCode::FAILURE
        }
    }
}

fn is_broken_pipe(problem: &anyhow::Error) -> bool {
    problem.downcast_ref::<std::io::Error>().is_some_and(|problem| problem.kind() == ErrorKind::BrokenPipe)
}

/// The text of a cause, in plain words if it is an error of a library.
fn cause_text(cause: &(dyn std::error::Error + 'static)) -> String {
    if let Some(problem) = cause.downcast_ref::<serde_json::Error>() {
        return plain::data(&problem.to_string());
    }
    outgoing::known(cause).unwrap_or_else(|| plain::text(&cause.to_string()))
}

/// The problem and its causes; a cause that a previous text already includes is omitted.
fn problem_text(problem: &anyhow::Error) -> String {
    let mut story = String::new();
    for cause in problem.chain() {
        let text = cause_text(cause);
        if !story.contains(&text) {
            let colon = if story.is_empty() { "" } else { ": " };
            story = format!("{story}{colon}{text}");
        }
        // Its text is complete, and its causes are in the words of the database's library.
        if cause.is::<StoreError>() || cause.is::<BackupError>() {
            break;
        }
    }
    story
}
