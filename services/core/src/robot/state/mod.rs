//! The state of a robot: its clock, its message numbers, its layout and its whiskers.

pub(in crate::robot) mod clock;
pub(in crate::robot) mod deadline;
pub(in crate::robot) mod head;
pub(in crate::robot) mod layout;
pub(in crate::robot) mod places;
pub(in crate::robot) mod rare_state;
pub(in crate::robot) mod rebaseline;
pub mod sequence;
pub mod sheet;
pub(in crate::robot) mod tracked;
pub mod whisker;
