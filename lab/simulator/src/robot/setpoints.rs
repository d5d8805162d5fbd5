//! Setpoints: accepted by the contract's rules, applied by the regulators, answered.

use vibrissa_protocol::{BootId, RobotTopic, Setpoint, SetpointError, SetpointOutcome, encode};
use vibrissa_robot::contract::supervision::pressure_without;
use vibrissa_robot::contract::{CommandAnswer, Moment, Verdict};

use super::misbehaviour::{AT_ONCE_MPA_PER_S, HELD_LESS_MPA};
use super::whisker::{Applying, OWN_SLEW_MPA_PER_S};
use super::{Outgoing, Robot};
use crate::journal::{HeardSetpoint, JournalEntry};
use crate::scenario::Misbehaviour;

impl Robot {
    pub(super) fn setpoint(&mut self, setpoint: &Setpoint, now_us: u64, out: &mut Vec<Outgoing>) {
        let at = self.places.get(&(setpoint.array.clone(), setpoint.whisker)).copied();
        let verdict = self.decide_setpoint(setpoint, at, now_us);
        self.journal.write(|| JournalEntry::Heard(heard(setpoint, self.voice.boot_id(), now_us)));
        let id = setpoint.command_id.as_str();
        match (verdict, at) {
            (Verdict::Take, Some(at)) => self.take(setpoint, at, now_us, out),
            (Verdict::Again(_), _) if self.breaks(Misbehaviour::SilentOnRepeats) => {}
            (Verdict::Again(_), Some(at)) if self.breaks(Misbehaviour::AppliesRepeats) => {
                self.take(setpoint, at, now_us, out);
            }
            (Verdict::Again(answer), _) => self.answer(id, at, answer, now_us, out),
            (Verdict::Reject(SetpointError::UnknownWhisker), _)
                if self.breaks(Misbehaviour::SilentOnUnknownWhisker) => {}
            (Verdict::Reject(error), _) => self.reject(id, at, error, now_us, out),
            // Only a setpoint for an existing whisker is accepted.
            (Verdict::Take, None) => self.reject(id, at, SetpointError::UnknownWhisker, now_us, out),
        }
    }

    fn take(&mut self, setpoint: &Setpoint, at: usize, now_us: u64, out: &mut Vec<Outgoing>) {
        let id = setpoint.command_id.as_str();
        let is_short = self.breaks(Misbehaviour::SaysOnlyTheEnd);
        if !is_short {
            self.answer(id, Some(at), CommandAnswer::plain(SetpointOutcome::Received), now_us, out);
        }
        if let Some(replaced) = self.whiskers[at].applying.take()
            && !self.breaks(Misbehaviour::NeverSuperseded)
        {
            self.answer(&replaced.command_id, Some(at), CommandAnswer::plain(SetpointOutcome::Superseded), now_us, out);
        }
        let less_mpa = if self.breaks(Misbehaviour::HoldsLess) { HELD_LESS_MPA } else { 0.0 };
        let at_once = self.breaks(Misbehaviour::IgnoresSlew);
        let slew_mpa_per_s = if at_once { AT_ONCE_MPA_PER_S } else { setpoint.slew_mpa_per_s };
        let whisker = &mut self.whiskers[at];
        whisker.regulator.set((setpoint.pressure_mpa - less_mpa).max(0.0), slew_mpa_per_s);
        self.journal.write(|| JournalEntry::Applied(heard(setpoint, self.voice.boot_id(), now_us)));
        let fails_at_us = now_us + whisker.regulator.patience_us();
        let (pressure_mpa, reading_gain) = (setpoint.pressure_mpa, setpoint.reading_gain);
        whisker.applying = Some(Applying { command_id: id.to_owned(), pressure_mpa, reading_gain, fails_at_us });
        if !is_short {
            self.answer(id, Some(at), CommandAnswer::plain(SetpointOutcome::Applying), now_us, out);
        }
    }

    fn reject(&mut self, id: &str, at: Option<usize>, error: SetpointError, now_us: u64, out: &mut Vec<Outgoing>) {
        self.answer(id, at, CommandAnswer::rejected(error), now_us, out);
    }

    /// Publishes and stores the state of a command.
    fn answer(&mut self, id: &str, at: Option<usize>, answer: CommandAnswer, now_us: u64, out: &mut Vec<Outgoing>) {
        self.commands.remember(id, answer);
        if !self.connected {
            return;
        }
        let pressure_mpa = at.and_then(|at| self.whiskers.get(at)).map(|whisker| whisker.regulator.reading_mpa());
        let state = self.voice.setpoint_state(id, answer, now_us, pressure_mpa);
        self.publish(RobotTopic::SetpointState, encode(&state), out);
    }

    /// Reports setpoints that have been reached, and those that have failed.
    pub(super) fn follow_setpoints(&mut self, at_us: u64, out: &mut Vec<Outgoing>) {
        let never_fails = self.breaks(Misbehaviour::NeverFails);
        for at in 0..self.whiskers.len() {
            let whisker = &mut self.whiskers[at];
            let Some(applying) = &whisker.applying else {
                continue;
            };
            let answer = if whisker.regulator.is_settled() {
                whisker.gain.applied(applying.pressure_mpa, applying.reading_gain);
                CommandAnswer::plain(SetpointOutcome::Applied)
            } else if at_us >= applying.fails_at_us && !never_fails {
                CommandAnswer { outcome: SetpointOutcome::Failed, error: Some(whisker.regulator.failure()) }
            } else {
                continue;
            };
            let id = applying.command_id.clone();
            whisker.applying = None;
            self.answer(&id, Some(at), answer, at_us, out);
        }
    }

    /// Behaves as the factsheet states after a long time without messages from the supervisor.
    pub(super) fn miss_supervisor(&mut self, at_us: u64, out: &mut Vec<Outgoing>) {
        if !self.supervision.is_lost(Moment::of_us(at_us)) {
            return;
        }
        for at in 0..self.whiskers.len() {
            let nominal_mpa = self.whiskers[at].facts().pressure_mpa;
            let Some(target_mpa) = pressure_without(self.without_supervisor(), nominal_mpa) else {
                return;
            };
            self.whiskers[at].regulator.set(target_mpa, OWN_SLEW_MPA_PER_S);
            self.whiskers[at].gain.left(target_mpa);
            if let Some(replaced) = self.whiskers[at].applying.take() {
                self.answer(
                    &replaced.command_id,
                    Some(at),
                    CommandAnswer::plain(SetpointOutcome::Superseded),
                    at_us,
                    out,
                );
            }
        }
    }
}

fn heard(setpoint: &Setpoint, boot_id: &BootId, at_us: u64) -> HeardSetpoint {
    HeardSetpoint { at_us, boot_id: boot_id.clone(), setpoint: setpoint.clone() }
}
