//! Touch tests: one that the robot names in its factsheet, and one for another boot.

use vibrissa_protocol::{BootId, Message, Rule, TestState, TouchTestError, TouchTestKind, TouchTestOutcome};

use super::bench::{Bench, Trial};
use super::listener::Listener;

/// Distance of the touch as a part of the whisker's length.
const NEAR: f64 = 0.6;

impl Bench {
    /// Tests the robot's reactions to touch tests.
    ///
    /// # Errors
    /// The connection broke, or a supervisor appeared.
    pub(super) async fn touch_tests(&mut self, trial: &Trial) -> anyhow::Result<()> {
        let Some((kind, near_mm)) = self.kind_of_test(trial) else {
            self.skip(&[Rule::TestDone, Rule::TestWrongBoot], "the factsheet names no touch test");
            return Ok(());
        };
        self.test_done(trial, kind, near_mm).await?;
        self.test_of_another_boot(trial, kind, near_mm).await
    }

    /// A touch test that the factsheet names, and a distance at which no robot fails to reach the whisker, in mm.
    pub(super) fn kind_of_test(&self, trial: &Trial) -> Option<(TouchTestKind, f64)> {
        let factsheet = self.heard.factsheet.as_ref()?;
        let arrays = factsheet.arrays.iter().filter(|one| one.array == trial.array);
        let whisker = arrays.flat_map(|one| &one.whiskers).find(|one| one.whisker == trial.whisker)?;
        Some((factsheet.touch_tests.first().copied()?, NEAR * whisker.length_mm))
    }

    async fn test_done(&mut self, trial: &Trial, kind: TouchTestKind, near_mm: f64) -> anyhow::Result<()> {
        let test = self.touch_test(trial, kind, near_mm);
        let id = test.test_id.clone();
        let mark = self.send_test(test).await?;
        let is_over = |state: &TestState| {
            matches!(state.state, TouchTestOutcome::Done | TouchTestOutcome::Failed | TouchTestOutcome::Rejected)
        };
        let limit = self.timings().apply;
        self.until(limit, |heard| states(heard, mark, &id).into_iter().find(is_over)).await?;
        // Its touches come before its end, but with another quality of service.
        let touches = self.until(self.timings().answer, |heard| Some(touches(heard, mark, &id)).filter(|&one| one > 0));
        let touches = touches.await?.unwrap_or_default();
        let states = states(&self.heard, mark, &id);
        let is_accepted = states.first().is_some_and(|first| first.state == TouchTestOutcome::Accepted);
        let is_done = states.last().is_some_and(|last| last.state == TouchTestOutcome::Done);
        let words: Vec<&str> = states.iter().map(|state| state.state.as_str()).collect();
        let seen = format!(
            "{}, with {touches} of 1 touch",
            if words.is_empty() { "no answer".into() } else { words.join(", ") }
        );
        self.judge(Rule::TestDone, is_accepted && is_done && touches == 1, seen);
        Ok(())
    }

    async fn test_of_another_boot(&mut self, trial: &Trial, kind: TouchTestKind, near_mm: f64) -> anyhow::Result<()> {
        let mut test = self.touch_test(trial, kind, near_mm);
        test.robot_boot_id = BootId::new("a-boot-that-never-was")?;
        let id = test.test_id.clone();
        let mark = self.send_test(test).await?;
        let first = self.until(self.timings().answer, |heard| states(heard, mark, &id).into_iter().next()).await?;
        let is_refused = first.as_ref().is_some_and(|state| {
            state.state == TouchTestOutcome::Rejected && state.error == Some(TouchTestError::WrongBoot)
        });
        let seen = first.map_or("no answer".to_owned(), |state| match state.error {
            Some(error) => format!("{} {error}", state.state),
            None => state.state.to_string(),
        });
        self.judge(Rule::TestWrongBoot, is_refused, seen);
        Ok(())
    }
}

/// States of a test since a position in the log.
pub(super) fn states(heard: &Listener, mark: usize, id: &str) -> Vec<TestState> {
    let mut found = Vec::new();
    for entry in &heard.log[mark..] {
        if let Message::TestState(state) = &entry.message
            && state.test_id == id
        {
            found.push(state.clone());
        }
    }
    found
}

/// Number of touches of a test since a position in the log, those that did not come included.
fn touches(heard: &Listener, mark: usize, id: &str) -> usize {
    let mut found = std::collections::BTreeSet::new();
    for entry in &heard.log[mark..] {
        if let Message::Contacts(message) = &entry.message {
            let felt = message.contacts.iter().filter(|one| one.test_id.as_deref() == Some(id)).map(|one| one.t_us);
            let missed = message.missed.iter().filter(|one| one.test_id.as_deref() == Some(id)).map(|one| one.t_us);
            // A message that is sent again counts once.
            found.extend(felt.chain(missed));
        }
    }
    found.len()
}
