//! Chooses compensators for broken whiskers.
//!
//! Knows lengths, pressures and offsets, not MQTT or SQL. [`candidate`] evaluates one whisker as a compensator;
//! [`assignment`] picks the best set for an array.

pub mod assignment;
pub mod candidate;

pub use assignment::{Offer, assign};
pub use candidate::{Case, Fitness, Ineligible, LongerForShorter, Mode, PolicyParams, Proposal, Refused, propose};
