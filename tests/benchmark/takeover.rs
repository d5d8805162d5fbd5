//! Measures the takeover of a fleet: the processor time until a supervisor hears it, of a hundred thousand and a million whiskers.

use std::time::{Duration, Instant};

use serde_json::json;
use vibrissa_tests::mosquitto::Mosquitto;

use crate::child::load;
use crate::report::{Figure, Target, median};
use crate::stage::{self, Store, Supervisor};
use crate::{Bench, usage};

const PART: &str = "takeover";
/// Whiskers of a robot.
const OF_ROBOT: usize = 100;
/// Time limit for the receipt of each whisker's contact.
const PATIENCE: Duration = Duration::from_secs(180);

/// Processor time of takeovers without the start of the program, and elapsed time with it, s.
struct Takeover {
    cpu_s: f64,
    elapsed_s: f64,
}

/// Makes a fleet, and takes it over once per round.
async fn takeovers(bench: &mut Bench, broker: &Mosquitto, whiskers: usize) -> anyhow::Result<Vec<Takeover>> {
    let (store, fleet) = (Store::postgres().await, format!("{PART}-{whiskers}"));
    let first = Supervisor::start(&bench.stage, broker, &store, &fleet).await?;
    let arguments = [
        ("robots", (whiskers / OF_ROBOT).to_string()),
        ("whiskers", OF_ROBOT.to_string()),
        ("array-whiskers", OF_ROBOT.to_string()),
        ("contacts", OF_ROBOT.to_string()),
        ("messages", (whiskers / OF_ROBOT).to_string()),
        ("patience-s", PATIENCE.as_secs().to_string()),
    ];
    load(broker.port(), &fleet, &arguments, &[], None).await?;
    first.stop().await?;
    let mut all = Vec::new();
    for round in 0..bench.pace.rounds {
        // A supervisor without robots needs this much until it is ready.
        let (base_s, _) = started(bench, broker, &store, "empty").await?;
        let (cpu_s, elapsed_s) = started(bench, broker, &store, &fleet).await?;
        let one = Takeover { cpu_s: cpu_s - base_s, elapsed_s };
        let line = json!({ "whiskers": whiskers, "cpu_s": one.cpu_s, "elapsed_s": one.elapsed_s });
        bench.line(PART, round, line)?;
        bench.say(&format!("{PART}: {whiskers} whiskers: {:.2} s of CPU, {:.2} s elapsed", one.cpu_s, one.elapsed_s));
        all.push(one);
    }
    Ok(all)
}

/// Starts a supervisor and stops it again. Returns its processor time and the elapsed time until it heard its fleet, s.
async fn started(bench: &Bench, broker: &Mosquitto, store: &Store, fleet: &str) -> anyhow::Result<(f64, f64)> {
    let begun = Instant::now();
    let started = Supervisor::start(&bench.stage, broker, store, fleet).await?;
    let (cpu_s, elapsed_s) = (usage::of_tree(started.pid()).cpu_s, begun.elapsed().as_secs_f64());
    started.stop().await?;
    Ok((cpu_s, elapsed_s))
}

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let broker = stage::broker();
    for whiskers in [bench.pace.whiskers_max, 10 * bench.pace.whiskers_max] {
        let all = takeovers(bench, &broker, whiskers).await?;
        let cpu_s = median(all.iter().map(|one| one.cpu_s));
        let elapsed_s = median(all.iter().map(|one| one.elapsed_s));
        let beside = format!("{} of CPU, {} elapsed", Figure(cpu_s, "s"), Figure(elapsed_s, "s"));
        let what = format!("{whiskers} whiskers: states taken over per second and core");
        bench.row(PART, &what, Target::AtLeast(200_000.0), Figure(whiskers as f64 / cpu_s, "/s"), beside)?;
    }
    Ok(())
}
