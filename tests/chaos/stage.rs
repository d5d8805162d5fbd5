//! The programs of a run: broker, PostgreSQL, two supervisors, robots, and links between them that can fail.

use std::io::BufRead;
use std::net::SocketAddr;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use vibrissa_protocol::Name;
use vibrissa_simulator::Broker;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::proxy::Proxy;

use crate::plan::{Control, LEASE_S};
use crate::scenario::FLEET;

/// The shipped access list of the broker.
const ACL: &str = include_str!("../../deploy/mosquitto/acl");
/// User of the client that repeats setpoints.
pub const REPLAY_USER: &str = "replay";
/// User of the client that deletes retained messages.
pub const FORGET_USER: &str = "forget";
/// Password of every robot; each has a user of its own.
pub const ROBOT_PASSWORD: &str = "robot's own";
/// Password of the supervisors and of the harness.
pub const SUPERVISOR_PASSWORD: &str = "supervisor's own";
/// User of the supervisors in the shipped access list.
const SUPERVISOR_USER: &str = "vibrissa";
/// Names of the supervisors.
const SUPERVISORS: [&str; 2] = ["a", "b"];
/// A line of a log with this text reports a panic.
const PANIC: &[u8] = b"panicked at";
/// Number of links between robots and broker; each serves an equal share of the robots.
pub const ROBOT_LINKS: usize = 4;
/// Contacts until a whisker counts as learned; few, so that trims are detected from the start.
const LEARNED: u32 = 20;

/// A supervisor and its links.
pub struct Supervisor {
    /// Its name, also in the database.
    pub name: &'static str,
    /// Process of `vibrissa run`.
    pub process: Process,
    /// Its link to the broker.
    pub broker_link: Proxy,
    /// Its link to PostgreSQL.
    pub database_link: Proxy,
    /// Its HTTP address, which stays the same after a restart.
    pub http: SocketAddr,
    /// The file that tells how far the clock of its host is ahead.
    clock: PathBuf,
}

impl Supervisor {
    /// Sets the clock of its host so far ahead of the true time, in µs.
    pub fn set_clock(&self, ahead_us: i64) {
        let new = self.clock.with_extension("new");
        std::fs::write(&new, ahead_us.to_string()).expect("a folder of ours");
        std::fs::rename(new, &self.clock).expect("a file of ours");
    }
}

/// Command line of the supervisors.
pub struct Program {
    /// Path of the program.
    pub path: PathBuf,
    /// Argument before `run`, if any.
    pub first_argument: Option<String>,
}

/// All programs except the robots.
pub struct Stage {
    /// The broker, with Mosquitto's default limits and the shipped access list.
    pub broker: Mosquitto,
    /// The PostgreSQL server.
    pub database: Postgres,
    /// The two supervisors.
    pub supervisors: [Supervisor; 2],
    /// Links between robots and broker.
    pub robot_links: Vec<Proxy>,
    /// Names of the robots.
    pub robots: Vec<Name>,
}

impl Stage {
    /// Starts everything for these robots; supervisors write their logs to the given folder.
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
        Self { broker, database, supervisors: [a, b], robot_links, robots: robots.to_vec() }
    }

    /// Restarts supervisors that have ended unexpectedly, and returns their number.
    pub fn revive(&mut self) -> u64 {
        let mut ended = 0;
        for supervisor in &mut self.supervisors {
            if let Some(status) = supervisor.process.ended_already() {
                eprintln!("chaos: supervisor {} has ended unexpectedly: {status}", supervisor.name);
                ended += 1;
            }
            if !supervisor.process.is_running() {
                supervisor.process.restart();
            }
        }
        ended
    }
}

/// A broker with one user per robot.
fn broker(robots: &[Name]) -> Mosquitto {
    let acl = format!(
        "{ACL}\nuser {REPLAY_USER}\ntopic readwrite whisker/v1/+/+/setpoint\nuser {FORGET_USER}\ntopic write whisker/v1/#\n"
    );
    let builder = Mosquitto::builder().default_limits().acl(&acl);
    let builder = [SUPERVISOR_USER, REPLAY_USER, FORGET_USER]
        .into_iter()
        .fold(builder, |builder, user| builder.user(user, SUPERVISOR_PASSWORD));
    let of_robot = |robot: &Name| format!("{FLEET}/{robot}");
    let broker = robots.iter().fold(builder, |builder, robot| builder.user(&of_robot(robot), ROBOT_PASSWORD)).start();
    let file = password_file(&broker);
    write_password(&file, SUPERVISOR_PASSWORD);
    broker
}

/// Writes a password to a file that only this user can read.
pub fn write_password(file: &Path, password: &str) {
    std::fs::write(file, password).expect("a folder of ours");
    std::fs::set_permissions(file, PermissionsExt::from_mode(0o600)).expect("a file of ours");
}

/// Path of the file with the supervisors' password.
fn password_file(broker: &Mosquitto) -> PathBuf {
    broker.folder().join("supervisor.password")
}

/// Number of panics in the supervisors' logs. A thread may panic and be restarted while the process continues.
pub fn panics(logs: &Path) -> u64 {
    panics_of(logs, &SUPERVISORS)
}

/// As [`panics`], of supervisors with these names.
pub fn panics_of(logs: &Path, names: &[&str]) -> u64 {
    let of = |name: &&str| {
        let Ok(file) = std::fs::File::open(log_of(logs, name)) else { return 0 };
        let lines = std::io::BufReader::new(file).split(b'\n').map_while(Result::ok);
        lines.filter(|line| line.windows(PANIC.len()).any(|part| part == PANIC)).count() as u64
    };
    names.iter().map(of).sum()
}

/// Log of a supervisor.
pub fn log_of(logs: &Path, name: &str) -> PathBuf {
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
    let level = ("RUST_LOG".to_owned(), "info,rumqttc=warn".to_owned());
    let clock = broker.folder().join(format!("clock-{name}"));
    let clock_file = ("VIBRISSA_TEST_CLOCK_FILE".to_owned(), clock.display().to_string());
    let process = Process::start(Launch {
        program: program.path.clone(),
        arguments,
        environment: [level, clock_file].into_iter().chain(control.environment()).collect(),
        log: log_of(logs, name),
    });
    Supervisor { name, process, broker_link, database_link, http, clock }
}

/// The broker as robots reach it, through each link.
pub fn brokers(links: &[Proxy]) -> Vec<Broker> {
    let credentials = Some(("{fleet}/{robot}".to_owned(), ROBOT_PASSWORD.to_owned()));
    let through = |link: &Proxy| Broker { credentials: credentials.clone(), ..Broker::new("127.0.0.1", link.port()) };
    links.iter().map(through).collect()
}
