//! Tests with a closed air supply: a setpoint that cannot be reached, and the conditions in the statuses meanwhile.
//!
//! The chamber is at the lower one of the two pressures of the trial, and the setpoint is the higher one, so that only air
//! from the supply reaches it. Each setpoint is sent right after a status: a robot that reports changes does so before its
//! next regular one. No status is requested meanwhile, because the answer could be taken for such a report.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_protocol::{Rule, Setpoint, Status};

use super::action::Action;
use super::assisted::{Ended, Told};
use super::bench::{Bench, Trial};
use super::log::conditions;
use super::report::seconds;
use super::timings::TOO_QUICK;

/// Least difference of the two pressures: more than the tolerance of a reached pressure.
const ROOM_MPA: f64 = 0.006;
/// Part of the status period before which a status is no regular one.
const EARLY: f64 = 0.7;
/// Changes of which at least one must come early: with fewer, all may have come late by chance.
const CHANGES: usize = 3;
/// Duration of a slow change, in periods of the status.
const RAMP: f64 = 2.5;
const RULES: [Rule; 2] = [Rule::FailedWithReason, Rule::StatusOnChange];

impl Bench {
    /// Tests a setpoint without supply.
    pub(super) async fn supply(&mut self, trial: &Trial, progress: Told<'_>) -> anyhow::Result<()> {
        let (low_mpa, high_mpa) = (trial.home_mpa.min(trial.away_mpa), trial.home_mpa.max(trial.away_mpa));
        if high_mpa - low_mpa < ROOM_MPA {
            self.skip(&RULES, "the range of the factsheet has no second pressure");
            return Ok(());
        }
        if self.try_pressure(trial, low_mpa).await? != Ended::Reached {
            self.skip(&RULES, &format!("{low_mpa:.4} MPa was not reached before the supply was closed"));
            return Ok(());
        }
        let (mark, limit) = (self.mark(), self.timings().help);
        self.please(progress, Action::CloseSupply(trial.spot()), limit);
        let end = self.starve(trial, (low_mpa, high_mpa), limit).await?;
        let is_closed = end.is_some();
        self.judge_failure(end, high_mpa);
        if is_closed {
            // The condition may be reported after the end of the setpoint.
            self.next_status(trial).await?;
        }
        let open = Action::OpenSupply(trial.spot());
        self.please(progress, open.clone(), limit);
        let deadline = Instant::now() + limit;
        while Instant::now() < deadline {
            self.next_status(trial).await?;
            if self.try_pressure(trial, high_mpa).await? == Ended::Reached {
                self.done(&open);
                break;
            }
        }
        self.more_changes(trial, (low_mpa, high_mpa), mark).await?;
        self.judge_changes(mark);
        self.go_home().await.map(drop)
    }

    /// Changes the pressure so slowly that also regular statuses show it, until there are enough changes to judge.
    async fn more_changes(
        &mut self,
        trial: &Trial,
        (low_mpa, high_mpa): (f64, f64),
        mark: usize,
    ) -> anyhow::Result<()> {
        let Some(period) = self.usable_period() else { return Ok(()) };
        let ramp = period.mul_f64(RAMP).min(self.timings().apply / 3);
        let slew_mpa_per_s = (high_mpa - low_mpa) / ramp.as_secs_f64();
        for pressure_mpa in [low_mpa, high_mpa, low_mpa, high_mpa] {
            let (early, all) = self.changes(mark, period);
            if early > 0 || all >= CHANGES {
                break;
            }
            self.next_status(trial).await?;
            let setpoint = Setpoint { slew_mpa_per_s, ..self.setpoint(trial, pressure_mpa) };
            self.try_setpoint(trial, setpoint).await?;
        }
        Ok(())
    }

    /// The period of statuses, unless a report cannot be distinguished from the next regular status.
    fn usable_period(&self) -> Option<Duration> {
        self.period.filter(|&period| period >= TOO_QUICK)
    }

    fn changes(&self, mark: usize, period: Duration) -> (usize, usize) {
        let statuses: Vec<(&Status, Instant)> = self.heard.statuses(mark).collect();
        changes(&statuses, period.mul_f64(EARLY))
    }

    /// Sends setpoints until one is not reached; `None` if all are, because nobody closes the supply.
    async fn starve(
        &mut self,
        trial: &Trial,
        (low_mpa, high_mpa): (f64, f64),
        limit: Duration,
    ) -> anyhow::Result<Option<Ended>> {
        let deadline = Instant::now() + limit;
        while Instant::now() < deadline {
            self.next_status(trial).await?;
            let end = self.try_pressure(trial, high_mpa).await?;
            if end != Ended::Reached {
                return Ok(Some(end));
            }
            self.try_pressure(trial, low_mpa).await?;
        }
        Ok(None)
    }

    fn judge_failure(&mut self, end: Option<Ended>, high_mpa: f64) {
        let without = format!("for {high_mpa:.4} MPa without supply");
        let (holds, seen) = match end {
            None => {
                let limit = seconds(self.timings().help);
                self.skip(&[Rule::FailedWithReason], &format!("the supply was not closed within {limit}"));
                return;
            }
            Some(Ended::Refused(outcome)) => {
                self.skip(&[Rule::FailedWithReason], &format!("{outcome}: without supply no setpoint is accepted"));
                return;
            }
            Some(Ended::Failed(outcome)) => (true, format!("{outcome}, {without}")),
            Some(Ended::Claimed(mpa)) => (false, format!("APPLIED at {mpa:.4} MPa, {without}")),
            Some(Ended::Otherwise(outcome)) => (false, format!("{outcome}, {without}")),
            Some(Ended::Open) => (false, format!("no final state within {}, {without}", seconds(self.timings().apply))),
            Some(Ended::Unanswered | Ended::Reached) => (false, format!("no answer, {without}")),
        };
        self.judge(Rule::FailedWithReason, holds, seen);
    }

    fn judge_changes(&mut self, mark: usize) {
        let Some(period) = self.usable_period() else {
            let why = "the period of statuses is not known, or too short to distinguish a report from the next one";
            self.skip(&[Rule::StatusOnChange], why);
            return;
        };
        let (early, all) = self.changes(mark, period);
        let seen = format!("{early} of {all} changes came before the next regular status (period {})", seconds(period));
        if early > 0 {
            self.pass(Rule::StatusOnChange, seen);
        } else if all >= CHANGES {
            self.fail(Rule::StatusOnChange, seen);
        } else {
            let few = "too few conditions changed without supply, and none before the next regular status";
            self.skip(&[Rule::StatusOnChange], few);
        }
    }
}

/// Number of statuses with another condition than the one before that came sooner than `early` after it, and of all such
/// statuses.
fn changes(statuses: &[(&Status, Instant)], early: Duration) -> (usize, usize) {
    let changed = statuses.windows(2).filter(|pair| conditions(pair[0].0) != conditions(pair[1].0));
    let gaps: Vec<Duration> = changed.map(|pair| pair[1].1 - pair[0].1).collect();
    (gaps.iter().filter(|&&gap| gap < early).count(), gaps.len())
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::{BootId, Gauge, Name, Regulator, WhiskerStatus};

    use super::*;

    fn status(regulator: Regulator) -> Status {
        let array = Name::new("left").unwrap();
        let one = WhiskerStatus {
            array,
            whisker: 0,
            pressure_mpa: 0.1,
            setpoint_mpa: 0.1,
            regulator,
            gauge: Gauge::Ok,
            segmenter: None,
        };
        Status { boot_id: BootId::new("b").unwrap(), seq: 0, t_us: 0, whiskers: vec![one], contacts_dropped: None }
    }

    #[test]
    fn a_change_counts_as_early_by_the_time_since_the_status_before() {
        let [ok, low] = [Regulator::Ok, Regulator::SupplyLow].map(status);
        let begun = Instant::now();
        let at = |ms: u64| begun + Duration::from_millis(ms);
        let regular = [(&ok, at(0)), (&low, at(1000)), (&low, at(1100)), (&ok, at(2000))];
        assert_eq!(changes(&regular, Duration::from_millis(700)), (0, 2));
        let at_once = [(&ok, at(0)), (&low, at(200)), (&low, at(1200)), (&ok, at(2200))];
        assert_eq!(changes(&at_once, Duration::from_millis(700)), (1, 2));
        assert_eq!(changes(&regular[1..3], Duration::from_millis(700)), (0, 0));
    }
}
