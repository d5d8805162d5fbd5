//! Behaviour without a supervisor, with a timer of the robot's own.

use vibrissa_protocol::OnSupervisorLoss;

use super::Moment;

/// Time since the last message from the supervisor.
#[derive(Debug)]
pub struct Supervision {
    lost_after_us: u64,
    /// Time of the last message; `None` before the first one of this boot, and once the loss has been handled.
    heard: Option<Moment>,
}

impl Supervision {
    /// A supervisor that counts as lost after this time without a message.
    #[must_use]
    pub fn new(lost_after_us: u64) -> Self {
        Self { lost_after_us, heard: None }
    }

    /// A valid message has arrived on one of the robot's own topics. An estimate that the robot has already is none: the
    /// broker has kept it.
    pub fn heard(&mut self, now: Moment) {
        self.heard = Some(now);
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
