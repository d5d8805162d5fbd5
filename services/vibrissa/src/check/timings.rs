//! How long a check waits for what.

use std::time::Duration;

/// Times of a check. The contract's own are those of the default; tests with robots that are known to be quick take shorter ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timings {
    /// For what the broker retains.
    pub retained: Duration,
    /// For an answer to a request, and for the first one to a setpoint.
    pub answer: Duration,
    /// After a receipt what it covers may still come: it was under way.
    pub grace: Duration,
    /// The shortest and the longest time between two statuses that the contract allows.
    pub status: (Duration, Duration),
    /// How far times may be from ours.
    pub clock: Duration,
    /// For a setpoint's final state.
    pub apply: Duration,
    /// What the pressure's slow change takes.
    pub slew: Duration,
    /// For contacts: somebody has to touch a whisker.
    pub contacts: Duration,
    /// For a contacts message to be sent again for the first time, or after a receipt.
    pub resend: Duration,
    /// For it to be sent again so often that pauses can be seen to grow.
    pub backoff: Duration,
    /// For somebody to take the robot's power away and give it back.
    pub restart: Duration,
}

impl Default for Timings {
    fn default() -> Self {
        let s = Duration::from_secs;
        Self {
            retained: s(1),
            answer: s(5),
            grace: s(1),
            status: (s(1), s(10)),
            clock: s(2),
            apply: s(30),
            slew: s(4),
            contacts: s(60),
            resend: s(60),
            backoff: s(120),
            restart: s(180),
        }
    }
}

impl Timings {
    /// How long a robot that keeps the contract takes, and how long any robot may take.
    #[must_use]
    pub fn expected(&self, with_restart: bool) -> (Duration, Duration) {
        let usual = self.retained + 3 * self.status.0 + 4 * self.answer + self.slew + 5 * self.grace;
        let setpoints = 6 * self.apply + 20 * self.answer + self.slew;
        let contacts = self.contacts + 3 * self.resend + self.backoff;
        let restart = if with_restart { self.restart + 3 * self.answer } else { Duration::ZERO };
        (usual, self.retained + 8 * self.status.1 + setpoints + contacts + restart)
    }
}
