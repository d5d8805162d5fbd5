//! The stored bytes of robots and whiskers, with a version each.

mod parts;
pub(in crate::robot) mod robot;
mod whisker;
