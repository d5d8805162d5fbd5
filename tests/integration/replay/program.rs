//! Runs the program `vibrissa`, which records and replays.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

/// Path of the program.
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_lab-under-test");

/// Runs the program until it ends.
pub(crate) fn run(arguments: &[&str]) -> Output {
    Command::new(PROGRAM).args(arguments).env_remove("RUST_LOG").output().unwrap()
}

/// Replays a file and returns the standard output.
pub(crate) fn replay(file: &Path, arguments: &[&str]) -> String {
    let file = file.to_str().unwrap();
    let output = run(&[&["replay", file], arguments].concat());
    assert!(output.status.success(), "{}", errors(&output));
    String::from_utf8(output.stdout).unwrap()
}

pub(crate) fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Lines of one kind of effect.
pub(crate) fn effects(text: &str, effect: &str) -> Vec<Value> {
    let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter(|line| line["effect"] == effect).collect()
}
