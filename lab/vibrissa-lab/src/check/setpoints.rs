//! Valid setpoints: accepted, applied, superseded, repeated.

use std::time::Duration;

use anyhow::bail;
use serde_json::Value;
use tokio::time::Instant;
use vibrissa_protocol::{RequestKind, RobotTopic, Rule, Setpoint, SetpointError, SetpointOutcome, SetpointState};

use super::bench::{Bench, Trial, answers, state_text};
use super::report::seconds;

/// Tolerance between a pressure and its setpoint: regulators of small robots dither by a step of a coarse sensor.
pub(super) const NEAR_MPA: f64 = 0.005;
/// Tolerance of a pressure ahead of its ramp, for the same reason.
const AHEAD_MPA: f64 = 0.005;
/// Tolerance of the setpoint in a status.
pub(super) const REPEATED_MPA: f64 = 0.0005;
/// Interval of status requests during a slow change.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// So slow that a setpoint is still being applied when the next one comes.
pub(super) const SLOW_MPA_PER_S: f64 = 0.002;
/// Rules that require an accepted setpoint.
const TAKEN: [Rule; 6] = [
    Rule::SetpointApplied,
    Rule::SetpointInStatus,
    Rule::Slew,
    Rule::CommandAgainAnswered,
    Rule::CommandAgainNotApplied,
    Rule::Supersede,
];

impl Bench {
    /// Tests the robot's reactions to valid setpoints.
    ///
    /// # Errors
    /// The robot has seen a higher epoch.
    pub(super) async fn setpoints(&mut self, trial: &Trial) -> anyhow::Result<()> {
        let Some(away) = self.first(trial).await? else { return Ok(()) };
        self.slew(trial).await?;
        self.repeat(trial, &away).await?;
        self.supersede(trial).await?;
        self.extra_fields(trial).await
    }

    /// Sends the first setpoint; `None` if it is not applied.
    async fn first(&mut self, trial: &Trial) -> anyhow::Result<Option<Setpoint>> {
        let setpoint = self.setpoint(trial, trial.away_mpa);
        let mark = self.send(&setpoint).await?;
        let end = self.final_answer(mark, &setpoint.command_id).await?;
        if end.as_ref().and_then(|end| end.error) == Some(SetpointError::Stale) {
            self.is_away = false;
            bail!(
                "the robot refuses epoch {} as STALE: it has seen a higher one, perhaps of a supervisor that the \
                 broker no longer knows. Restart the robot, which then forgets it, or use --epoch",
                self.epoch
            );
        }
        let all = answers(&self.heard, mark, &setpoint.command_id);
        let shown = if all.is_empty() { "no answer".into() } else { list(&all) };
        let is_in_order = matches!(&all[..], [first, second, last]
            if first.state == SetpointOutcome::Received && second.state == SetpointOutcome::Applying && last.state.is_final());
        let Some(end) = end.filter(|end| end.state == SetpointOutcome::Applied) else {
            if !all.is_empty() && all.iter().all(|one| one.state != SetpointOutcome::Rejected) {
                self.judge(Rule::SetpointAnswers, is_in_order, shown.clone());
            }
            let limit = seconds(self.timings().apply);
            self.fail(Rule::SetpointApplied, format!("{shown} within {limit}, for {:.4} MPa", setpoint.pressure_mpa));
            self.skip(&[Rule::SetpointAnswers], "no setpoint was applied");
            self.skip(&TAKEN, "no setpoint was applied");
            return Ok(None);
        };
        self.judge(Rule::SetpointAnswers, is_in_order, shown);
        self.judge_pressure(trial, &setpoint, &end).await?;
        Ok(Some(setpoint))
    }

    async fn judge_pressure(&mut self, trial: &Trial, setpoint: &Setpoint, end: &SetpointState) -> anyhow::Result<()> {
        let asked_mpa = setpoint.pressure_mpa;
        let status = self.fresh_status(trial).await?;
        let read_mpa = status.as_ref().map(|status| status.pressure_mpa);
        let is_near = |mpa: Option<f64>| mpa.is_none_or(|mpa| (mpa - asked_mpa).abs() <= NEAR_MPA);
        let shown = |mpa: Option<f64>| mpa.map_or("not reported".to_owned(), |mpa| format!("{mpa:.4} MPa"));
        let seen = format!(
            "APPLIED at {}, then {} in the status, of {asked_mpa:.4} MPa",
            shown(end.pressure_mpa),
            shown(read_mpa)
        );
        self.judge(Rule::SetpointApplied, is_near(end.pressure_mpa) && is_near(read_mpa), seen);
        let Some(status) = status else {
            self.skip(&[Rule::SetpointInStatus], "no status contains the whisker");
            return Ok(());
        };
        let holds = (status.setpoint_mpa - asked_mpa).abs() <= REPEATED_MPA;
        self.judge(Rule::SetpointInStatus, holds, format!("{:.4} MPa, of {asked_mpa:.4} MPa", status.setpoint_mpa));
        Ok(())
    }

    /// Returns to the first setpoint slowly, and requests statuses meanwhile.
    async fn slew(&mut self, trial: &Trial) -> anyhow::Result<()> {
        let Some(before) = self.fresh_status(trial).await? else {
            self.skip(&[Rule::Slew], "no status contains the whisker");
            return Ok(());
        };
        let way_mpa = (trial.home_mpa - trial.away_mpa).abs();
        let rate_mpa_per_s = (way_mpa / self.timings().slew.as_secs_f64()).max(1e-4);
        let setpoint = Setpoint { slew_mpa_per_s: rate_mpa_per_s, ..self.setpoint(trial, trial.home_mpa) };
        let sent = Instant::now();
        let mark = self.send(&setpoint).await?;
        let mut end = None;
        while end.is_none() && sent.elapsed() < self.timings().apply {
            self.request(RequestKind::Status).await?;
            let is_final = |state: &SetpointState| state.state.is_final();
            let id = setpoint.command_id.as_str();
            end = self.until(LOOK_EVERY, |heard| answers(heard, mark, id).into_iter().find(is_final)).await?;
        }
        self.is_away = end.is_none_or(|end| end.state != SetpointOutcome::Applied);
        self.judge_slew(trial, (mark, sent), before.pressure_mpa, rate_mpa_per_s);
        Ok(())
    }

    fn judge_slew(&mut self, trial: &Trial, (mark, sent): (usize, Instant), before_mpa: f64, rate_mpa_per_s: f64) {
        let mut looked = 0;
        let mut worst_mpa = f64::NEG_INFINITY;
        for (status, at) in self.heard.statuses(mark) {
            let after = at.saturating_duration_since(sent);
            let entry = status.whiskers.iter().find(|one| one.array == trial.array && one.whisker == trial.whisker);
            // Later the pressure may have arrived.
            let Some(entry) = entry.filter(|_| after < self.timings().slew.mul_f64(0.75)) else { continue };
            looked += 1;
            let ahead_mpa = (entry.pressure_mpa - before_mpa).abs() - rate_mpa_per_s * after.as_secs_f64();
            worst_mpa = worst_mpa.max(ahead_mpa);
        }
        if looked == 0 {
            self.skip(&[Rule::Slew], "no status came during the change: the robot does not answer requests for it");
            return;
        }
        let seen = format!(
            "at {rate_mpa_per_s:.4} MPa/s, at most {:.4} MPa ahead of the ramp in {looked} statuses",
            worst_mpa.max(0.0)
        );
        self.judge(Rule::Slew, worst_mpa <= AHEAD_MPA, seen);
    }

    /// Sends the first command again, after another one was applied.
    async fn repeat(&mut self, trial: &Trial, first: &Setpoint) -> anyhow::Result<()> {
        let (again, was_away) = (self.again(first), self.is_away);
        let mark = self.send(&again).await?;
        self.first_answer(mark, &again.command_id).await?;
        self.listen(self.timings().grace / 2).await?;
        let all = answers(&self.heard, mark, &again.command_id);
        let is_begun = |one: &SetpointState| matches!(one.state, SetpointOutcome::Received | SetpointOutcome::Applying);
        let is_applied_again = all.iter().any(is_begun);
        let is_answered = is_applied_again || all.iter().any(|one| one.state == SetpointOutcome::Applied);
        let shown = if all.is_empty() { "no answer".to_owned() } else { list(&all) };
        self.judge(Rule::CommandAgainAnswered, is_answered, format!("{shown}, to a command that was APPLIED"));
        // The setpoint in a status must not have changed.
        let status = self.fresh_status(trial).await?;
        let has_moved = status.is_some_and(|one| (one.setpoint_mpa - trial.away_mpa).abs() <= REPEATED_MPA)
            && (trial.away_mpa - trial.home_mpa).abs() > 2.0 * REPEATED_MPA;
        let seen = match (is_applied_again, has_moved) {
            (true, _) => format!("{shown}, to a command that was APPLIED before"),
            (false, true) => "the status shows its setpoint again".to_owned(),
            (false, false) => "the setpoint did not change".to_owned(),
        };
        self.judge(Rule::CommandAgainNotApplied, !is_applied_again && !has_moved, seen);
        if is_applied_again || has_moved {
            self.final_answer(mark, &again.command_id).await?;
        } else {
            self.is_away = was_away;
        }
        self.go_home().await.map(drop)
    }

    /// Sends a setpoint while another one is being applied.
    async fn supersede(&mut self, trial: &Trial) -> anyhow::Result<()> {
        let slow = Setpoint { slew_mpa_per_s: SLOW_MPA_PER_S, ..self.setpoint(trial, trial.away_mpa) };
        let mark = self.send(&slow).await?;
        self.first_answer(mark, &slow.command_id).await?;
        let newer = self.setpoint(trial, trial.home_mpa);
        self.send(&newer).await?;
        let newer_end = self.final_answer(mark, &newer.command_id).await?;
        self.listen(self.timings().grace / 2).await?;
        let older_end = answers(&self.heard, mark, &slow.command_id).into_iter().find(|one| one.state.is_final());
        let is_applied = newer_end.as_ref().is_some_and(|one| one.state == SetpointOutcome::Applied);
        self.is_away = !is_applied;
        let end = |end: Option<SetpointState>| end.map_or("no final state".to_owned(), |end| state_text(&end));
        let is_superseded = older_end.as_ref().is_some_and(|one| one.state == SetpointOutcome::Superseded);
        let seen = format!("the older one: {}; the newer one: {}", end(older_end), end(newer_end));
        self.judge(Rule::Supersede, is_superseded && is_applied, seen);
        Ok(())
    }

    /// Sends a setpoint with fields that the contract does not have.
    async fn extra_fields(&mut self, trial: &Trial) -> anyhow::Result<()> {
        let setpoint = self.setpoint(trial, trial.home_mpa);
        let mut value = serde_json::to_value(&setpoint)?;
        if let Value::Object(fields) = &mut value {
            fields
                .insert("check_note".to_owned(), serde_json::json!({"for": "robots with strict parsers", "n": [1, 2]}));
        }
        let mark = self.mark();
        self.is_away = true;
        self.say(RobotTopic::Setpoint, serde_json::to_vec(&value)?, None).await?;
        let first = self.first_answer(mark, &setpoint.command_id).await?;
        let is_taken = first.as_ref().is_some_and(|one| one.state != SetpointOutcome::Rejected);
        let shown = first.map_or("no answer".to_owned(), |first| state_text(&first));
        self.judge(Rule::UnknownFields, is_taken, format!("{shown}, to a setpoint with a field check_note"));
        if is_taken {
            let end = self.final_answer(mark, &setpoint.command_id).await?;
            self.is_away = end.is_none_or(|end| end.state != SetpointOutcome::Applied);
        }
        Ok(())
    }
}

fn list(all: &[SetpointState]) -> String {
    all.iter().map(state_text).collect::<Vec<_>>().join(", ")
}
