//! `vibrissa-ros2` is a driver of the agent `vibrissa-robot`, and a ROS 2 node: contacts, strain and pressures come
//! from ROS topics, setpoints, estimates and reports go to them. No ROS installation is needed. `docs/ros2.md` describes
//! the topics.

pub mod actions;
pub mod bridge;
mod health;
pub mod lifecycle;
mod lines;
pub mod link;
pub mod log;
pub mod managed;
pub mod mapping;
pub mod messages;
pub mod names;
pub mod node;
pub mod options;
pub mod params;
pub mod remap;
pub mod ros_args;
mod stamps;
mod subscriptions;
#[cfg(test)]
mod tests;
pub mod touch;
pub mod units;
mod whisker;
pub mod words;
