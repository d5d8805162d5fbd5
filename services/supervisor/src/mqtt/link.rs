//! State of the two connections to the broker, the reason of an outage, and the pauses between attempts.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tracing::{info, warn};

use super::problem::Problem;

/// One of the fleet's two connections.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Receiving,
    Publishing,
}

/// State of one connection.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
enum State {
    /// No attempt has ended yet.
    #[default]
    New,
    Connected,
    /// Not connected, for this reason.
    Broken(String),
}

impl State {
    fn problem(&self) -> Option<String> {
        match self {
            Self::Connected => None,
            Self::New => Some("not connected to the MQTT broker yet".to_owned()),
            Self::Broken(why) => Some(why.clone()),
        }
    }
}

/// Shortest interval between two log messages about takeovers, or possible takeovers, of this supervisor's client ids.
const TAKEOVERS_LOGGED_EVERY: Duration = Duration::from_secs(60);

/// State of a fleet's broker connections: why its robots cannot be heard or answered. Shared by both connections.
#[derive(Debug, Clone, Default)]
pub struct LinkState(Arc<Mutex<Link>>);

#[derive(Debug)]
struct Link {
    receiving: State,
    publishing: State,
    /// The connection that the broker has closed without a reason while the other one stayed up.
    closed_alone: Option<Side>,
    /// Since when it is unproven that robots are heard.
    deaf_since: Option<Instant>,
    /// Number of takeovers not logged yet, and the time of the last log message.
    takeovers: u64,
    takeover_logged: Option<Instant>,
    /// The last outage was not logged, so its end is not logged either.
    is_quiet: bool,
    /// Problem with a file of secrets, if there is one.
    secrets: Option<String>,
}

impl Default for Link {
    fn default() -> Self {
        Self {
            receiving: State::New,
            publishing: State::New,
            closed_alone: None,
            deaf_since: Some(Instant::now()),
            takeovers: 0,
            takeover_logged: None,
            is_quiet: false,
            secrets: None,
        }
    }
}

impl Link {
    /// State of one connection, and of the other.
    fn sides(&mut self, side: Side) -> (&mut State, &State) {
        match side {
            Side::Receiving => (&mut self.receiving, &self.publishing),
            Side::Publishing => (&mut self.publishing, &self.receiving),
        }
    }

    /// Number of takeovers to log now; `None` if one was logged a short time ago.
    fn takeovers_to_log(&mut self, now: Instant) -> Option<u64> {
        self.takeovers += 1;
        let is_due = self.takeover_logged.is_none_or(|logged| now >= logged + TAKEOVERS_LOGGED_EVERY);
        is_due.then(|| {
            self.takeover_logged = Some(now);
            std::mem::take(&mut self.takeovers)
        })
    }
}

impl LinkState {
    /// The first problem, as a sentence with the host, file or user concerned, and what to do; `None` while both
    /// connections are up.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        self.problems().into_iter().next()
    }

    /// The problems of both connections.
    #[must_use]
    pub fn problems(&self) -> Vec<String> {
        let link = self.link();
        [&link.receiving, &link.publishing].into_iter().filter_map(State::problem).collect()
    }

    /// For how long robots have not been heard, and the reason; `None` while they are heard.
    #[must_use]
    pub fn deafness(&self) -> Option<(Duration, String)> {
        let link = self.link();
        let deaf_for = link.deaf_since?.elapsed();
        Some((deaf_for, link.receiving.problem().unwrap_or_default()))
    }

    /// Records that a connection is up and works. Returns true if the broker had closed it without a reason while the
    /// other one stayed up.
    pub(super) fn connected(&self, side: Side) -> bool {
        let mut link = self.link();
        let was_closed_alone = link.closed_alone.take_if(|closed| *closed == side).is_some();
        if side == Side::Receiving {
            link.deaf_since = None;
        }
        let is_quiet = std::mem::take(&mut link.is_quiet);
        let (own, _) = link.sides(side);
        if std::mem::replace(own, State::Connected) != State::Connected && !is_quiet {
            match side {
                Side::Receiving => info!("connected to the MQTT broker: robots are heard"),
                Side::Publishing => info!("connected to the MQTT broker: robots are answered"),
            }
        }
        was_closed_alone
    }

    /// Records that a connection is down or does not work. An outage is logged once, not at each attempt, and once for
    /// both connections.
    pub(super) fn broken(&self, side: Side, problem: &Problem) {
        let why = problem.to_string();
        let mut link = self.link();
        if side == Side::Receiving && link.deaf_since.is_none() {
            link.deaf_since = Some(Instant::now());
        }
        let (own, other) = link.sides(side);
        let broken = State::Broken(why.clone());
        let is_news = *own != broken && *other != broken;
        let is_alone = *own == State::Connected && *other == State::Connected;
        *own = broken;
        // If the other connection breaks too, the broker has stopped.
        if problem.is_unexplained_end() && is_alone {
            link.closed_alone = Some(side);
        } else if link.closed_alone != Some(side) {
            link.closed_alone = None;
        }
        if problem.is_takeover() || (problem.is_unexplained_end() && is_alone) {
            let takeovers = link.takeovers_to_log(Instant::now());
            link.is_quiet = takeovers.is_none();
            if let Some(takeovers) = takeovers {
                warn!(takeovers, "{why}");
            }
        } else if is_news {
            warn!("{why}");
        }
    }

    /// Sets or clears the problem with a file of secrets. Changes are logged.
    pub(super) fn secrets(&self, problem: Option<String>) {
        let mut link = self.link();
        if let Some(problem) = problem.as_deref().filter(|_| link.secrets != problem) {
            warn!(problem, "cannot read a file of secrets, using its last contents");
        }
        link.secrets = problem;
    }

    fn link(&self) -> MutexGuard<'_, Link> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Pauses between attempts to connect: doubled each time and randomised, so that supervisors that lost the same broker
/// do not reconnect at the same time.
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

    /// Starts again with the shortest pause, after a success.
    pub(super) fn reset(&mut self) {
        self.next = Self::START;
    }

    /// The next pause: between half of its nominal length and all of it.
    pub(super) fn pause(&mut self) -> Duration {
        let due = self.next;
        self.next = (due * 2).min(Self::MAX);
        // The standard library seeds its hasher at random.
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

    #[test]
    fn deafness_lasts_from_the_first_loss_to_the_next_proof_and_is_the_receivers_alone() {
        let link = LinkState::default();
        assert!(link.deafness().is_some(), "deaf before the first proof");
        link.connected(Side::Publishing);
        assert!(link.deafness().is_some());
        link.connected(Side::Receiving);
        assert_eq!(link.deafness(), None);
        let problem = |cause| Problem::new(&BrokerAddress::new("h", 1), cause);
        link.broken(Side::Publishing, &problem(Cause::Refused));
        assert_eq!(link.deafness(), None);
        link.broken(Side::Receiving, &problem(Cause::Silent));
        let (first, _) = link.deafness().unwrap();
        std::thread::sleep(Duration::from_millis(2));
        link.broken(Side::Receiving, &problem(Cause::Refused));
        let (later, why) = link.deafness().unwrap();
        assert!(later > first && why == problem(Cause::Refused).to_string(), "{why}");
    }

    #[test]
    fn a_connection_that_is_closed_alone_is_told_apart_from_a_broker_that_ends() {
        let closed = Problem::new(&BrokerAddress::new("h", 1), Cause::Closed);
        let refused = Problem::new(&BrokerAddress::new("h", 1), Cause::Refused);
        let sides = [Side::Receiving, Side::Publishing];
        for (side, other) in [(sides[0], sides[1]), (sides[1], sides[0])] {
            let link = LinkState::default();
            assert!(!link.connected(side) && !link.connected(other));
            link.broken(side, &closed);
            assert!(link.connected(side), "the other connection stayed up");
            assert!(!link.connected(side), "reported only once");
            // A failed attempt in between changes nothing.
            link.broken(side, &closed);
            link.broken(side, &refused);
            assert!(link.connected(side));
            // The broker stops.
            link.broken(side, &closed);
            link.broken(other, &closed);
            assert!(!link.connected(side) && !link.connected(other));
            // An end with a stated reason does not count.
            link.broken(side, &refused);
            assert!(!link.connected(side));
        }
    }

    #[test]
    fn takeovers_are_logged_once_a_minute_with_their_number() {
        let (mut link, now) = (Link::default(), Instant::now());
        assert_eq!(link.takeovers_to_log(now), Some(1));
        for _ in 0..200 {
            assert_eq!(link.takeovers_to_log(now + TAKEOVERS_LOGGED_EVERY / 2), None);
        }
        assert_eq!(link.takeovers_to_log(now + TAKEOVERS_LOGGED_EVERY), Some(201));
    }
}
