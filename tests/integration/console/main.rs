//! The operators' console in a real browser with a real service.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod alarms;
mod axe;
mod browser;
mod browsing;
mod charts;
mod checks;
mod following;
mod incidents;
mod stage;
mod story;
mod touch_tests;
mod widths;
mod zones;

mod acting;
mod advising;
mod keyboard;
mod live;
mod loading;
mod overview;
mod picture;
mod reading;
mod signing_in;
