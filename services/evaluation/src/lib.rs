//! How well the core does, measured: detection, health and compensation on simulated whiskers whose truth is
//! known. Nothing here is given to the core that the service would not have.

pub mod world;

pub use world::World;
