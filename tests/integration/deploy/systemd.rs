//! Checks of the systemd units of the supervisor and the agent with systemd-analyze.

use std::process::{Command, Output};

use tempfile::TempDir;

use crate::{PROGRAM, project};

/// Names of the programs, with their arguments.
const UNITS: [(&str, &str); 2] =
    [("vibrissa", "run --config /etc/vibrissa/vibrissa.toml"), ("vibrissa-robot", "--config /etc/vibrissa/agent.toml")];

/// The units, with the path of a program that exists.
fn units() -> (TempDir, Vec<String>) {
    let folder = tempfile::tempdir().unwrap();
    let unit = |(name, arguments)| {
        let text = std::fs::read_to_string(project().join(format!("deploy/systemd/{name}.service"))).unwrap();
        assert!(text.contains(&format!("ExecStart={name} {arguments}\n")));
        let path = folder.path().join(format!("{name}.service"));
        std::fs::write(&path, text.replace(&format!("={name} "), &format!("={PROGRAM} "))).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let units = UNITS.into_iter().map(unit).collect();
    (folder, units)
}

fn analyze(arguments: &[&str]) -> Output {
    let mut command = Command::new("systemd-analyze");
    command.args(arguments).output().expect("systemd-analyze must be installed for this test")
}

#[test]
fn the_unit_is_understood_without_a_warning() {
    let (_folder, units) = units();
    for unit in units {
        let ended = analyze(&["verify", "--man=no", &unit]);
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        // Messages about other units of this machine are ignored.
        let ours: Vec<&str> = said.lines().filter(|line| line.contains("vibrissa")).collect();
        assert!(ended.status.success() && ours.is_empty(), "{said}");
    }
}

#[test]
fn the_unit_is_exposed_to_little() {
    let (_folder, units) = units();
    for unit in units {
        let ended = analyze(&["security", "--offline=true", "--threshold=20", "--no-pager", &unit]);
        assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stdout));
    }
}
