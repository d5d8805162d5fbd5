//! The robot of `docs/robot-quickstart.md`, as it stands there: it keeps the contract's rules.

mod by_hand;
mod script;
mod supervised;
