//! `vibrissa-lab simulate`: the service in simulated time.

use std::io::Write;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use anyhow::ensure;
use clap::Args;
use tokio::time::Instant;
use vibrissa_host::task;
use vibrissa_simulation::history::diagram;
use vibrissa_simulation::plan::{Kind, Plan, Sizes};
use vibrissa_simulation::shrink::shrink;
use vibrissa_simulation::statistics::Statistics;
use vibrissa_simulation::world::{self, Outcome};

/// Interval of the lines about the progress.
const TOLD_EVERY: Duration = Duration::from_secs(10);
/// Steps of the smallest history that are shown.
const SHOWN: usize = 40;

/// Arguments of `vibrissa-lab simulate`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Each run draws a world (supervisors, fleets, robots) and its faults from its seed, and takes some two minutes of simulated time.
The first run has the seed SEED, the next one SEED + 1. A run with a violated invariant ends the command with status 1: it is
shrunk to the fewest faults that still violate the invariant, and its end is shown as a sequence diagram. The same seed gives the
same history on every machine, if the program was built with the flags in .cargo/config.toml.")]
pub struct SimulateArgs {
    /// Seed of the first run.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Simulated time of all runs together, in hours.
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// Number of supervisors of each run; drawn from 1 to 3 if absent.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..=20))]
    supervisors: Option<u8>,
    /// Number of robots of each run; drawn from 1 to 20 if absent.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=1000))]
    robots: Option<u16>,
    /// Number of threads; each run has one. All cores if absent.
    #[arg(long, value_parser = clap::value_parser!(u8).range(1..))]
    threads: Option<u8>,
    /// Kinds of faults that are left out, as the summary names them, separated by commas.
    #[arg(long, value_name = "KIND", value_parser = kind, value_delimiter = ',', conflicts_with = "only")]
    without: Vec<Kind>,
    /// Kinds of faults that occur in the place of all others, separated by commas.
    #[arg(long, value_name = "KIND", value_parser = kind, value_delimiter = ',')]
    only: Vec<Kind>,
    /// Print the whole history of the first run instead.
    #[arg(long)]
    history: bool,
}

impl SimulateArgs {
    fn sizes(&self) -> Sizes {
        let usual = Sizes::default();
        Sizes {
            supervisors: self.supervisors.map_or(usual.supervisors, usize::from),
            robots: self.robots.map_or(usual.robots, usize::from),
            are_fixed: self.supervisors.is_some() || self.robots.is_some(),
            ..usual
        }
    }

    fn plan(&self, seed: u64) -> Plan {
        let plan = Plan::draw(seed, self.sizes());
        if self.only.is_empty() { plan.without(&self.without) } else { plan.only(&self.only) }
    }
}

/// A kind of fault by its name.
fn kind(name: &str) -> Result<Kind, String> {
    let named = Kind::all().find(|kind| kind.as_str().eq_ignore_ascii_case(name));
    let all = || Kind::all().map(Kind::as_str).collect::<Vec<_>>().join(", ");
    named.ok_or_else(|| format!("no kind of fault has this name; there are: {}", all()))
}

/// Runs simulations until the time is over, or until an invariant is violated.
///
/// # Errors
/// The hours are not a positive number, or the output cannot be written.
pub fn run(args: &SimulateArgs, out: &mut dyn Write) -> anyhow::Result<ExitCode> {
    ensure!(args.hours > 0.0 && args.hours.is_finite(), "--hours must be above 0");
    if args.history {
        let plan = args.plan(args.seed);
        let outcome = world::run_keeping(usize::MAX, &plan);
        for step in &outcome.steps {
            writeln!(out, "{:.6} {} {} {}", step.at.as_secs_f64(), step.from, step.to, step.what)?;
        }
        writeln!(out, "{} steps, hash {:016x}", outcome.steps_in_all, outcome.hash)?;
        return Ok(code(&outcome));
    }
    let begun = Instant::now();
    let (statistics, failed) = simulate(args, begun);
    tell(&statistics, begun, out)?;
    let Some((plan, outcome)) = failed else { return Ok(ExitCode::SUCCESS) };
    show(&plan, outcome, out)?;
    Ok(ExitCode::FAILURE)
}

fn code(outcome: &Outcome) -> ExitCode {
    if outcome.violations.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs in all threads; returns sums, and the first run that violated an invariant.
fn simulate(args: &SimulateArgs, begun: Instant) -> (Statistics, Option<(Plan, Outcome)>) {
    let threads = args.threads.map_or_else(task::cores, usize::from);
    let (next, is_over) = (AtomicU64::new(args.seed), AtomicBool::new(false));
    let (sender, done) = mpsc::channel::<(Plan, Outcome)>();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            let (sender, next, is_over) = (sender.clone(), &next, &is_over);
            scope.spawn(move || {
                while !is_over.load(Ordering::Relaxed) {
                    let plan = args.plan(next.fetch_add(1, Ordering::Relaxed));
                    let outcome = world::run(&plan);
                    if sender.send((plan, outcome)).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let (mut statistics, mut told, mut failed) = (Statistics::default(), begun, None);
        for (plan, outcome) in done {
            statistics.add(&plan, &outcome);
            if !outcome.violations.is_empty() && failed.is_none() {
                failed = Some((plan, outcome));
            }
            if failed.is_some() || statistics.simulated.as_secs_f64() >= args.hours * 3600.0 {
                is_over.store(true, Ordering::Relaxed);
            }
            if told.elapsed() >= TOLD_EVERY {
                told = Instant::now();
                let (hours, faults) = (statistics.simulated.as_secs_f64() / 3600.0, statistics.faults_in_all());
                eprintln!("{hours:.1} hours simulated, {} runs, {faults} faults", statistics.runs);
            }
        }
        (statistics, failed)
    })
}

fn tell(statistics: &Statistics, begun: Instant, out: &mut dyn Write) -> std::io::Result<()> {
    let (took_s, hours) = (begun.elapsed().as_secs_f64(), statistics.simulated.as_secs_f64() / 3600.0);
    let [contacts, setpoints, trims] = statistics.counts;
    let faults = statistics.faults_in_all();
    writeln!(out, "simulated        {hours:.2} hours in {took_s:.0} s: {:.0} times as fast", hours * 3600.0 / took_s)?;
    writeln!(out, "runs             {}", statistics.runs)?;
    writeln!(out, "faults           {faults}, {:.0} an hour of this machine", faults as f64 * 3600.0 / took_s)?;
    let (pairs, all) = (statistics.pairs.len(), Kind::all().count().pow(2));
    writeln!(out, "pairs of faults  {pairs} of {all}, {} different sets at a time", statistics.sets.len())?;
    writeln!(out, "steps            {}", statistics.steps)?;
    writeln!(out, "contacts         {contacts}, {setpoints} setpoints, {trims} trims found")?;
    writeln!(out, "webhooks         {} events taken", statistics.delivered)?;
    writeln!(out, "settled          {:.1} s after the last fault at most", statistics.settled_after.as_secs_f64())?;
    let alarms: Vec<String> = statistics.alarms.iter().map(|(kind, count)| format!("{count} {kind}")).collect();
    writeln!(out, "alarms           {}", alarms.join(", "))?;
    for (kind, count) in &statistics.faults {
        writeln!(out, "  {kind:32} {count:9}")?;
    }
    Ok(())
}

/// Shrinks a failed run, and shows it.
fn show(plan: &Plan, outcome: Outcome, out: &mut dyn Write) -> std::io::Result<()> {
    let Some(violation) = outcome.violations.first().cloned() else { return Ok(()) };
    writeln!(out, "\nVIOLATED with seed {}: {violation}", plan.seed)?;
    let before = plan.strikes.len();
    let (plan, outcome) = shrink(plan, violation.invariant, outcome);
    let (supervisors, fleets, robots) = (plan.supervisors, plan.fleets, plan.robots);
    writeln!(
        out,
        "{} of {before} faults are enough, with {supervisors} supervisors, {fleets} fleets, {robots} robots:",
        plan.strikes.len()
    )?;
    for strike in &plan.strikes {
        writeln!(out, "  {strike}")?;
    }
    for violation in &outcome.violations {
        writeln!(out, "  violated: {violation}")?;
    }
    let first = outcome.steps.len().saturating_sub(SHOWN);
    writeln!(out, "\n{}", diagram(&outcome.steps[first..]))
}
