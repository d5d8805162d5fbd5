//! The connection of one robot to the broker.
//!
//! One task only polls the MQTT event loop; another one works with the robot. Each connection is used once: after
//! it breaks, a new client makes a clean start, subscribes again and publishes the robot's birth again.

mod broker;
mod connection;
mod problem;
mod session;
mod silence;

pub use broker::{Authorities, BadBroker, Broker, ClientCertificate, address, password_in};
pub use rumqttc::Transport;
pub use session::{Delivery, Endpoint, Signals, run};
