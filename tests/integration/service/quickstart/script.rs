//! The Python block of the document, and an environment in which it runs.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::TempDir;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::python::environment;

/// The document's robot as a process: robot `r` of fleet `f`.
pub(super) struct Script {
    pub(super) process: Process,
    folder: TempDir,
}

impl Script {
    /// Starts the robot; whisker 1 loses 5 mm after this many seconds.
    pub(super) fn start(broker_port: u16, cut_after_s: f64) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.py");
        fs::write(&path, block()).unwrap();
        let environment = [
            ("BROKER_PORT", broker_port.to_string()),
            ("FLEET", "f".to_owned()),
            ("ROBOT", "r".to_owned()),
            ("CUT_AFTER_S", cut_after_s.to_string()),
        ];
        let process = Process::start(Launch {
            program: python().to_owned(),
            arguments: vec![path.to_str().unwrap().to_owned()],
            environment: environment.map(|(name, value)| (name.to_owned(), value)).to_vec(),
            log: folder.path().join("log"),
        });
        Self { process, folder }
    }

    /// Errors that the robot has printed.
    pub(super) fn complaints(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap()
    }
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The document's only Python block.
fn block() -> String {
    let document = fs::read_to_string(repository().join("docs/robot-quickstart.md")).unwrap();
    let (_, rest) = document.split_once("```python\n").expect("a block of Python");
    assert!(!rest.contains("```python"), "there must be only one block");
    rest.split_once("```").expect("the end of the block").0.to_owned()
}

/// Path of a Python with the packages that the block needs.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| environment("requirements.txt", env!("CARGO_TARGET_TMPDIR")).join("python"))
}

#[test]
fn the_whole_robot_has_less_than_100_lines_that_fit_a_screen() {
    let block = block();
    assert!(block.lines().count() < 100, "{} lines", block.lines().count());
    assert!(block.lines().all(|line| line.chars().count() <= 120));
}
