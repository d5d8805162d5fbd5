//! Replays recorded traffic through the core, without a broker or a database: shows the decisions that would have been
//! made, and their reasons.
//!
//! Read in this order: [`vibrissa_edge::recording`] (format of a recording), [`vibrissa::recording::lines`] (reading one
//! of any size), [`replayer`] (messages and time for the core), `answers` (robots' answers to setpoints that were never
//! sent to them), [`effect_json`] (effects as JSON lines), [`comparison`] (two policies on the same traffic).

mod answers;
mod recorded_tests;
mod refusals;
pub mod replayer;
mod status;

pub mod effect_json;

pub mod comparison;

pub use comparison::Comparison;
pub use refusals::Refusals;
pub use replayer::{Happened, Replayer, What};
pub use vibrissa_edge::recording::{LineError, Recorded};
