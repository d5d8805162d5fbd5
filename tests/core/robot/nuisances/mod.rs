//! Nuisances of real robots and real silicone: none of them is a cut, and none may hide or forget one.

mod camera;
mod confirmed;
mod curvature;
mod factory;
mod leaks;
mod learning;
mod losses;
mod maintenance;
mod noise;
pub(crate) mod rig;
mod scrapes;
mod second_cuts;
mod temperature;
mod touches;
mod turns;
mod wandering;
mod wear;
mod zeros;
mod zones;
