//! Chaos test: nothing may be lost and no stale setpoint applied, whatever fails. Robots, broker, PostgreSQL and two
//! supervisors run for real under faults drawn from a seed. In the end, the contacts made and setpoints applied by
//! robots are compared with the database.
//!
//! Some of the robots are hostile. The harness judges only the others.
//!
//! Read in this order: [`plan`] (the faults), [`stage`] and [`scenario`] (the setup), [`strike`], [`forget`],
//! [`replay`] and [`hostile`] (injection of faults), [`owner`] (which supervisor owns the fleet), [`vibrissa_tests::oracle`]
//! (the comparison), [`refusals`], [`report`]. [`cluster`] does the same to a cluster.

mod cluster;
mod forget;
mod hostile;
mod owner;
mod plan;
mod refusals;
mod replay;
mod report;
mod scenario;
mod stage;
mod strike;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use clap::Parser;
use sqlx::ConnectOptions;
use sqlx::postgres::PgConnection;
use tokio::time::sleep;
use vibrissa_program::signals::StopSignals;
use vibrissa_protocol::Name;
use vibrissa_tests::oracle::recorded;
use vibrissa_tests::oracle::robots::Robots;

use hostile::{Behaviour, Hostile};
use owner::{START_PATIENCE, Watch};
use plan::Control;
use refusals::Refusals;
use replay::Replay;
use report::{FaultReport, Report};
use stage::{Program, REPLAY_USER, ROBOT_LINKS, SUPERVISOR_PASSWORD, Stage};
use strike::Striker;

/// The drain ends when the number of messages without a receipt has not changed for this time.
const DRAIN_PATIENCE: Duration = Duration::from_secs(60);
/// Pause between two counts of the messages without a receipt.
const DRAIN_PAUSE: Duration = Duration::from_millis(100);
/// Interval of the progress lines.
const PROGRESS: Duration = Duration::from_secs(30);
/// Longest run in days: supervisors remove contacts after 30 days.
const LONGEST_DAYS: f64 = 25.0;
/// The recording is complete when two counts of rows this far apart are equal.
const SETTLED: Duration = Duration::from_secs(1);
/// A run with robots that take any setpoint ends once so many were repeated after they had expired ...
const LATE_REPEATS: u64 = 5;
/// ... or fails after this time.
const LATE_PATIENCE: Duration = Duration::from_secs(120);
/// Contacts per second without and with `--cluster`.
const RATE: f64 = 2000.0;
const CLUSTER_RATE: f64 = 200.0;
/// Exit code of a run that is not possible here.
const SKIPPED: u8 = 77;
/// With this argument the program runs as a supervisor, so the test always runs the current sources.
const SUPERVISOR: &str = "supervisor";

/// Runs supervisors, robots and servers under faults, and reports lost contacts and stale setpoints
#[derive(Debug, Parser)]
#[command(name = "chaos", version)]
struct Arguments {
    /// Seed of all random decisions.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Time in seconds during which robots make contacts and faults occur: up to 25 days.
    #[arg(long, default_value_t = 60.0, conflicts_with = "minutes")]
    seconds: f64,
    /// The same in minutes.
    #[arg(long)]
    minutes: Option<f64>,
    /// Run three broker nodes, three supervisors and a pair of databases, and several fleets. Needs root, RMQTT
    /// (tests/rmqtt), Patroni and etcd; ends with code 77 without them.
    #[arg(long)]
    cluster: bool,
    /// With --cluster: the broker. One Mosquitto needs no RMQTT, and has no other node to go to.
    #[arg(long, value_enum, default_value_t = cluster::BrokerKind::Rmqtt)]
    broker: cluster::BrokerKind,
    /// With --cluster: strike the broker, each supervisor and the database at the same time, instead of one after the other.
    #[arg(long, requires = "cluster")]
    overlapping: bool,
    /// With --cluster: number of Kafka brokers between the broker and the supervisors, with a bridge of the harness; 0 for
    /// none. Needs Kafka (tests/kafka); ends with code 77 without it.
    #[arg(long, requires = "cluster", default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=5))]
    kafka: u8,
    /// Number of simulated robots, hostile ones included.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=999))]
    robots: u32,
    /// Contacts per second of all honest robots together; 2000 by default, 200 with --cluster.
    #[arg(long)]
    rate: Option<f64>,
    /// Number of hostile robots; 0 for none. There are none with --cluster.
    #[arg(long, default_value_t = 10)]
    hostile: u32,
    /// Only these behaviours of hostile robots, separated by commas; all by default.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "BEHAVIOUR")]
    hostile_only: Vec<Behaviour>,
    /// Exclude these behaviours of hostile robots, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "BEHAVIOUR")]
    hostile_without: Vec<Behaviour>,
    /// Break something on purpose, to check that the harness detects it.
    #[arg(long, value_enum, default_value_t = Control::None)]
    control: Control,
    /// Print the result as one line of JSON, too.
    #[arg(long)]
    json: bool,
    /// The program `vibrissa` to test, instead of the one inside this program.
    #[arg(long)]
    program: Option<PathBuf>,
    /// Folder for supervisors' logs. By default a temporary folder, kept only if the run shows a violation.
    #[arg(long)]
    logs: Option<PathBuf>,
}

fn main() -> anyhow::Result<ExitCode> {
    let mut arguments = std::env::args().skip(1).peekable();
    if arguments.peek().is_some_and(|first| first == SUPERVISOR) {
        return vibrissa::cli::run(vibrissa::cli::Cli::parse_from(arguments));
    }
    let arguments = Arguments::parse();
    let seconds = arguments.minutes.map_or(arguments.seconds, |minutes| 60.0 * minutes);
    let arguments = Arguments { seconds, ..arguments };
    let shortest_s = arguments.control.shortest_s();
    ensure!(
        arguments.control != Control::Asynchronous || arguments.cluster,
        "--control asynchronous needs --cluster: one PostgreSQL has no standby"
    );
    ensure!(
        arguments.control != Control::OffsetBeforeState || arguments.kafka > 0,
        "--control offset-before-state needs --kafka: other contacts have no offset"
    );
    ensure!(
        arguments.cluster || arguments.seconds >= shortest_s,
        "--seconds must be at least {shortest_s} for a fault to strike"
    );
    let longest_s = LONGEST_DAYS * 86_400.0;
    ensure!(arguments.seconds <= longest_s, "--seconds must be at most {longest_s}: older contacts are removed");
    ensure!(arguments.hostile < arguments.robots, "--hostile must be below --robots: only the others are judged");
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().context("starting the runtime")?;
    // An error needs the logs, too.
    let folder = tempfile::Builder::new().disable_cleanup(true).tempdir().context("a temporary folder")?;
    let logs = arguments.logs.clone().unwrap_or_else(|| folder.path().to_owned());
    std::fs::create_dir_all(&logs).context("the folder for logs")?;
    let violations = if arguments.cluster {
        match runtime.block_on(unless_interrupted(run_cluster(&arguments, &logs)))? {
            Ok(report) => shown(&report, arguments.json)?.violations(),
            Err(missing) => {
                eprintln!("skipped: chaos in a cluster: {missing}");
                std::fs::remove_dir_all(folder.path()).context("removing the logs")?;
                return Ok(ExitCode::from(SKIPPED));
            }
        }
    } else {
        shown(&runtime.block_on(unless_interrupted(run(&arguments, &logs)))?, arguments.json)?.violations()
    };
    if violations.is_empty() {
        std::fs::remove_dir_all(folder.path()).context("removing the logs")?;
        return Ok(ExitCode::SUCCESS);
    }
    eprintln!("chaos: {}", violations.join("; "));
    if arguments.logs.is_none() {
        eprintln!("chaos: logs are in {}", folder.path().display());
    }
    Ok(ExitCode::FAILURE)
}

/// Ends a run at SIGINT or SIGTERM, so that its programs are ended and its namespaces deleted.
async fn unless_interrupted<T>(run: impl Future<Output = anyhow::Result<T>>) -> anyhow::Result<T> {
    let mut signals = StopSignals::install()?;
    tokio::select! {
        result = run => result,
        () = signals.received() => bail!("stopped by a signal"),
    }
}

/// Prints a report.
fn shown<R: std::fmt::Display + serde::Serialize>(report: &R, as_json: bool) -> anyhow::Result<&R> {
    print!("{report}");
    if as_json {
        println!("{}", serde_json::to_string(&report).context("writing JSON")?);
    }
    Ok(report)
}

fn program(arguments: &Arguments) -> anyhow::Result<Program> {
    Ok(match &arguments.program {
        Some(path) => Program { path: path.clone(), first_argument: None },
        None => Program { path: std::env::current_exe()?, first_argument: Some(SUPERVISOR.to_owned()) },
    })
}

async fn run_cluster(
    arguments: &Arguments,
    logs: &std::path::Path,
) -> anyhow::Result<Result<cluster::Report, &'static str>> {
    let settings = cluster::Settings {
        seed: arguments.seed,
        seconds: arguments.seconds,
        robots: arguments.robots as usize,
        rate: arguments.rate.unwrap_or(CLUSTER_RATE),
        control: arguments.control,
        broker: arguments.broker,
        overlapping: arguments.overlapping,
        kafka: arguments.kafka.into(),
    };
    cluster::run(&settings, &program(arguments)?, logs).await
}

async fn run(arguments: &Arguments, logs: &std::path::Path) -> anyhow::Result<Report> {
    let Arguments { seed, seconds, control, .. } = *arguments;
    let program = program(arguments)?;
    let names: Vec<Name> = (0..arguments.robots as usize).map(scenario::robot_name).collect();
    let (honest, hostile_names) = names.split_at((arguments.robots - arguments.hostile) as usize);
    let strangers: Vec<String> = hostile_names.iter().map(|name| name.as_str().to_owned()).collect();
    // The folder may contain logs of an earlier run.
    let panics_before = stage::panics(logs);
    let mut stage = Stage::set(&program, control, logs, &names).await;
    let watch = Watch::start(stage.database.connect());
    let address = ("127.0.0.1", stage.broker.port());
    let fleets = [scenario::fleet()];
    let mut replay = Replay::start(address, (REPLAY_USER, SUPERVISOR_PASSWORD), &fleets, seed);
    let refusals = Refusals::start(stage.supervisors.iter().map(|supervisor| supervisor.http).collect());
    let (rate, links) = (arguments.rate.unwrap_or(RATE), vec![scenario::fleet(); ROBOT_LINKS]);
    let scenarios = scenario::scenarios(seed, seconds, honest, rate, control, &links);
    let robots = Robots::start(&scenarios, &stage::brokers(&stage.robot_links))?;
    let behaviours = Behaviour::chosen(&arguments.hostile_only, &arguments.hostile_without);
    let hostile = Hostile::start(hostile_names, &stage.robot_links, &behaviours, seed);
    let started = Instant::now();
    let owner = watch.owner(0, START_PATIENCE).await;
    ensure!(owner.is_some(), "no supervisor acquires the fleet: see the supervisors' logs in {logs:?}");

    let mut striker = Striker::new(&mut stage, &watch);
    let mut progress = Progress::new(&robots, started, seconds);
    for strike in plan::plan(seed, seconds, control) {
        progress.wait_until(strike.at_s).await;
        striker.strike(&strike).await;
    }
    progress.wait_until(seconds).await;
    if control == Control::RobotIgnoresEpochs {
        let late = replay.late(LATE_REPEATS);
        tokio::time::timeout(LATE_PATIENCE, late)
            .await
            .context("hardly any setpoint was repeated after it had expired")?;
    }
    let (struck, mut surprises) = (striker.struck, striker.surprises);
    surprises.ended += stage.revive();
    let run_s = started.elapsed().as_secs_f64();

    hostile.stop();
    robots.rest();
    let mut connection = stage.database.connect().connect().await?;
    let drain = drain(&robots, &mut connection, &strangers).await?;
    surprises.ended += stage.revive();
    let faults = struck.iter().map(|one| FaultReport::new(one, started, &watch.reigns())).collect();
    let (undelivered, dropped, made) = (robots.undelivered(), robots.dropped(), robots.made());
    let mut truth = robots.stop().await;
    eprintln!("chaos: reading {} contacts back", truth.ledger.count());
    recorded::contacts(&mut connection, &strangers, &mut truth.ledger).await?;
    let contacts = truth.ledger.verdict();
    ensure!(
        contacts.felt == made || undelivered > 0,
        "robots made {made} contacts, but their journals have {}",
        contacts.felt
    );
    let setpoints = truth.obedience.verdict(&recorded::setpoints(&mut connection, &strangers).await?);
    Ok(Report {
        repeated: replay.count(),
        dropped,
        undelivered,
        run_s,
        drain_s: drain.as_secs_f64(),
        panics: stage::panics(logs) - panics_before,
        hostile_robots: arguments.hostile.into(),
        hostile: if arguments.hostile > 0 { hostile.counts() } else { BTreeMap::new() },
        hostile_setpoints: hostile.setpoints(),
        refusals: refusals.counts(),
        faults,
        ..Report::new(seed, contacts, setpoints, surprises)
    })
}

/// Prints the progress of a run every 30 seconds.
struct Progress<'a> {
    robots: &'a Robots,
    started: Instant,
    seconds: f64,
    next: Instant,
}

impl<'a> Progress<'a> {
    fn new(robots: &'a Robots, started: Instant, seconds: f64) -> Self {
        Self { robots, started, seconds, next: started + PROGRESS }
    }

    /// Waits until this many seconds after the start.
    async fn wait_until(&mut self, at_s: f64) {
        let until = self.started + Duration::from_secs_f64(at_s);
        loop {
            if Instant::now() >= self.next {
                self.tell();
            }
            if Instant::now() >= until {
                return;
            }
            sleep(self.next.min(until).saturating_duration_since(Instant::now())).await;
        }
    }

    fn tell(&mut self) {
        let elapsed = self.started.elapsed();
        eprintln!(
            "chaos: {} of {} s: {} contacts made, {} messages without a receipt",
            elapsed.as_secs(),
            self.seconds,
            self.robots.made(),
            self.robots.undelivered()
        );
        self.next = Instant::now() + PROGRESS;
    }
}

/// Waits until robots have nothing left to send, or until that number has not changed for [`DRAIN_PATIENCE`]. Then
/// waits until the number of rows is stable, too. Returns the duration.
async fn drain(robots: &Robots, connection: &mut PgConnection, strangers: &[String]) -> anyhow::Result<Duration> {
    let begun = Instant::now();
    let (mut undelivered, mut changed) = (robots.undelivered(), begun);
    while undelivered > 0 && changed.elapsed() < DRAIN_PATIENCE {
        sleep(DRAIN_PAUSE).await;
        let now = robots.undelivered();
        if now != undelivered {
            (undelivered, changed) = (now, Instant::now());
        }
    }
    let drain = begun.elapsed();
    let mut rows = recorded::count(connection, strangers).await?;
    loop {
        // The pause begins after a count, because counting the rows of a long run is slow.
        sleep(SETTLED).await;
        let before = std::mem::replace(&mut rows, recorded::count(connection, strangers).await?);
        if rows == before {
            return Ok(drain);
        }
    }
}
