//! Whether leases and members are alive, as a competitor sees it: by its own monotonic clock.
//!
//! An owner renews its lease's row several times per time to live. Each renewal is a change of the row. A row that has
//! not changed for a time to live is free, whatever the database's wall clock says: that clock may be stepped. A step
//! back would leave the fleet without an owner, and a step ahead would take it from a living one.
//!
//! The database's clock counts only at the first reading, for at most a time to live: so whoever has just started does not
//! wait for a lease that has expired long ago. It does not count for holds of webhooks, because no epoch fences their requests.

use std::collections::BTreeMap;
use std::time::Duration;

use tokio::time::Instant;
use vibrissa_protocol::Name;

/// The columns of a lease's row that change with each renewal. A competitor acquires the lease only if the row is still
/// the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Renewal {
    /// Epoch of the lease.
    pub epoch: i64,
    /// Number of its committed transactions.
    pub commits: i64,
    /// End of the lease, µs since 1970 UTC by the database's clock; 0 if it is released.
    pub expires_us: i64,
}

/// A row of a lease or of a member, as read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading<T> {
    pub(super) renewal: T,
    /// Time until it expires by the database's clock, in µs; at most 0 if it has expired.
    pub(super) left_us: i64,
    pub(super) time_to_live: Duration,
}

/// Whether a supervisor may take a lease.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Claim {
    /// Nothing was read of it yet: the database's clock decides.
    Unknown,
    /// It is free as long as its row is this one.
    Free(Renewal),
    /// Its owner is alive.
    Held,
}

impl Claim {
    /// The row that must not have changed; `None` if the database's clock decides.
    pub(super) fn seen(self) -> Option<Renewal> {
        match self {
            Self::Unknown => None,
            Self::Free(seen) => Some(seen),
            // No row has this epoch.
            Self::Held => Some(Renewal { epoch: -1, commits: 0, expires_us: 0 }),
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Watched<T> {
    renewal: T,
    /// From then on it is free, unless it changes.
    until: Instant,
}

impl<T: PartialEq + Copy> Watched<T> {
    fn first(reading: &Reading<T>, now: Instant) -> Self {
        let left = Duration::from_micros(u64::try_from(reading.left_us).unwrap_or_default());
        Self { renewal: reading.renewal, until: now + left.min(reading.time_to_live) }
    }

    fn again(&mut self, reading: &Reading<T>, now: Instant) {
        if self.renewal != reading.renewal {
            *self = Self { renewal: reading.renewal, until: now + reading.time_to_live };
        }
    }
}

/// The leases and members that a supervisor watches.
#[derive(Debug, Default)]
pub(super) struct LeaseWatch {
    leases: BTreeMap<Name, Watched<Renewal>>,
    members: BTreeMap<String, Watched<i64>>,
    /// Holds of webhooks.
    holds: BTreeMap<i64, Watched<i64>>,
}

impl LeaseWatch {
    /// Takes a lease's row in that was read by `now`. Returns the time until it is free; zero if it is.
    pub(super) fn lease(&mut self, fleet: &Name, row: &Reading<Renewal>, now: Instant) -> Duration {
        let watched = self.leases.entry(fleet.clone()).or_insert_with(|| Watched::first(row, now));
        watched.again(row, now);
        if row.renewal.expires_us == 0 {
            // It was released, or nobody had it.
            watched.until = now;
        }
        watched.until.saturating_duration_since(now)
    }

    /// Takes a member's row in that was read by `now`: until when it is alive by its own word. Returns whether it is.
    pub(super) fn is_alive(&mut self, supervisor: &str, row: &Reading<i64>, now: Instant) -> bool {
        let watched = self.members.entry(supervisor.to_owned()).or_insert_with(|| Watched::first(row, now));
        watched.again(row, now);
        now < watched.until
    }

    /// Takes the hold of a webhook in that was read by `now`: until when it is held. Returns whether it has lapsed.
    pub(super) fn has_lapsed(&mut self, webhook_id: i64, row: &Reading<i64>, now: Instant) -> bool {
        let watched = self.holds.entry(webhook_id).or_insert_with(|| Watched::first(row, now));
        watched.again(row, now);
        now >= watched.until
    }

    /// The hold of a webhook that has lapsed by `now`, as it was last read; -1, which no row has, if none has.
    pub(super) fn lapsed_hold(&self, webhook_id: i64, now: Instant) -> i64 {
        self.holds.get(&webhook_id).filter(|watched| now >= watched.until).map_or(-1, |watched| watched.renewal)
    }

    /// Forgets holds of webhooks that wait for nobody.
    pub(super) fn retain_holds(&mut self, exists: impl Fn(i64) -> bool) {
        self.holds.retain(|webhook_id, _| exists(*webhook_id));
    }

    /// Forgets members whose rows are gone.
    pub(super) fn retain_members(&mut self, exists: impl Fn(&str) -> bool) {
        self.members.retain(|supervisor, _| exists(supervisor));
    }

    /// Whether this supervisor may take a lease at `now`.
    pub(super) fn claim(&self, fleet: &Name, now: Instant) -> Claim {
        match self.leases.get(fleet) {
            None => Claim::Unknown,
            Some(watched) if now >= watched.until => Claim::Free(watched.renewal),
            Some(_) => Claim::Held,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TIME_TO_LIVE: Duration = Duration::from_secs(2);
    /// Between two readings of a competitor.
    const TURN: Duration = Duration::from_millis(250);

    /// An owner and a database whose clock can be stepped.
    struct Cluster {
        now: Instant,
        /// The database's clock.
        database_us: i64,
        row: Renewal,
        watch: LeaseWatch,
        fleet: Name,
    }

    impl Cluster {
        fn new() -> Self {
            let row = Renewal { epoch: 1, commits: 0, expires_us: 0 };
            let fleet = Name::new("f").unwrap();
            let mut cluster =
                Self { now: Instant::now(), database_us: 1 << 50, row, watch: LeaseWatch::default(), fleet };
            cluster.renew();
            cluster
        }

        fn renew(&mut self) {
            self.row.commits += 1;
            self.row.expires_us = self.database_us + TIME_TO_LIVE.as_micros() as i64;
        }

        fn step_database(&mut self, seconds: i64) {
            self.database_us += seconds * 1_000_000;
        }

        /// One turn later: reads the row, and returns whether the lease is free.
        fn turn(&mut self) -> bool {
            self.now += TURN;
            self.database_us += TURN.as_micros() as i64;
            let left_us = self.row.expires_us - self.database_us;
            let reading = Reading { renewal: self.row, left_us, time_to_live: TIME_TO_LIVE };
            let left = self.watch.lease(&self.fleet, &reading, self.now);
            let is_free = left.is_zero();
            let expected = if is_free { Claim::Free(self.row) } else { Claim::Held };
            assert_eq!(self.watch.claim(&self.fleet, self.now), expected);
            is_free
        }

        /// Time after which the lease of an owner that does not renew any more is free.
        fn free_after(&mut self) -> Duration {
            let before = self.now;
            while !self.turn() {
                assert!(self.now - before < Duration::from_secs(600));
            }
            self.now - before
        }
    }

    #[test]
    fn regress_a_dead_owner_is_replaced_although_the_databases_clock_went_back() {
        for step_s in [0, -1, -120, -3_600, -1_700_000_000, 1, 120] {
            for turns_between in 0..6 {
                let mut cluster = Cluster::new();
                for _ in 0..20 {
                    cluster.renew();
                    assert!(!cluster.turn());
                }
                cluster.renew();
                for _ in 0..turns_between {
                    assert!(!cluster.turn());
                }
                cluster.step_database(step_s);
                let left = TIME_TO_LIVE.saturating_sub(TURN * turns_between);
                let after = cluster.free_after();
                assert!(after <= left + TURN, "{step_s} s after {turns_between} turns: {after:?}");
                assert!(after >= left, "{step_s} s after {turns_between} turns: {after:?}");
            }
        }
    }

    #[test]
    fn regress_a_living_owner_keeps_its_lease_although_the_databases_clock_is_stepped() {
        let mut cluster = Cluster::new();
        for turn in 0..400_i64 {
            let step_s = [3_600, -120, 5, -3_600, 1_000_000][turn as usize % 5];
            // Before and after the renewal.
            if turn % 7 == 0 {
                cluster.step_database(step_s);
            }
            // It renews in the fastest and in the slowest allowed manner.
            if turn % [1, 4][turn as usize / 200] == 0 {
                cluster.renew();
            }
            if turn % 11 == 0 {
                cluster.step_database(-step_s);
            }
            let is_first = turn == 0;
            assert!(!cluster.turn() || is_first, "turn {turn}");
        }
    }

    #[test]
    fn a_competitor_that_has_just_started_trusts_the_databases_clock_for_at_most_a_time_to_live() {
        let mut cluster = Cluster::new();
        cluster.step_database(60);
        assert_eq!(cluster.free_after(), TURN, "it has expired long ago");
        let mut cluster = Cluster::new();
        cluster.step_database(-60);
        assert!(cluster.free_after() <= TIME_TO_LIVE + TURN);
        assert_eq!(LeaseWatch::default().claim(&cluster.fleet, cluster.now), Claim::Unknown);
    }

    #[test]
    fn a_released_lease_is_free_at_once() {
        let mut cluster = Cluster::new();
        assert!(!cluster.turn());
        cluster.row.expires_us = 0;
        assert!(cluster.turn());
    }

    #[test]
    fn regress_a_hold_lapses_when_it_stands_still_and_not_when_the_databases_clock_says_so() {
        let (mut watch, mut now, time_to_live) = (LeaseWatch::default(), Instant::now(), TIME_TO_LIVE);
        let reading = |until_us, left_us| Reading { renewal: until_us, left_us, time_to_live };
        for until_us in 0..20 {
            now += TURN;
            let left_us = if until_us == 0 { 1_000_000 } else { -1 };
            assert!(
                !watch.has_lapsed(7, &reading(until_us, left_us), now),
                "it is renewed, the clock was stepped ahead"
            );
        }
        for turn in 1..=20 {
            now += TURN;
            let has_lapsed = watch.has_lapsed(7, &reading(19, 3_600_000_000), now);
            assert_eq!(has_lapsed, TURN * turn >= TIME_TO_LIVE, "turn {turn}");
        }
        assert_eq!(watch.lapsed_hold(7, now), 19);
        assert_eq!(watch.lapsed_hold(7, now.checked_sub(TURN * 19).unwrap()), -1, "it was held");
        watch.retain_holds(|_| false);
        assert_eq!(watch.lapsed_hold(7, now), -1);
    }

    #[test]
    fn regress_a_dead_member_is_not_taken_for_present_although_the_databases_clock_went_back() {
        let mut watch = LeaseWatch::default();
        let (mut now, time_to_live) = (Instant::now(), TIME_TO_LIVE);
        let reading = |alive_us, left_us| Reading { renewal: alive_us, left_us, time_to_live };
        for alive_us in 0..10 {
            now += TURN;
            assert!(watch.is_alive("a", &reading(alive_us, 1_900_000), now));
        }
        for turn in 1..=20 {
            now += TURN;
            let is_alive = watch.is_alive("a", &reading(9, 120_000_000), now);
            assert_eq!(is_alive, TURN * turn < TIME_TO_LIVE, "turn {turn}");
        }
        watch.retain_members(|_| false);
        assert!(watch.members.is_empty());
    }
}
