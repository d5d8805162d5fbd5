//! The service in simulated time: drawn histories keep all invariants, each planted fault is found, and a seed gives one history.

mod controls;
mod histories;
mod log;

use std::time::Duration;

use vibrissa_simulation::plan::{Kind, Strike};

/// Faults that lead to a new owner of a fleet whose last owner is forgotten.
const LOST_EPOCHS: [Kind; 5] =
    [Kind::StoreClockStepped, Kind::StoreFailover, Kind::SupervisorKilled, Kind::SupervisorFrozen, Kind::FromStoreCut];

/// One fault of a shrunk history, times in milliseconds.
fn strike(at_ms: u64, kind: Kind, lasts_ms: u64, victim: usize, measure: u64) -> Strike {
    let (at, lasts) = (Duration::from_millis(at_ms), Duration::from_millis(lasts_ms));
    Strike { at, lasts, kind, victim, measure }
}
