//! Measures whiskers in the core alone: memory of a million whiskers, and bytes of one stored state.

use serde_json::{Value, json};
use vibrissa_evaluation::crowd;

use crate::Bench;
use crate::child::Helper;
use crate::report::{Figure, Target};

const PART: &str = "core";
const WHISKERS: u16 = 24;
/// Contacts per whisker: the baselines are learned, and the state has its final size in memory.
const CONTACTS: u32 = 40;
/// Contacts and robots of the measurement of stored states: by then suspected changes have begun and the leak detection
/// has all its data.
const STORED: (u32, usize) = (1000, 100);
const KIB: f64 = 1024.0;

/// Prints the memory of this many robots. It runs in a process of its own, so that only they use its memory.
pub fn print(robots: usize) {
    let size = crowd::size(robots, WHISKERS, CONTACTS, &|| ());
    let stored = crowd::size(STORED.1, WHISKERS, STORED.0, &|| ());
    let line = json!({
        "whiskers": size.whiskers,
        "resident_bytes": size.resident_bytes,
        "resident_max_bytes": size.resident_max_bytes,
        "stored_bytes_a_whisker": stored.stored_bytes_a_whisker,
        "stored_bytes_a_whisker_learned": size.stored_bytes_a_whisker,
    });
    println!("{line}");
}

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let robots = bench.pace.crowd_robots;
    bench.say(&format!("{PART}: {} whiskers with {CONTACTS} contacts each", robots * usize::from(WHISKERS)));
    let output = Helper::start(&["crowd".to_owned(), robots.to_string()])?.ended().await?;
    let mut line: Value = serde_json::from_str(&output)?;
    let of = |name: &str| line[name].as_f64().unwrap_or(f64::NAN);
    let whiskers = of("whiskers");
    let million_gib = of("resident_max_bytes") / whiskers * 1e6 / KIB.powi(3);
    let beside = format!("{:.0} whiskers, {:.0} bytes each in memory", whiskers, of("resident_max_bytes") / whiskers);
    let stored = Figure(of("stored_bytes_a_whisker"), "B");
    let young = format!("{} just after learning", Figure(of("stored_bytes_a_whisker_learned"), "B"));
    bench.row(PART, "memory of a million whiskers", Target::AtMost(2.5), Figure(million_gib, "GiB"), beside)?;
    bench.row(PART, "stored state of a whisker", Target::AtMost(2.0 * KIB), stored, young)?;
    line["subject"] = "crowd".into();
    bench.line(PART, 0, line)
}
