//! When a change is no longer chance.
//!
//! Knows innovations and shifts of log length, not whiskers: what a change means is decided in
//! [`crate::robot`]. [`candidate`] follows one supposed shift, [`detector`] mixes them and decides.

pub mod candidate;
pub mod detector;

pub use candidate::{Candidate, Evidence, SlopeFit};
pub use detector::{Change, ChangeKind, DetectionParams, Detector, Verdict};
