//! Who compensates for whom.
//!
//! Knows whiskers as lengths, pressures and offsets, not as MQTT or SQL. [`candidate`] asks of one whisker
//! whether and how well it can compensate, [`assignment`] picks the best set for an array.

pub mod assignment;
pub mod candidate;

pub use assignment::{Offer, assign};
pub use candidate::{Case, Fitness, Ineligible, LongerForShorter, Mode, PolicyParams, Proposal, Refused, propose};
