//! The loss of the supervisor: the check says nothing on the robot's own topics, only to the whole fleet.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_protocol::{OnSupervisorLoss, Rule, WhiskerStatus};

use super::assisted::{Ended, Told};
use super::bench::{Bench, Trial};
use super::listener::Listener;
use super::report::seconds;
use super::setpoints::{NEAR_MPA, REPEATED_MPA};
use super::{Progress, log};

/// Least difference between the pressure before the loss and the one that another behaviour would have.
const AWAY_MPA: f64 = 0.006;
/// Number of messages to the whole fleet meanwhile.
const TO_ALL: u32 = 6;

/// The test of one whisker.
#[derive(Debug, Clone, Copy)]
struct Loss {
    rule: OnSupervisorLoss,
    /// Pressure at the beginning, away from `nominal_mpa`.
    from_mpa: f64,
    nominal_mpa: f64,
}

/// State of the test after a status.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    /// As before the loss.
    Same,
    /// On the way to the pressure that the factsheet states.
    Going,
    /// There.
    There,
    /// Elsewhere.
    Wrong,
}

impl Bench {
    /// Tests the robot's behaviour without a supervisor.
    pub(super) async fn silence(&mut self, trial: &Trial, progress: Told<'_>) -> anyhow::Result<()> {
        let rules = [Rule::OnSupervisorLoss];
        let Some(factsheet) = self.heard.factsheet.clone() else { return Ok(()) };
        let facts = log::facts(&factsheet, (&trial.array, trial.whisker));
        let nominal_mpa = facts.map_or(trial.home_mpa, |facts| facts.pressure_mpa);
        let loss = Loss::new(factsheet.on_supervisor_loss, (trial.home_mpa, trial.away_mpa), nominal_mpa);
        if !loss.shows() {
            self.skip(&rules, "no pressure near the present one differs from that of another behaviour");
            return Ok(());
        }
        if self.try_pressure(trial, loss.from_mpa).await? != Ended::Reached {
            self.skip(&rules, &format!("{:.4} MPa was not reached before the silence", loss.from_mpa));
            return Ok(());
        }
        let shown = self.next_status(trial).await?;
        if shown.is_none_or(|status| loss.state(&status) != State::Same) {
            self.skip(&rules, &format!("the status does not show the setpoint of {:.4} MPa", loss.from_mpa));
            return self.go_home().await.map(drop);
        }
        progress(Progress::Step("silence, after which the robot must have lost its supervisor"));
        let (begun, mark) = (Instant::now(), self.mark());
        let (silence, patience) = (self.timings().silence, self.timings().apply);
        let every = silence / TO_ALL;
        let mut state = State::Same;
        while begun.elapsed() < silence || (state == State::Going && begun.elapsed() < silence + patience) {
            // A message to the whole fleet is no sign that this robot has a supervisor.
            self.request_births().await?;
            let left = silence.saturating_sub(begun.elapsed());
            let left = if left.is_zero() { every } else { left.min(every) };
            self.until(left, |heard| loss.ended(heard, mark, trial)).await?;
            state = loss.state_of(&self.heard, mark, trial);
            if loss.is_over(state) {
                break;
            }
        }
        let newest = self.heard.newest(mark, (&trial.array, trial.whisker)).map(|(status, _)| status);
        match newest {
            None => self.skip(&rules, "no status came"),
            Some(newest) => self.judge(rules[0], loss.holds(state), loss.text(begun.elapsed(), &newest)),
        }
        self.is_away = true;
        self.go_home().await.map(drop)
    }
}

impl Loss {
    /// Takes the one of two pressures that differs more from the pressures of other behaviours.
    fn new(rule: OnSupervisorLoss, (home_mpa, away_mpa): (f64, f64), nominal_mpa: f64) -> Self {
        let loss = |from_mpa| Self { rule, from_mpa, nominal_mpa };
        let (home, away) = (loss(home_mpa), loss(away_mpa));
        if home.contrast_mpa() > away.contrast_mpa() { home } else { away }
    }

    fn contrast_mpa(self) -> f64 {
        let from_nominal_mpa = (self.from_mpa - self.nominal_mpa).abs();
        match self.rule {
            OnSupervisorLoss::Hold => from_nominal_mpa.min(self.from_mpa),
            OnSupervisorLoss::Nominal => from_nominal_mpa,
            OnSupervisorLoss::Vent => self.from_mpa,
        }
    }

    fn shows(self) -> bool {
        self.contrast_mpa() >= AWAY_MPA
    }

    /// Pressure after the loss.
    fn to_mpa(self) -> f64 {
        match self.rule {
            OnSupervisorLoss::Hold => self.from_mpa,
            OnSupervisorLoss::Nominal => self.nominal_mpa,
            OnSupervisorLoss::Vent => 0.0,
        }
    }

    fn state(self, status: &WhiskerStatus) -> State {
        let is_set_to = |mpa: f64| (status.setpoint_mpa - mpa).abs() <= REPEATED_MPA;
        let is_at = |mpa: f64| (status.pressure_mpa - mpa).abs() <= NEAR_MPA;
        if self.rule == OnSupervisorLoss::Hold {
            return if is_set_to(self.from_mpa) && is_at(self.from_mpa) { State::Same } else { State::Wrong };
        }
        match (is_set_to(self.to_mpa()), is_at(self.to_mpa())) {
            (true, true) => State::There,
            (true, false) => State::Going,
            (false, _) if is_set_to(self.from_mpa) => State::Same,
            (false, _) => State::Wrong,
        }
    }

    /// The state after all statuses: something wrong stays so.
    fn state_of(self, heard: &Listener, mark: usize, trial: &Trial) -> State {
        let mut last = State::Same;
        for (status, _) in heard.statuses(mark) {
            let mut whiskers = status.whiskers.iter();
            let Some(one) = whiskers.find(|one| one.array == trial.array && one.whisker == trial.whisker) else {
                continue;
            };
            last = self.state(one);
            if last == State::Wrong {
                break;
            }
        }
        last
    }

    fn is_over(self, state: State) -> bool {
        match state {
            State::There | State::Wrong => true,
            State::Same | State::Going => false,
        }
    }

    fn ended(self, heard: &Listener, mark: usize, trial: &Trial) -> Option<()> {
        self.is_over(self.state_of(heard, mark, trial)).then_some(())
    }

    fn holds(self, state: State) -> bool {
        match state {
            State::There => true,
            State::Same => self.rule == OnSupervisorLoss::Hold,
            State::Going | State::Wrong => false,
        }
    }

    fn text(self, after: Duration, newest: &WhiskerStatus) -> String {
        let (rule, from_mpa) = (self.rule, self.from_mpa);
        let WhiskerStatus { setpoint_mpa, pressure_mpa, .. } = newest;
        format!(
            "{rule}: {} after {from_mpa:.4} MPa, the setpoint is {setpoint_mpa:.4} MPa and the pressure {pressure_mpa:.4} \
             MPa; --silence states after which time the robot must have noticed the loss",
            seconds(after)
        )
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::{Gauge, Name, Regulator};

    use super::*;

    fn status(setpoint_mpa: f64, pressure_mpa: f64) -> WhiskerStatus {
        let array = Name::new("left").unwrap();
        WhiskerStatus {
            array,
            whisker: 0,
            pressure_mpa,
            setpoint_mpa,
            regulator: Regulator::Ok,
            gauge: Gauge::Ok,
            segmenter: None,
        }
    }

    #[test]
    fn the_pressure_before_the_loss_differs_from_those_of_other_behaviours() {
        let from = |rule, home_mpa, away_mpa| Loss::new(rule, (home_mpa, away_mpa), 0.1).from_mpa;
        assert_eq!(from(OnSupervisorLoss::Hold, 0.1, 0.11), 0.11);
        // Away from home is the nominal pressure.
        assert_eq!(from(OnSupervisorLoss::Nominal, 0.09, 0.1), 0.09);
        assert_eq!(from(OnSupervisorLoss::Vent, 0.0, 0.01), 0.01);
        assert!(!Loss::new(OnSupervisorLoss::Hold, (0.1, 0.1), 0.1).shows());
    }

    #[test]
    fn each_behaviour_is_distinguished_from_the_others() {
        for rule in [OnSupervisorLoss::Hold, OnSupervisorLoss::Nominal, OnSupervisorLoss::Vent] {
            let loss = Loss::new(rule, (0.1, 0.11), 0.1);
            for (other, mpa) in
                [(OnSupervisorLoss::Hold, 0.11), (OnSupervisorLoss::Nominal, 0.1), (OnSupervisorLoss::Vent, 0.0)]
            {
                assert_eq!(loss.holds(loss.state(&status(mpa, mpa))), rule == other, "{rule} {other}");
            }
        }
        let vent = Loss::new(OnSupervisorLoss::Vent, (0.1, 0.11), 0.1);
        assert_eq!(vent.state(&status(0.0, 0.06)), State::Going);
        // The pressure of a chamber that is held must not fall.
        let hold = Loss::new(OnSupervisorLoss::Hold, (0.1, 0.11), 0.1);
        assert_eq!(hold.state(&status(0.11, 0.1)), State::Wrong);
    }
}
