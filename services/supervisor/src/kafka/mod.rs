//! A partitioned log, Apache Kafka: events go out to it, and contacts may come from it.
//!
//! Nothing here decides about a robot. [`publisher`] carries the log of events of a fleet to Kafka, [`reader`] reads all
//! partitions of a topic ([`partition`]), [`again`] reads them for a recovery, [`client`] and
//! [`wire`] have the connections. [`batch`], [`record`] and [`unpack`] read what the brokers send.

mod again;
mod batch;
mod cause;
mod client;
mod defect;
mod fetch;
mod partition;
mod publisher;
mod reader;
mod record;
mod topic;
mod unpack;
mod wire;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64};

use tokio::sync::Notify;
use tokio::task::JoinHandle;
use vibrissa_host::task;
use vibrissa_protocol::Name;
use vibrissa_store::Store;

use crate::events::{EventSink, OutboxRoom};
use crate::kafka_options::{EventTopics, KafkaOptions, topic_of};
use crate::metrics::FleetMetrics;
use crate::readiness::Readiness;
use client::Connector;
pub use client::KafkaError;
use publisher::Publisher;
pub(crate) use reader::LogReader;
use topic::FleetTopic;

/// The log, as far as the configuration uses it.
#[derive(Debug, Clone)]
pub(crate) struct Kafka {
    connector: Connector,
    publish: Option<EventTopics>,
    /// Topic of contacts and statuses, if they come from the log; `{fleet}` stands for the name of the fleet.
    ingest: Option<String>,
}

impl Kafka {
    /// The log of the configuration; `None` if it is not used. Connects to nothing.
    ///
    /// # Errors
    /// TLS cannot be configured.
    pub(crate) fn new(options: &KafkaOptions) -> Result<Option<Self>, KafkaError> {
        let (publish, ingest) = (options.publish.clone(), options.ingest.clone());
        if publish.is_none() && ingest.is_none() {
            return Ok(None);
        }
        Ok(Some(Self { connector: Connector::new(options)?, publish, ingest }))
    }

    /// The reader of a fleet's contacts; `None` if they come over MQTT.
    pub(crate) fn reader(&self, fleet: &Name, metrics: &FleetMetrics, readiness: &Readiness) -> Option<LogReader> {
        let topic = topic_of(self.ingest.as_ref()?, fleet.as_str());
        let (connector, fleet) = (self.connector.clone(), fleet.clone());
        Some(LogReader::new(FleetTopic::new(connector, &topic, fleet, metrics.clone(), readiness.clone())))
    }

    /// Where the engine of a fleet reports events; `None` if they are not published.
    pub(crate) fn sink(&self, fleet: &Name, metrics: &FleetMetrics) -> Option<EventSink> {
        let EventTopics { contacts, waiting_mib_max, .. } = self.publish.as_ref()?;
        let room = OutboxRoom {
            fleet: fleet.clone(),
            metrics: metrics.clone(),
            bytes_max: i64::from(*waiting_mib_max) * 1024 * 1024,
            bytes: AtomicI64::new(0),
            is_full: AtomicBool::new(false),
        };
        Some(EventSink { has_contacts: contacts.is_some(), committed: Arc::new(Notify::new()), room: Arc::new(room) })
    }

    /// Publishes the events of a fleet until the result is dropped.
    pub(crate) fn publish(&self, store: &Store, fleet: &Name, metrics: &FleetMetrics, sink: EventSink) -> Option<Task> {
        let topics = self.publish.clone()?;
        let publisher = Publisher {
            connector: self.connector.clone(),
            topics,
            store: store.clone(),
            fleet: fleet.clone(),
            metrics: metrics.clone(),
            room: sink.room,
        };
        Some(Task(task::spawn(publisher.run(sink.committed))))
    }
}

/// A task that ends when this is dropped.
#[derive(Debug)]
pub(crate) struct Task(JoinHandle<()>);

impl Drop for Task {
    fn drop(&mut self) {
        self.0.abort();
    }
}
