//! Runs the program until it ends.

use std::path::Path;
use std::process::{Command, Output};

/// Path of the program.
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_lab-under-test");

/// Runs the program in a folder, without the log filter of the caller.
pub(crate) fn vibrissa(arguments: &[&str], folder: &Path) -> Output {
    Command::new(PROGRAM).args(arguments).current_dir(folder).env_remove("RUST_LOG").output().unwrap()
}

/// Standard output of a command that must succeed.
pub(crate) fn out(output: &Output) -> String {
    assert!(output.status.success(), "{}", err(output));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Standard error of a command.
pub(crate) fn err(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}
