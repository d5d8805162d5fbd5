//! Reads all partitions of a fleet's topic.
//!
//! Consumer groups are not used: the owner of the fleet's lease reads, and the positions are in the database.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::task::JoinSet;
use tokio::time::sleep;
use tracing::{error, warn};
use vibrissa_host::task;

use super::again::Again;
use super::client::KafkaError;
use super::partition::PartitionReader;
use super::topic::FleetTopic;
use super::wire::SharedBrokers;
use crate::backoff::Backoff;
use crate::log_inbox::{LogBatch, LogRange, LogRecord, LogSource, NextOffsets, Recall};

/// Interval of the looks for new partitions.
const LOOK_EVERY: Duration = Duration::from_secs(30);

/// Reads the topic of one fleet: for the engine, and again for its recovery. Clones share their state.
#[derive(Debug, Clone)]
pub(crate) struct LogReader {
    topic: FleetTopic,
}

impl LogReader {
    pub(super) fn new(topic: FleetTopic) -> Self {
        Self { topic }
    }

    /// The log for an engine. A task reads records again for it, until the engine is gone.
    pub(crate) fn source(&self) -> LogSource {
        let topic = self.topic.counting_anew();
        let (recalls, wanted) = mpsc::channel(1);
        let source = LogSource::new(topic.name.clone(), topic.link.clone(), recalls, topic.set_aside.clone());
        task::spawn(Self { topic }.answer(wanted));
        source
    }

    /// Answers what an engine asks while it recovers robots.
    async fn answer(self, mut wanted: mpsc::Receiver<Recall>) {
        let mut again = None;
        while let Some(wanted) = wanted.recv().await {
            match wanted {
                Recall::Records(range, mut answer) => {
                    let records = tokio::select! {
                        records = self.records(&mut again, range) => Some(records),
                        () = answer.closed() => None,
                    };
                    match records {
                        // An error means that nobody waits any more.
                        Some(records) => drop(answer.send(records)),
                        None => again = None,
                    }
                }
                Recall::Done => again = None,
            }
        }
    }

    /// The messages of records that were read before. Tries until the log answers.
    async fn records(&self, again: &mut Option<Again>, range: LogRange) -> Vec<LogRecord> {
        let (mut backoff, mut is_failing) = (Backoff::default(), false);
        loop {
            match self.try_records(again, range).await {
                Ok(records) => return records,
                Err(problem) => {
                    *again = None;
                    if !std::mem::replace(&mut is_failing, true) {
                        let partition = range.partition;
                        error!(
                            %problem, fleet = %self.topic.fleet, partition,
                            "cannot read the log again for the recovery, retrying"
                        );
                    }
                    backoff.wait().await;
                }
            }
        }
    }

    async fn try_records(&self, again: &mut Option<Again>, range: LogRange) -> Result<Vec<LogRecord>, KafkaError> {
        let again = match again {
            Some(again) => again,
            none => none.insert(Again::start(&self.topic).await?),
        };
        again.records(&self.topic, range).await
    }

    /// Reads from these offsets until the engine is gone: one task for each partition. New partitions are read from
    /// their first record.
    pub(crate) async fn run(self, mut from: NextOffsets, batches: mpsc::Sender<LogBatch>) {
        self.topic.metrics.log_ingest.set(1);
        let (log, mut tasks) = (Arc::new(SharedBrokers::new(self.topic.connector.clone())), JoinSet::new());
        let (mut known, mut backoff, mut logged) = (0, Backoff::default(), None);
        loop {
            match self.count(&log).await {
                Ok(count) => {
                    (backoff, logged) = (Backoff::default(), None);
                    // Known before one of them answers: the log is not connected until all do.
                    for partition in known..count {
                        self.topic.note(partition, |_| ());
                    }
                    for partition in known..count {
                        let next = from.remove(&partition);
                        let reader = PartitionReader { of: self.topic.clone(), log: log.clone(), partition, next };
                        task::spawn_in(&mut tasks, reader.run(batches.clone()));
                    }
                    known = known.max(count);
                    tokio::select! {
                        () = batches.closed() => return,
                        () = sleep(LOOK_EVERY) => {}
                        // A task that was not aborted ends with the engine, or by a panic.
                        Some(Err(ended)) = tasks.join_next() => std::panic::resume_unwind(ended.into_panic()),
                    }
                }
                Err(problem) => {
                    let text = problem.to_string();
                    if logged.as_ref() != Some(&text) {
                        warn!(
                            problem = %text, fleet = %self.topic.fleet, topic = %self.topic.name,
                            "cannot learn the partitions of the log, retrying"
                        );
                        logged = Some(text);
                    }
                    tokio::select! {
                        () = batches.closed() => return,
                        () = backoff.wait() => {}
                    }
                }
            }
        }
    }

    /// Number of partitions that the topic has now.
    async fn count(&self, shared: &SharedBrokers) -> Result<u32, KafkaError> {
        let log = shared.get().await?;
        let counted = log.partitions_now(&self.topic.name).await;
        if counted.is_err() {
            shared.forget(&log).await;
        }
        counted
    }
}
