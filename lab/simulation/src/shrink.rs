//! The smallest plan that still violates an invariant.

use crate::invariants::Invariant;
use crate::plan::{Plan, Strike};
use crate::world::{self, Outcome};

/// Most runs of a search.
const RUNS: usize = 400;

/// A search for the smallest plan.
struct Search {
    invariant: Invariant,
    runs: usize,
}

impl Search {
    /// Runs a plan; the outcome if it violates the invariant.
    fn fails(&mut self, plan: &Plan) -> Option<Outcome> {
        if self.runs >= RUNS {
            return None;
        }
        self.runs += 1;
        let outcome = world::run(plan);
        outcome.violations.iter().any(|one| one.invariant == self.invariant).then_some(outcome)
    }
}

/// Removes faults, robots and supervisors from a plan as long as it still violates `invariant`. Returns the smallest plan that
/// was found, and its outcome.
#[must_use]
pub fn shrink(plan: &Plan, invariant: Invariant, outcome: Outcome) -> (Plan, Outcome) {
    let mut search = Search { invariant, runs: 0 };
    let mut smallest = (plan.clone(), outcome);
    let end = smallest.1.simulated;
    let early: Vec<Strike> = plan.strikes.iter().copied().filter(|strike| strike.at <= end).collect();
    try_plan(&mut search, &mut smallest, plan.with(early));
    remove_strikes(&mut search, &mut smallest);
    for robots in [1, 2, 3, 5, 8, 13] {
        if robots < smallest.0.robots {
            let fewer = Plan { robots, ..smallest.0.clone() };
            if try_plan(&mut search, &mut smallest, fewer) {
                break;
            }
        }
    }
    for supervisors in 1..smallest.0.supervisors {
        let fewer = Plan { supervisors, fleets: smallest.0.fleets.min(supervisors), ..smallest.0.clone() };
        if try_plan(&mut search, &mut smallest, fewer) {
            break;
        }
    }
    remove_strikes(&mut search, &mut smallest);
    smallest
}

/// Takes a plan as the smallest if it fails.
fn try_plan(search: &mut Search, smallest: &mut (Plan, Outcome), plan: Plan) -> bool {
    let Some(outcome) = search.fails(&plan) else { return false };
    *smallest = (plan, outcome);
    true
}

/// Removes parts of the faults: first halves, in the end each one alone.
fn remove_strikes(search: &mut Search, smallest: &mut (Plan, Outcome)) {
    let mut size = smallest.0.strikes.len().div_ceil(2);
    while size > 0 {
        let mut at = 0;
        let mut has_shrunk = false;
        while at < smallest.0.strikes.len() {
            let mut fewer = smallest.0.strikes.clone();
            fewer.drain(at..(at + size).min(fewer.len()));
            let plan = smallest.0.with(fewer);
            if try_plan(search, smallest, plan) {
                has_shrunk = true;
            } else {
                at += size;
            }
        }
        if !(has_shrunk && size == 1) {
            size = if size == 1 { 0 } else { size.div_ceil(2) };
        }
    }
}
