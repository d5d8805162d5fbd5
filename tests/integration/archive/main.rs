//! The archive: whatever is killed, DuckDB finds each contact that robots made exactly once in its files.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod folder;
mod reading;
mod retention;
mod s3;
mod stage;
