//! Histories whose contacts and statuses come from a model of the partitioned log.

use std::thread;
use std::time::Duration;

use rayon::iter::{IntoParallelIterator as _, ParallelIterator as _};
use vibrissa_simulation::plan::{Kind, Plan, Sizes};
use vibrissa_simulation::world::run;

use crate::strike;

/// Seeds that take some fifteen seconds of one core in all.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=16;

#[test]
fn property_histories_with_contacts_from_the_log_keep_all_invariants() {
    let problem = |seed| {
        let outcome = run(&Plan::draw(seed, Sizes::default()).from_log());
        assert!(outcome.counts[0] > 0, "seed {seed}: no contact");
        let violations: Vec<String> = outcome.violations.iter().map(ToString::to_string).collect();
        (!violations.is_empty()).then(|| format!("seed {seed}: {}", violations.join("; ")))
    };
    let problems: Vec<String> = SEEDS.into_par_iter().filter_map(problem).collect();
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The robots keep what has no receipt, and send it again.
#[test]
fn contacts_whose_records_are_deleted_or_damaged_before_anybody_reads_them_are_recorded_all_the_same() {
    let sizes = Sizes { supervisors: 1, robots: 6, length: Duration::from_secs(60), are_fixed: true };
    // While nobody can read, the records of each partition are deleted, and later damaged.
    let mut strikes = vec![strike(20_000, Kind::LogFrozen, 8_000, 0, 0), strike(40_000, Kind::ToLogCut, 8_000, 0, 0)];
    for partition in 0..3 {
        strikes.push(strike(26_000, Kind::RecordsDeleted, 0, partition, 0));
        strikes.push(strike(46_000, Kind::RecordDamaged, 0, partition, 0));
    }
    strikes.sort_by_key(|strike| strike.at);
    for seed in 1..=5 {
        let outcome = run(&Plan::draw(seed, sizes).from_log().with(strikes.clone()));
        assert!(outcome.violations.is_empty(), "seed {seed}: {:?}", outcome.violations);
    }
}

/// A supervisor of the next version has written the state of a robot, and one of the present version reads the log
/// afterwards, whose messages of this robot it does not take. In the end the next version replays these records.
#[test]
fn regress_a_replay_takes_no_message_that_a_former_program_has_left_alone() {
    // The smallest history of a seed in which robots got receipts of contacts that nobody had recorded.
    let strikes = vec![
        strike(26_618, Kind::BrokerRestarted, 3_366, 77, 10_367_151_037_783_124_010),
        strike(28_884, Kind::SlowBroker, 9_297, 581, 7_761_346_811_776_868_842),
        strike(61_311, Kind::SupervisorUpgraded, 2_377, 531, 6_176_468_088_424_929_065),
        strike(63_473, Kind::ToBrokerCut, 18_189, 72, 5_956_333_572_608_168_471),
        strike(64_188, Kind::RecordsLate, 7_741, 918, 17_179_968_319_947_640_280),
        strike(64_637, Kind::PartitionAway, 10_781, 480, 7_910_766_671_158_002_863),
    ];
    let plan = Plan::draw(101_045, Sizes::default()).with(strikes);
    let outcome = run(&Plan { supervisors: 3, fleets: 3, robots: 8, ..plan });
    assert!(outcome.violations.is_empty(), "{:?}", outcome.violations);
}

#[test]
fn property_a_seed_gives_the_same_history_with_the_log() {
    let sizes = Sizes { supervisors: 3, robots: 8, length: Duration::from_secs(60), are_fixed: true };
    let hash = move || {
        let outcome = run(&Plan::draw(1, sizes).from_log());
        (outcome.hash, outcome.steps_in_all)
    };
    // Each thread has hash maps with other keys.
    let (other, own) = (thread::spawn(hash), hash());
    assert_eq!(own, other.join().expect("a run"));
}
