//! Detects changes of a whisker's state.
//!
//! Knows innovations and state changes, not whiskers: [`crate::robot`] decides what a change means. [`hypothesis`]
//! lists the changes searched for, [`candidate`] holds their statistics, [`start`] their most likely starts. [`detector`]
//! mixes them and raises alarms. `decision` decides on an alarm; [`kinds`] and [`continuation`] tell the kinds apart.

pub mod candidate;
pub mod continuation;
mod decision;
pub mod detector;
pub mod hypothesis;
pub mod kinds;
pub mod start;

pub use candidate::{Candidates, Evidence, Fit};
pub use detector::{Checks, DetectionParams, Detector, Others, Situation, Verdict};
pub use hypothesis::HypothesisKind;
pub use kinds::Change;
pub use start::Stored;
