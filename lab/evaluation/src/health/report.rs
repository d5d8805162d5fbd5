//! The confusion matrix with its statistics.

use super::{Called, Class, Outcome, Plan};

/// Results of all cases.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// Seed of the plan.
    pub seed: u64,
    /// One entry for each class, in the order of the plan.
    pub classes: Vec<ClassReport>,
    /// All outcomes, in the order of the plan.
    pub outcomes: Vec<Outcome>,
}

/// Results of the cases of one class.
#[derive(Debug, Clone, PartialEq)]
pub struct ClassReport {
    /// True class of the cases.
    pub truth: Class,
    /// Number of cases.
    pub cases: u32,
    /// Number of cases by verdict, in the order of [`Report::columns`].
    pub called: Vec<u32>,
    /// Number of cases with a statement about an unaffected whisker.
    pub with_bystanders: u32,
    /// Number of correct cases: the right verdict, and no statement about another whisker.
    pub right: u32,
    /// Number of false trim verdicts.
    pub wrong_trims: u32,
    /// Median and 95 % quantile of the contacts until the right verdict; `None` without one.
    pub delay_contacts: Option<(f64, f64)>,
}

impl Report {
    pub(super) fn new(plan: &Plan, outcomes: Vec<Outcome>) -> Self {
        let classes = plan.classes.iter().map(|&truth| ClassReport::new(truth, &outcomes)).collect();
        Self { seed: plan.seed, classes, outcomes }
    }

    /// Columns of the matrix: each class, and all other statements.
    #[must_use]
    pub fn columns() -> Vec<&'static str> {
        Class::ALL.into_iter().map(Class::word).chain(["OTHER"]).collect()
    }

    /// Share of correct cases.
    #[must_use]
    pub fn right(&self) -> f64 {
        let cases: u32 = self.classes.iter().map(|class| class.cases).sum();
        f64::from(self.classes.iter().map(|class| class.right).sum::<u32>()) / f64::from(cases.max(1))
    }

    /// Number of false trim verdicts.
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
