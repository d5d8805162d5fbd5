//! The partitioned log with brokers of Apache Kafka.

mod bridge;
mod iceberg;
mod ingested;
mod left_out;
mod model;
mod partitions;
mod published;
mod rmqtt_bridge;
mod secured;
mod shared;
mod stage;
