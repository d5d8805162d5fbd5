//! Runs `vibrissa run` for tests of its connections to the broker.

use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use nix::sys::signal::Signal;
use serde_json::Value;
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::{PATIENCE, until, until_true};
use vibrissa_tests::web::try_get;

/// A running program, killed on drop.
pub(crate) struct Supervised {
    process: Process,
    http: u16,
    log: PathBuf,
}

impl Supervised {
    /// Starts the program under this name with further arguments. The folder contains its log and, unless the arguments
    /// name another database, a SQLite database.
    pub(crate) fn start(folder: &Path, name: &str, arguments: &[&str]) -> Self {
        let http = free_port();
        let listen = format!("127.0.0.1:{http}");
        let database = format!("sqlite:{}", folder.join(format!("{name}.sqlite3")).display());
        let mut all = vec!["run", "--name", name, "--http-listen", &listen];
        if !arguments.contains(&"--database-url") {
            all.extend(["--database-url", &database]);
        }
        all.extend(arguments);
        let log = folder.join(format!("{name}.log"));
        let launch = Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: all.iter().map(|&argument| argument.to_owned()).collect(),
            environment: vec![
                ("RUST_LOG".to_owned(), "info,vibrissa=debug".to_owned()),
                ("VIBRISSA_TEST_CLOCK_FILE".to_owned(), clock_file(folder, name).display().to_string()),
            ],
            log: log.clone(),
        };
        Self { process: Process::start(launch), http, log }
    }

    /// Address of its HTTP server.
    pub(crate) fn address(&self) -> SocketAddr {
        ([127, 0, 0, 1], self.http).into()
    }

    /// State and text of `/readyz`; None without an answer.
    pub(crate) async fn ready(&self) -> Option<(bool, String)> {
        let (status, body) = try_get(self.address(), "/readyz").await.ok()?;
        let answer: Value = serde_json::from_str(&body).unwrap();
        assert_eq!(answer["ready"] == true, status == 200, "{body}");
        Some((status == 200, body))
    }

    /// Waits until `/readyz` reports this state with these words. Returns its text.
    pub(crate) async fn says(&self, is_ready: bool, words: &[String]) -> String {
        let mut last = None;
        until(&format!("ready: {is_ready} with {words:?}"), async || {
            let readiness = self.ready().await;
            if readiness != last {
                eprintln!("{readiness:?}");
                last.clone_from(&readiness);
            }
            let (ready, text) = readiness?;
            (ready == is_ready && words.iter().all(|word| text.contains(word))).then_some(text)
        })
        .await
    }

    /// Sum of a metric's series whose labels contain this text.
    pub(crate) async fn metric(&self, name: &str, labels: &str) -> f64 {
        let (_, text) = try_get(self.address(), "/metrics").await.unwrap();
        let series = text.lines().filter_map(|line| line.rsplit_once(' '));
        let values = series.filter(|(series, _)| {
            series
                .strip_prefix(name)
                .is_some_and(|rest| (rest.is_empty() || rest.starts_with('{')) && rest.contains(labels))
        });
        values.map(|(_, value)| value.parse::<f64>().unwrap()).sum()
    }

    /// The log so far.
    pub(crate) fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap()
    }

    /// Number of log lines that contain this text.
    pub(crate) fn logged(&self, text: &str) -> usize {
        self.log().lines().filter(|line| line.contains(text)).count()
    }

    /// Stops the program in an orderly way.
    pub(crate) async fn terminate(&mut self) {
        self.process.signal(Signal::SIGTERM);
        assert!(self.process.ended(PATIENCE).await.expect("the program must end").success());
    }
}

/// Sets the clock of the host of the supervisor of this name so far ahead of the true time, in microseconds.
pub(crate) fn set_host_clock(folder: &Path, name: &str, ahead_us: i64) {
    let new = folder.join(format!("{name}.clock.new"));
    std::fs::write(&new, ahead_us.to_string()).unwrap();
    std::fs::rename(new, clock_file(folder, name)).unwrap();
}

fn clock_file(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.clock"))
}

/// Waits until a metric reaches this value.
pub(crate) async fn metric_reaches(supervised: &Supervised, name: &str, labels: &str, goal: f64) {
    until_true(&format!("{name}{{{labels}}} of {goal}"), async || supervised.metric(name, labels).await >= goal).await;
}
