//! Messages of robots that come from a partitioned log instead of the broker.

use bytes::Bytes;
use vibrissa_protocol::{Name, RobotTopic, Topic};

/// Why a record of the log is skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Skipped {
    /// Neither a header nor the key is an MQTT topic of a robot.
    NoTopic,
    /// The topic is of another fleet.
    OtherFleet,
    /// A message that supervisors receive over MQTT only.
    OtherMessage,
    /// The record has no value.
    NoValue,
    /// The log has deleted it before it was read.
    Deleted,
    /// A header names another robot, or another message, than the key.
    Contradiction,
    /// The record cannot be read.
    Unreadable,
}

impl Skipped {
    /// All reasons.
    pub(crate) const ALL: [Self; 7] = [
        Self::NoTopic,
        Self::OtherFleet,
        Self::OtherMessage,
        Self::NoValue,
        Self::Deleted,
        Self::Contradiction,
        Self::Unreadable,
    ];

    /// The reason as a label of metrics.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::NoTopic => "NO_TOPIC",
            Self::OtherFleet => "OTHER_FLEET",
            Self::OtherMessage => "OTHER_MESSAGE",
            Self::NoValue => "NO_VALUE",
            Self::Deleted => "DELETED",
            Self::Contradiction => "CONTRADICTION",
            Self::Unreadable => "UNREADABLE",
        }
    }
}

/// Records of a partition that were read together, in order.
#[derive(Debug, Clone)]
pub(crate) struct LogBatch {
    /// Offset of the first record.
    pub(crate) from: i64,
    /// Offset after the last record.
    pub(crate) to: i64,
    /// The messages among the records.
    pub(crate) records: Vec<LogRecord>,
}

/// Where the log is to be read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LogStart {
    /// From its first record.
    Earliest,
    /// From this record.
    At(i64),
}

/// A message of a robot of the fleet.
#[derive(Debug, Clone)]
pub(crate) struct LogRecord {
    /// Offset of the record in the partition.
    pub(crate) offset: i64,
    /// The MQTT topic.
    pub(crate) topic: Topic,
    /// The robot.
    pub(crate) robot: Name,
    /// Contacts or status.
    pub(crate) kind: RobotTopic,
    /// The payload of the MQTT message.
    pub(crate) payload: Bytes,
}
