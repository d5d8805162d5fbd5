//! Nuisances of real robots and real silicone: none of them is a cut, and none may hide or forget one.

mod leaks;
mod losses;
mod rig;
mod scrapes;
mod second_cuts;
mod wear;
