//! Simulated robots that obey the MQTT contract, with whiskers of known true state.
//!
//! The core is pure: [`Robot`] has no sockets and no clock. Its caller passes the time and received messages, and
//! gets the messages to send. The same seed and inputs give the same contacts byte for byte. [`Fleet`] drives
//! robots over real MQTT by the wall clock.
//!
//! A [`state`] file stores the true state of a fleet across restarts of the process.
//!
//! The rules of the contract are those of [`vibrissa_robot`], which real robots use, too. Robots break them on purpose by a
//! [`scenario::Misbehaviour`], which changes messages before or after the rules.
//!
//! Read in this order: [`scenario`] (input), [`plant`] and [`regulator`] (physics of a whisker), [`robot`] (the
//! contract), [`fleet`] (the network). [`load`] is separate: a cheap generator of many messages.

pub mod board;
pub mod clock;
pub mod fleet;
mod journal;
mod link;
pub mod load;
pub mod places;
pub mod plant;
mod random;
pub mod regulator;
pub mod robot;
mod robot_handle;
pub mod scenario;
pub mod state;

pub use fleet::{Authorities, Broker, CannotStart, Fleet, password_in};
pub use journal::{HeardSetpoint, JournalEntry};
pub use plant::LengthChange;
pub use robot::{Outgoing, Robot, RobotConfig, Whisker};
pub use robot_handle::RobotHandle;
pub use scenario::Scenario;
pub use state::StateError;
