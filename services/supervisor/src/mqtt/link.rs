//! Whether there is a connection, why not, and when to try again.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tracing::{info, warn};

use super::problem::Problem;

/// One of the two connections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Receiving,
    Publishing,
}

/// Whether one connection stands.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
enum State {
    /// Not tried to the end yet.
    #[default]
    New,
    Connected,
    /// For this reason.
    Broken(String),
}

/// Why a fleet's robots cannot be heard or answered; shared by the two connections and whoever asks.
#[derive(Debug, Clone, Default)]
pub struct LinkState(Arc<Mutex<[State; 2]>>);

impl LinkState {
    /// One sentence for people: what is wrong, with which host, file or user, and what to do; none while
    /// both connections stand.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        let states = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        states.iter().find_map(|state| match state {
            State::Connected => None,
            State::New => Some("not connected to the MQTT broker yet".to_owned()),
            State::Broken(why) => Some(why.clone()),
        })
    }

    /// A connection stands, and does what it is for.
    pub(super) fn connected(&self, side: Side) {
        if self.change(side, State::Connected).is_some() {
            match side {
                Side::Receiving => info!("connected to the MQTT broker: robots are heard"),
                Side::Publishing => info!("connected to the MQTT broker: robots are answered"),
            }
        }
    }

    /// There is none, or it does not do what it is for. Said once in the log, not at each attempt, and once
    /// for both connections.
    pub(super) fn broken(&self, side: Side, problem: &Problem) {
        let why = problem.to_string();
        let Some(other) = self.change(side, State::Broken(why.clone())) else { return };
        if other != State::Broken(why.clone()) {
            warn!("{why}");
        }
    }

    /// The other connection's state, if this one's has changed.
    fn change(&self, side: Side, to: State) -> Option<State> {
        let mut states = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let [receiving, publishing] = &mut *states;
        let (own, other) = match side {
            Side::Receiving => (receiving, publishing),
            Side::Publishing => (publishing, receiving),
        };
        let is_news = *own != to;
        *own = to;
        is_news.then(|| other.clone())
    }
}

/// Pauses between attempts: doubled each time, never quite equal, so that supervisors which lost the same
/// broker do not come back all at once.
#[derive(Debug)]
pub(super) struct Backoff {
    next: Duration,
}

impl Backoff {
    const START: Duration = Duration::from_millis(250);
    const MAX: Duration = Duration::from_secs(5);

    pub(super) fn new() -> Self {
        Self { next: Self::START }
    }

    /// What was tried has worked.
    pub(super) fn reset(&mut self) {
        self.next = Self::START;
    }

    /// Between half of what is due and all of it.
    pub(super) fn pause(&mut self) -> Duration {
        let due = self.next;
        self.next = (due * 2).min(Self::MAX);
        // The standard library's hasher starts at random.
        let random = RandomState::new().build_hasher().finish() % 1024;
        due / 2 + due / 2 * u32::try_from(random).unwrap_or(0) / 1024
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mqtt::address::BrokerAddress;
    use crate::mqtt::problem::Cause;

    #[test]
    fn pauses_double_from_a_quarter_of_a_second_to_five() {
        let mut backoff = Backoff::new();
        for due_ms in [250, 500, 1000, 2000, 4000, 5000, 5000] {
            let pause = backoff.pause();
            let due = Duration::from_millis(due_ms);
            assert!((due / 2..=due).contains(&pause), "{pause:?} of {due:?}");
        }
        backoff.reset();
        assert!(backoff.pause() <= Backoff::START);
    }

    #[test]
    fn pauses_differ() {
        let pauses: std::collections::BTreeSet<_> = (0..50).map(|_| Backoff::new().pause()).collect();
        assert!(pauses.len() > 10, "{pauses:?}");
    }

    #[test]
    fn a_link_stands_when_both_connections_do() {
        let link = LinkState::default();
        assert_eq!(link.problem().as_deref(), Some("not connected to the MQTT broker yet"));
        link.connected(Side::Receiving);
        assert!(link.problem().is_some());
        link.connected(Side::Publishing);
        assert_eq!(link.problem(), None);
        let problem = Problem::new(&BrokerAddress::new("h", 1), Cause::Refused);
        link.broken(Side::Publishing, &problem);
        assert_eq!(link.problem(), Some(problem.to_string()));
        link.connected(Side::Publishing);
        assert_eq!(link.problem(), None);
    }
}
