//! Checks of the systemd unit with systemd-analyze.

use std::process::{Command, Output};

use tempfile::TempDir;

use crate::{PROGRAM, project};

/// The unit with the path of the program under test.
fn unit() -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(project().join("deploy/systemd/vibrissa.service")).unwrap();
    assert!(text.contains("ExecStart=/usr/local/bin/vibrissa run --config /etc/vibrissa/vibrissa.toml\n"));
    let path = folder.path().join("vibrissa.service");
    std::fs::write(&path, text.replace("/usr/local/bin/vibrissa", PROGRAM)).unwrap();
    (folder, path.to_str().unwrap().to_owned())
}

fn analyze(arguments: &[&str]) -> Output {
    let mut command = Command::new("systemd-analyze");
    command.args(arguments).output().expect("systemd-analyze must be installed for this test")
}

#[test]
fn the_unit_is_understood_without_a_warning() {
    let (_folder, unit) = unit();
    let ended = analyze(&["verify", "--man=no", &unit]);
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    // Messages about other units of this machine are ignored.
    let ours: Vec<&str> = said.lines().filter(|line| line.contains("vibrissa")).collect();
    assert!(ended.status.success() && ours.is_empty(), "{said}");
}

#[test]
fn the_unit_is_exposed_to_little() {
    let (_folder, unit) = unit();
    let ended = analyze(&["security", "--offline=true", "--threshold=20", "--no-pager", &unit]);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stdout));
}
