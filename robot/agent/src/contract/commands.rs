//! Rules of the contract for accepting a setpoint, without the chambers.

use std::collections::{BTreeMap, VecDeque};

use vibrissa_protocol::{BootId, Setpoint, SetpointError, SetpointOutcome};

/// Number of commands whose answer is remembered.
const REMEMBERED: usize = 1024;

/// Decision about a setpoint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// Accept it.
    Take,
    /// It was answered before: repeat the answer, apply nothing.
    Again(CommandAnswer),
    /// Reject it.
    Reject(SetpointError),
}

/// Latest state of a command.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandAnswer {
    /// State of the setpoint.
    pub outcome: SetpointOutcome,
    /// Reason of a rejection or failure.
    pub error: Option<SetpointError>,
}

impl CommandAnswer {
    /// An answer without an error.
    #[must_use]
    pub fn plain(outcome: SetpointOutcome) -> Self {
        Self { outcome, error: None }
    }

    /// A rejection.
    #[must_use]
    pub fn rejected(error: SetpointError) -> Self {
        Self { outcome: SetpointOutcome::Rejected, error: Some(error) }
    }
}

/// The properties of the addressed whisker that matter for the decision.
#[derive(Debug)]
pub struct Addressee<'a> {
    /// Highest (epoch, version) seen for the whisker.
    pub seen: &'a mut Option<(u64, u64)>,
    /// Highest pressure that the factsheet allows, in MPa.
    pub pressure_max_mpa: f64,
}

/// Answers of one boot.
#[derive(Debug, Default)]
pub struct Commands {
    answers: BTreeMap<String, CommandAnswer>,
    order: VecDeque<String>,
}

impl Commands {
    /// Decides about a setpoint by the contract's rules; `addressee` is `None` if the robot has no such whisker.
    pub fn judge(
        &self,
        setpoint: &Setpoint,
        boot_id: &BootId,
        now_us: u64,
        addressee: Option<Addressee<'_>>,
    ) -> Verdict {
        if let Some(&answer) = self.answers.get(&setpoint.command_id) {
            return Verdict::Again(answer);
        }
        let Some(addressee) = addressee else {
            return Verdict::Reject(SetpointError::UnknownWhisker);
        };
        // Checked before the order: a setpoint for another boot must not change the highest order seen.
        if setpoint.robot_boot_id != *boot_id {
            return Verdict::Reject(SetpointError::WrongBoot);
        }
        let order = (setpoint.epoch, setpoint.version);
        if addressee.seen.is_some_and(|seen| order <= seen) {
            return Verdict::Reject(SetpointError::Stale);
        }
        *addressee.seen = (*addressee.seen).max(Some(order));
        if setpoint.expires_us <= now_us {
            return Verdict::Reject(SetpointError::Expired);
        }
        if !(0.0..=addressee.pressure_max_mpa).contains(&setpoint.pressure_mpa) {
            return Verdict::Reject(SetpointError::OutOfRange);
        }
        Verdict::Take
    }

    /// Stores the latest state of a command.
    pub fn remember(&mut self, command_id: &str, answer: CommandAnswer) {
        if self.answers.insert(command_id.to_owned(), answer).is_none() {
            self.order.push_back(command_id.to_owned());
            if self.order.len() > REMEMBERED
                && let Some(oldest) = self.order.pop_front()
            {
                self.answers.remove(&oldest);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::{Name, SetpointReason, Timestamp};

    use super::*;

    const NOW_US: u64 = 1_000;

    fn boot() -> BootId {
        BootId::new("b7").unwrap()
    }

    fn setpoint(epoch: u64, version: u64) -> Setpoint {
        Setpoint {
            boot_id: BootId::new("s3").unwrap(),
            seq: 0,
            command_id: format!("{epoch}.{version}"),
            epoch,
            version,
            robot_boot_id: boot(),
            array: Name::new("left").unwrap(),
            whisker: 0,
            pressure_mpa: 0.05,
            slew_mpa_per_s: 0.02,
            issued: Timestamp(0),
            expires_us: NOW_US + 1,
            reason: SetpointReason::Operator,
            gain: vec![],
            reading_gain: None,
        }
    }

    fn judge(setpoint: &Setpoint, seen: &mut Option<(u64, u64)>) -> Verdict {
        let addressee = Addressee { seen, pressure_max_mpa: 0.2 };
        Commands::default().judge(setpoint, &boot(), NOW_US, Some(addressee))
    }

    #[test]
    fn a_higher_epoch_or_version_is_taken() {
        let mut seen = None;
        for (epoch, version) in [(12, 57), (12, 58), (13, 0)] {
            assert_eq!(judge(&setpoint(epoch, version), &mut seen), Verdict::Take);
        }
        assert_eq!(seen, Some((13, 0)));
    }

    #[test]
    fn an_order_not_higher_than_any_seen_is_stale() {
        for (epoch, version) in [(12, 57), (12, 56), (11, 99)] {
            let mut seen = Some((12, 57));
            assert_eq!(judge(&setpoint(epoch, version), &mut seen), Verdict::Reject(SetpointError::Stale));
            assert_eq!(seen, Some((12, 57)));
        }
    }

    #[test]
    fn a_setpoint_for_another_boot_is_rejected_and_not_seen() {
        let other = Setpoint { robot_boot_id: BootId::new("b6").unwrap(), ..setpoint(12, 57) };
        let mut seen = None;
        assert_eq!(judge(&other, &mut seen), Verdict::Reject(SetpointError::WrongBoot));
        assert_eq!(seen, None);
    }

    #[test]
    fn an_expired_setpoint_is_rejected_and_seen() {
        let late = Setpoint { expires_us: NOW_US, ..setpoint(12, 57) };
        let mut seen = None;
        assert_eq!(judge(&late, &mut seen), Verdict::Reject(SetpointError::Expired));
        assert_eq!(judge(&setpoint(12, 57), &mut seen), Verdict::Reject(SetpointError::Stale));
    }

    #[test]
    fn a_pressure_outside_the_factsheets_range_is_rejected() {
        for pressure_mpa in [-0.001, 0.2001, f64::NAN] {
            let wild = Setpoint { pressure_mpa, ..setpoint(1, 1) };
            assert_eq!(judge(&wild, &mut None), Verdict::Reject(SetpointError::OutOfRange));
        }
    }

    #[test]
    fn an_unknown_whisker_is_rejected() {
        let verdict = Commands::default().judge(&setpoint(1, 1), &boot(), NOW_US, None);
        assert_eq!(verdict, Verdict::Reject(SetpointError::UnknownWhisker));
    }

    #[test]
    fn the_same_command_again_is_answered_again() {
        let mut commands = Commands::default();
        let answer = CommandAnswer { outcome: SetpointOutcome::Applied, error: None };
        commands.remember("1.1", answer);
        let late = Setpoint { expires_us: 0, ..setpoint(1, 1) };
        let mut seen = Some((9, 9));
        let addressee = Addressee { seen: &mut seen, pressure_max_mpa: 0.2 };
        assert_eq!(commands.judge(&late, &boot(), NOW_US, Some(addressee)), Verdict::Again(answer));
    }

    #[test]
    fn only_so_many_answers_are_remembered() {
        let mut commands = Commands::default();
        let answer = CommandAnswer { outcome: SetpointOutcome::Applied, error: None };
        (0..REMEMBERED + 10).for_each(|number| commands.remember(&number.to_string(), answer));
        assert_eq!((commands.answers.len(), commands.order.len()), (REMEMBERED, REMEMBERED));
        assert!(!commands.answers.contains_key("0"));
    }
}
