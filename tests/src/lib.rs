//! Shared helpers of the integration tests.

pub mod actions;
pub mod certificates;
pub mod demo;
pub mod extremes;
pub mod installed;
pub mod jwt;
pub mod kafka;
pub mod mosquitto;
pub mod mqtt_311;
pub mod mqtt_proxy;
pub mod network;
pub mod observer;
pub mod oracle;
pub mod patroni;
pub mod postgres;
pub mod process;
pub mod prometheus;
pub mod proxy;
pub mod python;
pub mod rmqtt;
pub mod robot;
pub mod rollouts;
pub mod standby;
pub mod svg;
pub mod wait;
pub mod web;
