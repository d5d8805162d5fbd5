//! The engine's output: messages on their way to a transport.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use prometheus::Histogram;
use tokio::time::Instant;
use vibrissa_core::units::Micros;
use vibrissa_protocol::{self as protocol, Name, RobotTopic, encode};

use vibrissa_edge::clock::wall_clock;

/// A message to a robot. It leaves the engine as data, and the transport encodes it.
#[derive(Debug, Clone)]
pub enum ToRobot {
    /// A pressure to apply.
    Setpoint(Box<protocol::Setpoint>),
    /// States which contacts are committed.
    Receipt(protocol::Receipt),
    /// Asks for something.
    Request(protocol::Request),
    /// The lengths of the whiskers.
    Estimate(protocol::Estimate),
    /// Facts for the maintenance of its whiskers, for other tools.
    Maintenance(protocol::Maintenance),
    /// Clears the retained message of this topic.
    Cleared(RobotTopic),
}

impl ToRobot {
    /// The topic of the contract.
    #[must_use]
    pub fn topic(&self) -> RobotTopic {
        match self {
            Self::Setpoint(_) => RobotTopic::Setpoint,
            Self::Receipt(_) => RobotTopic::Receipt,
            Self::Request(_) => RobotTopic::Request,
            Self::Estimate(_) => RobotTopic::Estimate,
            Self::Maintenance(_) => RobotTopic::Maintenance,
            Self::Cleared(topic) => *topic,
        }
    }

    /// The message as JSON, as the contract has it.
    #[must_use]
    pub fn encoded(&self) -> Vec<u8> {
        match self {
            Self::Setpoint(setpoint) => encode(setpoint),
            Self::Receipt(receipt) => encode(receipt),
            Self::Request(request) => encode(request),
            Self::Estimate(estimate) => encode(estimate),
            Self::Maintenance(facts) => encode(facts),
            Self::Cleared(_) => Vec::new(),
        }
    }
}

/// A message to publish.
#[derive(Debug, Clone)]
pub struct Publication {
    /// The robot that gets it.
    pub robot: Name,
    /// The message, not encoded yet.
    pub message: ToRobot,
    /// Deadline for sending, after which the transport drops the message. Robots get it by then, too, unless it is
    /// retained.
    pub until: Option<Instant>,
    /// Measures the time until the setpoint is published; `None` for other messages, and for setpoints that are sent
    /// again.
    pub stopwatch: Option<Stopwatch>,
    /// Number of the transaction that it states or belongs to: it goes out after this one's commit.
    pub transaction: i64,
    /// Withdraws it while it waits; `None` for messages that move nothing.
    pub withdrawal: Option<Withdrawal>,
}

impl Publication {
    /// A publication without a deadline, and of no transaction yet.
    #[must_use]
    pub fn new(robot: Name, message: ToRobot) -> Self {
        Self { robot, message, until: None, stopwatch: None, transaction: 0, withdrawal: None }
    }

    /// Whether it only states what a transaction has recorded. Such a message stays true after the lease has expired.
    #[must_use]
    pub fn states_a_commit(&self) -> bool {
        matches!(self.message, ToRobot::Receipt(_))
    }

    /// Whether it makes the robot move air or whiskers.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.withdrawal.is_some()
    }

    /// Whether it must not be sent any more.
    #[must_use]
    pub fn is_withdrawn(&self) -> bool {
        self.withdrawal.as_ref().is_some_and(Withdrawal::is_withdrawn)
    }

    /// Whether robots that connect later get it, too.
    #[must_use]
    pub fn is_retained(&self) -> bool {
        self.message.topic().is_retained()
    }
}

/// Withdraws messages that make a robot move: those that wait for the commit, and those that wait for the connection.
#[derive(Debug, Clone, Default)]
pub struct Withdrawal(Arc<AtomicBool>);

impl Withdrawal {
    /// From now on none of its messages is sent.
    pub fn withdraw(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn is_withdrawn(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// Measures the time from the event that led to a setpoint, as a metric.
#[derive(Debug, Clone)]
pub struct Stopwatch {
    pub(crate) since: Micros,
    pub(crate) seconds: Histogram,
}

impl Stopwatch {
    /// Records the elapsed time.
    pub fn stop(&self) {
        self.seconds.observe(wall_clock().since(self.since).as_s());
    }
}

/// Whether publications may have been lost, because the connection has broken. Messages of which nobody expects an answer
/// must then be published again.
#[derive(Debug, Clone, Default)]
pub struct Losses(Arc<AtomicBool>);

impl Losses {
    /// Records that publications may have been lost.
    pub fn note(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Number of those who share it.
    #[cfg(test)]
    pub(crate) fn holders(&self) -> usize {
        Arc::strong_count(&self.0)
    }

    /// Whether publications may have been lost since the last call.
    pub(crate) fn take(&self) -> bool {
        self.0.swap(false, Ordering::Relaxed)
    }
}
