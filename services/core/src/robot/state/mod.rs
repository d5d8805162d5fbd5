//! The state of a robot: its clock, its message numbers, its layout and its whiskers.

pub(in crate::robot) mod arrival;
pub(in crate::robot) mod clock;
pub(in crate::robot) mod contact_evaluation;
pub(in crate::robot) mod deadline;
pub mod factsheet;
pub(in crate::robot) mod first_contacts;
pub(in crate::robot) mod head;
pub(in crate::robot) mod index;
pub(in crate::robot) mod layout;
pub(in crate::robot) mod place;
pub(in crate::robot) mod rare_state;
pub(in crate::robot) mod rebaseline;
pub mod sequence;
mod suspected_length;
pub(in crate::robot) mod tracked;
pub mod whisker;
