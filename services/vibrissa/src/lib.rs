//! The program `vibrissa`: its command line and configuration, exports and recordings.
//!
//! The service is in [`vibrissa_supervisor`], its database in [`vibrissa_store`].

pub mod cli;
pub mod config;

pub mod export;
pub mod exposure;
pub mod recording;
