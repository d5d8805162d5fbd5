//! Measures the time from the contact that confirms a cut until its setpoint reaches the robot, by the generator's
//! clock.
//!
//! The generator notes the times of each contacts message sent and each setpoint received. A setpoint contains the time
//! at which the supervisor received the message behind it, rounded down to a millisecond. So that message is the
//! whisker's last one sent before the next millisecond. A whisker that waits for its setpoint has one contact per 100
//! ms, so the match is unique.

use serde_json::json;

use crate::Bench;
use crate::burst::Subject;
use crate::child::Helper;
use crate::pingpong;
use crate::report::{Figure, Target, median, quantile_ms};
use crate::stage::{self, Store};

const PART: &str = "latency";
const ROBOTS: usize = 100;
/// Whiskers per robot, each in an array of its own, so that it compensates itself.
const WHISKERS: usize = 4;
const LEARN: usize = 160;
/// Messages per second of a robot for the whisker that was cut.
const CUT_PER_S: usize = 10;
/// Messages per second of all robots, and the targets for p50 and p99.
const RATES: [(usize, Target, Target); 2] =
    [(1_000, Target::AtMost(2.0), Target::AtMost(10.0)), (10_000, Target::None, Target::AtMost(25.0))];
const ROUND_TRIPS: usize = 5000;

#[derive(Default)]
struct Series {
    latencies_us: Vec<u64>,
    missed: u64,
    wrong: i64,
    cpus: Vec<f64>,
}

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let broker = stage::broker();
    let store = Store::postgres().await;
    let mut floor: Vec<u64> = Vec::new();
    let mut series = RATES.map(|_| Series::default());
    let mut round = 0;
    while bench.has_time_for(round) {
        let mut responder = Helper::start(&["echo", "--port", &broker.port().to_string()].map(str::to_owned))?;
        responder.ready().await?;
        let port = broker.port();
        let trips = tokio::task::spawn_blocking(move || pingpong::round_trips(port, ROUND_TRIPS)).await??;
        bench.line(
            PART,
            round,
            json!({ "subject": "ping-pong", "p50_ms": quantile_ms(&trips, 0.5), "p99_ms": quantile_ms(&trips, 0.99) }),
        )?;
        floor.extend(trips);
        drop(responder);
        for ((rate, ..), series) in RATES.into_iter().zip(&mut series) {
            // Each measurement has a new fleet, whose whiskers are not cut.
            let subject = Subject::start(bench, &broker, &store, &format!("{PART}-{rate}-{round}")).await?;
            let messages = (rate as f64 * bench.pace.latency_s) as u64;
            let burst = subject.burst(&broker, &arguments(rate, messages)).await?;
            let report = &burst.loaded.report;
            let of = |share| quantile_ms(&report.latencies_us, share);
            bench.say(&format!(
                "{PART}, round {}: {rate}/s, {} setpoints, p50 {:.2} ms, p99 {:.2} ms",
                round + 1,
                report.latencies_us.len(),
                of(0.5),
                of(0.99)
            ));
            let mut line = burst.json(&format!("{rate}/s"));
            line["p50_ms"] = of(0.5).into();
            line["p99_ms"] = of(0.99).into();
            line["max_ms"] = of(1.0).into();
            bench.report.line(PART, round, line)?;
            series.latencies_us.extend(&report.latencies_us);
            series.missed += report.missed;
            series.wrong += burst.lost.abs() + burst.duplicated;
            series.cpus.push(burst.loaded.cpu_s_per_million("supervisor"));
            subject.supervisor.stop().await?;
        }
        round += 1;
    }
    rows(bench, floor, series)
}

fn arguments(rate: usize, messages: u64) -> Vec<(&'static str, String)> {
    vec![
        ("robots", ROBOTS.to_string()),
        ("whiskers", WHISKERS.to_string()),
        ("array-whiskers", "1".to_owned()),
        ("learn", LEARN.to_string()),
        ("trim-every", (rate / (ROBOTS * CUT_PER_S)).to_string()),
        ("rate", rate.to_string()),
        ("messages", messages.to_string()),
    ]
}

fn rows(bench: &mut Bench, mut floor: Vec<u64>, series: [Series; 2]) -> anyhow::Result<()> {
    floor.sort_unstable();
    let floor_text = |share| format!("ping-pong {:.2} ms", quantile_ms(&floor, share));
    for ((rate, middle, high), mut series) in RATES.into_iter().zip(series) {
        series.latencies_us.sort_unstable();
        let of = |share| Figure(quantile_ms(&series.latencies_us, share), "ms");
        bench.row(PART, &format!("{rate} msg/s: p50"), middle, of(0.5), floor_text(0.5))?;
        bench.row(PART, &format!("{rate} msg/s: p99"), high, of(0.99), floor_text(0.99))?;
        let count = series.latencies_us.len();
        let beside = format!("of {count} setpoints; {} cuts without one", series.missed);
        bench.row(PART, &format!("{rate} msg/s: longest"), Target::None, of(1.0), beside)?;
        let cpu = median(series.cpus.iter().copied());
        bench.row(PART, &format!("{rate} msg/s: CPU per million"), Target::None, Figure(cpu, "s"), String::new())?;
        let wrong = Figure(series.wrong as f64, "");
        bench.row(
            PART,
            &format!("{rate} msg/s: contacts lost or duplicated"),
            Target::AtMost(0.0),
            wrong,
            String::new(),
        )?;
    }
    Ok(())
}
