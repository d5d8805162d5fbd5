//! Runs a private Mosquitto on a free port with its files in a temporary folder.

use std::fs::File;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tempfile::TempDir;

use crate::certificates::{Authority, Identity, write};

/// Ports below the range that systems use for outgoing connections: such a connection cannot occupy a broker's port
/// while the broker is down.
const PORTS: std::ops::Range<u16> = 12_000..30_000;

/// Keyword that begins a listener in a configuration.
const LISTENER: &str = "listener ";

/// Name of the OpenSSL settings in a broker's folder; the file is optional.
const OPENSSL_SETTINGS: &str = "openssl.cnf";
const TLS_1_2_SETTINGS: &str = "openssl_conf = all\n[all]\nssl_conf = ssl\n[ssl]\nsystem_default = limits\n\
                                [limits]\nMaxProtocol = TLSv1.2\n";

/// A running broker, killed on drop.
#[derive(Debug)]
pub struct Mosquitto {
    process: Child,
    port: u16,
    supervisor_port: u16,
    folder: TempDir,
    log: Log,
}

/// Lines of the broker's log since its first start.
type Log = Arc<Mutex<Vec<String>>>;

/// A broker stopped by SIGSTOP; it continues on drop.
#[derive(Debug)]
pub struct Frozen(Pid);

impl Drop for Frozen {
    fn drop(&mut self) {
        // The broker may have been killed meanwhile.
        let _ = kill(self.0, Signal::SIGCONT);
    }
}

/// Settings of a broker beside its port.
#[derive(Debug, Clone, Default)]
pub struct Builder {
    tls: Option<Tls>,
    users: Vec<(String, String)>,
    supervisors: Vec<(String, String)>,
    acl: Option<String>,
    lines: Vec<String>,
    has_default_limits: bool,
    file: Option<String>,
    has_old_tls: bool,
}

/// Certificates of a listener: its own, and the authority of its clients.
#[derive(Debug, Clone)]
struct Tls {
    server: Identity,
    clients: Option<String>,
}

impl Builder {
    /// Makes the listener use TLS.
    #[must_use]
    pub fn tls(mut self, server: Identity) -> Self {
        self.tls = Some(Tls { server, clients: None });
        self
    }

    /// Makes the listener use TLS and require client certificates of this authority.
    #[must_use]
    pub fn tls_with_clients_of(mut self, server: Identity, authority: &Authority) -> Self {
        self.tls = Some(Tls { server, clients: Some(authority.certificate()) });
        self
    }

    /// Limits the broker to TLS 1.2, which requires settings of OpenSSL itself.
    #[must_use]
    pub fn tls_1_2(mut self) -> Self {
        self.has_old_tls = true;
        self
    }

    /// Adds a user with a password. As soon as there is a user, anonymous clients are refused.
    #[must_use]
    pub fn user(mut self, name: &str, password: &str) -> Self {
        self.users.push((name.to_owned(), password.to_owned()));
        self
    }

    /// Adds a user to the supervisors' listener of a configuration from [`Self::file`].
    #[must_use]
    pub fn supervisor(mut self, name: &str, password: &str) -> Self {
        self.supervisors.push((name.to_owned(), password.to_owned()));
        self
    }

    /// Sets the access rules: the text of an `acl_file`.
    #[must_use]
    pub fn acl(mut self, text: &str) -> Self {
        self.acl = Some(text.to_owned());
        self
    }

    /// Adds a line to the configuration.
    #[must_use]
    pub fn line(mut self, line: &str) -> Self {
        self.lines.push(line.to_owned());
        self
    }

    /// Uses Mosquitto's own limits and defaults: queues of 1,000 messages, and Nagle's algorithm delays small packets.
    #[must_use]
    pub fn default_limits(mut self) -> Self {
        self.has_default_limits = true;
        self
    }

    /// Uses this configuration text, such as a shipped file. The ports of its listeners (the first for robots, an
    /// optional second one for supervisors), the paths of files and the user of the process are replaced.
    #[must_use]
    pub fn file(mut self, text: &str) -> Self {
        self.file = Some(text.to_owned());
        self
    }

    /// Starts the broker and waits until it logs that it runs.
    ///
    /// # Panics
    /// Mosquitto is not installed, or does not start.
    #[must_use]
    pub fn start(&self) -> Mosquitto {
        let folder = tempfile::tempdir().expect("a temporary folder");
        // Another test may take the port between the check and the broker's start.
        for _ in 0..5 {
            let (port, second) = (free_port(), free_port());
            self.configure(folder.path(), [port, second]);
            let log = Log::default();
            if let Some(process) = run(folder.path(), &log) {
                let listeners =
                    self.file.iter().flat_map(|text| text.lines()).filter(|line| line.starts_with(LISTENER));
                let supervisor_port = if listeners.count() > 1 { second } else { port };
                return Mosquitto { process, port, supervisor_port, folder, log };
            }
        }
        panic!("Mosquitto did not start");
    }

    fn configure(&self, folder: &Path, ports: [u16; 2]) {
        let mut settings = match &self.file {
            Some(text) => substituted(text, folder, ports),
            None => self.settings(folder, ports[0]),
        };
        // As root, Mosquitto would change to a user that cannot read the folder.
        settings.push("user root".to_owned());
        settings.extend(self.lines.iter().cloned());
        write(folder, "mosquitto.conf", &(settings.join("\n") + "\n"));
        if let Some(acl) = &self.acl {
            write(folder, "acl", acl);
        }
        if let Some(tls) = &self.tls {
            write(folder, "server.crt", &tls.server.certificate);
            write(folder, "server.key", &tls.server.key);
            write(folder, "ca.crt", tls.clients.as_deref().unwrap_or_default());
        }
        if self.has_old_tls {
            write(folder, OPENSSL_SETTINGS, TLS_1_2_SETTINGS);
        }
        for (name, password) in &self.users {
            add_user(&folder.join("passwords"), name, password);
        }
        for (name, password) in &self.supervisors {
            add_user(&folder.join("supervisor_passwords"), name, password);
        }
    }

    fn settings(&self, folder: &Path, port: u16) -> Vec<String> {
        let path = |name: &str| folder.join(name).display().to_string();
        let mut settings = vec![format!("listener {port} 127.0.0.1"), "log_dest stderr".to_owned()];
        settings.push(format!("allow_anonymous {}", self.users.is_empty()));
        if let Some(tls) = &self.tls {
            settings.push(format!("certfile {}", path("server.crt")));
            settings.push(format!("keyfile {}", path("server.key")));
            if tls.clients.is_some() {
                settings.push(format!("cafile {}", path("ca.crt")));
                settings.push("require_certificate true".to_owned());
            }
        }
        if !self.users.is_empty() {
            settings.push(format!("password_file {}", path("passwords")));
        }
        if self.acl.is_some() {
            settings.push(format!("acl_file {}", path("acl")));
        }
        if !self.has_default_limits {
            settings.push("set_tcp_nodelay true".to_owned());
            settings.push("max_queued_messages 100000".to_owned());
        }
        settings
    }
}

/// A shipped configuration with ports, paths and log destination replaced for the test.
fn substituted(text: &str, folder: &Path, ports: [u16; 2]) -> Vec<String> {
    let mut ports = ports.into_iter();
    let line = |line: &str| {
        let Some((setting, value)) = line.split_once(' ') else { return line.to_owned() };
        let file = || Path::new(value).file_name().expect("a file").to_string_lossy().into_owned();
        match setting {
            "listener" => format!("{LISTENER}{} 127.0.0.1", ports.next().expect("at most two listeners")),
            // The log level `information` includes the line that the broker runs.
            "log_dest" => "log_dest stderr\nlog_type information".to_owned(),
            "password_file" | "acl_file" | "certfile" | "keyfile" | "cafile" => {
                format!("{setting} {}", folder.join(file()).display())
            }
            _ => line.to_owned(),
        }
    };
    text.lines().map(line).collect()
}

/// Adds a user to a password file and creates the file if needed.
///
/// # Panics
/// `mosquitto_passwd` is not installed or fails.
pub fn add_user(passwords: &Path, name: &str, password: &str) {
    let mut command = Command::new("mosquitto_passwd");
    if !passwords.exists() {
        command.arg("-c");
    }
    let status = command.arg("-b").arg(passwords).args([name, password]).status();
    assert!(status.expect("mosquitto_passwd must be installed for this test").success());
}

impl Mosquitto {
    /// Starts a broker without authentication and waits until it runs.
    ///
    /// # Panics
    /// Mosquitto is not installed, or does not start.
    #[must_use]
    pub fn start() -> Self {
        Builder::default().start()
    }

    /// Starts a broker with Mosquitto's default limits: queues of 1,000 messages, and Nagle's algorithm delays small
    /// packets.
    ///
    /// # Panics
    /// As [`Self::start`].
    #[must_use]
    pub fn start_with_its_defaults() -> Self {
        Builder::default().default_limits().start()
    }

    /// A broker with further settings.
    #[must_use]
    pub fn builder() -> Builder {
        Builder::default()
    }

    /// The broker's folder: `mosquitto.conf` and, depending on the settings, `passwords`, `acl`, `server.crt` and
    /// others.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Port of the first listener on 127.0.0.1.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Port of the supervisors' listener on 127.0.0.1: [`Self::port`] unless the configuration has a second listener.
    #[must_use]
    pub fn supervisor_port(&self) -> u16 {
        self.supervisor_port
    }

    /// Process id of the broker.
    #[must_use]
    pub fn pid(&self) -> u32 {
        self.process.id()
    }

    /// The broker's log lines since its first start.
    ///
    /// # Panics
    /// The thread that reads the log has panicked.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        self.log.lock().expect("no panic while it was held").clone()
    }

    /// Number of log lines that contain this text.
    ///
    /// # Panics
    /// The thread that reads the log has panicked.
    #[must_use]
    pub fn logged(&self, text: &str) -> usize {
        let lines = self.log.lock().expect("no panic while it was held");
        lines.iter().filter(|line| line.contains(text)).count()
    }

    /// Freezes the broker (SIGSTOP): connections stay open, and it answers nothing.
    ///
    /// # Panics
    /// The broker's process has ended.
    #[must_use]
    pub fn freeze(&self) -> Frozen {
        let pid = Pid::from_raw(i32::try_from(self.process.id()).expect("a process id"));
        kill(pid, Signal::SIGSTOP).expect("our process");
        Frozen(pid)
    }

    /// Kills the broker (SIGKILL): connections break, and all messages and sessions are lost.
    ///
    /// # Panics
    /// The broker's process has ended.
    pub fn kill(&mut self) {
        self.process.kill().expect("our process");
        self.process.wait().expect("our process");
    }

    /// Starts the broker again on the same port.
    ///
    /// # Panics
    /// The broker does not start.
    pub fn restart(&mut self) {
        self.process = run(self.folder.path(), &self.log).expect("Mosquitto did not start again");
    }
}

impl Drop for Mosquitto {
    fn drop(&mut self) {
        // It may have been killed already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// A port of 127.0.0.1 on which no process listens. It stays this process's own until its end: no other test gets it.
///
/// # Panics
/// No free port is found.
#[must_use]
pub fn free_port() -> u16 {
    let folder = std::env::temp_dir().join("vibrissa-test-ports");
    std::fs::create_dir_all(&folder).expect("a folder for locks");
    // The standard library's hasher has a random seed, so tests that run in parallel try different ports.
    let any = || PORTS.start + (RandomState::new().build_hasher().finish() % PORTS.len() as u64) as u16;
    let is_own = |port: &u16| {
        let path = folder.join(port.to_string());
        let locked = File::options().create(true).append(true).open(path).is_ok_and(|file| {
            let locked = file.try_lock().is_ok();
            // The lock ends with the process.
            std::mem::forget(file);
            locked
        });
        locked && TcpListener::bind(("127.0.0.1", *port)).is_ok()
    };
    (0..100).map(|_| any()).find(is_own).expect("a free port")
}

/// Starts the process and waits until it runs. None if it ends instead.
fn run(folder: &Path, lines: &Log) -> Option<Child> {
    let program = ["/usr/sbin/mosquitto", "/usr/local/sbin/mosquitto", "/opt/homebrew/sbin/mosquitto"]
        .into_iter()
        .map(PathBuf::from)
        .find(|path| path.exists())
        .unwrap_or_else(|| PathBuf::from("mosquitto"));
    let openssl = folder.join(OPENSSL_SETTINGS);
    let mut process = Command::new(program)
        .envs(openssl.exists().then_some(("OPENSSL_CONF", openssl)))
        .arg("-c")
        .arg(folder.join("mosquitto.conf"))
        .stderr(Stdio::piped())
        .spawn()
        .expect("Mosquitto must be installed for this test");
    let log = BufReader::new(process.stderr.take().expect("piped"));
    let (running, ran) = std::sync::mpsc::channel();
    // Reading goes on afterwards so that a full pipe never blocks the broker.
    let lines = lines.clone();
    std::thread::spawn(move || {
        for line in log.lines().map_while(Result::ok) {
            if line.contains("running") {
                let _ = running.send(());
            }
            lines.lock().expect("no panic while it was held").push(line);
        }
    });
    if ran.recv_timeout(Duration::from_secs(10)).is_ok() {
        return Some(process);
    }
    let _ = process.kill();
    let _ = process.wait();
    None
}
