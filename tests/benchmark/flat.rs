//! Measures scaling from a hundred to a hundred thousand whiskers: the same burst for each, and a restart.

use serde_json::json;

use crate::burst::{Burst, Subject, messages};
use crate::report::{Figure, Target, median};
use crate::stage::{self, Store};
use crate::{Bench, usage};

/// Number of whiskers of the fleet, and of each robot.
const WHISKERS: [usize; 4] = [100, 1_000, 10_000, 100_000];
const OF_ROBOT: usize = 50;
const OF_ARRAY: usize = 25;
const PART: &str = "flat";
/// Assumed messages per second in the first round, so that its burst is long enough, too.
const FIRST_RATE: f64 = 50_000.0;
/// Factor on the length of a burst: in the first second, states of new robots are still being written.
const LONGER: f64 = 2.0;
/// Time limit in seconds for the database to number all whiskers; the time is reported.
const PATIENCE_S: u32 = 150;

struct Scale {
    whiskers: usize,
    store: Store,
    rate: f64,
    rates: Vec<f64>,
    peaks_mib: Vec<f64>,
    prepared_s: Vec<f64>,
    ready_s: Vec<f64>,
    wrong: i64,
}

/// Runs this part of the benchmark.
pub async fn run(bench: &mut Bench) -> anyhow::Result<()> {
    let broker = stage::broker();
    let mut scales = Vec::new();
    for whiskers in WHISKERS.into_iter().filter(|&whiskers| whiskers <= bench.pace.whiskers_max) {
        let store = Store::postgres().await;
        scales.push(Scale {
            whiskers,
            store,
            rate: FIRST_RATE,
            rates: Vec::new(),
            peaks_mib: Vec::new(),
            prepared_s: Vec::new(),
            ready_s: Vec::new(),
            wrong: 0,
        });
    }
    let mut round = 0;
    while bench.has_time_for(round) {
        for scale in &mut scales {
            let subject = Subject::start(bench, &broker, &scale.store, &scale.part()).await?;
            if round > 0 {
                scale.ready_s.push(subject.supervisor.ready_s);
            }
            let burst =
                subject.burst(&broker, &arguments(scale.whiskers, messages(&bench.pace, LONGER * scale.rate))).await?;
            bench.report.line(PART, round, burst.json(&format!("{} whiskers", scale.whiskers)))?;
            subject.supervisor.stop().await?;
            scale.take(&burst);
            bench.say(&format!(
                "{PART}, round {}: {} whiskers {:.0}/s, registered within {:.1} s",
                round + 1,
                scale.whiskers,
                scale.rate,
                burst.loaded.report.prepared_s
            ));
        }
        round += 1;
    }
    if let Some(last) = scales.last_mut() {
        let supervisor = Subject::start(bench, &broker, &last.store, &last.part()).await?.supervisor;
        last.ready_s.push(supervisor.ready_s);
        let peak_mib = usage::of_tree(supervisor.pid()).peak_mib;
        let line = json!({ "restart_s": supervisor.ready_s, "whiskers": last.whiskers, "peak_mib": peak_mib });
        bench.line(PART, round, line)?;
        supervisor.stop().await?;
    }
    rows(bench, &scales)
}

impl Scale {
    /// The part's name, from which the fleet's name follows.
    fn part(&self) -> String {
        format!("{PART}-{}", self.whiskers)
    }

    fn take(&mut self, burst: &Burst) {
        self.rate = burst.loaded.messages_per_s();
        self.rates.push(self.rate);
        self.peaks_mib.push(burst.loaded.usages.get("supervisor").map_or(f64::NAN, |usage| usage.peak_mib));
        self.prepared_s.push(burst.loaded.report.prepared_s);
        self.wrong += burst.lost.abs() + burst.duplicated;
    }
}

/// Arguments of the generator. Whiskers do not learn their baselines here, because a hundred thousand would take too
/// long.
fn arguments(whiskers: usize, messages: u64) -> Vec<(&'static str, String)> {
    vec![
        ("robots", (whiskers / OF_ROBOT).to_string()),
        ("whiskers", OF_ROBOT.to_string()),
        ("array-whiskers", OF_ARRAY.to_string()),
        ("messages", messages.to_string()),
        ("patience-s", PATIENCE_S.to_string()),
    ]
}

fn rows(bench: &mut Bench, scales: &[Scale]) -> anyhow::Result<()> {
    let of = |values: &[f64]| median(values.iter().copied());
    let first = of(&scales[1].rates);
    for scale in scales {
        let ratio = median(scale.rates.iter().zip(&scales[1].rates).map(|(rate, first)| rate / first));
        let target = if scale.whiskers == 100_000 { Target::AtLeast(0.85) } else { Target::None };
        let what = format!("{} whiskers: share of the rate with 1000", scale.whiskers);
        let beside = format!("{} of {}", Figure(of(&scale.rates), "msg/s"), Figure(first, ""));
        bench.row(PART, &what, target, Figure(ratio, ""), beside)?;
        let what = format!("{} whiskers: peak memory", scale.whiskers);
        let beside = format!("registered within {}", Figure(scale.prepared_s[0], "s"));
        bench.row(PART, &what, Target::None, Figure(of(&scale.peaks_mib), "MiB"), beside)?;
    }
    if let Some(last) = scales.last() {
        let target = if last.whiskers == 100_000 { Target::AtMost(5.0) } else { Target::None };
        let what = format!("{} whiskers: ready after a restart", last.whiskers);
        bench.row(PART, &what, target, Figure(of(&last.ready_s), "s"), String::new())?;
    }
    let wrong = scales.iter().map(|scale| scale.wrong).sum::<i64>() as f64;
    bench.row(PART, "contacts lost or duplicated", Target::AtMost(0.0), Figure(wrong, ""), String::new())
}
