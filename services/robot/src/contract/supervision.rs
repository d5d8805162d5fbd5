//! Behaviour without a supervisor, with a timer of the robot's own.

use vibrissa_protocol::OnSupervisorLoss;

/// Time since the last message from the supervisor.
#[derive(Debug)]
pub struct Supervision {
    lost_after_us: u64,
    /// Time of the last message; `None` before the first one of this boot, and once the loss has been handled.
    heard_us: Option<u64>,
}

impl Supervision {
    /// A supervisor that counts as lost after this time without a message.
    #[must_use]
    pub fn new(lost_after_us: u64) -> Self {
        Self { lost_after_us, heard_us: None }
    }

    /// A valid message has arrived on one of the robot's own topics.
    pub fn heard(&mut self, now_us: u64) {
        self.heard_us = Some(now_us);
    }

    /// The robot has restarted.
    pub fn restart(&mut self) {
        self.heard_us = None;
    }

    /// Whether the supervisor has just been lost. True once for each loss.
    pub fn is_lost(&mut self, now_us: u64) -> bool {
        let is_lost = self.heard_us.is_some_and(|heard_us| now_us >= heard_us + self.lost_after_us);
        if is_lost {
            self.heard_us = None;
        }
        is_lost
    }

    /// Time at which the supervisor counts as lost unless it is heard before.
    #[must_use]
    pub fn lost_at_us(&self) -> Option<u64> {
        self.heard_us.map(|heard_us| heard_us + self.lost_after_us)
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

    #[test]
    fn a_loss_is_noticed_once_and_only_after_a_message() {
        let mut supervision = Supervision::new(10);
        assert!(!supervision.is_lost(1_000));
        supervision.heard(1_000);
        assert_eq!(supervision.lost_at_us(), Some(1_010));
        assert!(!supervision.is_lost(1_009));
        assert!(supervision.is_lost(1_010));
        assert!(!supervision.is_lost(2_000));
        supervision.heard(2_000);
        supervision.restart();
        assert!(!supervision.is_lost(3_000));
    }

    #[test]
    fn a_chamber_is_held_set_to_its_nominal_pressure_or_vented() {
        let pressures = OnSupervisorLoss::ALL.iter().map(|&rule| pressure_without(rule, 0.1));
        assert_eq!(pressures.collect::<Vec<_>>(), [None, Some(0.1), Some(0.0)]);
    }
}
