//! The robot's side of the MQTT contract.
//!
//! [`contract`] has the rules, each once: the agent of real robots and the simulated robots use them. It is pure: no
//! sockets and no clock. [`agent`] stands between the contract and a [`driver`], and is pure, too. [`store`] keeps what
//! survives a restart, [`hub`] runs an agent, [`ending`] tells another program why it has ended, [`mqtt`] carries the messages of one robot over a connection that it renews, and [`config`] is
//! `agent.toml`. [`preflight`] and [`exposure`] say what is wrong with it on this machine.
//! [`monitor`] shows a running agent to a person, [`discover`] the serial devices, and [`calibrate`] measures what the
//! configuration must know of gauges, sensors and valves.

pub mod agent;
pub mod calibrate;
pub mod clock;
pub mod config;
pub mod contract;
pub mod discover;
pub mod driver;
pub mod ending;
pub mod exposure;
pub mod hub;
pub mod monitor;
pub mod mqtt;
pub mod preflight;
pub mod store;

pub use vibrissa_regulator as regulator;
pub use vibrissa_segmenter as segmenter;

pub use agent::{Agent, Input, Output};
pub use config::Config;
