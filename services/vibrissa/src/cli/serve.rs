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

/// Levels of libraries by default: warnings of MQTT, errors of the others. The program tells the rest in its own words, and
/// each error of the database: its library repeats them, such as that of a server that is read-only.
const OF_LIBRARIES: &str =
    "mqtt5=warn,rumqttc=warn,sqlx=off,rskafka=error,object_store=error,rustls=error,ureq=error,hyper=error";

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

#[cfg(test)]
mod tests {
    use std::io::{Result, Write};
    use std::sync::{Arc, Mutex};

    use super::*;

    #[derive(Clone, Default)]
    struct Written(Arc<Mutex<Vec<u8>>>);

    impl Write for Written {
        fn write(&mut self, bytes: &[u8]) -> Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> Result<()> {
            Ok(())
        }
    }

    #[test]
    fn regress_the_librarys_words_about_the_database_are_not_logged() {
        let written = Written::default();
        let writer = written.clone();
        let log = tracing_subscriber::fmt().with_env_filter(format!("{OF_LIBRARIES},info"));
        tracing::subscriber::with_default(log.with_writer(move || writer.clone()).finish(), || {
            tracing::error!(target: "sqlx_core::pool::inner", "error returned from after_connect");
            tracing::error!(target: "vibrissa_store", "no server accepts writes");
        });
        let text = String::from_utf8(written.0.lock().unwrap().clone()).unwrap();
        assert!(text.contains("no server accepts writes") && !text.contains("after_connect"), "{text}");
    }
}
