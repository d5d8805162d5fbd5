//! Detects changes of a whisker's state.
//!
//! Knows innovations and state changes, not whiskers: [`crate::robot`] decides what a change means. [`hypothesis`]
//! lists the changes searched for, [`candidate`] holds their statistics, [`detector`] mixes them and decides,
//! [`start`] holds their most likely starts, [`kinds`] and [`continuation`] tell the kinds apart.

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
