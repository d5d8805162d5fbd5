//! Messages of robots that come from a partitioned log instead of the broker.

use std::collections::BTreeMap;
use std::future::pending;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use borsh::{BorshDeserialize, BorshSerialize};
use bytes::Bytes;
use tokio::sync::{mpsc, oneshot};
use vibrissa_protocol::{Name, RobotTopic, Topic};

use crate::link_state::LinkState;

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

/// Records of a partition that follow each other. The order is that of reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, BorshSerialize, BorshDeserialize)]
pub struct LogRange {
    /// Number of the partition.
    pub partition: u32,
    /// Offset of the first record.
    pub from: i64,
    /// Offset after the last record.
    pub to: i64,
}

/// Records of a partition that were read together, in order.
#[derive(Debug, Clone)]
pub struct LogBatch {
    /// Partition and offsets of the records.
    pub range: LogRange,
    /// The messages among the records.
    pub records: Vec<LogRecord>,
}

/// The next offset to read, by partition. A partition without one is read from its first record.
pub type NextOffsets = BTreeMap<u32, i64>;

/// A message of a robot of the fleet.
#[derive(Debug, Clone)]
pub struct LogRecord {
    /// Offset of the record in the partition.
    pub offset: i64,
    /// The topic of the contract.
    pub topic: Topic,
    /// The robot.
    pub robot: Name,
    /// Contacts or status.
    pub kind: RobotTopic,
    /// The payload of the message.
    pub payload: Bytes,
}

/// Requests of the engine to the log while it recovers robots.
#[derive(Debug)]
pub enum Recall {
    /// The messages of records that were read before. Ranges of a partition in rising order are read together.
    Records(LogRange, oneshot::Sender<Vec<LogRecord>>),
    /// No more are wanted now: the log may forget records that it has read ahead.
    Done,
}

/// The log as the engine knows it. Clones share their state.
#[derive(Debug, Clone)]
pub struct LogSource {
    /// Name of the topic.
    topic: Arc<str>,
    link: LinkState,
    recalls: mpsc::Sender<Recall>,
    /// Number of recalled records that could not be read.
    set_aside: Arc<AtomicU64>,
}

impl LogSource {
    /// The log on this topic of a transport, which answers the recalls.
    #[must_use]
    pub fn new(topic: Arc<str>, link: LinkState, recalls: mpsc::Sender<Recall>, set_aside: Arc<AtomicU64>) -> Self {
        Self { topic, link, recalls, set_aside }
    }

    /// Name of the topic.
    #[must_use]
    pub fn topic(&self) -> &str {
        &self.topic
    }

    /// State of the connection: whether all partitions of the log answer.
    #[must_use]
    pub fn link(&self) -> &LinkState {
        &self.link
    }

    /// The messages of records that were read before. Waits for the log, however long that takes: they are part of the
    /// fleet's state.
    pub async fn records(&self, range: LogRange) -> Vec<LogRecord> {
        let (answer, records) = oneshot::channel();
        // An error of either means that the transport has panicked: without the records there is no state.
        if self.recalls.send(Recall::Records(range, answer)).await.is_err() {
            return pending().await;
        }
        match records.await {
            Ok(records) => records,
            Err(_) => pending().await,
        }
    }

    /// Notes that no more records are wanted now.
    pub async fn records_are_read(&self) {
        // An error means that the transport has nothing to forget any more.
        let _ = self.recalls.send(Recall::Done).await;
    }

    /// Number of recalled records that could not be read.
    #[must_use]
    pub fn set_aside(&self) -> u64 {
        self.set_aside.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn the_transport_answers_each_recall_and_learns_when_all_are_read() {
        let (recalls, mut wanted) = mpsc::channel(1);
        let source = LogSource::new("t".into(), LinkState::default(), recalls, Arc::default());
        let transport = vibrissa_host::task::spawn(async move {
            let mut answered = Vec::new();
            while let Some(Recall::Records(range, answer)) = wanted.recv().await {
                let topic = Topic::parse("whisker/v1/f/r/contacts").unwrap();
                let (robot, kind) = (Name::robot("r").unwrap(), RobotTopic::Contacts);
                let record = LogRecord { offset: range.from, topic, robot, kind, payload: Bytes::new() };
                answer.send(vec![record]).unwrap();
                answered.push(range.from);
            }
            answered
        });
        for from in [3, 5] {
            let records = source.records(LogRange { partition: 0, from, to: from + 2 }).await;
            assert_eq!(records.iter().map(|record| record.offset).collect::<Vec<_>>(), [from]);
        }
        source.records_are_read().await;
        assert_eq!(transport.await.unwrap(), [3, 5]);
    }
}
