//! vibrissa, the supervisor: robots' whiskers in over MQTT, pressure setpoints out, everything recorded.
//!
//! Read in this order: [`service`] (what runs), [`mqtt`] and [`broker`], [`edge`] (messages become events),
//! [`engine`] (one message's way), [`store`] (SQL), [`http`]; then [`config`], [`demo`] and [`cli`].

pub mod service;

pub mod broker;
pub mod mqtt;

pub mod edge;

pub mod engine;

pub mod store;

pub mod secret;

pub mod http;
pub mod metrics;
pub mod words;

pub mod calibration_file;
pub mod plot;

pub mod demo;

pub mod config;

pub mod cli;
