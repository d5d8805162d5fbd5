//! What HTTP tells of rows that were written by hand, on both databases.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod document;
mod groups;
mod pages;
mod pictures;
mod rows;
mod scope;
mod series;
mod served;
