//! Evaluates the segmenter on hours of simulated streams and prints the table of docs/segmenter.md:
//! `cargo run --manifest-path robot/Cargo.toml --release -p vibrissa-segmenter --example evaluate_segmenter [HOURS] [SEED] [SCENES]`;
//! with a part of the names of scenes only these, with `table` only the table of streams that begin at rest.

#[path = "../tests/stream/mod.rs"]
mod stream;

use std::time::Instant;

use stream::scene::{Glitches, HABITS, Habit, Motion, Polarity, Scene};
use stream::verdict::judge_all;
use stream::{Plan, Score, evaluate, fused, quantile};
use vibrissa_segmenter::{Params, Segmenter};

/// Seconds of one stream.
const STREAM_S: f64 = 900.0;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let hours: f64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(2.0);
    let seed: u64 = arguments.next().and_then(|text| text.parse().ok()).unwrap_or(1_000);
    let only = arguments.next();
    if only.as_deref() != Some("table") {
        scenes(seed, (hours * 20.0) as u64, only.as_deref().unwrap_or_default());
        println!();
    }
    if only.is_none_or(|only| only == "table") {
        table(seed, hours);
    }
}

/// Streams that begin at rest.
fn table(seed: u64, hours: f64) {
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

/// Streams that begin anywhere, with the disturbances of real robots.
fn scenes(seed: u64, streams: u64, only: &str) {
    println!(
        "| scene | streams | right | inverted | touches | found | false an hour | strain error: median | 95 % | onset error, ms: 95 % | 99 % | slip-offs |"
    );
    println!("|:---{}|", "| ---: ".repeat(11));
    let base = Scene { seed, ..Scene::default() };
    let row = |name: &str, scene: Scene| {
        if name.contains(only) {
            scene_row(name, &scene, Params::default(), streams);
        }
    };
    for habit in [Habit::OneInThree, Habit::LongHolds, Habit::Rare] {
        let name = format!("{habit:?}, no motion, sign stated");
        let seconds = if habit == Habit::LongHolds { 600.0 } else { 130.0 };
        let scene = Scene { habit, seconds, motion: Motion::None, gap_s: 0.3, ..base };
        if name.contains(only) {
            scene_row(&name, &scene, Params { sign: 1.0, ..Params::default() }, streams);
        }
    }
    for habit in HABITS {
        let seconds = if habit == Habit::LongHolds { 600.0 } else { 130.0 };
        let scene = Scene { habit, seconds, ..base };
        row(&format!("{habit:?}, way told"), scene);
        row(
            &format!("{habit:?}, press told, minus"),
            Scene { motion: Motion::Pressed, polarity: Polarity::Minus, ..scene },
        );
        row(&format!("{habit:?}, no motion"), Scene { motion: Motion::None, ..scene });
        for gap_s in [0.1, 0.3, 1.0, 5.0] {
            row(&format!("{habit:?}, gaps of {gap_s} s"), Scene { motion: Motion::Pressed, gap_s, ..scene });
        }
        row(&format!("{habit:?}, no motion, gaps of 0.3 s"), Scene { motion: Motion::None, gap_s: 0.3, ..scene });
        row(&format!("{habit:?}, both ways"), Scene { polarity: Polarity::Mixed, ..scene });
        row(
            &format!("{habit:?}, both ways, no motion"),
            Scene { polarity: Polarity::Mixed, motion: Motion::None, ..scene },
        );
        row(&format!("{habit:?}, 10 Hz"), Scene { motion: Motion::Pressed, rate_hz: 10.0, ..scene });
        row(&format!("{habit:?}, 1000 Hz"), Scene { rate_hz: 1000.0, ..scene });
        row(&format!("{habit:?}, steps of air"), Scene { air: true, ..scene });
    }
    for habit in [Habit::OneInThree, Habit::Rare] {
        for (part, longest, at) in [
            (0.01, 1, Some(0.2)),
            (0.03, 1, Some(0.2)),
            (0.01, 3, Some(0.2)),
            (0.05, 3, Some(0.2)),
            (0.01, 3, Some(-0.03)),
            (0.01, 3, None),
            (0.05, 3, None),
        ] {
            let glitches = Some(Glitches { part, longest, at });
            let name = format!("{habit:?}, {} % glitches of 1 to {longest} at {at:?}", part * 100.0);
            row(&name, Scene { habit, glitches, motion: Motion::Pressed, ..base });
        }
    }
    for driving in [0.02, 0.1] {
        for rate_hz in [80.0, 250.0, 1000.0] {
            let scene = Scene { driving, rate_hz, habit: Habit::Nothing, seconds: 600.0, ..base };
            row(&format!("driving {driving}, {rate_hz} Hz"), scene);
            row(&format!("driving {driving}, {rate_hz} Hz, told"), Scene { tells_driving: true, ..scene });
        }
        row(&format!("driving {driving}, touches of 1 s in 3"), Scene { driving, habit: Habit::OneInThree, ..base });
    }
}

fn scene_row(name: &str, scene: &Scene, params: Params, streams: u64) {
    let verdict = judge_all(scene, params, streams);
    let percent = |part: f64| format!("{:.1} %", 100.0 * part);
    let errors: Vec<f64> = verdict.strain.iter().map(|error| error.abs()).collect();
    println!(
        "| {name} | {} | {} | {} | {} | {} | {:.1} | {} | {} | {:.0} | {:.0} | {} |",
        verdict.streams,
        percent(verdict.right_part()),
        verdict.inverted,
        verdict.touches,
        percent(verdict.found_part()),
        verdict.false_per_hour(),
        percent(quantile(&errors, 0.5)),
        percent(quantile(&errors, 0.95)),
        quantile(&verdict.onset_ms, 0.95),
        quantile(&verdict.onset_ms, 0.99),
        if verdict.slips > 0 { percent(verdict.slip_part()) } else { "-".to_owned() },
    );
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
