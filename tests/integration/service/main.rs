//! The running service: real MQTT, a real database, and HTTP.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks the messages that it waits for"
)]

mod collector;
mod database;
mod program;
mod running;
mod web;

mod a_document;
mod actions;
mod api;
mod bad_input;
mod bulk;
mod config;
mod decommission;
mod duplicates;
mod estimates;
mod excluded;
mod forgetful;
mod http;
mod maintenance;
mod metrics;
mod quickstart;
mod replaced;
mod restart;
mod rollouts;
mod set_aside;
mod setpoint_command;
mod setpoints;
mod start;
mod told;
mod touch_tests;
mod traces;
