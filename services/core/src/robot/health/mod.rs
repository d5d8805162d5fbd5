//! The condition of whiskers, gauges and chambers, and the alarms that follow from it.

pub mod alarms;
pub(in crate::robot) mod array_shift;
pub(in crate::robot) mod contact;
mod deafness;
pub(in crate::robot) mod duplicate;
pub(in crate::robot) mod faults;
pub(in crate::robot) mod flapping;
pub(in crate::robot) mod gauge;
