//! The laboratory: everything that examines the service, the core or a robot, and runs no fleet.
//!
//! Its program `vibrissa-lab` has the commands of [`vibrissa`], too.

pub mod cli;

pub mod check;
pub mod demo;
pub mod figures;
pub mod replay;
