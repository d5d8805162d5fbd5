//! The drawings of the documents are those that the program makes.

use std::process::Command;

use vibrissa_tests::svg::{is_up_to_date, writes_docs};

const PROGRAM: &str = env!("CARGO_BIN_EXE_lab-under-test");

#[test]
fn the_drawing_beyond_the_paper_in_docs_is_up_to_date() {
    let folder = tempfile::tempdir().unwrap();
    let output = Command::new(PROGRAM).args(["paper", "--svg"]).arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let drawn = std::fs::read_to_string(folder.path().join("beyond-the-paper.svg")).unwrap();
    is_up_to_date("beyond-the-paper.svg", &drawn, "cargo test -p vibrissa-tests --test demo pictures");
}

/// All trials of the evaluation take minutes. Those on one plant show whether the drawing looks as in the documents.
#[test]
fn the_drawing_of_the_evaluation_in_docs_is_up_to_date() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = Command::new(PROGRAM);
    command.args(["evaluate", "compensation", "--svg"]).arg(folder.path());
    if !writes_docs() {
        command.args(["--plants", "1"]);
    }
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let drawn = std::fs::read_to_string(folder.path().join("fig-10.svg")).unwrap();
    is_up_to_date("compensation.svg", &drawn, "cargo test -p vibrissa-tests --test demo pictures");
}
