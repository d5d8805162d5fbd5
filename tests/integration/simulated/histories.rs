//! Histories without planted faults.

use std::thread;
use std::time::Duration;

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use vibrissa_simulation::invariants::Invariant;
use vibrissa_simulation::plan::{Kind, Plan, Sizes, Strike};
use vibrissa_simulation::world::run;
use vibrissa_store::fault::{Fault, planted};

/// Seeds that take about a minute of one core in all.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=120;

/// Runs a history, and says which invariants it violates.
fn problem(seed: u64) -> Option<String> {
    let outcome = run(&Plan::draw(seed, Sizes::default()));
    let violations: Vec<String> = outcome.violations.iter().map(ToString::to_string).collect();
    (!violations.is_empty()).then(|| format!("seed {seed}: {}", violations.join("; ")))
}

#[test]
fn property_drawn_histories_keep_all_invariants() {
    let problems: Vec<String> = SEEDS.into_par_iter().filter_map(problem).collect();
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// A failover lost the commit that began an epoch, after the database's clock had gone back. The history is the smallest one that
/// has it; `VIBRISSA_TEST_FAULT=epoch_reuse cargo run -p vibrissa-tests --bin lab-under-test -- simulate` finds another one.
#[test]
fn regress_no_epoch_is_given_twice_after_a_failover_with_a_clock_that_went_back() {
    let strike = |at_us, kind, lasts_ms, victim, measure| Strike {
        at: Duration::from_micros(at_us),
        kind,
        lasts: Duration::from_millis(lasts_ms),
        victim,
        measure,
    };
    let plan = Plan {
        seed: 55,
        supervisors: 2,
        fleets: 1,
        robots: 3,
        contacts_per_second: 0.28,
        length: Duration::from_secs(130),
        strikes: vec![
            strike(99_774_668, Kind::StoreClockStepped, 1, 961, 17_784_037_738_611_171_279),
            strike(104_833_629, Kind::StoreAway, 5_162, 900, 0),
            strike(104_978_297, Kind::FromStoreCut, 4_998, 272, 0),
            strike(105_091_429, Kind::SupervisorFrozen, 2_827, 389, 0),
            strike(106_504_500, Kind::StoreAway, 1_821, 750, 0),
            strike(108_246_077, Kind::StoreFailover, 365, 837, 0),
            strike(110_500_688, Kind::SupervisorKilled, 4_856, 563, 16_878_182_701_264_902_950),
            strike(123_086_765, Kind::SupervisorFrozen, 4_842, 796, 0),
        ],
        misbehaviour: None,
    };
    let violated = || run(&plan).violations.iter().map(|one| one.invariant).collect::<Vec<_>>();
    assert_eq!(planted(Fault::EpochReuse, violated), [Invariant::EpochOnce]);
    assert_eq!(violated(), []);
}

#[test]
fn property_a_seed_gives_the_same_history_with_many_supervisors() {
    let sizes = Sizes { supervisors: 6, robots: 12, length: Duration::from_secs(60), are_fixed: true };
    for seed in 1..=3 {
        let hash = move || {
            let outcome = run(&Plan::draw(seed, sizes));
            (outcome.hash, outcome.steps_in_all)
        };
        // Each thread has hash maps with other keys.
        let (other, own) = (thread::spawn(hash), hash());
        assert_eq!(own, other.join().expect("a run"), "seed {seed}");
    }
}
