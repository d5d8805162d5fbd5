//! Checks of the deployment files, as far as possible without a container engine.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod advisories;
mod circles;
mod clocks;
mod compose;
mod debian;
mod documents;
mod guidance;
mod invariants;
mod packages;
mod ports;
mod profiles;
mod sbom;
mod scale;
mod secrets;
mod stand_ins;
mod structure;
mod systemd;
mod words;

use std::path::PathBuf;

use vibrissa::config::{Key, Sources, read, show};

/// Path of the program.
pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_vibrissa-under-test");

/// Folder of the project.
pub(crate) fn project() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

#[test]
fn the_example_configuration_is_the_table_of_keys() {
    let path = project().join("deploy/vibrissa.example.toml");
    let (written, expected) = (std::fs::read_to_string(&path).unwrap(), show::example());
    assert!(written == expected, "{} must be:\n{expected}", path.display());
}

#[test]
fn the_example_configuration_uncommented_gives_the_defaults() {
    let written = std::fs::read_to_string(project().join("deploy/vibrissa.example.toml")).unwrap();
    // "# " begins a comment; an empty text stands for a setting without a value.
    let settings: Vec<&str> = written
        .lines()
        .map(|line| line.strip_prefix('#').filter(|rest| !rest.starts_with(' ')).unwrap_or(line))
        .filter(|line| !line.ends_with("\"\""))
        .collect();
    let count = settings.iter().filter(|line| line.contains(" = ")).count();
    assert_eq!(count, Key::ALL.iter().filter(|key| key.default().is_some()).count());
    let file = Sources { file: Some(("v.toml".into(), settings.join("\n"))), ..Sources::default() };
    let [written, built_in] = [file, Sources::default()].map(|sources| read(&sources).config.unwrap());
    assert_eq!(format!("{written:?}"), format!("{built_in:?}"));
}

#[test]
fn variables_of_the_deployment_files_are_the_programs() {
    // Variables of the simulator, and names that only appear in explanations.
    let others = ["VIBRISSA_SCENARIO", "VIBRISSA_STATE_FILE"];
    for file in ["Dockerfile", "docker-compose.yml", "deploy/systemd/vibrissa.service", "deploy/supervisor/readyz.sh"] {
        let text = std::fs::read_to_string(project().join(file)).unwrap();
        let is_part = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_';
        let words = text.split(|c: char| !is_part(c)).filter(|word| word.starts_with("VIBRISSA_"));
        for word in words.filter(|word| !others.contains(word)) {
            assert!(Key::ALL.iter().any(|key| key.environment() == word), "{file}: {word} is not a setting");
        }
    }
}
