//! `vibrissa run`.

use anyhow::Context;
use tracing_subscriber::EnvFilter;
use vibrissa_program::signals::StopSignals;

use super::config::ConfigArgs;
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
        let mut signals = StopSignals::install().context("waiting for SIGTERM")?;
        // A start can take long: it waits for a lock, or migrates a large database.
        let service = tokio::select! {
            service = Service::start(config.into()) => service?,
            () = signals.received() => return Ok(()),
        };
        let http = service.http;
        let nodes: Vec<String> = service.broker.nodes().iter().map(ToString::to_string).collect();
        println!("vibrissa: MQTT on {}, HTTP on http://{http}", nodes.join(", "));
        if let Some(monitoring) = service.monitoring {
            println!("vibrissa: monitoring on http://{monitoring}");
        }
        signals.received().await;
        service.stop().await;
        Ok(())
    })
}

/// Levels of libraries by default: warnings of MQTT, errors of the others. The program tells the rest in its own words.
const OF_LIBRARIES: &str =
    "mqtt5=warn,rumqttc=warn,sqlx=error,rskafka=error,object_store=error,rustls=error,ureq=error,hyper=error";

/// Logs to standard error; `RUST_LOG` overrides the filter.
pub fn log(filter: &str) {
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
    if let Err(problem) = vibrissa_program::log::start(filter) {
        eprintln!("vibrissa: no log: {problem}");
    }
}

/// A runtime of several threads.
///
/// # Errors
/// The threads cannot be started.
pub fn runtime() -> anyhow::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().context("starting the runtime")
}
