//! HTTP answers for rows that the test has written, on both databases.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod access;
mod alarms;
mod alarms_at_once;
mod assistant;
mod board;
mod bulk;
mod contact_uses;
mod document;
mod events;
mod exports;
mod fleets;
mod formats;
mod groups;
mod history;
mod items;
mod labels;
mod maintenance;
mod notes;
mod oidc;
mod overview;
mod pages;
mod proxies;
mod rollouts;
mod rows;
mod scope;
mod series;
mod served;
mod sign_in;
mod streams;
mod timeline;
mod words;
