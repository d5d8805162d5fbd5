//! The Debian packages, as far as possible without cargo-deb: `tests/packages` makes and installs them.

use std::fs::read_to_string;
use std::path::Path;
use std::process::Command;

use toml::Table;
use vibrissa_robot::Config;

use crate::{PROGRAM, project};

/// Packages with the folders of their manifests.
const PACKAGES: [(&str, &str); 2] = [("vibrissa", "services/vibrissa"), ("vibrissa-robot", "robot/agent")];

fn text(path: impl AsRef<Path>) -> String {
    let path = project().join(path);
    read_to_string(&path).unwrap_or_else(|problem| panic!("{}: {problem}", path.display()))
}

fn manifest(folder: &str) -> Table {
    text(Path::new(folder).join("Cargo.toml")).parse().unwrap()
}

#[test]
fn every_file_of_the_packages_exists_and_the_scripts_are_shell() {
    for (name, folder) in PACKAGES {
        let manifest = manifest(folder);
        let deb = manifest["package"]["metadata"]["deb"].as_table().unwrap();
        let here = |path: &str| project().join(folder).join(path);
        let assets = deb["assets"].as_array().unwrap();
        let sources: Vec<&str> = assets.iter().map(|asset| asset[0].as_str().unwrap()).collect();
        assert!(sources.contains(&format!("target/release/{name}").as_str()), "{sources:?}");
        for source in sources.into_iter().filter(|source| !source.starts_with("target/")) {
            assert!(here(source).is_file(), "{folder}: {source}");
        }
        for file in [&deb["changelog"], &deb["license-file"][0]] {
            assert!(here(file.as_str().unwrap()).is_file(), "{folder}: {file}");
        }
        let units = here(deb["systemd-units"]["unit-scripts"].as_str().unwrap());
        assert!(["service", "sysusers"].iter().all(|kind| units.join(format!("{name}.{kind}")).is_file()), "{folder}");
        // A robot without a configuration must not start.
        for key in ["enable", "start"] {
            assert_eq!(deb["systemd-units"][key].as_bool(), Some(false), "{folder}: {key}");
        }
        for script in ["postinst", "postrm"] {
            let path = here(deb["maintainer-scripts"].as_str().unwrap()).join(script);
            assert!(read_to_string(&path).unwrap().contains("#DEBHELPER#"), "{}", path.display());
            assert!(Command::new("sh").arg("-n").arg(&path).status().unwrap().success(), "{}", path.display());
        }
    }
}

#[test]
fn the_packages_have_the_version_of_the_programs() {
    let newest = text("deploy/debian/changelog").lines().next().unwrap().to_owned();
    for manifest in ["Cargo.toml", "robot/Cargo.toml"] {
        let manifest: Table = text(manifest).parse().unwrap();
        let version = manifest["workspace"]["package"]["version"].as_str().unwrap();
        assert!(newest.starts_with(&format!("vibrissa ({version}-")), "{newest}");
    }
}

#[test]
fn the_manual_pages_have_every_command() {
    let robot = env!("CARGO_BIN_EXE_robot-under-test");
    for (name, program) in [("vibrissa", PROGRAM), ("vibrissa-robot", robot)] {
        let page = text(format!("deploy/debian/{name}.1"));
        let help = Command::new(program).arg("--help").output().unwrap();
        let help = String::from_utf8(help.stdout).unwrap();
        let commands = help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
        let commands: Vec<&str> = commands.filter_map(|line| line.split_whitespace().next()).collect();
        assert!(commands.len() > 2, "{help}");
        for command in commands.into_iter().filter(|command| *command != "help") {
            assert!(page.contains(&format!("\n.B {command}\n")), "{name}: {command}");
        }
    }
}

#[test]
fn the_example_of_the_agent_is_complete_without_the_marks() {
    let written = text("deploy/agent.example.toml");
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("robot_password"), "secret").unwrap();
    let problem = Config::from_toml_str(&written, folder.path()).unwrap_err().to_string();
    assert!(problem.contains("fleet"), "{problem}");
    // "# " begins a comment.
    let is_key = |line: &&str| line.starts_with('#') && !line.starts_with("# ") && *line != "#";
    let settings: Vec<&str> = written.lines().filter(is_key).map(|line| &line[1..]).collect();
    let config = Config::from_toml_str(&settings.join("\n"), folder.path()).unwrap();
    assert_eq!((config.fleet.as_str(), config.robot.as_str()), ("lab", "crawler"));
    assert_eq!(config.outbox_file.as_deref(), Some(Path::new("/var/lib/vibrissa-robot/outbox")));
}
