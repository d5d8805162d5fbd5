//! Recorded traffic through the core once more: what would have been decided, and why, without a broker or a
//! database.
//!
//! Read in this order: [`line`](mod@line) (what a recording looks like), [`lines`] (reading one of any size),
//! [`replayer`] (messages and time into the core), `answers` (what robots say to setpoints that nobody sent them),
//! [`told`] (effects as JSON lines), [`comparison`] (two policies on the same traffic).

pub mod line;
pub mod lines;

mod answers;
pub mod replayer;
mod status;

pub mod told;

pub mod comparison;

pub use comparison::Comparison;
pub use line::{LineError, Recorded};
pub use lines::Lines;
pub use replayer::{Happened, Replayer, What};
