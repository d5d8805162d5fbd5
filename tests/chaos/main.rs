//! Nothing lost, nothing stale, whatever fails: robots, broker, PostgreSQL and two supervisors, all real, under
//! faults that a seed decides; at the end what robots felt and obeyed is held against what was recorded.
//!
//! Read in this order: [`plan`] (what goes wrong), [`stage`] and [`scenario`] (what is there), [`strike`] and
//! [`replay`] (making it go wrong), [`owner`] (who supervises), [`ledger`], [`obedience`] and [`recorded`] (the
//! judgement), [`report`].

mod ledger;
mod obedience;
mod owner;
mod plan;
mod recorded;
mod replay;
mod report;
mod scenario;
mod stage;
mod strike;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use clap::Parser;
use sqlx::ConnectOptions;
use sqlx::postgres::PgConnection;
use tokio::time::sleep;

use owner::Watch;
use plan::Control;
use replay::Replay;
use report::{FaultReport, Report};
use stage::{Program, ROBOT_LINKS, Robots, Stage};
use strike::Striker;

/// How long what was felt may take to arrive after the last fault.
const DRAIN_PATIENCE: Duration = Duration::from_secs(60);
/// Nothing more is recorded for so long: that was all.
const SETTLED: Duration = Duration::from_secs(1);
/// As this the program is a supervisor: it always tests what the sources say.
const SUPERVISOR: &str = "supervisor";

/// Chaos: nothing lost, nothing stale?
#[derive(Debug, Parser)]
#[command(name = "chaos", version)]
struct Arguments {
    /// Where all randomness comes from.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How long robots touch and things go wrong, seconds.
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// Simulated robots.
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=999))]
    robots: u32,
    /// Contacts per second of all robots together.
    #[arg(long, default_value_t = 2000.0)]
    rate: f64,
    /// What is broken on purpose, to see that it is noticed.
    #[arg(long, value_enum, default_value_t = Control::None)]
    control: Control,
    /// Print the result as one line of JSON, too.
    #[arg(long)]
    json: bool,
    /// The program `vibrissa` to test, instead of the one inside this program.
    #[arg(long)]
    program: Option<PathBuf>,
    /// Where supervisors' logs go; kept in a temporary folder only if something is wrong, unless given.
    #[arg(long)]
    logs: Option<PathBuf>,
}

fn main() -> anyhow::Result<ExitCode> {
    let mut arguments = std::env::args().skip(1).peekable();
    if arguments.peek().is_some_and(|first| first == SUPERVISOR) {
        return vibrissa::cli::run(vibrissa::cli::Cli::parse_from(arguments));
    }
    let arguments = Arguments::parse();
    let shortest_s = arguments.control.shortest_s();
    ensure!(arguments.seconds >= shortest_s, "--seconds must be at least {shortest_s} for each fault to strike");
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().context("starting the runtime")?;
    let folder = tempfile::tempdir().context("a temporary folder")?;
    let logs = arguments.logs.clone().unwrap_or_else(|| folder.path().to_owned());
    std::fs::create_dir_all(&logs).context("the folder for logs")?;
    let report = runtime.block_on(run(&arguments, &logs))?;
    print!("{report}");
    if arguments.json {
        println!("{}", serde_json::to_string(&report).context("writing JSON")?);
    }
    let violations = report.violations();
    if violations.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    eprintln!("chaos: {}", violations.join("; "));
    if arguments.logs.is_none() {
        eprintln!("chaos: logs are in {}", folder.keep().display());
    }
    Ok(ExitCode::FAILURE)
}

async fn run(arguments: &Arguments, logs: &std::path::Path) -> anyhow::Result<Report> {
    let Arguments { seed, seconds, control, .. } = *arguments;
    let program = match &arguments.program {
        Some(path) => Program { path: path.clone(), first_argument: None },
        None => Program { path: std::env::current_exe()?, first_argument: Some(SUPERVISOR.to_owned()) },
    };
    let mut stage = Stage::set(&program, control, logs).await;
    let watch = Watch::start(stage.database.connect());
    let replay = Replay::start(stage.broker.port(), seed);
    let robots = arguments.robots as usize;
    let scenarios = scenario::scenarios(seed, seconds, robots, arguments.rate, control, ROBOT_LINKS);
    let robots = Robots::start(&scenarios, &stage.robot_links)?;
    let started = Instant::now();
    ensure!(watch.owner(0).await.is_some(), "nobody takes up the fleet: see the supervisors' logs in {logs:?}");

    let mut striker = Striker::new(&mut stage, &watch);
    for strike in plan::plan(seed, seconds, control) {
        sleep(Duration::from_secs_f64(strike.at_s).saturating_sub(started.elapsed())).await;
        striker.strike(&strike).await;
    }
    sleep(Duration::from_secs_f64(seconds).saturating_sub(started.elapsed())).await;
    let (struck, mut surprises) = (striker.struck, striker.surprises);
    surprises.ended += stage.revive();
    let run_s = started.elapsed().as_secs_f64();

    robots.rest();
    let mut connection = stage.database.connect().connect().await?;
    let drain = drain(&robots, &mut connection).await?;
    surprises.ended += stage.revive();
    let faults = struck.iter().map(|one| FaultReport::new(one, started, &watch.reigns())).collect();
    let (undelivered, dropped, made) = (robots.undelivered(), robots.dropped(), robots.made());
    let mut truth = robots.stop().await;
    recorded::contacts(&mut connection, &mut truth.ledger).await?;
    let contacts = truth.ledger.verdict();
    ensure!(contacts.felt == made || undelivered > 0, "robots made {made} contacts and wrote down {}", contacts.felt);
    let setpoints = truth.obedience.verdict(&recorded::setpoints(&mut connection).await?);
    Ok(Report {
        repeated: replay.count(),
        dropped,
        undelivered,
        run_s,
        drain_s: drain.as_secs_f64(),
        faults,
        ..Report::new(seed, contacts, setpoints, surprises)
    })
}

/// Waits until robots have nothing left to send, and nothing more is recorded; tells how long it took.
async fn drain(robots: &Robots, connection: &mut PgConnection) -> anyhow::Result<Duration> {
    let begun = Instant::now();
    let (mut count, mut changed) = (-1, Instant::now());
    loop {
        let now = recorded::count(connection).await?;
        if now != count {
            (count, changed) = (now, Instant::now());
        }
        let is_settled = changed.elapsed() > SETTLED && robots.undelivered() == 0;
        if is_settled || begun.elapsed() > DRAIN_PATIENCE {
            return Ok(changed - begun);
        }
        sleep(Duration::from_millis(100)).await;
    }
}
