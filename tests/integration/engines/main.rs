//! The features of brokers that the supervisor and its robots need, and a fleet on each broker.
//!
//! Mosquitto, the embedded broker, RMQTT (one node and three) and Apache Artemis (one and a pair). `tests/artemis` and
//! `tests/rmqtt` install the last two; an engine that is not installed is skipped, and the skip is printed. The model broker of
//! the simulation passes the same checks.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks the messages that it waits for"
)]

mod artemis;
mod engine;
mod feature;
mod peer;
mod running;

mod conformance;
mod document;
mod failover;
mod fleet;
mod late;
mod old_robot;
