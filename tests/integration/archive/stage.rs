//! A broker, supervisors with an archive, and robots that touch all the time.

use std::path::{Path, PathBuf};
use std::time::Duration;

use tempfile::TempDir;
use vibrissa_protocol::{ArrayType, Name, OnSupervisorLoss};
use vibrissa_simulator::scenario::{ArrayScenario, Behaviour, Noise, RobotScenario, WhiskerScenario};
use vibrissa_simulator::{Broker, Scenario};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::oracle::robots::Robots;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::web::ask;

/// Name of the fleet.
pub(crate) const FLEET: &str = "lab";
const ROBOTS: usize = 4;
const WHISKERS: u16 = 2;
/// Time limit of waits: a file is written every five seconds at least.
pub(crate) const LONG: Duration = Duration::from_secs(90);

pub(crate) struct Stage {
    pub(crate) broker: Mosquitto,
    pub(crate) robots: Robots,
    database_url: String,
    archive: Vec<String>,
    folder: TempDir,
}

/// A supervisor that can be killed.
pub(crate) struct Supervisor {
    pub(crate) process: Process,
    http: u16,
    log: PathBuf,
}

impl Stage {
    /// Starts the broker and the robots. Supervisors use this database, or a file; `archive` has their further arguments.
    pub(crate) fn start(database_url: Option<String>, archive: &[&str]) -> Self {
        let broker = Mosquitto::start();
        let robots = Robots::start(&[scenario()], &[Broker::new("127.0.0.1", broker.port())]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let database_url =
            database_url.unwrap_or_else(|| format!("sqlite:{}", folder.path().join("v.sqlite3").display()));
        let archive = archive.iter().map(|&argument| argument.to_owned()).collect();
        Self { broker, robots, database_url, archive, folder }
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// Starts a supervisor, with a planted fault if one is named.
    pub(crate) fn supervisor(&self, name: &str, fault: Option<&str>) -> Supervisor {
        let (http, log) = (free_port(), self.folder.path().join(format!("{name}.log")));
        let (listen, broker) = (format!("127.0.0.1:{http}"), format!("mqtt://127.0.0.1:{}", self.broker.port()));
        let arguments = [
            "run",
            "--name",
            name,
            "--fleet",
            FLEET,
            "--database-url",
            &self.database_url,
            "--mqtt-url",
            &broker,
            "--http-listen",
            &listen,
            "--archive-every-s",
            "1",
            "--detection-cold-start-contacts",
            "20",
        ];
        let arguments = arguments.into_iter().map(str::to_owned).chain(self.archive.clone()).collect();
        let mut environment = vec![("RUST_LOG".to_owned(), "info,rumqttc=warn".to_owned())];
        environment.extend(fault.map(|fault| ("VIBRISSA_TEST_FAULT".to_owned(), fault.to_owned())));
        let program = env!("CARGO_BIN_EXE_vibrissa-under-test").into();
        let process = Process::start(Launch { program, arguments, environment, log: log.clone() });
        Supervisor { process, http, log }
    }
}

impl Supervisor {
    pub(crate) fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap_or_default()
    }

    /// Sum of a metric over its labels; `None` before the program answers.
    pub(crate) async fn metric(&self, name: &str) -> Option<f64> {
        let text = ask(([127, 0, 0, 1], self.http).into(), "GET", "/metrics", &[]).await.ok()?.body;
        let values = text.lines().filter_map(|line| {
            let rest = line.strip_prefix(name)?;
            rest.starts_with(['{', ' ']).then(|| line.rsplit_once(' ')?.1.parse::<f64>().ok())?
        });
        Some(values.sum())
    }
}

fn scenario() -> Scenario {
    let behaviour = Behaviour {
        contacts_per_second: 10.0,
        contacts_per_message: 4,
        message_after_s: 0.5,
        kept_messages: 20_000,
        journal: true,
        ..Behaviour::default()
    };
    Scenario {
        calibration: None,
        seed: 1,
        fleet: name(FLEET),
        behaviour,
        noise: Noise::default(),
        calibration_error: 0.03,
        robots: (0..ROBOTS).map(robot).collect(),
    }
}

fn robot(number: usize) -> RobotScenario {
    let whisker = |whisker| WhiskerScenario { whisker, x_mm: 25.0 * f64::from(whisker), ..WhiskerScenario::default() };
    RobotScenario {
        robot: name(&format!("r{number}")),
        model: "archive".to_owned(),
        on_supervisor_loss: OnSupervisorLoss::Hold,
        applies_gain: false,
        arrays: vec![ArrayScenario {
            array: name("left"),
            array_type: ArrayType::Type1,
            whiskers: (0..WHISKERS).map(whisker).collect(),
        }],
        events: Vec::new(),
    }
}

fn name(text: &str) -> Name {
    Name::new(text).unwrap()
}
