//! The service in simulated time: drawn histories keep all invariants, each planted fault is found, and a seed gives one history.

mod controls;
mod histories;

use vibrissa_simulation::plan::{Kind, Plan, Strike};

/// Faults that lead to a new owner of a fleet whose last owner is forgotten.
const LOST_EPOCHS: [Kind; 5] =
    [Kind::StoreClockStepped, Kind::StoreFailover, Kind::SupervisorKilled, Kind::SupervisorFrozen, Kind::FromStoreCut];

/// The plan with these kinds of faults in the place of all.
fn with_kinds(plan: &Plan, kinds: &[Kind]) -> Plan {
    let strike = |strike: &Strike| Strike { kind: kinds[strike.victim % kinds.len()], ..*strike };
    plan.with(plan.strikes.iter().map(strike).collect())
}
