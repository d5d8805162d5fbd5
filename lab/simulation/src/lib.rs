//! The service in simulated time: supervisors, robots, broker, store and clocks in one thread, with faults, from one seed.

pub mod store;
