//! Attacks on the real program: one robot with its own password, or anyone who reaches a port, tries to stop or mislead
//! a fleet.

#![allow(
    clippy::unwrap_used,
    clippy::wildcard_enum_match_arm,
    reason = "a test that cannot go on has failed, and it picks the messages that it waits for"
)]

mod access;
mod access_list;
mod allow_list;
mod clocks;
mod connections;
mod crowds;
mod database_errors;
mod deaf;
mod fair;
mod flapping;
mod forgeries;
mod fuzz;
mod headers;
mod http_program;
mod jwt;
mod listener;
mod monitoring;
mod odd_values;
mod old_boots;
mod planted;
mod refused_rows;
mod routes;
mod stage;
mod started;
mod startup;
mod stepped_clock;
mod supervised;
mod takeover;
mod unheard_owner;
mod with_limits;
mod wrong_clock;

use tokio::sync::{Mutex, MutexGuard};

/// Lock for tests that load all processors or measure times: they run one at a time, beside tests that mostly wait.
pub(crate) async fn turn() -> MutexGuard<'static, ()> {
    static TURN: Mutex<()> = Mutex::const_new(());
    TURN.lock().await
}
