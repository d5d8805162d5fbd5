//! The `vibrissa` program.

use std::io::ErrorKind;
use std::process::ExitCode;

use vibrissa::cli;
use vibrissa::cli::stop::{EXIT_CODE, Stopped};

fn main() -> ExitCode {
    match cli::run(cli::parse()) {
        Ok(code) => code,
        // The reader of the output has closed the pipe, as in `vibrissa paper | head`.
        Err(problem) if is_broken_pipe(&problem) => ExitCode::SUCCESS,
        Err(problem) if problem.is::<Stopped>() => {
            eprintln!("vibrissa: {problem}");
            ExitCode::from(EXIT_CODE)
        }
        Err(problem) => {
            eprintln!("vibrissa: {}", told_once(&problem));
            ExitCode::FAILURE
        }
    }
}

fn is_broken_pipe(problem: &anyhow::Error) -> bool {
    problem.downcast_ref::<std::io::Error>().is_some_and(|problem| problem.kind() == ErrorKind::BrokenPipe)
}

/// The problem and its causes; a cause that a previous text already includes is omitted.
fn told_once(problem: &anyhow::Error) -> String {
    let mut story = String::new();
    for cause in problem.chain().map(ToString::to_string) {
        if !story.contains(&cause) {
            let colon = if story.is_empty() { "" } else { ": " };
            story = format!("{story}{colon}{cause}");
        }
    }
    story
}
