//! Measures a quiet fleet: a hundred robots with one message per second each.

use serde_json::json;

use crate::Bench;
use crate::burst::{Burst, ROBOTS, Subject, arguments};
use crate::report::{Figure, Target, median};
use crate::stage::{self, Store};

const SECONDS: usize = 10;
const PART: &str = "idle";

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    bench.say(&format!("{PART}: {ROBOTS} robots, one message per second each"));
    let broker = stage::broker();
    let sqlite = Store::Sqlite(bench.stage.folder.path().join("idle.sqlite3"));
    let stores = [Store::postgres().await, sqlite];
    let mut subjects = Vec::new();
    for store in &stores {
        subjects.push((Subject::start(bench, &broker, store, PART).await?, Vec::new()));
    }
    let mut options = arguments(0, 1, (ROBOTS * SECONDS) as u64);
    options.push(("rate", ROBOTS.to_string()));
    let mut round = 0;
    while bench.has_time_for(round) {
        for (subject, shares) in &mut subjects {
            let burst = subject.burst(&broker, &options).await?;
            let measured = Shares::of(&burst);
            let name = subject.store.name();
            let line = json!({
                "subject": name, "supervisor_percent": measured.supervisor, "usages": burst.loaded.usages,
            });
            bench.report.line(PART, round, line)?;
            shares.push(measured);
        }
        round += 1;
    }
    for (subject, shares) in subjects {
        row(bench, &subject, &shares)?;
        subject.supervisor.stop().await?;
    }
    Ok(())
}

/// Processor time of one core, in percent.
struct Shares {
    supervisor: f64,
    broker: f64,
    postgresql: f64,
}

impl Shares {
    fn of(burst: &Burst) -> Self {
        let share = |process| {
            let usage = burst.loaded.usages.get(process);
            100.0 * usage.map_or(f64::NAN, |usage| usage.cpu_s / burst.loaded.report.seconds)
        };
        Self { supervisor: share("supervisor"), broker: share("broker"), postgresql: share("postgresql") }
    }
}

fn row(bench: &mut Bench, subject: &Subject<'_>, shares: &[Shares]) -> anyhow::Result<()> {
    let of = |share: fn(&Shares) -> f64| Figure(median(shares.iter().map(share)), "%");
    let server = if subject.store.pid().is_some() {
        format!(", PostgreSQL {}", of(|shares| shares.postgresql))
    } else {
        String::new()
    };
    let beside = format!("broker {}{server}", of(|shares| shares.broker));
    let what = format!("{}: supervisor's share of one core", subject.store.name());
    bench.row(PART, &what, Target::AtMost(2.0), of(|shares| shares.supervisor), beside)
}
