//! When a change is no longer chance.
//!
//! Knows innovations and changes of a whisker's state, not whiskers: what a change means is decided in
//! [`crate::robot`]. [`hypothesis`] lists what is looked for, [`candidate`] follows them, [`detector`]
//! mixes them and decides, [`kinds`] and [`continuation`] tell them apart.

pub mod candidate;
pub mod continuation;
pub mod detector;
pub mod hypothesis;
pub mod kinds;

pub use candidate::{Candidates, Evidence, Fit};
pub use detector::{DetectionParams, Detector, Others, Verdict};
pub use hypothesis::Kind;
pub use kinds::Change;
