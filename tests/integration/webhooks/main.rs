//! Webhooks: real supervisors deliver to a real receiver, on both databases.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod delivery;
mod failures;
mod killed;
mod limits;
mod mailbox;
mod mails;
mod maintenance;
mod managed;
mod receiver;
mod stage;
