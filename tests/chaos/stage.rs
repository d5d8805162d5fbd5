//! What is there: broker, PostgreSQL, two supervisors, robots, and links between them that can fail.

use std::io::BufRead;
use std::net::SocketAddr;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use vibrissa_protocol::Name;
use vibrissa_simulator::{Broker, Fleet, JournalEntry, RobotHandle, Scenario};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::proxy::Proxy;

use crate::ledger::Ledger;
use crate::obedience::Obedience;
use crate::plan::{Control, LEASE_S};
use crate::scenario::FLEET;

/// The access list that is shipped.
const ACL: &str = include_str!("../../deploy/mosquitto/acl");
/// The user of the client that repeats setpoints.
pub const REPLAY_USER: &str = "replay";
/// Every robot's password; each has a user of its own.
pub const ROBOT_PASSWORD: &str = "robot's own";
/// The password of the supervisors and of the harness.
pub const SUPERVISOR_PASSWORD: &str = "supervisor's own";
/// The supervisors' user in the list that is shipped.
const SUPERVISOR_USER: &str = "vibrissa";
/// The supervisors' names.
const SUPERVISORS: [&str; 2] = ["a", "b"];
/// A line of a log with this text reports a panic.
const PANIC: &[u8] = b"panicked at";
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
    /// Its HTTP address, also after a restart.
    pub http: SocketAddr,
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
    /// The broker, with its own default limits and the access list that is shipped.
    pub broker: Mosquitto,
    /// The database.
    pub database: Postgres,
    /// The supervisors.
    pub supervisors: [Supervisor; 2],
    /// Links between robots and broker.
    pub robot_links: Vec<Proxy>,
}

impl Stage {
    /// Starts it for those robots; supervisors write their logs into that folder.
    pub async fn set(program: &Program, control: Control, logs: &Path, robots: &[Name]) -> Self {
        let broker = tokio::task::block_in_place(|| broker(robots));
        let database = Postgres::start().await;
        let mut robot_links = Vec::new();
        for _ in 0..ROBOT_LINKS {
            robot_links.push(Proxy::to(broker.port()).await);
        }
        let [a, b] = SUPERVISORS;
        let a = supervisor(a, program, control, logs, &broker, &database).await;
        let b = supervisor(b, program, control, logs, &broker, &database).await;
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

/// A broker at which each of the robots has a user.
fn broker(robots: &[Name]) -> Mosquitto {
    let acl = format!("{ACL}\nuser {REPLAY_USER}\ntopic readwrite whisker/v1/+/+/setpoint\n");
    let builder = Mosquitto::builder().default_limits().acl(&acl);
    let builder = [SUPERVISOR_USER, REPLAY_USER]
        .into_iter()
        .fold(builder, |builder, user| builder.user(user, SUPERVISOR_PASSWORD));
    let of_robot = |robot: &Name| format!("{FLEET}/{robot}");
    let broker = robots.iter().fold(builder, |builder, robot| builder.user(&of_robot(robot), ROBOT_PASSWORD)).start();
    let file = password_file(&broker);
    std::fs::write(&file, SUPERVISOR_PASSWORD).expect("a folder of ours");
    std::fs::set_permissions(&file, PermissionsExt::from_mode(0o600)).expect("a file of ours");
    broker
}

/// The file with the supervisors' password.
fn password_file(broker: &Mosquitto) -> PathBuf {
    broker.folder().join("supervisor.password")
}

/// The number of panics in the supervisors' logs: a thread may panic and start again while the process goes on.
pub fn panics(logs: &Path) -> u64 {
    let of = |name: &str| {
        let Ok(file) = std::fs::File::open(log_of(logs, name)) else { return 0 };
        let lines = std::io::BufReader::new(file).split(b'\n').map_while(Result::ok);
        lines.filter(|line| line.windows(PANIC.len()).any(|part| part == PANIC)).count() as u64
    };
    SUPERVISORS.into_iter().map(of).sum()
}

fn log_of(logs: &Path, name: &str) -> PathBuf {
    logs.join(format!("supervisor-{name}.log"))
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
    let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
    arguments.extend(["run", "--name", name, "--fleets", FLEET].map(str::to_owned));
    arguments.extend(["--http-listen".to_owned(), http.to_string()]);
    arguments.extend(["--mqtt-username".to_owned(), SUPERVISOR_USER.to_owned()]);
    arguments.extend(["--mqtt-password-file".to_owned(), password_file(broker).display().to_string()]);
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
        log: log_of(logs, name),
    });
    Supervisor { name, process, broker_link, database_link, http }
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
            let credentials = Some(("{fleet}/{robot}".to_owned(), ROBOT_PASSWORD.to_owned()));
            let broker = Broker { credentials, ..Broker::new("127.0.0.1", link.port()) };
            fleets.push(Fleet::start(scenario, &broker)?);
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
