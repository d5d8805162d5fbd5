//! Chooses compensators for broken whiskers.
//!
//! Knows lengths, pressures and offsets, not MQTT or SQL. [`candidate`] evaluates one whisker as a compensator;
//! [`assignment`] picks the best set for an array; [`params`] declares the settings of both.

pub mod assignment;
pub mod candidate;
pub mod params;

pub use assignment::{Offer, assign};
pub use candidate::{Case, Fitness, Ineligible, Proposal, READING_GAINS, Refused, propose};
pub use params::{LongerForShorter, Mode, PolicyNumber, PolicyParams};
