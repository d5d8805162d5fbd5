//! Robots that keep the MQTT contract, with whiskers whose truth is known.
//!
//! The inside is pure: [`Robot`] has no sockets and no clock; it is polled with the time and given what
//! was received, and returns what to send. The same seed and the same inputs give the same contacts byte
//! for byte. Outside of it, [`Fleet`] drives robots over real MQTT by the wall clock.
//!
//! A [`state`] file keeps the truth of a fleet over restarts of the process.
//!
//! Read in this order: [`scenario`] (what is simulated), [`plant`] and [`regulator`] (a whisker's
//! physics), [`robot`] (the contract), [`fleet`] (the network). [`load`] is another thing: many messages, made cheaply.

mod commands;
mod driver;
pub mod fleet;
mod journal;
mod link;
pub mod load;
pub mod outbox;
pub mod plant;
mod random;
pub mod regulator;
pub mod robot;
pub mod scenario;
pub mod state;

pub use fleet::{Authorities, Broker, CannotStart, Fleet, RobotHandle};
pub use journal::{HeardSetpoint, JournalEntry};
pub use plant::LengthChange;
pub use robot::{Outgoing, Robot, RobotConfig, Whisker};
pub use scenario::Scenario;
pub use state::StateError;
