//! `vibrissa-ros2` with a robot that uses another implementation of DDS. The tests play the agent, or run the real one.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod agent;
mod bridge;
mod mapping;
mod stage;
