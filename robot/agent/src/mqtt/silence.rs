//! Detects a broker that has gone silent without the end of its connection, as when the network is cut.
//!
//! The keep-alive of MQTT does not: a client that publishes needs no pings, and the library then sends none, so nothing needs
//! an answer. Contacts and statuses have QoS 0, which needs none either.

use tokio::time::{Duration, Instant};

/// Time without any packet from the broker after which the robot asks for one, and then waits for the answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// The time since the last packet of a connection.
#[derive(Debug)]
pub(crate) struct Silence {
    heard_at: Instant,
    is_asked: bool,
}

/// The next measure against silence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Measure {
    /// Send something that the broker must answer.
    Ask,
    /// Give the connection up.
    GiveUp,
}

impl Silence {
    /// Of a connection that begins now.
    pub(crate) fn new(now: Instant) -> Self {
        Self { heard_at: now, is_asked: false }
    }

    /// A packet has arrived.
    pub(crate) fn heard(&mut self, now: Instant) {
        *self = Self::new(now);
    }

    /// Time of the next measure, if nothing arrives before it.
    pub(crate) fn due(&self) -> Instant {
        self.heard_at + if self.is_asked { 2 * PATIENCE } else { PATIENCE }
    }

    /// The measure that is due.
    pub(crate) fn measure(&mut self) -> Measure {
        if self.is_asked {
            return Measure::GiveUp;
        }
        self.is_asked = true;
        Measure::Ask
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    #[test]
    fn a_silent_broker_is_asked_and_then_given_up() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        silence.heard(begin + 3 * S);
        assert_eq!(silence.due(), begin + 13 * S);
        assert_eq!(silence.measure(), Measure::Ask);
        assert_eq!(silence.due(), begin + 23 * S);
        assert_eq!(silence.measure(), Measure::GiveUp);
    }

    #[test]
    fn an_answer_starts_the_time_over() {
        let begin = Instant::now();
        let mut silence = Silence::new(begin);
        assert_eq!(silence.measure(), Measure::Ask);
        silence.heard(begin + 12 * S);
        assert_eq!(silence.due(), begin + 22 * S);
        assert_eq!(silence.measure(), Measure::Ask);
    }
}
