//! The Python packages, built and installed from the checkout.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod client;
mod robot;
mod stage;
