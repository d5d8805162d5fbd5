//! Processes of this program beside the measured ones: the generator of load, and what subscribes in the supervisor's place.

use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context, ensure};
use tokio::io::{AsyncBufReadExt, AsyncReadExt, BufReader, Lines};
use tokio::process::{Child, ChildStderr, Command};
use tokio::time::timeout;
use vibrissa_simulator::load::{LoadReport, PREPARED};

use crate::usage::{self, Usage};

/// What [`crate::null`] and [`crate::pingpong`] say when they are subscribed.
pub const READY: &str = "ready";
const READY_PATIENCE: Duration = Duration::from_secs(10);

/// A process of this program; dropped, it is killed.
pub struct Helper {
    process: Child,
    said: Lines<BufReader<ChildStderr>>,
}

impl Helper {
    /// Starts it with arguments.
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

    /// Waits until it says that word on standard error.
    pub async fn until(&mut self, word: &str) -> anyhow::Result<()> {
        let mut heard = Vec::new();
        while let Some(line) = self.said.next_line().await? {
            if line == word {
                return Ok(());
            }
            heard.push(line);
        }
        anyhow::bail!("a helper has ended: {}", heard.join("\n"))
    }

    /// Waits until it is ready.
    pub async fn ready(&mut self) -> anyhow::Result<()> {
        timeout(READY_PATIENCE, self.until(READY)).await.context("a helper does not get ready")?
    }

    /// Waits for its end, and gives what it has printed.
    pub async fn ended(mut self) -> anyhow::Result<String> {
        let mut printed = String::new();
        self.process.stdout.take().context("piped")?.read_to_string(&mut printed).await?;
        let mut heard = Vec::new();
        while let Some(line) = self.said.next_line().await? {
            heard.push(line);
        }
        let status = self.process.wait().await?;
        ensure!(status.success(), "a helper has failed: {}", heard.join("\n"));
        Ok(printed)
    }
}

/// A load, and what processes took meanwhile; preparation left out.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// What the generator says.
    pub report: LoadReport,
    /// What each of the watched processes took.
    pub usages: BTreeMap<&'static str, Usage>,
    /// What the helper has printed that was waited for, too.
    pub helper: String,
}

impl Loaded {
    /// Processor seconds that a process took for a million messages.
    pub fn cpu_s_per_million(&self, name: &str) -> f64 {
        self.usages.get(name).map_or(f64::NAN, |usage| usage.cpu_s * 1e6 / self.report.sent as f64)
    }

    /// Messages per second until all of it was receipted.
    pub fn messages_per_s(&self) -> f64 {
        self.report.sent as f64 / self.report.seconds
    }
}

/// Makes load with those arguments of the generator, and waits for a helper that ends when it has got everything.
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
