//! A fleet that does little: a hundred robots with a message a second.

use serde_json::json;

use crate::Bench;
use crate::burst::{ROBOTS, Subject, arguments};
use crate::report::{Figure, Target};
use crate::stage::{self, Store};

const SECONDS: usize = 10;
const PART: &str = "idle";

/// Measures.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    bench.say(&format!("{PART}: {ROBOTS} robots, a message a second each"));
    let broker = stage::broker();
    let sqlite = Store::Sqlite(bench.stage.folder.path().join("idle.sqlite3"));
    for store in [&Store::postgres().await, &sqlite] {
        let subject = Subject::start(bench, &broker, store, PART).await?;
        let mut told = arguments(0, 1, (ROBOTS * SECONDS) as u64);
        told.push(("rate", ROBOTS.to_string()));
        let burst = subject.burst(&broker, &told).await?;
        let name = subject.store.name();
        let share = |process| {
            let usage = burst.loaded.usages.get(process);
            100.0 * usage.map_or(f64::NAN, |usage| usage.cpu_s / burst.loaded.report.seconds)
        };
        let server = if subject.store.pid().is_some() {
            format!(", PostgreSQL {}", Figure(share("postgresql"), "%"))
        } else {
            String::new()
        };
        let beside = format!("broker {}{server}", Figure(share("broker"), "%"));
        bench.row(
            PART,
            &format!("{name}: supervisor's CPU of a core"),
            Target::AtMost(2.0),
            Figure(share("supervisor"), "%"),
            beside,
        )?;
        bench.line(
            PART,
            0,
            json!({ "subject": name, "supervisor_percent": share("supervisor"), "usages": burst.loaded.usages }),
        )?;
        subject.supervisor.stop().await?;
    }
    Ok(())
}
