//! What is there: broker, PostgreSQL, two supervisors, robots, and links between them that can fail.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use vibrissa_simulator::{Broker, Fleet, JournalEntry, RobotHandle, Scenario};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::proxy::Proxy;

use crate::ledger::Ledger;
use crate::obedience::Obedience;
use crate::plan::{Control, LEASE_S};
use crate::scenario::FLEET;

/// Links between robots and broker, each with as many of the robots.
pub const ROBOT_LINKS: usize = 4;
/// Contacts until a whisker counts as learned: few, so that trims are found from the start.
const LEARNED: u32 = 20;
/// How often robots' journals are read.
const JOURNALS: Duration = Duration::from_millis(500);

/// A supervisor and its links.
pub struct Supervisor {
    /// What it is called, in the database as well.
    pub name: &'static str,
    /// The process.
    pub process: Process,
    /// Its link to the broker.
    pub broker_link: Proxy,
    /// Its link to PostgreSQL.
    pub database_link: Proxy,
}

/// How supervisors are started.
pub struct Program {
    /// The program.
    pub path: PathBuf,
    /// What goes before `run`.
    pub first_argument: Option<String>,
}

/// Everything but the robots.
pub struct Stage {
    /// The broker, with its own default limits.
    pub broker: Mosquitto,
    /// The database.
    pub database: Postgres,
    /// The supervisors.
    pub supervisors: [Supervisor; 2],
    /// Links between robots and broker.
    pub robot_links: Vec<Proxy>,
}

impl Stage {
    /// Starts it; supervisors write their logs into that folder.
    pub async fn set(program: &Program, control: Control, logs: &Path) -> Self {
        let broker = tokio::task::block_in_place(|| Mosquitto::builder().default_limits().start());
        let database = Postgres::start().await;
        let mut robot_links = Vec::new();
        for _ in 0..ROBOT_LINKS {
            robot_links.push(Proxy::to(broker.port()).await);
        }
        let a = supervisor("a", program, control, logs, &broker, &database).await;
        let b = supervisor("b", program, control, logs, &broker, &database).await;
        Self { broker, database, supervisors: [a, b], robot_links }
    }

    /// Starts supervisors again that have ended by themselves; tells how many.
    pub fn revive(&mut self) -> u64 {
        let mut ended = 0;
        for supervisor in &mut self.supervisors {
            if let Some(status) = supervisor.process.ended_already() {
                eprintln!("chaos: supervisor {} has ended by itself: {status}", supervisor.name);
                ended += 1;
            }
            if !supervisor.process.is_running() {
                supervisor.process.restart();
            }
        }
        ended
    }
}

async fn supervisor(
    name: &'static str,
    program: &Program,
    control: Control,
    logs: &Path,
    broker: &Mosquitto,
    database: &Postgres,
) -> Supervisor {
    let broker_link = Proxy::to(broker.port()).await;
    let database_link = Proxy::to(database.port()).await;
    let mut arguments: Vec<String> = program.first_argument.iter().cloned().collect();
    arguments.extend(["run", "--name", name, "--fleets", FLEET, "--http-listen", "127.0.0.1:0"].map(str::to_owned));
    arguments.extend(["--database-url".to_owned(), Postgres::url(database_link.port())]);
    arguments.extend(["--mqtt-url".to_owned(), format!("mqtt://127.0.0.1:{}", broker_link.port())]);
    arguments.extend(["--lease-time-to-live-s".to_owned(), LEASE_S.to_string()]);
    arguments.extend(["--detection-cold-start-contacts".to_owned(), LEARNED.to_string()]);
    let fault = match control {
        Control::ReceiptBeforeCommit => Some("receipt_before_commit"),
        Control::NoFence => Some("no_fence"),
        Control::None | Control::RobotIgnoresEpochs | Control::NoRobotBuffer => None,
    };
    let fault = fault.map(|fault| ("VIBRISSA_TEST_FAULT".to_owned(), fault.to_owned()));
    let level = ("RUST_LOG".to_owned(), "info,rumqttc=warn".to_owned());
    let process = Process::start(Launch {
        program: program.path.clone(),
        arguments,
        environment: [level].into_iter().chain(fault).collect(),
        log: logs.join(format!("supervisor-{name}.log")),
    });
    Supervisor { name, process, broker_link, database_link }
}

/// The robots, and what they did in truth.
pub struct Robots {
    fleets: Vec<Fleet>,
    truth: Arc<Mutex<Truth>>,
}

/// What robots felt and obeyed.
#[derive(Debug, Default)]
pub struct Truth {
    /// Contacts.
    pub ledger: Ledger,
    /// Setpoints.
    pub obedience: Obedience,
}

impl Truth {
    fn read(&mut self, robot: &RobotHandle) {
        let name = robot.name().as_str();
        for entry in robot.with(vibrissa_simulator::Robot::take_journal) {
            match entry {
                JournalEntry::Felt(message) => self.ledger.felt(name, &message),
                JournalEntry::Heard(setpoint) => self.obedience.heard(name, &setpoint),
                JournalEntry::Applied(setpoint) => self.obedience.applied(name, &setpoint),
            }
        }
    }
}

impl Robots {
    /// Starts them, each group behind its link.
    ///
    /// # Errors
    /// They cannot be simulated.
    pub fn start(scenarios: &[Scenario], links: &[Proxy]) -> anyhow::Result<Self> {
        let mut fleets = Vec::new();
        for (scenario, link) in scenarios.iter().zip(links) {
            fleets.push(Fleet::start(scenario, &Broker::new("127.0.0.1", link.port()))?);
        }
        let truth = Arc::new(Mutex::new(Truth::default()));
        let robots: Vec<RobotHandle> = fleets.iter().flat_map(|fleet| fleet.robots().to_vec()).collect();
        let weak = Arc::downgrade(&truth);
        tokio::spawn(async move {
            while let Some(truth) = weak.upgrade() {
                for robot in &robots {
                    truth.lock().unwrap_or_else(PoisonError::into_inner).read(robot);
                }
                drop(truth);
                tokio::time::sleep(JOURNALS).await;
            }
        });
        Ok(Self { fleets, truth })
    }

    fn all(&self) -> impl Iterator<Item = &RobotHandle> {
        self.fleets.iter().flat_map(Fleet::robots)
    }

    /// No robot makes contacts any more.
    pub fn rest(&self) {
        self.fleets.iter().for_each(Fleet::rest);
    }

    /// Messages that no receipt covers yet; those that wait to be filled up count as well.
    pub fn undelivered(&self) -> u64 {
        let of = |robot: &mut vibrissa_simulator::Robot| {
            // What waits to be filled up is due at once when a robot rests.
            let waiting = robot.next_deadline() <= robot.start_us();
            robot.messages_kept() as u64 + u64::from(waiting)
        };
        self.all().map(|robot| robot.with(of)).sum()
    }

    /// Contacts made so far.
    pub fn made(&self) -> u64 {
        self.all().map(|robot| robot.with(|robot| robot.contacts_made())).sum()
    }

    /// Messages that were dropped because too many were kept.
    pub fn dropped(&self) -> u64 {
        self.all().map(|robot| robot.with(|robot| robot.messages_dropped())).sum()
    }

    /// Ends them, and tells what they did.
    pub async fn stop(self) -> Truth {
        let robots: Vec<RobotHandle> = self.all().cloned().collect();
        for fleet in self.fleets {
            fleet.stop().await;
        }
        let mut truth = std::mem::take(&mut *self.truth.lock().unwrap_or_else(PoisonError::into_inner));
        robots.iter().for_each(|robot| truth.read(robot));
        truth
    }
}
