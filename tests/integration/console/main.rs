//! The operators' console in a real browser with a real service.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod alarms;
mod axe;
mod board;
mod browser;
mod browsing;
mod bulk;
mod candour;
mod charts;
mod checks;
mod counted;
mod design;
mod failing;
mod following;
mod incidents;
mod interface;
mod keycloak;
mod provider;
mod stage;
mod story;
mod tale;
mod told;
mod touch_tests;
mod tour;
mod vented;
mod webhooks;
mod widths;
mod zones;

mod acting;
mod advising;
mod keyboard;
mod labels;
mod live;
mod loading;
mod maintenance;
mod notes;
mod notifying;
mod overview;
mod picture;
mod reading;
mod rollouts;
mod saving;
mod signing_in;
