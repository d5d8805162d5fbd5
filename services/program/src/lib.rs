//! Parts of every program here: the supervisor, the agent, the simulator and the laboratory.

pub mod clock;
pub mod files;
pub mod log;
pub mod log_filter;
pub mod options;
pub mod process;
pub mod random;
pub mod task;
