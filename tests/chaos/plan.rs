//! Draws the faults of a run and their times from a seed.

use std::fmt;

use clap::ValueEnum;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Serialize, Serializer};

/// Time in seconds without faults at the start, in which robots learn their whiskers.
const CALM_BEFORE_S: f64 = 5.0;
/// Time in seconds without faults at the end, for the last fault to end.
const CALM_AFTER_S: f64 = 3.0;
/// Seconds between two faults: the longest fault, and some time to resume work.
const APART_S: f64 = 4.5;
/// Largest random delay of a fault in seconds.
const JITTER_S: f64 = 0.4;

/// A time in seconds that is longer than a supervisor's lease.
pub const LEASE_S: f64 = 2.0;

/// A fault. The owner is the supervisor that owns the fleet when the fault strikes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Fault {
    /// SIGKILL to the owner, and the broker forgets all retained messages; the owner is started again later.
    OwnerKilled,
    /// SIGTERM to the owner; it is started again later.
    OwnerTerminated,
    /// SIGSTOP to the owner until after its lease has expired, then SIGCONT.
    OwnerFrozen,
    /// SIGKILL to the broker; it is started again on the same port.
    BrokerKilled,
    /// SIGKILL to every process of PostgreSQL; it is started again on the same port.
    DatabaseKilled,
    /// Links between robots and broker are cut, or stalled, or first stalled and then cut.
    RobotLinks,
    /// Links between supervisors and broker fail in the same ways.
    BrokerLinks,
    /// Links between supervisors and PostgreSQL fail in the same ways.
    DatabaseLinks,
    /// The owner's link to PostgreSQL is stalled until after its lease has expired; then its pending writes arrive.
    OwnerCommitsLate,
    /// PostgreSQL is killed and, while it is down, the owner as well.
    DatabaseAwayOwnerKilled,
    /// The owner is frozen until after its lease has expired; meanwhile the broker is killed and started again.
    OwnerFrozenBrokerKilled,
    /// The clock of the owner's host is stepped by an hour, or to 1970, and later set right.
    HostClockStepped,
    /// The database's clock goes back by two minutes and the owner is killed. It is started again with a clock that is two
    /// minutes behind, which stays so until its host's clock is stepped.
    DatabaseClockBackOwnerKilled,
}

impl Fault {
    /// All faults, one of each.
    pub const ALL: [Self; 13] = [
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
        Self::HostClockStepped,
        Self::DatabaseClockBackOwnerKilled,
    ];

    /// Name of the fault in outputs.
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
            Self::HostClockStepped => "host's clock stepped",
            Self::DatabaseClockBackOwnerKilled => "database's clock back, owner killed",
        }
    }

    /// Range of its duration in seconds, from the first action to the last repair.
    fn lasts_s(self) -> std::ops::Range<f64> {
        match self {
            Self::OwnerKilled | Self::HostClockStepped | Self::DatabaseClockBackOwnerKilled => 2.5..3.5,
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

/// Failure mode of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Manner {
    /// Its connections are closed.
    Cut,
    /// No data passes for a while; then all waiting data passes.
    Stall,
    /// No data passes for a while; then its connections are closed and waiting data is lost.
    StallThenCut,
}

/// One fault at its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strike {
    /// Seconds after the start.
    pub at_s: f64,
    /// Kind of the fault.
    pub fault: Fault,
    /// Duration in seconds.
    pub lasts_s: f64,
    /// For faults of links: their failure mode.
    pub manner: Manner,
    /// For faults of links: one bit per link that may be struck, at least one bit set. For steps of a clock: which.
    pub victims: u8,
}

/// A defect introduced on purpose, to show that the harness detects it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Control {
    /// Nothing is changed.
    None,
    /// Supervisors receipt contacts before they are committed.
    ReceiptBeforeCommit,
    /// Supervisors write even if they do not own the fleet.
    NoFence,
    /// Robots apply any setpoint, even late and outdated ones.
    RobotIgnoresEpochs,
    /// Robots send each message once and do not keep it.
    NoRobotBuffer,
    /// PostgreSQL's commits do not wait for the standby. Only with `--cluster`.
    Asynchronous,
    /// Supervisors commit the position in Kafka before the effects of its records. Only with `--kafka`.
    OffsetBeforeState,
}

impl Control {
    /// The faults that reveal the defect; each round contains all of them.
    fn faults(self) -> &'static [Fault] {
        match self {
            Self::None | Self::Asynchronous | Self::OffsetBeforeState => &Fault::ALL,
            Self::ReceiptBeforeCommit => &[Fault::DatabaseAwayOwnerKilled],
            Self::NoFence => &[Fault::OwnerFrozen],
            Self::RobotIgnoresEpochs => &[Fault::OwnerTerminated],
            Self::NoRobotBuffer => &[Fault::OwnerKilled, Fault::BrokerKilled],
        }
    }

    /// The environment variable of a supervisor with this defect.
    pub fn environment(self) -> Option<(String, String)> {
        let fault = match self {
            Self::ReceiptBeforeCommit => "receipt_before_commit",
            Self::NoFence => "no_fence",
            Self::OffsetBeforeState => "offset_before_state",
            Self::None | Self::RobotIgnoresEpochs | Self::NoRobotBuffer | Self::Asynchronous => return None,
        };
        Some(("VIBRISSA_TEST_FAULT".to_owned(), fault.to_owned()))
    }

    /// Length in seconds of the shortest run: without a control it has some of the faults, with one each of its own.
    pub fn shortest_s(self) -> f64 {
        let faults = if self == Self::None { 1 } else { self.faults().len() };
        CALM_BEFORE_S + CALM_AFTER_S + APART_S * faults as f64
    }
}

/// The faults of a run in order: complete rounds of all faults, each round shuffled. A run that is too short for a round has as
/// many faults of one as fit.
pub fn plan(seed: u64, seconds: f64, control: Control) -> Vec<Strike> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let stretch_s = seconds - CALM_BEFORE_S - CALM_AFTER_S;
    let faults = control.faults();
    let fitting = ((stretch_s / APART_S) as usize).max(1);
    let rounds = (fitting / faults.len()).max(1);
    let count = (rounds * faults.len()).min(fitting);
    let apart_s = stretch_s / count as f64;
    let mut strikes = Vec::new();
    for _ in 0..rounds {
        let mut round = faults.to_vec();
        round.shuffle(&mut random);
        round.truncate(count);
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
    fn every_fault_strikes_in_a_short_run_whatever_the_seed() {
        for seed in 0..200 {
            let faults: BTreeSet<Fault> = plan(seed, 67.0, Control::None).iter().map(|strike| strike.fault).collect();
            assert_eq!(faults, BTreeSet::from(Fault::ALL), "seed {seed}");
        }
    }

    #[test]
    fn a_run_that_is_too_short_for_a_round_has_as_many_faults_as_fit() {
        for (seconds, count) in [(13.0, 1), (45.0, 8), (66.0, 12), (67.0, 13), (124.0, 13), (126.0, 26)] {
            assert_eq!(plan(1, seconds, Control::None).len(), count, "{seconds} s");
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
        for (seconds, control) in
            [(45.0, Control::None), (67.0, Control::None), (3600.0, Control::None), (20.0, Control::NoFence)]
        {
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
