//! Evaluates the segmenter on hours of simulated streams and prints the table of docs/segmenter.md:
//! `cargo run --manifest-path robot/Cargo.toml --release -p vibrissa-segmenter --example evaluate_segmenter [HOURS] [SEED]`.

#[path = "../tests/stream/mod.rs"]
mod stream;

use std::time::Instant;

use stream::{Plan, Score, evaluate, fused, quantile};
use vibrissa_segmenter::{Params, Segmenter};

/// Seconds of one stream.
const STREAM_S: f64 = 900.0;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let hours: f64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(2.0);
    let seed: u64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(1_000);
    println!("{hours} hours of touches and {hours} quiet hours a row, seeds from {seed}");
    println!();
    println!(
        "| Hz | gauges | motion | touches | found | 0.5-1 mm | 1-3 mm | 3-10 mm | onset error, ms: 50 % | 95 % | 99 % | delay of the event, ms: 50 % | 95 % | false contacts an hour | slip-offs recognised | false slip-offs | strain error: 68 % | 95 % | within 2 sd | distance sd, mm | within 2 sd |"
    );
    println!("|{}", " ---: |".repeat(21));
    for rate_hz in [50.0, 88.0, 100.0, 250.0, 1000.0] {
        for (two_gauges, motion) in [(false, false), (true, false), (true, true)] {
            let mut score = Score::default();
            for index in 0..(2.0 * hours * 3_600.0 / STREAM_S).ceil() as u64 {
                let touches = index % 2 == 0;
                let plan = Plan { seed: seed + index, rate_hz, two_gauges, motion, seconds: STREAM_S, touches };
                score.add(evaluate(&plan, Params::default()));
            }
            row(rate_hz, two_gauges, motion, &score);
        }
    }
    let (rounds, within, sds) = fused(seed, 5_000, &Params::default());
    println!();
    println!(
        "Ten contacts at one distance, fused: standard deviation {:.1} mm, {:.1} % within two of them.",
        sds / f64::from(rounds),
        100.0 * f64::from(within) / f64::from(rounds)
    );
    cost(seed);
}

/// Time that a sample takes.
fn cost(seed: u64) {
    let plan = Plan { seed, rate_hz: 1000.0, two_gauges: true, motion: true, seconds: 600.0, touches: true };
    let mut samples = Vec::new();
    stream::stream(&plan, |sample| samples.push(sample));
    let mut segmenter = Segmenter::new(Params::default());
    #[expect(clippy::disallowed_methods, reason = "it measures its own time")]
    let begin = Instant::now();
    let events = samples.iter().filter(|sample| segmenter.push(**sample).is_some()).count();
    let ns = begin.elapsed().as_nanos() as f64 / samples.len() as f64;
    println!(
        "{ns:.0} ns a sample at 1000 Hz with two gauges and motion ({events} events): 24 whiskers take {:.2} % of a core.",
        24_000.0 * ns * 1e-9 * 100.0
    );
}

fn row(rate_hz: f64, two_gauges: bool, motion: bool, score: &Score) {
    let percent = |part: f64| format!("{:.1} %", 100.0 * part);
    let class = |index: usize| percent(f64::from(score.found[index]) / f64::from(score.touches[index]));
    let errors: Vec<f64> = score.strain.iter().map(|error| error.abs()).collect();
    let contacts = score.strain.len() as f64;
    let distances = f64::from(score.distances);
    let (sd, within) = if score.distances > 0 {
        (format!("{:.1}", score.distance_sd_mm / distances), percent(f64::from(score.distances_within) / distances))
    } else {
        ("-".to_owned(), "-".to_owned())
    };
    println!(
        "| {rate_hz} | {} | {} | {} | {} | {} | {} | {} | {:.1} | {:.1} | {:.1} | {:.0} | {:.0} | {:.2} | {} | {} | {} | {} | {} | {sd} | {within} |",
        if two_gauges { 2 } else { 1 },
        if motion { "yes" } else { "no" },
        score.touches.iter().sum::<u32>(),
        percent(score.found_part()),
        class(0),
        class(1),
        class(2),
        quantile(&score.onset_ms, 0.5),
        quantile(&score.onset_ms, 0.95),
        quantile(&score.onset_ms, 0.99),
        quantile(&score.delay_ms, 0.5),
        quantile(&score.delay_ms, 0.95),
        score.false_per_hour(),
        percent(score.slip_part()),
        percent(score.false_slip_part()),
        percent(quantile(&errors, 0.68)),
        percent(quantile(&errors, 0.95)),
        percent(f64::from(score.strain_within) / contacts),
    );
}
