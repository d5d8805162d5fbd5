//! Behaviour without a supervisor, with a timer of the robot's own.

use vibrissa_protocol::OnSupervisorLoss;

use super::Moment;

/// Time without an answer to contacts after which a person is told, in microseconds.
const ANSWER_US: u64 = 60_000_000;

/// Time since the last message from the supervisor.
#[derive(Debug)]
pub struct Supervision {
    lost_after_us: u64,
    /// Time since which contacts wait for an answer on this connection.
    waiting: Option<Moment>,
    /// A person was told that no supervisor answers, and none has since.
    is_unanswered: bool,
    /// Time of the last message; `None` before the first one of this boot, and once the loss has been handled.
    heard: Option<Moment>,
}

impl Supervision {
    /// A supervisor that counts as lost after this time without a message.
    #[must_use]
    pub fn new(lost_after_us: u64) -> Self {
        Self { lost_after_us, waiting: None, is_unanswered: false, heard: None }
    }

    /// A valid message has arrived on one of the robot's own topics. An estimate that the robot has already is none: the
    /// broker has kept it.
    pub fn heard(&mut self, now: Moment) {
        self.heard = Some(now);
        (self.waiting, self.is_unanswered) = (None, false);
    }

    /// Notes whether contacts wait for a receipt on a connection. True once if no answer has come for too long: another fleet, or
    /// an access list of the broker, keeps every supervisor from this robot.
    pub fn waits(&mut self, is_waiting: bool, now: Moment) -> bool {
        if !is_waiting {
            self.waiting = None;
            return false;
        }
        let since = *self.waiting.get_or_insert(now);
        let is_late = !self.is_unanswered && now >= since + ANSWER_US;
        self.is_unanswered |= is_late;
        is_late
    }

    /// Whether no supervisor has answered for too long.
    #[must_use]
    pub fn is_unanswered(&self) -> bool {
        self.is_unanswered
    }

    /// Time at which a person is told unless an answer comes before.
    #[must_use]
    pub fn unanswered_at(&self) -> Option<Moment> {
        self.waiting.filter(|_| !self.is_unanswered).map(|since| since + ANSWER_US)
    }

    /// The robot has restarted.
    pub fn restart(&mut self) {
        self.heard = None;
    }

    /// Whether the supervisor has just been lost. True once for each loss.
    pub fn is_lost(&mut self, now: Moment) -> bool {
        let is_lost = self.heard.is_some_and(|heard| now >= heard + self.lost_after_us);
        if is_lost {
            self.heard = None;
        }
        is_lost
    }

    /// Time at which the supervisor counts as lost unless it is heard before.
    #[must_use]
    pub fn lost_at(&self) -> Option<Moment> {
        self.heard.map(|heard| heard + self.lost_after_us)
    }
}

/// Pressure of a chamber after the loss, in MPa; `None` to keep the present one.
#[must_use]
pub fn pressure_without(rule: OnSupervisorLoss, nominal_mpa: f64) -> Option<f64> {
    match rule {
        OnSupervisorLoss::Hold => None,
        OnSupervisorLoss::Nominal => Some(nominal_mpa),
        OnSupervisorLoss::Vent => Some(0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: Moment = Moment::of_us(0);

    #[test]
    fn a_loss_is_noticed_once_and_only_after_a_message() {
        let mut supervision = Supervision::new(10);
        assert!(!supervision.is_lost(AT + 1_000));
        supervision.heard(AT + 1_000);
        assert_eq!(supervision.lost_at(), Some(AT + 1_010));
        assert!(!supervision.is_lost(AT + 1_009));
        assert!(supervision.is_lost(AT + 1_010));
        assert!(!supervision.is_lost(AT + 2_000));
        supervision.heard(AT + 2_000);
        supervision.restart();
        assert!(!supervision.is_lost(AT + 3_000));
    }

    #[test]
    fn a_chamber_is_held_set_to_its_nominal_pressure_or_vented() {
        let pressures = OnSupervisorLoss::ALL.iter().map(|&rule| pressure_without(rule, 0.1));
        assert_eq!(pressures.collect::<Vec<_>>(), [None, Some(0.1), Some(0.0)]);
    }
}
