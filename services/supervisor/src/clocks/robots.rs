//! The median clock of the robots of this supervisor's fleets.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use vibrissa_protocol::Name;

use super::judge::{NEAR_US, SET_FROM_US, median};

/// Fewer robots say nothing about the time.
const ROBOTS_MIN: usize = 3;
/// A robot of a fleet counts only up to this number, so that a very large fleet costs nothing.
pub(crate) const ROBOTS_MAX: usize = 200;

/// How far the clocks of robots are ahead of the supervisor's, by fleet. Clones share their content.
#[derive(Debug, Clone, Default)]
pub(crate) struct RobotClocks(Arc<Mutex<BTreeMap<Name, Vec<i64>>>>);

impl RobotClocks {
    /// Takes in how far the robots of a fleet are ahead, in µs.
    pub(crate) fn show(&self, fleet: &Name, ahead_us: Vec<i64>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(fleet.clone(), ahead_us);
    }

    /// Forgets a fleet that is not supervised here any more.
    pub(crate) fn forget(&self, fleet: &Name) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).remove(fleet);
    }

    /// How far the robots' median is ahead at `now_us`, if enough of them agree.
    pub(crate) fn vote(&self, now_us: i64) -> Option<i64> {
        vote(self.all(now_us))
    }

    /// How far the robots' median is ahead at `now_us`, however few they are and whether they agree or not.
    pub(crate) fn any(&self, now_us: i64) -> Option<i64> {
        median(self.all(now_us))
    }

    /// How far each clock is ahead that was ever set.
    fn all(&self, now_us: i64) -> Vec<i64> {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.values().flatten().copied().filter(|one| now_us.saturating_add(*one) >= SET_FROM_US).collect()
    }
}

/// The median of clocks that were set, if most of them agree: robots that keep no time agree on nothing.
fn vote(ahead_us: Vec<i64>) -> Option<i64> {
    let count = ahead_us.len();
    let middle = median(ahead_us.clone()).filter(|_| count >= ROBOTS_MIN)?;
    let agreeing = ahead_us.iter().filter(|&&one| one.abs_diff(middle) <= NEAR_US as u64).count();
    (2 * agreeing > count).then_some(middle)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW_US: i64 = 1_795_248_000_000_000;

    #[test]
    fn most_robots_that_agree_have_a_vote_and_others_do_not() {
        let hour_us = 3_600_000_000;
        let vote = |ahead_us, now_us| {
            let clocks = RobotClocks::default();
            clocks.show(&Name::new("f").unwrap(), ahead_us);
            clocks.vote(now_us)
        };
        assert_eq!(vote(vec![10, 20, 30, hour_us], NOW_US), Some(20));
        assert_eq!(vote(vec![hour_us; 5], NOW_US), Some(hour_us));
        assert_eq!(vote(vec![10, 20], NOW_US), None, "too few");
        assert_eq!(vote(vec![0, hour_us, 2 * hour_us, 3 * hour_us], NOW_US), None, "they agree on nothing");
        // Boards without a battery begin in 1970.
        let since_1970 = 7_000_000 - NOW_US;
        assert_eq!(vote(vec![since_1970; 9], NOW_US), None);
        assert_eq!(vote([vec![since_1970; 9], vec![5; 3]].concat(), NOW_US), Some(5));
        // A supervisor in 1970 hears from its robots that it is not.
        assert_eq!(vote(vec![-since_1970; 3], 7_000_000), Some(-since_1970));
    }

    #[test]
    fn the_robots_of_all_fleets_vote_together() {
        let clocks = RobotClocks::default();
        let fleet = |name| Name::new(name).unwrap();
        assert_eq!(clocks.any(NOW_US), None);
        clocks.show(&fleet("a"), vec![1, 2, -NOW_US]);
        assert_eq!((clocks.vote(NOW_US), clocks.any(NOW_US)), (None, Some(1)));
        clocks.show(&fleet("b"), vec![3]);
        assert_eq!(clocks.vote(NOW_US), Some(2));
        clocks.forget(&fleet("b"));
        assert_eq!(clocks.vote(NOW_US), None);
    }
}
