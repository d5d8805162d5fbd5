//! Stands in for the module `kafka` in a build without the feature `kafka`: the same names, and no log can be configured.
//! [`Kafka`] has no value, so no method of this module ever runs except [`Kafka::new`].

use tokio::sync::mpsc;
use vibrissa_protocol::Name;
use vibrissa_store::Store;

use crate::events::EventSink;
use crate::kafka_options::KafkaOptions;
use crate::log_inbox::{LogBatch, LogSource, NextOffsets};
use crate::metrics::FleetMetrics;
use crate::readiness::Readiness;

/// A type without values.
#[derive(Debug, Clone, Copy)]
enum Never {}

/// The log, which does not exist.
#[derive(Debug, Clone)]
pub(crate) struct Kafka(Never);

/// A log is configured.
#[derive(Debug, thiserror::Error)]
#[error("this program was built without Kafka: build it with --features kafka, or leave publish and ingest out")]
pub struct KafkaError;

impl Kafka {
    /// Nothing, if nothing is configured.
    ///
    /// # Errors
    /// A log is configured, and the feature `kafka` is not built in.
    pub(crate) fn new(options: &KafkaOptions) -> Result<Option<Self>, KafkaError> {
        if options.publish.is_some() || options.ingest.is_some() { Err(KafkaError) } else { Ok(None) }
    }

    pub(crate) fn sink(&self, _: &Name, _: &FleetMetrics) -> Option<EventSink> {
        match self.0 {}
    }

    pub(crate) fn reader(&self, _: &Name, _: &FleetMetrics, _: &Readiness) -> Option<LogReader> {
        match self.0 {}
    }

    pub(crate) fn publish(&self, _: &Store, _: &Name, _: &FleetMetrics, _: EventSink) -> Option<Task> {
        match self.0 {}
    }
}

/// A task of the log, which does not exist.
#[derive(Debug)]
pub(crate) struct Task(Never);

/// The reader of a log, which does not exist.
#[derive(Debug, Clone)]
pub(crate) struct LogReader(Never);

impl LogReader {
    pub(crate) fn source(&self) -> LogSource {
        match self.0 {}
    }

    #[expect(clippy::unused_async, reason = "as in the module that this one stands in for")]
    pub(crate) async fn run(self, _: NextOffsets, _: mpsc::Sender<LogBatch>) {
        match self.0 {}
    }
}
