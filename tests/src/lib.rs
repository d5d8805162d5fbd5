//! What the integration tests share.

pub mod mosquitto;
pub mod observer;
pub mod robot;
pub mod wait;
pub mod world;
