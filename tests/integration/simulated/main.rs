//! The service in simulated time: drawn histories keep all invariants, each planted fault is found, and a seed gives one history.

mod controls;
mod histories;
