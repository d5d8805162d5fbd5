//! The gain of the readings. No message shows which factor a robot uses; but its contacts must have the strain before it,
//! because the supervisor measures the factor with them.

use vibrissa_protocol::{Contact, Message, Rule, Setpoint, SetpointOutcome, TouchTestOutcome};

use super::bench::{Bench, Trial};
use super::listener::Listener;
use super::touch_tests::states;

/// The factor that the robot is told. A larger reading makes a robot withdraw rather than press on.
const READING_GAIN: f64 = 1.25;
/// Touches with each factor.
const TOUCHES: u16 = 8;
/// Largest relative difference of strains that are the same: half of what the factor would cause.
const SAME: f64 = 0.12;
const RULES: [Rule; 1] = [Rule::StrainAsMeasured];

impl Bench {
    fn applies_gain(&self) -> bool {
        self.heard.factsheet.as_ref().is_some_and(|factsheet| factsheet.applies_gain)
    }

    /// Whether the check has taken a gain away: each of its setpoints has none.
    pub(super) fn has_reset_gain(&self) -> bool {
        self.applies_gain() && self.commands > 0
    }

    /// Tests whether the strain of contacts is the same with a factor and without.
    ///
    /// # Errors
    /// The connection broke, or a supervisor appeared.
    pub(super) async fn gains(&mut self, trial: &Trial) -> anyhow::Result<()> {
        if !self.applies_gain() {
            self.exempt(&RULES, "the factsheet does not state applies_gain: the robot is told no factor");
            return Ok(());
        }
        let without = self.strain_per_mm(trial, None).await?;
        let with = self.strain_per_mm(trial, Some(READING_GAIN)).await?;
        match (without, with) {
            (Ok(without), Ok(with)) => {
                let holds = (with / without - 1.0).abs() <= SAME;
                let seen = format!(
                    "touches at one place have a strain of {without:.6} per mm, and {with:.6} with reading_gain {READING_GAIN}"
                );
                self.judge(Rule::StrainAsMeasured, holds, seen);
            }
            (Err(why), _) | (_, Err(why)) => self.skip(&RULES, &why),
        }
        Ok(())
    }

    /// Median strain per mm of deflection of a touch test, after a setpoint with this factor; or why it is not known.
    async fn strain_per_mm(&mut self, trial: &Trial, reading_gain: Option<f64>) -> anyhow::Result<Result<f64, String>> {
        let Some((kind, near_mm)) = self.kind_of_test(trial) else {
            return Ok(Err("the factsheet names no touch test, and only touches at one place can be compared".into()));
        };
        let setpoint = Setpoint { reading_gain, ..self.setpoint(trial, trial.home_mpa) };
        let mark = self.send(&setpoint).await?;
        let end = self.final_answer(mark, &setpoint.command_id).await?;
        if end.is_none_or(|state| state.state != SetpointOutcome::Applied) {
            return Ok(Err("the setpoint was not APPLIED".to_owned()));
        }
        let mut test = self.touch_test(trial, kind, near_mm);
        test.contacts = TOUCHES;
        let id = test.test_id.clone();
        let mark = self.send_test(test).await?;
        let is_done = |heard: &Listener| {
            states(heard, mark, &id).iter().any(|state| state.state == TouchTestOutcome::Done).then_some(())
        };
        self.until(self.timings().apply, is_done).await?;
        // Its touches come before its end, but with another quality of service.
        let all = |heard: &Listener| Some(responses(heard, mark, &id)).filter(|one| one.len() >= usize::from(TOUCHES));
        self.until(self.timings().answer, all).await?;
        let mut responses = responses(&self.heard, mark, &id);
        responses.sort_unstable_by(f64::total_cmp);
        let median = responses.get(responses.len() / 2).copied().filter(|&one| one != 0.0);
        Ok(median
            .filter(|_| 2 * responses.len() >= usize::from(TOUCHES))
            .ok_or_else(|| format!("only {} of {TOUCHES} touches of a touch test came", responses.len())))
    }
}

/// Strain per mm of the touches of a test; a message that is sent again counts once.
fn responses(heard: &Listener, mark: usize, id: &str) -> Vec<f64> {
    let mut found = std::collections::BTreeMap::new();
    for entry in &heard.log[mark..] {
        if let Message::Contacts(message) = &entry.message {
            let of_test = message.contacts.iter().filter(|one| one.test_id.as_deref() == Some(id));
            found.extend(of_test.map(|one: &Contact| (one.t_us, one.strain / one.deflection_mm)));
        }
    }
    found.into_values().collect()
}
