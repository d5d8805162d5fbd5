//! State of the two connections to the broker, the reason of an outage, and the pauses between attempts.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;
use tokio::time::Instant;
use tracing::{info, warn};
use vibrissa_host::random;

use super::address::Node;
use super::problem::Problem;
use super::refusals::Refusals;

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
    /// Connected to this node.
    Connected(Node),
    /// Not connected: the newest problem of each node, the newest of all last.
    Broken(Vec<(Node, String)>),
}

impl State {
    /// The problems, the newest first.
    fn problems(&self) -> Vec<String> {
        match self {
            Self::Connected(_) => Vec::new(),
            Self::New => vec!["not connected to the MQTT broker yet".to_owned()],
            Self::Broken(problems) => problems.iter().rev().map(|(_, why)| why.clone()).collect(),
        }
    }

    fn node(&self) -> Option<&Node> {
        match self {
            Self::Connected(node) => Some(node),
            Self::New | Self::Broken(_) => None,
        }
    }

    /// The state after this problem.
    fn broken(self, node: Node, why: String) -> Self {
        let mut problems = match self {
            Self::Broken(problems) => problems,
            Self::New | Self::Connected(_) => Vec::new(),
        };
        problems.retain(|(other, _)| *other != node);
        problems.push((node, why));
        Self::Broken(problems)
    }
}

/// The last failure of a node. The order is that of the next attempts: an old and quick failure first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Failure {
    /// The attempt, or the broken connection, took its time limit.
    is_slow: bool,
    at: Instant,
}

/// Nodes of the broker that a fleet's connections use: host and port; null while a connection is down.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NodesInUse {
    /// Node of the connection that receives from robots.
    pub receiving: Option<String>,
    /// Node of the connection that publishes to robots.
    pub publishing: Option<String>,
}

/// Shortest interval between two log messages about takeovers, or possible takeovers, of this supervisor's client ids.
const TAKEOVERS_LOGGED_EVERY: Duration = Duration::from_secs(60);

/// Limit of the remembered problems of one outage. Texts of a broker may differ each time.
const LOGGED_MAX: usize = 64;

/// A limit of a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct LowLimit {
    /// The limit, and what to do.
    pub(super) what: String,
    /// Ordinary messages exceed it.
    pub(super) is_too_low: bool,
}

/// State of a fleet's broker connections for people: why its robots cannot be heard or answered. Shared by both
/// connections.
#[derive(Debug, Clone, Default)]
pub struct BrokerLink(Arc<Mutex<Link>>);

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
    /// Problems logged since a connection was up. Attempts at several nodes alternate between theirs.
    logged: BTreeSet<String>,
    /// Last failures of nodes that have not worked since.
    failed: BTreeMap<Node, Failure>,
    /// Limits of the nodes that are too low, and whether a fleet cannot work with them.
    limits: BTreeMap<Node, LowLimit>,
    /// Topics on which the broker has refused the last publication.
    refusals: Refusals,
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
            logged: BTreeSet::new(),
            failed: BTreeMap::new(),
            limits: BTreeMap::new(),
            refusals: Refusals::default(),
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

impl BrokerLink {
    /// The first problem, as a sentence with the host, file or user concerned, and what to do; `None` while both
    /// connections are up.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        self.problems().into_iter().next()
    }

    /// The problems of both connections, the newest of each first.
    #[must_use]
    pub fn problems(&self) -> Vec<String> {
        let link = self.link();
        let states = [&link.receiving, &link.publishing];
        let limits = link
            .limits
            .iter()
            .filter(|(node, limit)| limit.is_too_low && states.iter().any(|state| state.node() == Some(*node)));
        let limits = limits.map(|(node, limit)| format!("MQTT broker {node}: {}", limit.what));
        states.into_iter().flat_map(State::problems).chain(link.refusals.texts(Instant::now())).chain(limits).collect()
    }

    /// Notes that the broker has refused a publication on a topic. Only the first refusal is logged.
    pub(super) fn refused(&self, topic: &str, problem: &Problem) {
        let why = problem.to_string();
        if self.link().refusals.refused(topic, &why, Instant::now()) {
            warn!("{why}");
        }
    }

    /// Notes that the broker has accepted a publication on a topic.
    pub(super) fn accepted(&self, topic: &str) {
        if self.link().refusals.accepted(topic) {
            info!(topic, "the MQTT broker accepts publications on this topic again");
        }
    }

    /// Whether the broker has refused the last publication on a topic.
    pub(super) fn has_refused(&self, topic: &str) -> bool {
        self.link().refusals.has(topic)
    }

    /// Nodes that the connections use.
    #[must_use]
    pub fn nodes(&self) -> NodesInUse {
        let link = self.link();
        let shown = |state: &State| state.node().map(ToString::to_string);
        NodesInUse { receiving: shown(&link.receiving), publishing: shown(&link.publishing) }
    }

    /// Notes that a connection to this node has failed; `is_slow` if that took its time limit.
    pub(super) fn node_failed(&self, node: Node, is_slow: bool) {
        self.link().failed.insert(node, Failure { is_slow, at: Instant::now() });
    }

    /// The last failure of the node; `None` if it has worked since, or was not tried yet.
    pub(super) fn failure_of(&self, node: &Node) -> Option<Failure> {
        self.link().failed.get(node).copied()
    }

    /// For how long robots have not been heard, and the reason; `None` while they are heard.
    #[must_use]
    pub fn deafness(&self) -> Option<(Duration, String)> {
        let link = self.link();
        let deaf_for = link.deaf_since?.elapsed();
        Some((deaf_for, link.receiving.problems().into_iter().next().unwrap_or_default()))
    }

    /// Records that a connection to this node is up and works. Returns true if the broker had closed it without a reason
    /// while the other one stayed up.
    pub(super) fn connected(&self, side: Side, node: &Node) -> bool {
        let mut link = self.link();
        link.failed.remove(node);
        let was_closed_alone = link.closed_alone.take_if(|closed| *closed == side).is_some();
        let deaf_since = link.deaf_since.take_if(|_| side == Side::Receiving);
        let deaf_s = deaf_since.map(|since| since.elapsed().as_secs());
        let is_quiet = std::mem::take(&mut link.is_quiet);
        let (own, _) = link.sides(side);
        let connected = State::Connected(node.clone());
        if *own != connected {
            *own = connected;
            link.logged.clear();
            match side {
                _ if is_quiet => {}
                Side::Receiving => info!(%node, deaf_s, "connected to the MQTT broker: receiving"),
                Side::Publishing => info!(%node, "connected to the MQTT broker: publishing"),
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
        let is_alone = own.node().is_some() && other.node().is_some();
        *own = std::mem::take(own).broken(problem.node(), why.clone());
        if link.logged.len() >= LOGGED_MAX {
            link.logged.clear();
        }
        let is_news = link.logged.insert(why.clone());
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

    /// Notes a limit of this node that is too low; `None` if there is none. Changes are logged.
    pub(super) fn limited(&self, node: &Node, limit: Option<LowLimit>) {
        let mut link = self.link();
        let before = match &limit {
            Some(limit) => link.limits.insert(node.clone(), limit.clone()),
            None => link.limits.remove(node),
        };
        if let Some(LowLimit { what, .. }) = limit.filter(|limit| before.as_ref() != Some(limit)) {
            warn!("MQTT broker {node}: {what}");
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
        due.mul_f64(0.5 + random::fraction() / 2.0)
    }
}

#[cfg(test)]
mod tests;
