//! Python programs with what they need, in virtual environments that are kept with the build.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;

/// One environment is made at a time.
static MAKING: Mutex<()> = Mutex::new(());

/// The programs' folder of an environment with the packages of a requirements file of `tests/`; made anew for other
/// requirements. Where the file has hashes they are checked.
///
/// # Panics
/// There is no Python 3 with `venv`, or the packages cannot be had.
#[must_use]
pub fn environment(requirements: &str, target: &str) -> PathBuf {
    let _making = MAKING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let folder = Path::new(target).join(format!("venv-{requirements}"));
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

fn run(command: &mut Command) {
    let output = command.output().unwrap_or_else(|problem| panic!("{command:?}: {problem}; tests/run installs it"));
    assert!(output.status.success(), "{command:?}: {}", String::from_utf8_lossy(&output.stderr));
}
