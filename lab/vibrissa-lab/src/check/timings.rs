//! Time limits of a check.

use std::time::Duration;

/// Status period below which an answer to a request cannot be distinguished from the next regular status.
pub(super) const TOO_QUICK: Duration = Duration::from_millis(400);
/// Time within which robots answer a request for births, by the contract. The check waits for the time of an answer in
/// addition.
pub(super) const BIRTHS_WITHIN: Duration = Duration::from_secs(2);

/// Help at the robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Help {
    /// Nobody helps.
    None,
    /// Somebody cuts the robot's power and restores it.
    Restart,
    /// Somebody does each [`Action`](super::Action).
    All,
}

/// Time limits of a check. The defaults are those of the contract; tests with fast simulated robots use shorter ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timings {
    /// Reading the retained messages.
    pub retained: Duration,
    /// Hearing the fleet's supervisor where the broker retains no messages: it repeats its state every 5 s.
    pub supervisor: Duration,
    /// Answer to a request, and first answer to a setpoint.
    pub answer: Duration,
    /// Time after a receipt in which covered messages may still arrive, because they were in transit.
    pub grace: Duration,
    /// Shortest and longest status period that the contract allows.
    pub status: (Duration, Duration),
    /// Largest deviation of the robot's clock from this machine's.
    pub clock: Duration,
    /// Final state of a setpoint.
    pub apply: Duration,
    /// Duration of the slow pressure change.
    pub slew: Duration,
    /// First contacts: somebody has to touch a whisker.
    pub contacts: Duration,
    /// First retransmission of a contacts message, and retransmission after a receipt.
    pub resend: Duration,
    /// Enough retransmissions to see the pauses grow.
    pub backoff: Duration,
    /// An action of the helper: cutting the robot's power and restoring it, for instance.
    pub help: Duration,
    /// Filling the robot's memory of contacts.
    pub fill: Duration,
    /// Time without a message to the robot after which it must have noticed the loss of its supervisor.
    pub silence: Duration,
}

impl Default for Timings {
    fn default() -> Self {
        let s = Duration::from_secs;
        Self {
            retained: s(1),
            supervisor: s(6),
            answer: s(5),
            grace: s(1),
            status: (s(1), s(10)),
            clock: s(2),
            apply: s(30),
            slew: s(4),
            contacts: s(60),
            resend: s(60),
            backoff: s(120),
            help: s(180),
            fill: s(300),
            silence: s(90),
        }
    }
}

impl Timings {
    /// Expected duration for a robot that conforms to the contract, and longest duration for any robot.
    #[must_use]
    pub fn expected(&self, help: Help) -> (Duration, Duration) {
        let usual = BIRTHS_WITHIN + self.retained + 3 * self.status.0 + 4 * self.answer + self.slew + 5 * self.grace;
        let setpoints = 6 * self.apply + 20 * self.answer + self.slew;
        let births = BIRTHS_WITHIN + self.answer;
        let contacts = self.contacts + 3 * self.resend + self.backoff;
        let most = self.retained + births + 8 * self.status.1 + setpoints + contacts;
        let restart = self.help + 3 * self.answer;
        match help {
            Help::None => (usual, most),
            Help::Restart => (usual, most + restart),
            Help::All => {
                // The supply is closed and opened, the robot stopped and started, and a whisker touched four times.
                let helped = 8 * self.help + self.fill + self.silence + 8 * self.apply + 3 * self.resend;
                (usual + self.silence + 4 * self.apply, most + restart + helped)
            }
        }
    }
}
