//! Measures the core's performance in detection, health and compensation on simulated whiskers with known true
//! state. The core gets no information that it would not have in service.

#[expect(clippy::wildcard_enum_match_arm, reason = "only a few of many effects matter")]
pub mod compensation;
pub mod crowd;
pub mod detection;
pub mod health;
pub mod reality;
#[expect(clippy::wildcard_enum_match_arm, reason = "only a few of many effects and messages matter")]
pub mod world;

mod deviation;

pub use world::World;
