//! `vibrissa record`: records the MQTT traffic of fleets to a file.

use std::fs::File;
use std::io::{Write, stdout};
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, bail};
use clap::Args;

use super::config::BrokerArgs;
use super::serve::{log, runtime};
use crate::recording::{Report, record};
use vibrissa_program::signals::StopSignals;

/// Arguments of `vibrissa record`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Each line is one message: {\"received_us\":..., \"topic\":\"...\", \"payload\":{...}}. A payload that is not a JSON object
is stored as a text, one that is not UTF-8 as payload_base64. Recording needs only read access to whisker/v1/FLEET/#.
The retained messages connection and factsheet come first.")]
pub struct RecordArgs {
    /// Output file; - is standard output. An existing file is not overwritten.
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    /// Duration, such as 500ms, 60s, 5m or 1h; default: until Ctrl-C or SIGTERM.
    #[arg(long = "for", value_name = "TIME", value_parser = duration)]
    limit: Option<Duration>,
    #[command(flatten)]
    config: BrokerArgs,
}

/// A duration as a whole number and a unit.
///
/// # Errors
/// The text is no such duration.
pub fn duration(text: &str) -> Result<Duration, String> {
    let bad = || "must be a number and a unit, such as 500ms, 60s, 5m or 1h".to_owned();
    let digits = text.find(|c: char| !c.is_ascii_digit()).ok_or_else(bad)?;
    let (number, unit) = text.split_at(digits);
    let number: u64 = number.parse().map_err(|_| bad())?;
    let unit_ms = match unit {
        "ms" => 1,
        "s" => 1_000,
        "m" => 60_000,
        "h" => 3_600_000,
        _ => return Err(bad()),
    };
    number.checked_mul(unit_ms).filter(|&ms| ms > 0).map(Duration::from_millis).ok_or_else(bad)
}

/// Records until the duration is over, Ctrl-C or SIGTERM.
///
/// # Errors
/// No broker is configured or reached, the file exists already, or some messages could not be written.
pub fn run(args: &RecordArgs) -> anyhow::Result<()> {
    let config = args.config.read()?;
    let Some(broker) = &config.broker else { bail!("a broker is required: --broker mqtt://HOST:1883, or mqtt.url") };
    log(&config.log);
    let mut out: Box<dyn Write> = if args.out.as_os_str() == "-" {
        Box::new(stdout())
    } else {
        let file = File::create_new(&args.out);
        Box::new(file.with_context(|| format!("cannot create the recording {}", args.out.display()))?)
    };
    let report = runtime()?.block_on(async {
        let mut signals = StopSignals::install().context("waiting for SIGTERM")?;
        let stop = async {
            tokio::select! {
                () = signals.received() => {}
                () = over(args.limit) => {}
            }
        };
        record(broker, &config.fleets, &mut out, stop).await
    });
    drop(out);
    if report.is_err() && args.out.as_os_str() != "-" {
        remove_if_empty(&args.out);
    }
    tell(report?)
}

/// An empty recording would only be in the way of the next attempt.
fn remove_if_empty(path: &Path) {
    if std::fs::metadata(path).is_ok_and(|file| file.is_file() && file.len() == 0) {
        // The error of the recording is more important.
        let _ = std::fs::remove_file(path);
    }
}

async fn over(limit: Option<Duration>) {
    match limit {
        Some(limit) => tokio::time::sleep(limit).await,
        None => std::future::pending().await,
    }
}

fn tell(Report { messages, lost, breaks }: Report) -> anyhow::Result<()> {
    eprintln!("vibrissa: {messages} messages recorded");
    if breaks > 0 {
        eprintln!(
            "vibrissa: the connection broke {breaks} times; messages sent until it was restored are not recorded"
        );
    }
    if lost > 0 {
        bail!("{lost} messages could not be written");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_a_number_and_a_unit() {
        let good = ["500ms", "60s", "5m", "1h"].map(|text| duration(text).unwrap().as_millis());
        assert_eq!(good, [500, 60_000, 300_000, 3_600_000]);
        for bad in ["", "60", "s", "1.5s", "-1s", "0s", "5 m", "1d", "99999999999999999999s", "9999999999999999999h"] {
            assert!(duration(bad).is_err(), "{bad}");
        }
    }
}
