//! What every program asks of its host: time, randomness, tasks and connections. In simulated time a simulation answers.

pub mod clock;
pub mod process;
pub mod random;
pub mod task;
mod time_line;

pub use time_line::TimeLine;
