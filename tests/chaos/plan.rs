//! What goes wrong, and when: all of it from a seed.

use std::fmt;

use clap::ValueEnum;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Serialize, Serializer};

/// Robots learn their whiskers before anything goes wrong.
const CALM_BEFORE_S: f64 = 5.0;
/// What the last fault has to pass in.
const CALM_AFTER_S: f64 = 3.0;
/// From one fault to the next: the longest of them, and a moment to take up work again.
const APART_S: f64 = 4.5;
/// Faults do not strike on the beat.
const JITTER_S: f64 = 0.4;

/// Longer than a supervisor's lease.
pub const LEASE_S: f64 = 2.0;

/// Something that goes wrong. The owner is the supervisor that supervises at that moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fault {
    /// SIGKILL to the owner; it is started again later.
    OwnerKilled,
    /// SIGTERM to the owner; it is started again later.
    OwnerTerminated,
    /// SIGSTOP to the owner for longer than its lease lives, then SIGCONT.
    OwnerFrozen,
    /// SIGKILL to the broker; it is started again on the same port.
    BrokerKilled,
    /// SIGKILL to every process of PostgreSQL; it is started again on the same port.
    DatabaseKilled,
    /// Links between robots and broker are cut, or stalled, or first stalled and then cut.
    RobotLinks,
    /// The same between supervisors and broker.
    BrokerLinks,
    /// The same between supervisors and PostgreSQL.
    DatabaseLinks,
    /// The owner's link to PostgreSQL is stalled for longer than its lease lives: what it wrote arrives then.
    OwnerCommitsLate,
    /// PostgreSQL is killed, and while it is away the owner as well.
    DatabaseAwayOwnerKilled,
    /// The owner is frozen for longer than its lease lives, and meanwhile the broker is killed and comes back.
    OwnerFrozenBrokerKilled,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::OwnerKilled,
        Self::OwnerTerminated,
        Self::OwnerFrozen,
        Self::BrokerKilled,
        Self::DatabaseKilled,
        Self::RobotLinks,
        Self::BrokerLinks,
        Self::DatabaseLinks,
        Self::OwnerCommitsLate,
        Self::DatabaseAwayOwnerKilled,
        Self::OwnerFrozenBrokerKilled,
    ];

    /// What people read.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::OwnerKilled => "owner killed",
            Self::OwnerTerminated => "owner terminated",
            Self::OwnerFrozen => "owner frozen",
            Self::BrokerKilled => "broker killed",
            Self::DatabaseKilled => "database killed",
            Self::RobotLinks => "robots' links",
            Self::BrokerLinks => "broker's links",
            Self::DatabaseLinks => "database's links",
            Self::OwnerCommitsLate => "owner commits late",
            Self::DatabaseAwayOwnerKilled => "database away, owner killed",
            Self::OwnerFrozenBrokerKilled => "owner frozen, broker killed",
        }
    }

    /// How long it may last, in seconds, from the first blow to the last repair.
    fn lasts_s(self) -> std::ops::Range<f64> {
        match self {
            Self::OwnerKilled => 2.5..3.5,
            Self::OwnerTerminated => 1.0..2.0,
            Self::OwnerFrozen | Self::OwnerFrozenBrokerKilled => LEASE_S + 1.0..LEASE_S + 2.0,
            Self::BrokerKilled | Self::DatabaseKilled => 0.3..1.5,
            Self::RobotLinks | Self::BrokerLinks | Self::DatabaseLinks => 0.5..2.0,
            Self::OwnerCommitsLate => LEASE_S + 0.8..LEASE_S + 1.5,
            Self::DatabaseAwayOwnerKilled => 2.0..3.0,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.as_str())
    }
}

impl Serialize for Fault {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

/// How a link fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manner {
    /// Its connections end.
    Cut,
    /// Nothing passes for a while, and then everything that has waited.
    Stall,
    /// Nothing passes for a while, and then its connections end with what has waited.
    StallThenCut,
}

/// One fault at its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strike {
    /// Seconds after the start.
    pub at_s: f64,
    /// What goes wrong.
    pub fault: Fault,
    /// How long it lasts, in seconds.
    pub lasts_s: f64,
    /// For links: how they fail.
    pub manner: Manner,
    /// For links: a bit for each that may be struck; never all clear.
    pub victims: u8,
}

/// What is broken on purpose, for the test to show that it notices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Control {
    /// Nothing.
    None,
    /// Supervisors receipt contacts before they are committed.
    ReceiptBeforeCommit,
    /// Supervisors write whether or not the fleet is theirs.
    NoFence,
    /// Robots take any setpoint, however late or old.
    RobotIgnoresEpochs,
    /// Robots send once and forget.
    NoRobotBuffer,
}

impl Control {
    /// The faults that bring it to light, all of them in each round.
    fn faults(self) -> &'static [Fault] {
        match self {
            Self::None => &Fault::ALL,
            Self::ReceiptBeforeCommit => &[Fault::DatabaseAwayOwnerKilled],
            Self::NoFence => &[Fault::OwnerFrozen],
            Self::RobotIgnoresEpochs => &[Fault::OwnerTerminated],
            Self::NoRobotBuffer => &[Fault::OwnerKilled, Fault::BrokerKilled],
        }
    }

    /// The shortest run in which each of its faults strikes, in seconds.
    pub fn shortest_s(self) -> f64 {
        CALM_BEFORE_S + CALM_AFTER_S + APART_S * self.faults().len() as f64
    }
}

/// The faults of a run in their order: whole rounds of all of them, each round shuffled.
pub fn plan(seed: u64, seconds: f64, control: Control) -> Vec<Strike> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let stretch_s = seconds - CALM_BEFORE_S - CALM_AFTER_S;
    // Rounds that fit; none is left half done unless the first one does not fit.
    let faults = control.faults();
    let rounds = ((stretch_s / APART_S) as usize / faults.len()).max(1);
    let apart_s = stretch_s / (rounds * faults.len()) as f64;
    let mut strikes = Vec::new();
    for _ in 0..rounds {
        let mut round = faults.to_vec();
        round.shuffle(&mut random);
        for fault in round {
            strikes.push(Strike {
                at_s: CALM_BEFORE_S + apart_s * strikes.len() as f64 + random.random_range(0.0..JITTER_S),
                fault,
                lasts_s: random.random_range(fault.lasts_s()),
                manner: [Manner::Cut, Manner::Stall, Manner::StallThenCut][random.random_range(0..3)],
                victims: random.random_range(1..=u8::MAX),
            });
        }
    }
    strikes
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_fault_strikes_within_a_minute_whatever_the_seed() {
        for seed in 0..200 {
            let faults: BTreeSet<Fault> = plan(seed, 60.0, Control::None).iter().map(|strike| strike.fault).collect();
            assert_eq!(faults, BTreeSet::from(Fault::ALL), "seed {seed}");
        }
    }

    #[test]
    fn the_same_seed_makes_the_same_plan_and_another_another() {
        let first = plan(1, 600.0, Control::None);
        assert_eq!(first, plan(1, 600.0, Control::None));
        assert_ne!(first, plan(2, 600.0, Control::None));
    }

    #[test]
    fn faults_follow_each_other_to_the_end_and_do_not_begin_before_the_last_is_over() {
        for (seconds, control) in [(60.0, Control::None), (3600.0, Control::None), (20.0, Control::NoFence)] {
            let strikes = plan(3, seconds, control);
            for pair in strikes.windows(2) {
                assert!(pair[0].at_s + pair[0].lasts_s < pair[1].at_s, "{pair:?}");
                assert!(pair[1].at_s - pair[0].at_s < 3.0 * APART_S, "{pair:?}");
            }
            let last = strikes.last().unwrap();
            assert!(last.at_s + last.lasts_s < seconds, "{last:?}");
        }
    }

    #[test]
    fn a_control_has_the_faults_that_bring_it_to_light() {
        let faults = |control| plan(1, 20.0, control).iter().map(|strike| strike.fault).collect::<Vec<_>>();
        assert_eq!(faults(Control::NoFence), [Fault::OwnerFrozen; 2]);
        assert_eq!(faults(Control::ReceiptBeforeCommit), [Fault::DatabaseAwayOwnerKilled; 2]);
    }

    #[test]
    fn frozen_means_longer_than_the_lease_lives() {
        for fault in [Fault::OwnerFrozen, Fault::OwnerFrozenBrokerKilled, Fault::OwnerCommitsLate] {
            assert!(fault.lasts_s().start > LEASE_S + 0.5);
        }
    }
}
