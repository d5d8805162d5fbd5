//! `vibrissa-lab demo`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;
use vibrissa::cli::serve::{log, runtime};

use crate::demo::{self, DemoOptions, Serving};

/// Arguments of `vibrissa-lab demo`.
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
    /// With --serve or --live: open the console in the browser.
    #[arg(long)]
    open: bool,
}

/// Runs the demo; true if it succeeded.
///
/// # Errors
/// A part of the demo cannot be started.
pub fn run(args: DemoArgs) -> anyhow::Result<bool> {
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
        opens_browser: args.open,
    };
    runtime()?.block_on(demo::run(&options))
}
