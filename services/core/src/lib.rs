//! Model and decisions for arrays of soft whiskers, with no clock, no I/O and no randomness.
//!
//! Read in this order: [`units`], [`mechanics`] (the paper's equations and their inverses), [`estimation`] (a
//! whisker's length and offset from its contacts), [`detection`] (changes that are no longer chance), [`policy`]
//! (the choice of compensators), and [`robot`], whose `step(params, now, event)` puts them together.
//! [`rollout`] compares robots with and without a change.

mod encoding;
mod optional_parts;
pub mod text;
pub mod units;

pub mod mechanics;

pub mod estimation;

pub mod detection;

pub mod policy;

pub mod robot;

pub mod rollout;
