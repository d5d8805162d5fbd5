//! What a whisker array is and what to do about it, with no clock, no I/O and no randomness.
//!
//! Read in this order: [`units`], then [`mechanics`] (the paper's equations and their inverses),
//! [`estimation`] (what one contact says about a whisker's length), [`detection`] (when a change is no
//! longer chance), [`policy`] (who compensates for whom), and [`robot`], where
//! `step(state, params, now, event)` puts them together.

mod encoding;
pub mod text;
pub mod units;

pub mod mechanics;

pub mod estimation;

pub mod detection;

pub mod policy;

pub mod robot;
