//! Means over the trials of a case.

use super::{Case, Outcome, Served};

/// Means over the trials of one case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Experiment of the trials.
    pub case: Case,
    /// Number of trials in which the target was served.
    pub served: usize,
    /// Number of trials without compensation: the cut was not detected, or eq. 34 has no root in range.
    pub unserved: usize,
    /// Mean error in open loop by eq. 34, as a ratio.
    pub tip: f64,
    /// Mean error in open loop with the least-mean objective.
    pub mean: f64,
    /// Mean error in closed loop.
    pub closed: f64,
    /// Mean error in closed loop with the gain.
    pub with_gain: f64,
    /// Mean error at the best single pressure.
    pub best: f64,
    /// Mean error that the first decision predicted.
    pub predicted: f64,
    /// Share of the trials with a true open-loop error in the predicted interval.
    pub coverage: f64,
    /// Mean width of that interval.
    pub width: f64,
    /// Median number of contacts at the last pressure when the last gain was published.
    pub gain_contacts: u32,
    /// Number of setpoints sent: mean and maximum.
    pub setpoints: (f64, usize),
}

/// The means of a case; `None` if no trial was served.
#[must_use]
pub fn summary(case: Case, outcomes: &[Outcome]) -> Option<Summary> {
    let served: Vec<&Served> = served_in(case, outcomes).collect();
    let all = outcomes.iter().filter(|outcome| outcome.trial().case == case).count();
    let mean_of = |of: &dyn Fn(&Served) -> f64| served.iter().map(|one| of(one)).sum::<f64>() / served.len() as f64;
    let interval = |one: &Served| one.chosen.predicted_error_interval.unwrap_or((f64::NAN, f64::NAN));
    let covered = |one: &Served| {
        let (low, high) = interval(one);
        f64::from(u8::from(low <= one.tip.1.mean && one.tip.1.mean <= high))
    };
    let mut gain_contacts: Vec<u32> = served.iter().map(|one| one.gain_contacts).collect();
    gain_contacts.sort_unstable();
    (!served.is_empty()).then(|| Summary {
        case,
        served: served.len(),
        unserved: all - served.len(),
        tip: mean_of(&|one| one.tip.1.mean),
        mean: mean_of(&|one| one.mean.1.mean),
        closed: mean_of(&|one| one.closed.1.mean),
        with_gain: mean_of(&|one| one.with_gain.mean),
        best: mean_of(&|one| one.best.1.mean),
        predicted: mean_of(&|one| one.chosen.predicted_error.unwrap_or(f64::NAN)),
        coverage: mean_of(&covered),
        width: mean_of(&|one| interval(one).1 - interval(one).0),
        gain_contacts: gain_contacts[gain_contacts.len() / 2],
        setpoints: (mean_of(&|one| one.setpoints as f64), served.iter().map(|one| one.setpoints).max().unwrap_or(0)),
    })
}

/// The served trials of a case, in order.
pub fn served_in(case: Case, outcomes: &[Outcome]) -> impl Iterator<Item = &Served> {
    outcomes.iter().filter_map(move |outcome| match outcome {
        Outcome::Served(served) if served.trial.case == case => Some(&**served),
        Outcome::Served(_) | Outcome::Unserved(_) => None,
    })
}

/// The trial of a case for the plot over deflection: that of the first plant with the greatest difference in
/// length.
#[must_use]
pub fn example(case: Case, outcomes: &[Outcome]) -> Option<&Served> {
    let apart = |one: &Served| (one.trial.length_mm - case.target_mm()).abs();
    served_in(case, outcomes)
        .filter(|one| one.trial.plant == 0)
        .max_by(|one, other| apart(one).total_cmp(&apart(other)))
}
