//! Tests of dashboards and alerts with a real Prometheus and a real PostgreSQL.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod alerts;
mod dashboards;
