//! Where the scripts `tests/artemis` and `tests/rmqtt` install a broker, and whether they have.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// Time limit for a broker to listen. Java takes some seconds on a busy machine.
const START: Duration = Duration::from_secs(60);

/// The last line that a script of `tests` prints; `None`, with its message on standard error, if it fails.
///
/// # Panics
/// There is no such script.
#[must_use]
pub fn installed(script: &str, argument: Option<&str>) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(script);
    let output = Command::new(path).args(argument).output().expect("a script of ours");
    if !output.status.success() {
        eprintln!("skipped: {}", String::from_utf8_lossy(&output.stderr).trim());
        return None;
    }
    Some(PathBuf::from(String::from_utf8_lossy(&output.stdout).trim()))
}

/// Fetches the crates of a workspace of its own; false, with a line on standard error, if they cannot be fetched.
///
/// # Panics
/// Its Cargo.lock is outdated.
#[must_use]
pub fn crates_fetched(manifest: &Path) -> bool {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let output = cargo.args(["fetch", "--locked", "--quiet", "--manifest-path"]).arg(manifest).output().expect("cargo");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("--locked"), "{}: {said}", manifest.display());
    if !output.status.success() {
        eprintln!("skipped: the crates of {} cannot be fetched", manifest.display());
    }
    output.status.success()
}

/// Waits until a process listens on the port, or `has_ended`.
pub fn listens(host: &str, port: u16, mut has_ended: impl FnMut() -> bool) -> bool {
    let begun = Instant::now();
    while begun.elapsed() < START && !has_ended() {
        if std::net::TcpStream::connect((host, port)).is_ok() {
            return true;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    false
}
