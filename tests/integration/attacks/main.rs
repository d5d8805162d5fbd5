//! Attacks on the real program: one robot with its own password, or anyone who reaches a port, tries to stop or mislead a fleet.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod connections;
mod database_errors;
mod headers;
mod http_program;
mod monitoring;
mod planted;
mod refused_rows;
mod stage;
mod access;
mod jwt;
mod routes;
mod started;
mod startup;
mod clocks;
mod forgeries;
mod odd_values;
mod old_boots;
mod allow_list;
mod crowds;
mod fair;
mod supervised;
mod with_limits;
