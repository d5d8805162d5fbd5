//! Tests with private brokers: TLS, certificates, passwords, access lists, and messages about problems.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks the messages that it waits for"
)]

mod client;
mod link;
mod raw;
mod recorder;
mod running;

mod access;
mod files;
mod limits;
mod nodes;
mod recovery;
mod refusals;
mod secrecy;
mod shipped;
