//! The agent of real robots with drivers, brokers and supervisors: `vibrissa-robot`.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks what it waits for"
)]

mod chaos;
mod checked;
mod document;
mod first_robot;
mod links;
mod secured;
mod stage;
mod strain;
mod valves;
