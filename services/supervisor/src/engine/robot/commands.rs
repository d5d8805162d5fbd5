//! Setpoints sent to one robot: their deadlines for sending, and the robot's answers.
//!
//! None of this is stored. The age of a setpoint of an earlier supervisor counts from its time of issue.

use std::collections::VecDeque;
use std::time::Duration;

use tokio::time::Instant;
use uuid::Uuid;
use vibrissa_core::robot::effect::{Command, CommandKey};
use vibrissa_core::units::Micros;
use vibrissa_protocol::{SetpointOutcome, SetpointState};

/// Number of setpoints remembered besides those under way, because robots may answer late or twice.
const REMEMBERED: usize = 32;

/// How long after a takeover a robot may answer finished setpoints of the earlier supervisor: longer than any setpoint
/// is valid.
const OTHERS_FOR: Duration = Duration::from_secs(60);

/// The newest setpoints of one robot, in the order in which they were issued.
#[derive(Debug, Default)]
pub(crate) struct Commands {
    newest: VecDeque<Remembered>,
    /// `seq` of the last `setpoint_state`, with the number of its boot.
    answered: Option<(i64, u64)>,
    /// Until then the robot may answer setpoints of an earlier supervisor.
    others_until: Option<Instant>,
}

#[derive(Debug)]
struct Remembered {
    key: CommandKey,
    id: Uuid,
    until: Instant,
    /// The robot's last answer to this setpoint.
    answer: Option<SetpointOutcome>,
}

/// Whether a `setpoint_state` is consistent with the setpoints sent and the answers received before.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Plausibility {
    /// The state is consistent.
    Fits,
    /// No setpoint with this id was sent to the robot.
    UnknownCommand,
    /// The robot reported a later state of the setpoint before.
    Backward,
}

impl Commands {
    /// For a robot that another supervisor may have commanded before.
    pub(crate) fn taken_up() -> Self {
        Self { others_until: Some(Instant::now() + OTHERS_FOR), ..Self::default() }
    }

    /// Deadline for sending a setpoint, by the monotonic clock. `valid_for` counts from the time of issue, `now` is the
    /// wall clock. The deadline is computed once, so a clock that is set back does not extend it.
    pub(crate) fn until(
        &mut self,
        command: &Command,
        id: Uuid,
        (now, valid_for): (Micros, Micros),
        under_way: usize,
    ) -> Instant {
        if let Some(known) = self.newest.iter().find(|one| one.key == command.key) {
            return known.until;
        }
        let age = now.since(command.issued);
        let left = Duration::from_micros(valid_for.0.saturating_sub(age.0).min(valid_for.0));
        let until = Instant::now() + left;
        while self.newest.len() >= REMEMBERED + under_way {
            self.newest.pop_front();
        }
        self.newest.push_back(Remembered { key: command.key, id, until, answer: None });
        until
    }

    /// Judges a state, and remembers it. A message that is delivered twice has the same `seq` again.
    pub(crate) fn judge(&mut self, report: &SetpointState, boot: i64, is_under_way: bool) -> Plausibility {
        let is_new = self.answered.is_none_or(|(before, seq)| before != boot || report.seq > seq);
        if is_new {
            self.answered = Some((boot, report.seq));
        }
        let mut buffer = Uuid::encode_buffer();
        let mut is_named = |one: &Remembered| *one.id.hyphenated().encode_lower(&mut buffer) == report.command_id;
        let Some(known) = self.newest.iter_mut().find(|one| is_named(one)) else {
            let is_others = self.others_until.is_some_and(|until| Instant::now() < until);
            return if is_under_way || is_others { Plausibility::Fits } else { Plausibility::UnknownCommand };
        };
        if !is_new {
            return Plausibility::Fits;
        }
        let is_backward = known.answer.is_some_and(|answer| {
            let contradicts = answer.is_final() && answer != report.state;
            contradicts || stage(report.state) < stage(answer)
        });
        if is_backward {
            return Plausibility::Backward;
        }
        known.answer = Some(report.state);
        Plausibility::Fits
    }
}

/// Progress of a setpoint.
fn stage(state: SetpointOutcome) -> u8 {
    match state {
        SetpointOutcome::Received => 0,
        SetpointOutcome::Applying => 1,
        SetpointOutcome::Applied
        | SetpointOutcome::Rejected
        | SetpointOutcome::Failed
        | SetpointOutcome::Superseded => 2,
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_core::robot::effect::Reason;
    use vibrissa_core::units::Megapascal;
    use vibrissa_protocol::BootId;

    use super::*;

    const S: u64 = 1_000_000;

    fn command(version: u64, issued_s: u64) -> Command {
        Command {
            key: CommandKey { epoch: 1, version },
            whisker: 0,
            robot_boot_id: "b".to_owned(),
            pressure: Megapascal::known(0.05),
            slew_mpa_per_s: 0.02,
            issued: Micros(issued_s * S),
            expires: Micros(0),
            reason: Reason::Release,
            compensation: None,
            gain: None,
        }
    }

    fn state(id: Uuid, seq: u64, state: SetpointOutcome) -> SetpointState {
        let boot_id = BootId::new("b").unwrap();
        SetpointState { boot_id, seq, command_id: id.to_string(), state, t_us: 1, pressure_mpa: None, error: None }
    }

    #[test]
    fn a_setpoint_lives_no_longer_when_the_wall_clock_is_set_back() {
        let mut commands = Commands::default();
        let valid_for = Micros(10 * S);
        let first = commands.until(&command(1, 1000), Uuid::from_u128(1), (Micros(1000 * S), valid_for), 1);
        let again = commands.until(&command(1, 1000), Uuid::from_u128(1), (Micros(10 * S), valid_for), 1);
        assert_eq!(first, again);
        assert!(first <= Instant::now() + Duration::from_secs(10));
    }

    #[test]
    fn the_age_of_a_setpoint_of_an_earlier_supervisor_counts_from_when_it_was_issued() {
        let mut commands = Commands::default();
        let mut left_s = |version, now_s| {
            let times = (Micros(now_s * S), Micros(10 * S));
            let until = commands.until(&command(version, 1000), Uuid::from_u128(version.into()), times, 9);
            until.saturating_duration_since(Instant::now()).as_secs_f64().round()
        };
        assert_eq!([left_s(1, 1004), left_s(2, 1011), left_s(3, 990)], [6.0, 0.0, 10.0]);
    }

    #[test]
    fn a_state_must_be_of_a_setpoint_that_went_out_and_must_not_go_backward() {
        use SetpointOutcome::{Applied, Applying, Failed, Received};
        let mut commands = Commands::default();
        let id = Uuid::from_u128(7);
        commands.until(&command(1, 1000), id, (Micros(1000 * S), Micros(S)), 1);
        let mut seq = 0;
        let mut judge = |id, outcome, is_redelivered: bool| {
            seq += u64::from(!is_redelivered);
            commands.judge(&state(id, seq, outcome), 3, false)
        };
        let fits = [(Received, false), (Received, false), (Applying, false), (Received, true), (Applied, false)];
        for (outcome, is_redelivered) in fits {
            assert_eq!(judge(id, outcome, is_redelivered), Plausibility::Fits, "{outcome}");
        }
        assert_eq!(judge(id, Applied, false), Plausibility::Fits, "the final state may be repeated");
        for outcome in [Received, Applying, Failed] {
            assert_eq!(judge(id, outcome, false), Plausibility::Backward, "{outcome}");
        }
        assert_eq!(judge(Uuid::from_u128(8), Applied, false), Plausibility::UnknownCommand);
        let others = state(Uuid::from_u128(8), 0, Applied);
        assert_eq!(
            Commands::taken_up().judge(&others, 3, false),
            Plausibility::Fits,
            "it may answer an earlier supervisor"
        );
    }

    #[test]
    fn only_so_many_are_remembered() {
        let mut commands = Commands::default();
        for version in 0..1000 {
            commands.until(&command(version, 1000), Uuid::from_u128(version.into()), (Micros(1000 * S), Micros(S)), 5);
        }
        assert_eq!(commands.newest.len(), REMEMBERED + 5);
    }
}
