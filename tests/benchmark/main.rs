//! Measures throughput, scaling and cost of the whole supervisor, compared with upper limits measured in the same run.
//!
//! Absolute figures depend on the machine and its load, so each is compared with a floor or ceiling that was measured
//! in the same round: a subscriber that does nothing, a table without an index, an echo. `docs/performance.md` explains
//! each figure.
//!
//! Read in this order: [`stage`] (the programs under test), [`child`] (the load and other processes), `burst`, `batch`,
//! `flat`, `latency`, `idle`, [`crowd`] `pages`, [`takeover`] and [`kafka`] (the parts), [`report`].

mod batch;
mod burst;
mod child;
mod cost;
mod crowd;
mod flat;
mod idle;
mod kafka;
mod latency;
mod null;
mod pages;
mod pingpong;
mod report;
mod stage;
mod takeover;
mod unnest;
mod usage;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use anyhow::{Context, ensure};
use clap::{Parser, Subcommand, ValueEnum};
use serde_json::Value;
use vibrissa_simulator::load::{self, LoadPlan};

use null::NullArguments;
use report::{Figure, Report, Target};
use stage::Stage;

/// Name of the program under test, which is built beside this one.
const PROGRAM: &str = "vibrissa-under-test";

/// Measures the supervisor and compares it with floors and ceilings; takes at most eleven minutes.
#[derive(Debug, Parser)]
#[command(name = "bench", version, args_conflicts_with_subcommands = true)]
struct Arguments {
    #[command(subcommand)]
    child: Option<Child>,
    /// Run one short round of each part, about two minutes in total
    #[arg(long)]
    quick: bool,
    /// Run only these parts
    #[arg(long, value_enum, value_name = "NAME")]
    only: Vec<Part>,
    /// File for the measurements, one line of JSON each; a temporary file if omitted
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Program `vibrissa` to measure, instead of the one built beside this program
    #[arg(long, value_name = "FILE")]
    program: Option<PathBuf>,
}

/// Roles of this program in child processes.
#[derive(Debug, Subcommand)]
enum Child {
    /// Generate load, as `vibrissa-simulator load` does
    #[command(hide = true)]
    Load(LoadPlan),
    /// Subscribe as a supervisor does, and ignore the messages
    #[command(hide = true)]
    NullSubscriber(NullArguments),
    /// Print the memory and stored size of this many robots in the core
    #[command(hide = true)]
    Crowd {
        /// Number of robots
        robots: usize,
    },
    /// Send every message back
    #[command(hide = true)]
    Echo {
        /// Port of the broker on this machine
        #[arg(long)]
        port: u16,
    },
}

/// A part of the benchmark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Part {
    /// Bursts of messages with one contact each, at QoS 1
    Burst,
    /// The same bursts at QoS 0
    BurstQos0,
    /// Bursts of messages with twenty contacts each
    Batch,
    /// Scaling from a hundred to a hundred thousand whiskers
    Flat,
    /// Latency from a contact to its setpoint
    Latency,
    /// Cost of a quiet fleet
    Idle,
    /// A million whiskers in the core alone
    Core,
    /// Pages of tables with ten thousand robots
    Pages,
    /// A takeover of a hundred thousand and of a million whiskers; only if it is named
    Takeover,
    /// Contacts that come through Kafka, and their archive; only if it is named. Needs tests/kafka
    Kafka,
}

/// Durations and sizes of the measurements.
#[derive(Debug, Clone, Copy)]
struct Pace {
    rounds: usize,
    /// Length of one burst, seconds.
    burst_s: f64,
    /// Length of one round of latencies, seconds.
    latency_s: f64,
    /// Largest number of whiskers.
    whiskers_max: usize,
    /// Number of robots with 24 whiskers each in the core.
    crowd_robots: usize,
    /// Factor on the time budget of each part.
    budget: f64,
}

impl Part {
    /// Time after which the part begins no further round, in seconds. The budgets of all parts add up to ten and a
    /// half minutes.
    fn budget_s(self) -> f64 {
        match self {
            Self::Burst | Self::BurstQos0 | Self::Batch => 80.0,
            Self::Flat => 150.0,
            Self::Latency => 90.0,
            Self::Idle => 75.0,
            Self::Core => 15.0,
            // Seven requests for each page.
            Self::Pages => 60.0,
            // Not part of a run of everything.
            Self::Takeover | Self::Kafka => 900.0,
        }
    }
}

/// State shared by all parts.
struct Bench {
    stage: Stage,
    pace: Pace,
    report: Report,
    /// Start of the current part and its time budget.
    part: (Instant, Duration),
}

impl Bench {
    fn new(arguments: &Arguments) -> anyhow::Result<Self> {
        let program = match &arguments.program {
            Some(path) => path.clone(),
            None => std::env::current_exe()?.with_file_name(PROGRAM),
        };
        ensure!(
            program.exists(),
            "{} is missing: build it with tests/bench, or name another program with --program",
            program.display()
        );
        let folder = tempfile::Builder::new().prefix("vibrissa-bench-").tempdir().context("a temporary folder")?;
        let path = match &arguments.json {
            Some(path) => path.clone(),
            // The file remains when the folder is removed.
            None => tempfile::Builder::new().prefix("vibrissa-bench-").suffix(".jsonl").tempfile()?.keep()?.1,
        };
        let pace = if arguments.quick {
            Pace { rounds: 1, burst_s: 2.0, latency_s: 4.0, whiskers_max: 10_000, crowd_robots: 4_167, budget: 0.2 }
        } else {
            Pace { rounds: 3, burst_s: 3.5, latency_s: 8.0, whiskers_max: 100_000, crowd_robots: 41_667, budget: 1.0 }
        };
        let part = (Instant::now(), Duration::ZERO);
        Ok(Self { stage: Stage { program, folder }, pace, report: Report::new(path)?, part })
    }

    /// Prints a line of progress.
    fn say(&self, text: &str) {
        eprintln!("bench: {text}");
    }

    /// Whether there is time for one more round of the current part, if it takes as long as the earlier ones.
    fn has_time_for(&self, round: usize) -> bool {
        let (begun, budget) = self.part;
        let of_one = begun.elapsed() / u32::try_from(round.max(1)).unwrap_or(u32::MAX);
        round < self.pace.rounds && (round == 0 || begun.elapsed() + of_one < budget)
    }

    fn line(&mut self, part: &str, round: usize, measured: Value) -> anyhow::Result<()> {
        self.report.line(part, round, measured)
    }

    fn row(
        &mut self,
        part: &'static str,
        what: &str,
        target: Target,
        measured: Figure,
        beside: String,
    ) -> anyhow::Result<()> {
        self.report.row(part, what, target, measured, beside)
    }
}

fn main() -> anyhow::Result<()> {
    let arguments = Arguments::parse();
    let mut small = tokio::runtime::Builder::new_current_thread();
    match arguments.child {
        Some(Child::Load(plan)) => {
            let report = small.enable_all().build()?.block_on(load::run(plan, load::say_prepared))?;
            println!("{}", serde_json::to_string(&report)?);
            Ok(())
        }
        Some(Child::NullSubscriber(arguments)) => {
            let received = small.enable_all().build()?.block_on(null::run(arguments))?;
            println!("{}", serde_json::to_string(&received)?);
            Ok(())
        }
        Some(Child::Crowd { robots }) => {
            crowd::print(robots);
            Ok(())
        }
        Some(Child::Echo { port }) => small.enable_all().build()?.block_on(null::echo(port)),
        None => {
            let mut bench = Bench::new(&arguments)?;
            bench.say(&format!("writing measurements to {}", bench.report.path().display()));
            let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build()?;
            let ended = runtime.block_on(until_interrupted(&mut bench, &arguments.only));
            println!("{}", bench.report.table());
            ended
        }
    }
}

/// Runs the parts. All child processes end with them, also after an interruption.
async fn until_interrupted(bench: &mut Bench, only: &[Part]) -> anyhow::Result<()> {
    tokio::select! {
        ended = parts(bench, only) => ended,
        interrupted = tokio::signal::ctrl_c() => {
            interrupted?;
            eprintln!("bench: interrupted; results so far:");
            Ok(())
        }
    }
}

/// Whether a part is run. Some take so long that they must be named.
fn is_run(part: Part, only: &[Part]) -> bool {
    if only.is_empty() { !matches!(part, Part::Takeover | Part::Kafka) } else { only.contains(&part) }
}

async fn parts(bench: &mut Bench, only: &[Part]) -> anyhow::Result<()> {
    for part in Part::value_variants().iter().filter(|part| is_run(**part, only)) {
        let begun = Instant::now();
        bench.part = (begun, Duration::from_secs_f64(part.budget_s() * bench.pace.budget));
        match part {
            Part::Burst => burst::run(bench, 1).await,
            Part::BurstQos0 => burst::run(bench, 0).await,
            Part::Batch => batch::run(bench).await,
            Part::Flat => flat::run(bench).await,
            Part::Latency => latency::run(bench).await,
            Part::Idle => idle::run(bench).await,
            Part::Core => crowd::run(bench).await,
            Part::Pages => pages::run(bench).await,
            Part::Takeover => takeover::run(bench).await,
            Part::Kafka => kafka::run(bench).await,
        }
        .with_context(|| format!("{part:?}"))?;
        bench.say(&format!("{part:?} took {:.0} s", begun.elapsed().as_secs_f64()));
    }
    Ok(())
}
