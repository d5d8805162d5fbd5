//! When a change is no longer chance.
//!
//! Knows innovations and changes of a whisker's state, not whiskers: what a change means is decided in
//! [`crate::robot`]. [`hypothesis`] lists what is looked for, [`candidate`] follows them, [`detector`]
//! mixes them and decides, [`start`] says since when they are supposed to go on, [`kinds`] and [`continuation`] tell them apart.

pub mod candidate;
pub mod continuation;
pub mod detector;
pub mod hypothesis;
pub mod kinds;
pub mod start;

pub use candidate::{Candidates, Evidence, Fit};
pub use detector::{DetectionParams, Detector, Others, Verdict};
pub use hypothesis::Kind;
pub use kinds::Change;
