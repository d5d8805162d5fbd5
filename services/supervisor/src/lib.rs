//! vibrissa, a supervisor for robots with soft whiskers: contacts arrive over MQTT, pressure setpoints go out, and
//! everything is recorded.
//!
//! Reading order: [`service`] (all tasks), `ownership` and `fleet` (leases of fleets), [`mqtt`], [`inbox`], [`outbox`]
//! and [`broker`], [`vibrissa_edge`] (messages become events), [`engine`] (processing of a message), [`store`] (SQL),
//! [`http`], [`trace`]; then [`record`] and [`replay`], [`check`] (tests a robot against the contract), [`config`],
//! [`demo`] and [`cli`].

pub mod service;

mod ears;
mod ending;
mod fleet;
pub mod mailroom;
mod ownership;
pub mod readiness;
mod sharing;
mod thread;
mod upkeep;

pub mod broker;
pub mod mqtt;

pub mod engine;

pub mod check;
pub mod record;
pub mod replay;

pub mod store;

mod backoff;
pub mod clock;
pub mod exposure;
pub mod fault;
mod ids;
pub mod inbox;
pub mod outbox;
mod params;
pub mod robots_file;
pub mod secret;

pub mod http;
pub mod metrics;
pub mod trace;

pub mod calibration_file;
pub mod plot;

pub mod demo;

pub mod config;

pub mod cli;
