//! docs/first-robot.md with a board, in simulated time: the sketch on a simulated microcontroller with slide, rod,
//! chambers and gauges, the agent, and the supervisor's core. No clock of this machine is read, so its speed does not
//! matter.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks what it waits for"
)]

mod desk;
mod microcontroller;
mod walk;
