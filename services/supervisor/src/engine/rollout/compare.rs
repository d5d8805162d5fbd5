//! The comparison of changed and unchanged robots.

use vibrissa_core::rollout::{Look, Rules, Verdict, review};
use vibrissa_protocol::Name;
use vibrissa_store::rollouts::{Compared, RobotError};

use super::Rollout;

/// A comparison of changed and unchanged robots.
pub(in crate::engine) struct Comparison {
    pub(in crate::engine) verdict: Verdict,
    /// Whether it differs from the one before.
    pub(in crate::engine) is_new: bool,
}

impl Rollout {
    pub(in crate::engine) fn rules(&self) -> Rules {
        Rules { level: self.row.level, robots: self.row.robots as u32 }
    }

    /// Compares the errors of changed and unchanged robots.
    pub(in crate::engine) fn compare(&mut self, errors: &[RobotError]) -> Comparison {
        let trial = self.trial();
        let of = |is_changed: bool| -> Vec<f64> {
            let names = errors.iter().filter_map(|one| Some((Name::robot(&one.robot).ok()?, one.error)));
            names.filter(|(name, _)| trial.has(name) == is_changed).map(|(_, error)| error).collect()
        };
        let (mut changed, mut unchanged) = (of(true), of(false));
        let verdict = review(self.rules(), self.row.looks as u32, &changed, &unchanged);
        let before = self.row.compared;
        self.row.compared = Compared {
            probability: before.probability,
            changed_robots: changed.len() as i64,
            unchanged_robots: unchanged.len() as i64,
            changed_error: median(&mut changed),
            unchanged_error: median(&mut unchanged),
        };
        Comparison { verdict, is_new: self.row.compared != before }
    }
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        count if count % 2 == 1 => Some(values[middle]),
        _ => Some(f64::midpoint(values[middle - 1], values[middle])),
    }
}

/// The result of a look, in words.
pub(in crate::engine) fn summary(look: Look, rules: Rules, compared: &Compared) -> String {
    let percent = |error: Option<f64>| error.map_or_else(|| "-".to_owned(), |error| format!("{:.1} %", 100.0 * error));
    format!(
        "median error {} of {} changed robots, {} of {} unchanged ones; chance alone looks so much worse with probability {:.4}, \
         and the limit is {:.4}",
        percent(compared.changed_error),
        compared.changed_robots,
        percent(compared.unchanged_error),
        compared.unchanged_robots,
        look.probability,
        rules.threshold()
    )
}
