//! Sends a million messages at the limits of the contract, from bytes to the state of a robot. Nothing may panic, every
//! number stays finite, a receipt covers every accepted message, setpoints keep the contract, and the stored state can
//! be restored.
//!
//! `FUZZ_CASES=10000000` plays more messages, `FUZZ_SEED=7` other ones. The report of a fault contains its seed and the
//! fewest messages that cause it. `FUZZ_WITHOUT=factsheet,times` makes factsheets ordinary and times correct, to find
//! the cause of a fault.

use std::collections::BTreeMap;
use std::time::Instant;

use rayon::prelude::*;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_tests::extremes::{Messages, Without};

use crate::episode::{self, Inputs, MESSAGES};
use crate::subject::Input;

/// Number of messages, unless the environment sets another number.
const CASES: u64 = 1_000_000;
/// Number of kinds of faults that are reported with their messages.
const SHOWN: usize = 6;

fn from_environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().map_or(otherwise, |text| text.parse().expect("a number"))
}

/// Kind of a fault: its first words and the field at its end, without numbers.
fn kind_of(fault: &str) -> String {
    let words: Vec<String> =
        fault.split_whitespace().map(|word| word.replace(|one: char| !one.is_alphabetic(), "")).collect();
    let (start, end) = (words.len().min(5), words.len().saturating_sub(2).max(5).min(words.len()));
    format!("{} .. {}", words[..start].join(" "), words[end..].join(" "))
}

fn listed(inputs: &Inputs) -> String {
    let start = inputs.first().map_or(0, |(now, _)| now.0);
    let line = |(now, input): &(vibrissa_core::units::Micros, Input)| {
        let after_s = now.0.saturating_sub(start) as f64 / 1e6;
        match input {
            Input::Tick => format!("    {after_s:8.3} s  (time passes)\n"),
            Input::Message(kind, payload) => {
                format!("    {after_s:8.3} s  {kind} {}\n", String::from_utf8_lossy(payload))
            }
        }
    };
    inputs.iter().map(line).collect()
}

#[test]
fn property_extreme_messages_leave_every_number_finite_and_are_receipted() {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 10;
    let (messages, begun) = (Messages::default(), Instant::now());
    let without = Without::from_environment();
    let episodes = from_environment("FUZZ_CASES", CASES).div_ceil(MESSAGES as u64);
    let first = from_environment("FUZZ_SEED", 0) << 32;
    let played: Vec<(u64, BTreeMap<&str, u64>, Option<String>)> = (first..first + episodes)
        .into_par_iter()
        .map(|seed| {
            let played = episode::play(seed, &params, &messages, &without);
            (seed, played.fates, played.fault)
        })
        .collect();

    let mut fates: BTreeMap<&str, u64> = BTreeMap::new();
    let mut faults: BTreeMap<String, Vec<u64>> = BTreeMap::new();
    for (seed, counts, fault) in &played {
        counts.iter().for_each(|(label, count)| *fates.entry(label).or_default() += count);
        if let Some(fault) = fault {
            faults.entry(kind_of(fault)).or_default().push(*seed);
        }
    }
    let said: u64 = fates.values().sum();
    println!("{said} messages in {:.1} s: {fates:?}", begun.elapsed().as_secs_f64());
    let failed: usize = faults.values().map(Vec::len).sum();
    for (kind, seeds) in faults.iter().take(SHOWN) {
        let seed = seeds[0];
        println!("\n{} of {episodes} episodes, the first with seed {seed}: {kind}", seeds.len());
        let inputs = episode::play(seed, &params, &messages, &without).inputs;
        match episode::shrunk(inputs, &params) {
            Some((inputs, fault)) => println!("  {fault}\n  by these messages:\n{}", listed(&inputs)),
            None => println!("  not reproduced when the state is checked after each input"),
        }
    }
    assert_eq!(failed, 0, "{failed} of {episodes} episodes show a fault of {} kinds, see above", faults.len());
    assert!(said >= episodes * MESSAGES as u64, "{said} messages");
    let taken = fates.get("taken").copied().unwrap_or_default();
    assert!(taken * 2 > said, "only {taken} of {said} messages are accepted, too few for a meaningful test");
}
