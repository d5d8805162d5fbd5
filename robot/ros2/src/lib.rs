//! `vibrissa-ros2` is a driver of the agent `vibrissa-robot`, and a ROS 2 node: contacts and pressures come from ROS
//! topics, setpoints and reports go to them. No ROS installation is needed. `docs/ros2.md` describes the topics.

pub mod bridge;
mod health;
pub mod log;
pub mod messages;
pub mod names;
pub mod node;
#[cfg(test)]
mod tests;
pub mod units;
mod whisker;
pub mod words;
