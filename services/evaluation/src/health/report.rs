//! The confusion matrix and what goes with it.

use super::{Called, Class, Outcome, Plan};

/// What came of all cases.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// The seed.
    pub seed: u64,
    /// One entry for each class, in the order of the plan.
    pub classes: Vec<ClassReport>,
    /// All outcomes, in the order of the plan.
    pub outcomes: Vec<Outcome>,
}

/// What came of the cases of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassReport {
    /// What they are.
    pub truth: Class,
    /// How many there were.
    pub cases: u32,
    /// How many were called what, in the order of [`Report::columns`].
    pub called: Vec<u32>,
    /// In how many another whisker was called something.
    pub with_bystanders: u32,
    /// How many were right: called by their name, and no other whisker called anything.
    pub right: u32,
    /// Trims that were called and are none.
    pub wrong_trims: u32,
    /// Median and 95 % quantile of the contacts until the right call; none without one.
    pub delay_contacts: Option<(f64, f64)>,
}

impl Report {
    pub(super) fn new(plan: &Plan, outcomes: Vec<Outcome>) -> Self {
        let classes = plan.classes.iter().map(|&truth| ClassReport::new(truth, &outcomes)).collect();
        Self { seed: plan.seed, classes, outcomes }
    }

    /// The matrix's columns: each class, and any other name.
    #[must_use]
    pub fn columns() -> Vec<&'static str> {
        Class::ALL.into_iter().map(Class::word).chain(["OTHER"]).collect()
    }

    /// Part of the cases that were right.
    #[must_use]
    pub fn right(&self) -> f64 {
        let cases: u32 = self.classes.iter().map(|class| class.cases).sum();
        f64::from(self.classes.iter().map(|class| class.right).sum::<u32>()) / f64::from(cases.max(1))
    }

    /// Trims that were called and are none.
    #[must_use]
    pub fn wrong_trims(&self) -> u32 {
        self.classes.iter().map(|class| class.wrong_trims).sum()
    }
}

impl ClassReport {
    fn new(truth: Class, outcomes: &[Outcome]) -> Self {
        let own: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.truth == truth).collect();
        let mut called = vec![0; Class::ALL.len() + 1];
        for outcome in &own {
            called[column(outcome.called)] += 1;
        }
        let count = |is: &dyn Fn(&Outcome) -> bool| own.iter().filter(|outcome| is(outcome)).count() as u32;
        let right_calls = own.iter().filter(|outcome| outcome.called == Called::Class(truth));
        let mut delays: Vec<f64> = right_calls.filter_map(|outcome| outcome.delay_contacts).collect();
        delays.sort_by(f64::total_cmp);
        Self {
            truth,
            cases: own.len() as u32,
            called,
            with_bystanders: count(&|outcome| outcome.bystander.is_some()),
            right: count(&Outcome::is_right),
            wrong_trims: own.iter().map(|outcome| outcome.wrong_trims).sum(),
            delay_contacts: quantile(&delays, 0.5).zip(quantile(&delays, 0.95)),
        }
    }
}

fn column(called: Called) -> usize {
    match called {
        Called::Class(class) => class as usize,
        Called::Other(_) => Class::ALL.len(),
    }
}

fn quantile(sorted: &[f64], part: f64) -> Option<f64> {
    sorted.get((part * sorted.len() as f64) as usize).copied()
}
