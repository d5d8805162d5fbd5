//! The condition of whiskers, gauges and chambers, and the alarms that follow from it.

mod alarms;
pub(in crate::robot) mod array_shift;
pub(in crate::robot) mod contact;
mod deafness;
pub(in crate::robot) mod duplicate;
pub(in crate::robot) mod exchange;
mod fault_changes;
pub(in crate::robot) mod faults;
mod first_look;
pub(in crate::robot) mod flapping;
pub(in crate::robot) mod gauge;
pub(in crate::robot) mod misfit;
pub(in crate::robot) mod regained;
pub mod standing;
pub(in crate::robot) mod turn;
