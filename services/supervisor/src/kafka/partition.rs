//! Reads one partition of a fleet's topic. A partition that fails does not stop the others.

use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use tokio::sync::mpsc;
use tokio::time::timeout;
use tracing::{error, info, warn};

use super::client::KafkaError;
use super::topic::FleetTopic;
use super::wire::{Brokers, OffsetAt, SharedBrokers};
use crate::backoff::Backoff;
use crate::log_inbox::{LogBatch, LogRange, Skipped};

/// A broker answers a read at the latest after half a second, if it and the network work.
const LATE: Duration = Duration::from_secs(3);
/// Most records that the engine steps at a time.
const RECORDS_AT_A_TIME: usize = 512;

/// Reads one partition.
pub(super) struct PartitionReader {
    pub(super) of: FleetTopic,
    pub(super) log: Arc<SharedBrokers>,
    pub(super) partition: u32,
    /// Next offset to read; `None` for the first record.
    pub(super) next: Option<i64>,
}

impl PartitionReader {
    /// Reads until the engine is gone.
    pub(super) async fn run(mut self, batches: mpsc::Sender<LogBatch>) {
        let (mut backoff, mut logged) = (Backoff::default(), None);
        while !batches.is_closed() {
            let before = self.next;
            let Err(problem) = self.connect_and_read(&batches).await else { return };
            self.of.note(self.partition, |state| state.is_connected = false);
            let (text, fleet, topic) = (problem.to_string(), &self.of.fleet, &self.of.name);
            if logged.as_ref() != Some(&text) {
                warn!(problem = %text, %fleet, %topic, partition = self.partition, "cannot read the log, retrying");
                logged = Some(text);
            }
            if self.next != before {
                backoff = Backoff::default();
            }
            backoff.wait().await;
        }
    }

    async fn connect_and_read(&mut self, batches: &mpsc::Sender<LogBatch>) -> Result<(), KafkaError> {
        let log = self.log.get().await?;
        let read = self.read(&log, batches).await;
        if read.is_err() {
            self.log.forget(&log).await;
        }
        read
    }

    /// Waits for an answer. The partition does not count as connected while its answer is late: then nobody knows whether
    /// the robots are silent.
    async fn heard<T>(&self, answer: impl Future<Output = T>) -> T {
        let mut answer = pin!(answer);
        if let Ok(answer) = timeout(LATE, &mut answer).await {
            return answer;
        }
        self.of.note(self.partition, |state| state.is_connected = false);
        answer.await
    }

    /// Reads over one connection. Returns without an error when the engine is gone.
    async fn read(&mut self, log: &Brokers, batches: &mpsc::Sender<LogBatch>) -> Result<(), KafkaError> {
        let (of, partition) = (self.of.clone(), self.partition);
        let (fleet, topic) = (&of.fleet, &of.name);
        let client = log.open(topic, partition).await?;
        let earliest = client.offset(OffsetAt::Earliest).await?;
        let latest = client.offset(OffsetAt::Latest).await?;
        let mut at = self.next.unwrap_or(earliest);
        if at < earliest {
            of.skipped(Skipped::Deleted, at.abs_diff(earliest));
            error!(
                %fleet, %topic, partition, at, earliest,
                "the log has deleted records before they were read: robots send contacts without a receipt again. Keep \
                 records longer"
            );
            at = earliest;
        } else if at > latest {
            error!(
                %fleet, %topic, partition, at, latest,
                "the log ends before the stored position, because it was created anew: reading from its first record"
            );
            at = earliest;
        }
        info!(%fleet, %topic, partition, at, latest, "reading contacts from the log");
        let mut partitions = of.note(partition, |_| ());
        loop {
            self.next = Some(at);
            let read = self.heard(of.fetch((&client, partitions), at)).await?;
            of.note(partition, |state| state.is_connected = true);
            let (after, end) = (read.next, read.end);
            let mut read = read.records.into_iter().peekable();
            while read.peek().is_some() {
                let from = at;
                let mut records = Vec::new();
                for record in read.by_ref().take(RECORDS_AT_A_TIME) {
                    at = record.offset + 1;
                    match of.message(record) {
                        Ok(record) => records.push(record),
                        Err(reason) => of.skipped(reason, 1),
                    }
                }
                let range = LogRange { partition, from, to: at };
                if batches.send(LogBatch { range, records }).await.is_err() {
                    return Ok(());
                }
                self.next = Some(at);
            }
            at = after;
            partitions = of.note(partition, |state| state.lag = (end - at).max(0));
            if batches.is_closed() {
                return Ok(());
            }
        }
    }
}
