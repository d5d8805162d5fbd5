//! Runs this program as child processes: the load generator, and the subscribers that replace the supervisor.

use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context, ensure};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader, Lines};
use tokio::process::{Child, ChildStderr, Command};
use tokio::time::timeout;
use vibrissa_simulator::load::{LoadReport, PREPARED};

use crate::usage::{self, Usage};

/// Line that [`crate::null`] and [`crate::pingpong`] print once they are subscribed.
pub const READY: &str = "ready";
const READY_PATIENCE: Duration = Duration::from_secs(10);

/// A child process of this program, killed on drop.
pub struct Helper {
    process: Child,
    said: Lines<BufReader<ChildStderr>>,
}

impl Helper {
    /// Starts this program with these arguments.
    pub fn start(arguments: &[String]) -> anyhow::Result<Self> {
        let mut process = Command::new(std::env::current_exe()?)
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .kill_on_drop(true)
            .spawn()?;
        let said = BufReader::new(process.stderr.take().context("piped")?).lines();
        Ok(Self { process, said })
    }

    /// Waits until the process prints this word to standard error.
    pub async fn until(&mut self, word: &str) -> anyhow::Result<()> {
        let mut heard = Vec::new();
        while let Some(line) = self.said.next_line().await? {
            if line == word {
                return Ok(());
            }
            heard.push(line);
        }
        anyhow::bail!("a helper process has ended: {}", heard.join("\n"))
    }

    /// Waits until the process has printed [`READY`].
    pub async fn ready(&mut self) -> anyhow::Result<()> {
        timeout(READY_PATIENCE, self.until(READY)).await.context("a helper process does not become ready")?
    }

    /// Waits for the process to end and returns its standard output.
    pub async fn ended(mut self) -> anyhow::Result<String> {
        let mut printed = String::new();
        self.process.stdout.take().context("piped")?.read_to_string(&mut printed).await?;
        let mut heard = Vec::new();
        while let Some(line) = self.said.next_line().await? {
            heard.push(line);
        }
        let status = self.process.wait().await?;
        ensure!(status.success(), "a helper process has failed: {}", heard.join("\n"));
        Ok(printed)
    }
}

/// Result of a load: the report and the usage of processes, without the preparation.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// Report of the generator.
    pub report: LoadReport,
    /// Usage of each watched process, by its name.
    pub usages: BTreeMap<&'static str, Usage>,
    /// Output of the helper process that ended with the load.
    pub helper: String,
}

impl Loaded {
    /// Processor seconds of a process per million messages.
    pub fn cpu_s_per_million(&self, name: &str) -> f64 {
        self.usages.get(name).map_or(f64::NAN, |usage| usage.cpu_s * 1e6 / self.report.sent as f64)
    }

    /// Messages per second, until the last one was receipted.
    pub fn messages_per_s(&self) -> f64 {
        self.report.sent as f64 / self.report.seconds
    }
}

/// Runs the generator with these arguments and waits for a helper process that ends when it has received everything.
pub async fn load(
    port: u16,
    fleet: &str,
    arguments: &[(&str, String)],
    watched: &[(&'static str, u32)],
    helper: Option<Helper>,
) -> anyhow::Result<Loaded> {
    let mut all = vec!["load".to_owned(), "--mqtt-url".to_owned(), format!("mqtt://127.0.0.1:{port}")];
    all.extend(["--fleet".to_owned(), fleet.to_owned()]);
    for (name, value) in arguments {
        all.push(format!("--{name}"));
        all.extend((!value.is_empty()).then(|| value.clone()));
    }
    let mut generator = Helper::start(&all)?;
    generator.until(PREPARED).await?;
    watched.iter().for_each(|&(_, pid)| usage::forget_peak(pid));
    let before: Vec<Usage> = watched.iter().map(|&(_, pid)| usage::of_tree(pid)).collect();
    let printed = generator.ended().await?;
    let helper = match helper {
        Some(helper) => helper.ended().await?,
        None => String::new(),
    };
    let taken = watched.iter().zip(before).map(|(&(name, pid), before)| (name, usage::of_tree(pid).since(before)));
    let usages = taken.collect();
    Ok(Loaded { report: serde_json::from_str(&printed)?, usages, helper })
}
