//! The part of a check in which somebody helps at the robot.

use std::time::Duration;

use vibrissa_protocol::{Rule, Setpoint, SetpointOutcome, WhiskerStatus};

use super::action::{Action, Progress, Spot};
use super::bench::{Bench, Trial, answers, state_text};
use super::setpoints::NEAR_MPA;

/// Rules for which somebody must help.
pub(super) const RULES: [Rule; 8] = [
    Rule::Farewell,
    Rule::StatusOnChange,
    Rule::ContactsDropped,
    Rule::ContactsBounded,
    Rule::FailedWithReason,
    Rule::OnSupervisorLoss,
    Rule::EstimateOrder,
    Rule::EstimateLength,
];

/// Receives the progress of a check.
pub(super) type Told<'a> = &'a mut (dyn FnMut(Progress) + Send);

impl Trial {
    pub(super) fn spot(&self) -> Spot {
        Spot { array: self.array.clone(), whisker: self.whisker }
    }
}

/// How a setpoint ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Ended {
    /// It was applied, and the chamber has the pressure.
    Reached,
    /// It was reported as applied at this pressure, which is another one.
    Claimed(f64),
    /// It failed; the answer as text.
    Failed(String),
    /// It was not accepted; the answer as text.
    Refused(String),
    /// Another final state, as text.
    Otherwise(String),
    /// It was accepted, and had no final state in time.
    Open,
    /// It was not answered.
    Unanswered,
}

impl Bench {
    /// Asks the helper for an action. `limit` is the time in which the check expects to see its effect.
    pub(super) fn please(&mut self, progress: Told<'_>, action: Action, limit: Duration) {
        match &action {
            Action::CloseSupply(spot) => self.owed.push(Action::OpenSupply(spot.clone())),
            Action::Stop => self.owed.push(Action::Start),
            Action::Touch | Action::TouchPlace(_) => self.owed.push(Action::Rest),
            Action::Rest => self.done(&Action::Rest),
            Action::CutPower | Action::OpenSupply(_) | Action::Start => {}
        }
        progress(Progress::Act(action, limit));
    }

    /// The helper's action has been seen, so that it is no longer owed.
    pub(super) fn done(&mut self, action: &Action) {
        self.owed.retain(|owed| owed != action);
    }

    /// Waits for the next regular status of the whisker.
    pub(super) async fn next_status(&mut self, trial: &Trial) -> anyhow::Result<Option<WhiskerStatus>> {
        let (mark, limit) = (self.mark(), self.timings().status.1 + self.timings().answer);
        self.until(limit, |heard| heard.newest(mark, (&trial.array, trial.whisker)).map(|(entry, _)| entry)).await
    }

    /// Sends a setpoint, and waits for its end, without a request for a status.
    pub(super) async fn try_pressure(&mut self, trial: &Trial, pressure_mpa: f64) -> anyhow::Result<Ended> {
        let setpoint = self.setpoint(trial, pressure_mpa);
        self.try_setpoint(trial, setpoint).await
    }

    /// The same with a setpoint.
    pub(super) async fn try_setpoint(&mut self, trial: &Trial, setpoint: Setpoint) -> anyhow::Result<Ended> {
        let pressure_mpa = setpoint.pressure_mpa;
        let mark = self.send(&setpoint).await?;
        let end = self.final_answer(mark, &setpoint.command_id).await?;
        let Some(end) = end else {
            let is_answered = !answers(&self.heard, mark, &setpoint.command_id).is_empty();
            return Ok(if is_answered { Ended::Open } else { Ended::Unanswered });
        };
        Ok(match end.state {
            SetpointOutcome::Applied => {
                let read_mpa = match end.pressure_mpa {
                    Some(mpa) => Some(mpa),
                    None => self.next_status(trial).await?.map(|status| status.pressure_mpa),
                };
                match read_mpa.filter(|mpa| (mpa - pressure_mpa).abs() > NEAR_MPA) {
                    Some(other_mpa) => Ended::Claimed(other_mpa),
                    None => Ended::Reached,
                }
            }
            SetpointOutcome::Failed => Ended::Failed(state_text(&end)),
            SetpointOutcome::Rejected => Ended::Refused(state_text(&end)),
            SetpointOutcome::Received | SetpointOutcome::Applying | SetpointOutcome::Superseded => {
                Ended::Otherwise(state_text(&end))
            }
        })
    }
}
