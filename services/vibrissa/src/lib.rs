//! The program `vibrissa`: its command line and configuration, the demo, the check of a robot, recording and replay.
//!
//! The service is in [`vibrissa_supervisor`], its database in [`vibrissa_store`].

pub mod cli;
pub mod config;

pub mod check;
pub mod demo;
pub mod export;
pub mod exposure;
pub mod figures;
pub mod record;
pub mod replay;
