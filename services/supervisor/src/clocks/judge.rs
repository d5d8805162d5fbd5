//! A vote about the right clock, by pure functions.
//!
//! The voters are this supervisor, the database, the median of the robots, and each other supervisor. Clocks that differ by
//! at most [`NEAR_US`] agree.

/// Clocks further apart than this disagree, in microseconds.
pub(crate) const NEAR_US: i64 = 1_000_000;

/// A clock before this time (2020-01-01 UTC, in µs since 1970) was never set.
pub(crate) const SET_FROM_US: i64 = 1_577_836_800_000_000;

/// A clock besides this supervisor's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Source {
    /// The wall clock of this supervisor's host. It does not vote: this supervisor's time began with it.
    Host,
    /// The clock of the database's server.
    Database,
    /// The median of the robots.
    Robots,
    /// The median of the other supervisors.
    Supervisors,
}

impl Source {
    pub(crate) const ALL: [Self; 4] = [Self::Host, Self::Database, Self::Robots, Self::Supervisors];

    /// The source as a label of metrics.
    pub(crate) const fn label(self) -> &'static str {
        match self {
            Self::Host => "host",
            Self::Database => "database",
            Self::Robots => "robots",
            Self::Supervisors => "supervisors",
        }
    }

    /// The source in a sentence.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Host => "the host's clock",
            Self::Database => "the database's clock",
            Self::Robots => "the median clock of the robots",
            Self::Supervisors => "the median clock of the other supervisors",
        }
    }
}

/// How far other clocks are ahead of this supervisor's, in microseconds.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Readings {
    pub(crate) host: i64,
    pub(crate) database: Option<i64>,
    pub(crate) robots: Option<i64>,
    pub(crate) supervisors: Vec<i64>,
}

/// How this supervisor's clock stands among the others.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Standing {
    /// No other group of clocks is as large as the one that it belongs to.
    #[default]
    Agrees,
    /// Another group is as large: nobody knows which is right.
    Doubtful,
    /// Another group is larger.
    Wrong,
}

impl Readings {
    /// How far a clock is ahead, if it is known.
    pub(crate) fn of(&self, source: Source) -> Option<i64> {
        match source {
            Source::Host => Some(self.host),
            Source::Database => self.database,
            Source::Robots => self.robots,
            Source::Supervisors => median(self.supervisors.clone()),
        }
    }

    /// The votes of the others.
    fn votes(&self) -> impl Iterator<Item = i64> + Clone {
        self.database.into_iter().chain(self.robots).chain(self.supervisors.iter().copied())
    }

    fn near(&self, at_us: i64) -> usize {
        self.votes().filter(|&vote| is_near(vote, at_us)).count()
    }

    pub(crate) fn standing(&self) -> Standing {
        let own = self.near(0) + 1;
        let against = self.votes().filter(|&vote| !is_near(vote, 0)).map(|vote| self.near(vote)).max();
        match against.map(|against| against.cmp(&own)) {
            Some(std::cmp::Ordering::Greater) => Standing::Wrong,
            Some(std::cmp::Ordering::Equal) => Standing::Doubtful,
            Some(std::cmp::Ordering::Less) | None => Standing::Agrees,
        }
    }

    /// Whether the host's clock was stepped away from this supervisor's time.
    pub(crate) fn is_host_off(&self) -> bool {
        !is_near(self.host, 0)
    }

    /// Whether this supervisor, whose time is `now_us`, must follow the host's clock: more voters confirm the step than
    /// contradict it, or there is nobody to ask. It does not follow a clock that was reset to 1970: records of that time
    /// would be deleted as old.
    pub(crate) fn follows_host(&self, now_us: i64) -> bool {
        let (with_host, with_us) = (self.near(self.host), self.near(0));
        let is_confirmed = with_host > with_us || with_host == 0 && with_us == 0;
        self.is_host_off() && is_confirmed && now_us.saturating_add(self.host) >= SET_FROM_US
    }
}

fn is_near(one: i64, other: i64) -> bool {
    one.abs_diff(other) <= NEAR_US as u64
}

/// The lower one of the two in the middle of an even number.
pub(crate) fn median(mut values: Vec<i64>) -> Option<i64> {
    values.sort_unstable();
    values.get(values.len().saturating_sub(1) / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND_US: i64 = 1_000_000;
    const HOUR_US: i64 = 3_600 * SECOND_US;
    const NOW_US: i64 = 1_795_248_000 * SECOND_US;
    const TO_1970_US: i64 = -NOW_US;

    fn readings(host: i64, database: Option<i64>, robots: Option<i64>, supervisors: &[i64]) -> Readings {
        Readings { host, database, robots, supervisors: supervisors.to_vec() }
    }

    #[test]
    fn a_supervisor_that_most_contradict_is_wrong_and_the_others_are_not() {
        for off_us in [2 * SECOND_US, -120 * SECOND_US, HOUR_US, TO_1970_US] {
            // Seen by the one that is off, and by the others.
            let seen = readings(0, Some(off_us), Some(off_us), &[off_us]);
            assert_eq!(seen.standing(), Standing::Wrong);
            let seen = readings(0, Some(0), Some(0), &[-off_us]);
            assert_eq!(seen.standing(), Standing::Agrees);
            // The database alone is off.
            let seen = readings(0, Some(off_us), Some(0), &[0]);
            assert_eq!(seen.standing(), Standing::Agrees);
            // One against one.
            for seen in [readings(0, Some(off_us), None, &[]), readings(0, None, Some(off_us), &[])] {
                assert_eq!(seen.standing(), Standing::Doubtful);
            }
        }
        assert_eq!(Readings::default().standing(), Standing::Agrees);
        let near_us = NEAR_US - 1;
        assert_eq!(readings(0, Some(near_us), Some(-near_us), &[near_us]).standing(), Standing::Agrees);
    }

    #[test]
    fn others_that_disagree_among_themselves_outvote_nobody() {
        let seen = readings(0, Some(HOUR_US), Some(-HOUR_US), &[2 * HOUR_US]);
        assert_eq!(seen.standing(), Standing::Doubtful);
        let seen = readings(0, Some(0), Some(-HOUR_US), &[2 * HOUR_US]);
        assert_eq!(seen.standing(), Standing::Agrees);
    }

    #[test]
    fn a_step_of_the_hosts_clock_is_followed_only_if_others_confirm_it_or_nobody_is_there() {
        for step_us in [HOUR_US, -HOUR_US, 24 * HOUR_US] {
            assert!(readings(step_us, None, None, &[]).follows_host(NOW_US), "there is nobody to ask");
            assert!(!readings(step_us, None, Some(0), &[]).follows_host(NOW_US));
            assert!(!readings(step_us, Some(0), Some(0), &[0, 0]).follows_host(NOW_US));
            // The database shares the host.
            assert!(!readings(step_us, Some(step_us), Some(0), &[]).follows_host(NOW_US));
            // The host is set right.
            assert!(readings(step_us, Some(step_us), Some(step_us), &[]).follows_host(NOW_US));
            assert!(readings(step_us, Some(0), Some(step_us), &[step_us]).follows_host(NOW_US));
            // Robots that know no time are no reason to keep a wrong one.
            assert!(readings(step_us, None, Some(5 * step_us), &[]).follows_host(NOW_US));
        }
        assert!(!readings(NEAR_US, None, None, &[]).follows_host(NOW_US));
        // A clock that is reset to 1970 is not followed, and one that is set later is.
        assert!(!readings(TO_1970_US, None, None, &[]).follows_host(NOW_US));
        assert!(readings(-TO_1970_US, None, None, &[]).follows_host(5 * SECOND_US));
    }

    #[test]
    fn brute_force_exactly_those_outside_of_the_largest_groups_are_wrong() {
        // Three supervisors and a database, each with one of three clocks: all compute from the same offsets.
        let clocks = [0, HOUR_US, -HOUR_US];
        for code in 0..81_usize {
            let at: Vec<i64> = (0..4).map(|place| clocks[code / 3_usize.pow(place) % 3]).collect();
            let standing = |own: usize| {
                let others: Vec<i64> = (0..3).filter(|&one| one != own).map(|one| at[one] - at[own]).collect();
                readings(0, Some(at[3] - at[own]), None, &others).standing()
            };
            let all: Vec<Standing> = (0..3).map(standing).collect();
            for own in 0..3 {
                let size = |clock: i64| at.iter().filter(|&&one| one == clock).count();
                let largest = clocks.iter().map(|&clock| size(clock)).max().unwrap();
                assert_eq!(all[own] == Standing::Wrong, size(at[own]) < largest, "{at:?} {all:?}");
            }
        }
    }

    #[test]
    fn medians() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![5]), Some(5));
        assert_eq!(median(vec![9, 1]), Some(1));
        assert_eq!(median(vec![9, 1, 3]), Some(3));
    }
}
