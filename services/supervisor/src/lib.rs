//! The service of the supervisor: contacts in over MQTT, pressure setpoints out, everything recorded.
//!
//! Read in this order: [`service`] starts all tasks, [`supervision`] those without HTTP. `ownership` and `fleet` take fleets by leases. [`mqtt`] and
//! [`broker`] carry messages. [`inbox`], [`log_inbox`], [`link_state`] and [`outbox`] are the ports of [`engine`],
//! which knows no transport: it steps the core with the events that [`vibrissa_edge`] makes of messages, and commits
//! the effects to [`vibrissa_store`]. `black_box` keeps robots' messages around events. [`http`] serves people,
//! [`kafka`] sends [`events`] to a partitioned log, [`webhooks`] sends events to other programs, [`metrics`] and
//! [`trace`] serve monitoring.

pub mod service;

pub mod action_notifier;
mod clocks;
mod ending;
pub mod events;
mod fleet;
mod former_owner;
mod hearing_trials;
mod ownership;
pub mod promises;
pub mod readiness;
mod sharing;
pub mod supervision;
mod thread;
mod upkeep;

pub mod archive_options;
pub mod births;
pub mod broker;
pub mod inbox;
pub mod link_state;
pub mod log_inbox;
pub mod mqtt;
pub mod outbox;
pub mod outgoing;

pub mod engine;

pub mod http;
#[cfg(feature = "kafka")]
pub mod kafka;
#[cfg(not(feature = "kafka"))]
#[path = "kafka/disabled.rs"]
pub mod kafka;
pub mod kafka_options;
pub mod metrics;
pub mod one_of;
#[cfg(feature = "parquet")]
pub mod parquet_rows;
#[cfg(feature = "traces")]
pub mod trace;
#[cfg(not(feature = "traces"))]
#[path = "trace/disabled.rs"]
pub mod trace;

#[cfg(feature = "archive")]
mod archive;
#[cfg(not(feature = "archive"))]
#[path = "archive/disabled.rs"]
mod archive;
mod backoff;
mod black_box;
mod params;
mod replication;
pub mod robots_file;
mod set_aside;
pub mod webhooks;
