//! The partitioned log with brokers of Apache Kafka.

mod bridge;
mod ingested;
mod published;
mod shared;
mod stage;
