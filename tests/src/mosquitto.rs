//! A Mosquitto of the test's own: on a free port, in a temporary folder, stopped by its process.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use tempfile::TempDir;

/// Below the ports that systems give to outgoing connections: none of those can take a broker's port while
/// it is down.
const PORTS: std::ops::Range<u16> = 12_000..30_000;

/// A running broker; dropped, it is killed.
#[derive(Debug)]
pub struct Mosquitto {
    process: Child,
    port: u16,
    folder: TempDir,
}

impl Mosquitto {
    /// Starts a broker and waits until it says that it runs.
    ///
    /// # Panics
    /// Mosquitto is not installed, or does not start.
    #[must_use]
    pub fn start() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        // Between the look at a port and the broker's start another test may take it.
        for _ in 0..5 {
            let port = free_port();
            configure(folder.path(), port);
            if let Some(process) = run(folder.path()) {
                return Self { process, port, folder };
            }
        }
        panic!("Mosquitto did not start");
    }

    /// Where it listens, on 127.0.0.1.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Kills the broker: connections break, and everything that it had is gone.
    ///
    /// # Panics
    /// Its process is not ours any more.
    pub fn kill(&mut self) {
        self.process.kill().expect("our process");
        self.process.wait().expect("our process");
    }

    /// Starts it again on the same port.
    ///
    /// # Panics
    /// It does not start.
    pub fn restart(&mut self) {
        self.process = run(self.folder.path()).expect("Mosquitto did not start again");
    }
}

impl Drop for Mosquitto {
    fn drop(&mut self) {
        // It may have been killed already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A port of 127.0.0.1 that nothing listens on.
///
/// # Panics
/// There is none.
#[must_use]
pub fn free_port() -> u16 {
    // The standard library's hasher starts at random: tests that run at once look at different ports.
    let any = || PORTS.start + (RandomState::new().build_hasher().finish() % PORTS.len() as u64) as u16;
    (0..100).map(|_| any()).find(|&port| TcpListener::bind(("127.0.0.1", port)).is_ok()).expect("a free port")
}

fn configure(folder: &Path, port: u16) {
    // As root it would change to a user that cannot read the folder.
    let settings = format!(
        "listener {port} 127.0.0.1\nallow_anonymous true\nuser root\nset_tcp_nodelay true\n\
         max_queued_messages 100000\nlog_dest stderr\n"
    );
    std::fs::write(folder.join("mosquitto.conf"), settings).expect("a writable temporary folder");
}

/// The process, once it runs; none if it has ended instead.
fn run(folder: &Path) -> Option<Child> {
    let program = ["/usr/sbin/mosquitto", "/usr/local/sbin/mosquitto", "/opt/homebrew/sbin/mosquitto"]
        .into_iter()
        .map(PathBuf::from)
        .find(|path| path.exists())
        .unwrap_or_else(|| PathBuf::from("mosquitto"));
    let mut process = Command::new(program)
        .arg("-c")
        .arg(folder.join("mosquitto.conf"))
        .stderr(Stdio::piped())
        .spawn()
        .expect("Mosquitto must be installed for this test");
    let log = BufReader::new(process.stderr.take().expect("piped"));
    let (running, ran) = std::sync::mpsc::channel();
    // Reads on after that, so that the broker never waits for its log to be read.
    std::thread::spawn(move || {
        for line in log.lines().map_while(Result::ok) {
            if line.contains("running") {
                let _ = running.send(());
            }
        }
    });
    if ran.recv_timeout(Duration::from_secs(10)).is_ok() {
        return Some(process);
    }
    let _ = process.kill();
    let _ = process.wait();
    None
}
