//! How well the core does, measured: detection, health and compensation on simulated whiskers whose truth is
//! known. Nothing here is given to the core that the service would not have.

#[expect(clippy::wildcard_enum_match_arm, reason = "of many effects it looks at a few")]
pub mod compensation;
pub mod crowd;
pub mod detection;
pub mod health;
#[expect(clippy::wildcard_enum_match_arm, reason = "of many effects and messages it looks at a few")]
pub mod world;

pub use world::World;
