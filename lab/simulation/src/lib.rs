//! The service in simulated time: supervisors, robots, broker, store and clocks in one thread, with faults, from one seed.

pub mod broker;
pub mod history;
pub mod invariants;
pub mod log;
pub mod member;
pub mod oracle;
pub mod panics;
pub mod plan;
pub mod process;
pub mod receivers;
pub mod record;
pub mod robots;
pub mod scenario;
pub mod server;
pub mod shrink;
pub mod statistics;
pub mod store;
pub mod world;
