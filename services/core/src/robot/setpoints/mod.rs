//! Setpoints: their way to the robot, and those that operators ask for.

pub(in crate::robot) mod command;
pub(in crate::robot) mod operator;
pub(in crate::robot) mod tries;
