//! `vibrissa run` and `vibrissa demo`.

use std::net::SocketAddr;
use std::path::PathBuf;

use anyhow::Context;
use clap::Args;
use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::EnvFilter;

use super::config::ConfigArgs;
use crate::demo::{self, DemoOptions, Serving};
use crate::exposure::exposures;
use vibrissa_supervisor::service::Service;

/// Runs the service until SIGTERM or Ctrl-C.
///
/// # Errors
/// A part of the service cannot be started.
pub fn run(args: &ConfigArgs) -> anyhow::Result<()> {
    let config = args.read()?;
    log(&config.log);
    for exposure in exposures(&config) {
        tracing::warn!("{exposure}");
    }
    runtime()?.block_on(async {
        let service = Service::start(config.into()).await?;
        let http = service.http;
        let nodes: Vec<String> = service.broker.nodes().iter().map(ToString::to_string).collect();
        println!("vibrissa: MQTT on {}, HTTP on http://{http}", nodes.join(", "));
        if let Some(monitoring) = service.monitoring {
            println!("vibrissa: monitoring on http://{monitoring}");
        }
        let mut terminate = signal(SignalKind::terminate()).context("waiting for SIGTERM")?;
        tokio::select! {
            interrupted = tokio::signal::ctrl_c() => interrupted.context("waiting for Ctrl-C")?,
            _ = terminate.recv() => {}
        }
        service.stop().await;
        Ok(())
    })
}

/// Arguments of `vibrissa demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder for the database and the chart.
    #[arg(long, default_value = "vibrissa-demo")]
    folder: PathBuf,
    /// Seed of the simulation: equal seeds give equal contacts.
    #[arg(long, default_value_t = 2021)]
    seed: u64,
    /// Port of the embedded broker on 127.0.0.1; 0 takes any free port.
    #[arg(long, default_value_t = 0)]
    mqtt_port: u16,
    /// Address of the HTTP listener; port 0 takes any free port.
    #[arg(long, default_value = "127.0.0.1:0")]
    http: SocketAddr,
    /// After the report, let the robots go on touching, and cut or wear off whiskers by commands or on the console.
    #[arg(long)]
    serve: bool,
    /// Like --serve, at once and without the scripted part.
    #[arg(long)]
    live: bool,
}

/// Runs the demo; true if it succeeded.
///
/// # Errors
/// A part of the demo cannot be started.
pub fn demo(args: DemoArgs) -> anyhow::Result<bool> {
    // Broker and clients stop together, so that their messages about closed connections mean nothing.
    log("error,mqtt5=error,rumqttc=error");
    let options = DemoOptions {
        folder: args.folder,
        seed: args.seed,
        mqtt_port: args.mqtt_port,
        http: args.http,
        serving: match (args.live, args.serve) {
            (true, _) => Serving::AtOnce,
            (false, true) => Serving::AfterReport,
            (false, false) => Serving::Never,
        },
    };
    runtime()?.block_on(demo::run(&options))
}

/// Levels of libraries by default: warnings of MQTT, errors of the others. The program tells the rest in its own words.
const OF_LIBRARIES: &str =
    "mqtt5=warn,rumqttc=warn,sqlx=error,rskafka=error,object_store=error,rustls=error,ureq=error,hyper=error";

/// Logs to standard error; `RUST_LOG` overrides the filter.
pub(super) fn log(filter: &str) {
    let own = || EnvFilter::new(format!("{OF_LIBRARIES},{filter}"));
    // RUST_LOG may be meant for another program, so an invalid one is no error.
    let filter = match std::env::var(EnvFilter::DEFAULT_ENV).map(EnvFilter::try_new) {
        Ok(Ok(asked)) => asked,
        Ok(Err(problem)) => {
            eprintln!("vibrissa: RUST_LOG is ignored, because it is not a log filter: {problem}");
            own()
        }
        Err(_) => own(),
    };
    if let Err(problem) = vibrissa_robot::log::start(filter) {
        eprintln!("vibrissa: no log: {problem}");
    }
}

pub(super) fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().context("starting the runtime")
}
