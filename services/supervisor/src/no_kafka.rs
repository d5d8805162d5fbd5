//! Stands in for the module `kafka` in a build without the feature `kafka`: the same names, and no log can be configured.
//! [`Kafka`] has no value, so no method of this module ever runs except [`Kafka::new`].

use vibrissa_edge::shard::FleetShard;
use vibrissa_store::Store;

use crate::events::EventSink;
use crate::kafka_options::KafkaOptions;
use crate::metrics::FleetMetrics;

/// A type without values.
#[derive(Debug, Clone, Copy)]
enum Never {}

/// The log, which does not exist.
#[derive(Debug, Clone)]
pub(crate) struct Kafka(Never);

/// A log is configured.
#[derive(Debug, thiserror::Error)]
#[error("this program was built without Kafka: build it with --features kafka, or leave publish out")]
pub struct KafkaError;

impl Kafka {
    /// Nothing, if nothing is configured.
    ///
    /// # Errors
    /// A log is configured, and the feature `kafka` is not built in.
    pub(crate) fn new(options: &KafkaOptions) -> Result<Option<Self>, KafkaError> {
        if options.publish.is_some() { Err(KafkaError) } else { Ok(None) }
    }

    pub(crate) fn sink(&self) -> Option<EventSink> {
        match self.0 {}
    }

    pub(crate) fn publish(&self, _: &Store, _: &FleetShard, _: &FleetMetrics, _: EventSink) {
        match self.0 {}
    }
}
