//! The service in simulated time: supervisors, robots, broker, store and clocks in one thread, with faults, from one seed.

pub mod broker;
pub mod invariants;
pub mod oracle;
pub mod plan;
pub mod process;
pub mod robots;
pub mod store;
