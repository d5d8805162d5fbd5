//! The robot in `docs/robot-quickstart.md`, exactly as printed there, keeps the contract's rules.

mod by_hand;
mod checked;
mod script;
mod supervised;
