//! Parts of every program here: the supervisor, the agent, the simulator and the laboratory.

pub mod completions;
pub mod files;
pub mod log;
pub mod log_filter;
pub mod options;
pub mod signals;
