//! PostgreSQL with automatic failover: Patroni and etcd, HAProxy, PgBouncer, and a failover that loses commits.
//!
//! A supervisor and robots run while servers fail. In the end the robots' own record is compared with the database.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod haproxy;
mod lost_tail;
mod pair;
mod pgbouncer;
mod stage;
