//! The partitioned log with brokers of Apache Kafka.

mod published;
mod stage;
