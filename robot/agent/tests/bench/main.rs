//! The program `vibrissa-robot` with drivers on a bench, and a person who follows its requests.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod calibrate;
mod driver;
mod several;
