//! Runs `vibrissa run` with the embedded broker as a separate process whose HTTP server is attacked.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;

use tempfile::TempDir;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::wait::PATIENCE;
use vibrissa_tests::web::try_get;

/// Path of the program under test.
const PROGRAM: &str = env!("CARGO_BIN_EXE_vibrissa-under-test");

/// A running program, killed on drop.
pub(crate) struct HttpProgram {
    process: Child,
    /// Address of the API and the console.
    pub(crate) http: SocketAddr,
    /// Address of the monitoring listener.
    pub(crate) monitoring: SocketAddr,
    /// Address of the embedded broker.
    pub(crate) mqtt: SocketAddr,
    log: PathBuf,
    folder: TempDir,
}

impl HttpProgram {
    /// Starts the program on SQLite with further arguments.
    pub(crate) fn start(arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let database = format!("sqlite:{}", folder.path().join("v.sqlite3").display());
        Self::run(folder, &database, arguments, Command::new(PROGRAM))
    }

    /// Starts the program on PostgreSQL.
    pub(crate) fn on(server: &Postgres) -> Self {
        let database = Postgres::url(server.port());
        Self::run(tempfile::tempdir().unwrap(), &database, &[], Command::new(PROGRAM))
    }

    /// Starts the program on SQLite with this limit of file descriptors.
    pub(crate) fn with_descriptors(descriptors: u32) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let database = format!("sqlite:{}", folder.path().join("v.sqlite3").display());
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("ulimit -n {descriptors}; exec \"$@\""), "sh", PROGRAM]);
        Self::run(folder, &database, &[], shell)
    }

    fn run(folder: TempDir, database: &str, arguments: &[&str], mut command: Command) -> Self {
        let log = folder.path().join("log");
        let mut process = command
            .args(["run", "--fleet", "f", "--http", "127.0.0.1:0", "--http-monitoring-listen", "127.0.0.1:0"])
            .args(["--mqtt-port", "0", "--database-url", database])
            .args(arguments)
            .env("RUST_LOG", "warn")
            .stdout(Stdio::piped())
            .stderr(File::create(&log).unwrap())
            .spawn()
            .unwrap();
        let lines = BufReader::new(process.stdout.take().unwrap()).lines();
        let (said, says) = mpsc::channel();
        std::thread::spawn(move || lines.map_while(Result::ok).try_for_each(|line| said.send(line)));
        let line = || {
            says.recv_timeout(2 * PATIENCE).unwrap_or_else(|problem| {
                panic!("the program does not print its address ({problem}): {}", std::fs::read_to_string(&log).unwrap())
            })
        };
        let address =
            |line: &str| line.rsplit_once("http://").unwrap_or_else(|| panic!("no address: {line}")).1.parse().unwrap();
        let (first, second) = (line(), line());
        let mqtt = first.split(['/', ' ', ',']).find_map(|word| word.parse().ok());
        let mqtt = mqtt.unwrap_or_else(|| panic!("no address of MQTT: {first}"));
        Self { process, http: address(&first), monitoring: address(&second), mqtt, log, folder }
    }

    /// The log so far.
    pub(crate) fn logged(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap()
    }

    /// URL of its SQLite database.
    pub(crate) fn sqlite(&self) -> String {
        format!("sqlite:{}", self.folder.path().join("v.sqlite3").display())
    }

    /// Resident memory in bytes, without the pages of mapped files: a debug build maps its code as it runs.
    pub(crate) fn resident_bytes(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.process.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("RssAnon:")).unwrap();
        1024 * line.trim().trim_end_matches(" kB").parse::<u64>().unwrap()
    }

    /// Value of an HTTP metric by name with labels, from the listener that is not attacked.
    pub(crate) async fn metric(&self, name: &str) -> f64 {
        let (status, text) = try_get(self.monitoring, "/metrics").await.unwrap();
        assert_eq!(status, 200, "{text}");
        let line = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(' '));
        line.unwrap_or_else(|| panic!("no metric {name} in {text}")).parse().unwrap()
    }
}

impl Drop for HttpProgram {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
        if std::thread::panicking() {
            eprintln!("the program has logged:\n{}", self.logged());
        }
    }
}
