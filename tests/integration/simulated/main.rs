//! The service in simulated time: drawn histories keep all invariants, each planted fault is found, and a seed gives one history.

mod controls;
mod histories;
mod log;

use vibrissa_simulation::plan::Kind;

/// Faults that lead to a new owner of a fleet whose last owner is forgotten.
const LOST_EPOCHS: [Kind; 5] =
    [Kind::StoreClockStepped, Kind::StoreFailover, Kind::SupervisorKilled, Kind::SupervisorFrozen, Kind::FromStoreCut];
