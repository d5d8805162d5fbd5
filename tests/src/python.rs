//! Runs Python programs in virtual environments that are cached in the build folder.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// Only one environment is created at a time.
static MAKING: Mutex<()> = Mutex::new(());

/// The folder of programs of an environment with the packages of a requirements file in `tests/`. A changed
/// requirements file creates a new environment. Hashes in the file are verified.
///
/// # Panics
/// Python 3 with `venv` is missing, or the packages cannot be installed.
#[must_use]
pub fn environment(requirements: &str, target: &str) -> PathBuf {
    let _making = MAKING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let name = Path::new(requirements).file_name().and_then(|name| name.to_str()).expect("a file");
    let folder = Path::new(target).join(format!("venv-{name}"));
    let programs = folder.join("bin");
    let requirements = Path::new(env!("CARGO_MANIFEST_DIR")).join(requirements);
    let (wanted, made) = (fs::read_to_string(&requirements).expect("requirements"), folder.join("made-for"));
    if fs::read_to_string(&made).ok().as_ref() != Some(&wanted) {
        run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&folder));
        let mut pip = Command::new(programs.join("python"));
        pip.args(["-m", "pip", "install", "--quiet", "--no-input", "-r"]).arg(&requirements);
        run(if wanted.contains("--hash=") { pip.arg("--require-hashes") } else { &mut pip });
        fs::write(made, wanted).expect("a mark");
    }
    programs
}

/// The same; `None`, with a line on standard error, if no environment exists yet and the packages cannot be fetched.
#[must_use]
pub fn environment_if_reachable(requirements: &str, target: &str) -> Option<PathBuf> {
    let probe = ["-m", "pip", "download", "--quiet", "--no-input", "--no-deps", "--retries=1", "--timeout=10"];
    let name = Path::new(requirements).file_name()?.to_str()?;
    let is_made = Path::new(target).join(format!("venv-{name}")).join("made-for").exists();
    let is_reachable = is_made || {
        let folder = tempfile::tempdir().expect("a folder");
        let mut pip = Command::new("python3");
        pip.args(probe).arg("--dest").arg(folder.path()).arg("typing_extensions==4.16.0");
        pip.output().is_ok_and(|output| output.status.success())
    };
    if !is_reachable {
        eprintln!("skipped: {name}: the packages cannot be fetched");
        return None;
    }
    Some(environment(requirements, target))
}

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|problem| panic!("{command:?}: {problem}; tests/run installs it"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}
