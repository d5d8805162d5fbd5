//! `vibrissa-ros2` with a robot that uses another implementation of DDS; the test plays the agent.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod bridge;
mod stage;
