//! Recordings: made from a real broker, replayed, and compared with what the supervisor of that time did.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod by_hand;
mod live;
mod program;
