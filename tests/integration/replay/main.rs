//! Recordings of a real broker's messages, replayed and compared with the recorded supervisor's decisions.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod black_box;
mod by_hand;
mod live;
mod program;
