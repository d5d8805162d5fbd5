//! The robot's side of the MQTT contract.
//!
//! [`contract`] has the rules, each once: the agent of real robots and the simulated robots use them. It is pure: no
//! sockets and no clock. [`mqtt`] carries the messages of one robot over a connection that it renews.

pub mod clock;
pub mod contract;
pub mod mqtt;
