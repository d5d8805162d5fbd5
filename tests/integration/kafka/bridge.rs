//! Records as a bridge from MQTT to the log writes them.

use rskafka::record::Record;
use vibrissa_edge::partition::robot_hash;
use vibrissa_protocol::{Contacts, RobotTopic, encode};
use vibrissa_tests::kafka;

pub(crate) const MESSAGES: &str = "vibrissa.messages";

/// The record of a robot's message.
pub(crate) fn record_of(robot: &str, kind: RobotTopic, value: Vec<u8>) -> Record {
    kafka::record_of("f", robot, kind, value)
}

pub(crate) fn records(robot: &str, messages: &[Contacts]) -> Vec<Record> {
    messages.iter().map(|message| record_of(robot, RobotTopic::Contacts, encode(message))).collect()
}

/// The partition of a robot.
pub(crate) fn partition(robot: &str, partitions: u32) -> u32 {
    robot_hash("f", robot) % partitions
}
