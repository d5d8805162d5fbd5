//! The Python block of the document, and what it needs to run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use tempfile::TempDir;
use vibrissa_tests::process::{Launch, Process};

/// The document's robot as a process: robot `r` of the fleet `f`.
pub(super) struct Script {
    pub(super) process: Process,
    folder: TempDir,
}

impl Script {
    /// Starts it; whisker 1 loses 5 mm after so many seconds.
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

    /// What it has complained of.
    pub(super) fn complaints(&self) -> String {
        fs::read_to_string(self.folder.path().join("log")).unwrap()
    }
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The document's only block of Python.
fn block() -> String {
    let document = fs::read_to_string(repository().join("docs/robot-quickstart.md")).unwrap();
    let (_, rest) = document.split_once("```python\n").expect("a block of Python");
    assert!(!rest.contains("```python"), "one block");
    rest.split_once("```").expect("its end").0.to_owned()
}

/// A Python that has what the block needs: kept with the build, and made anew for other requirements.
fn python() -> &'static Path {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("quickstart-venv");
        let python = folder.join("bin/python");
        let requirements = repository().join("tests/requirements.txt");
        let (wanted, made) = (fs::read_to_string(&requirements).unwrap(), folder.join("made-for"));
        if fs::read_to_string(&made).ok().as_ref() != Some(&wanted) {
            run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder));
            let pip = ["-m", "pip", "install", "--quiet", "--no-input", "--require-hashes", "-r"];
            run(Command::new(&python).args(pip).arg(&requirements));
            fs::write(made, wanted).unwrap();
        }
        python
    })
}

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|problem| panic!("{command:?}: {problem}; tests/run installs it"));
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {told}");
}

#[test]
fn the_whole_robot_has_less_than_100_lines_that_fit_a_screen() {
    let block = block();
    assert!(block.lines().count() < 100, "{} lines", block.lines().count());
    assert!(block.lines().all(|line| line.chars().count() <= 120));
}
