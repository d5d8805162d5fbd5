//! `vibrissa-lab replay`: replays recorded traffic through the core.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, bail};
use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};
use vibrissa_core::robot::Params;
use vibrissa_protocol::Name;

use vibrissa::cli::config::CoreArgs;
use vibrissa::cli::stop::{self, Stopped};
use vibrissa::config::{Key, policy_over};
use vibrissa::recording::Lines;

use crate::replay::{Comparison, Recorded, Refusals, Replayer, effect_json};

/// Arguments of `vibrissa-lab replay`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
FILE is a recording of `vibrissa record`. Times come from the file: nothing waits. The same file gives the same bytes.

Setpoints of the replay get the recorded answers to the recorded setpoints. One without a recorded answer is assumed
to be applied (effects that depend on it have \"assumed\"); contacts at another pressure then count as UNSETTLED.
Standard error ends with the number of refused messages and parts of messages of each robot, by reason.
If the recording is silent for more than a minute, only the first minute and the end of the silence are simulated.
Of a configuration file the models, the policy, detection, touch tests and fleets count. Without --fleet all fleets
are replayed.")]
pub struct ReplayArgs {
    /// Recording; - is standard input.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// TOML file with other keys of [policy]: replay with both policies and print the differences.
    #[arg(long, value_name = "OTHER.toml")]
    policy: Option<PathBuf>,
    #[command(flatten)]
    config: CoreArgs,
}

/// Describes the output of a replay that was stopped.
const STOPPED: &str = "the output covers only the part that was replayed";
/// Bad lines reported one by one; further ones are only counted.
const TOLD_MAX: u64 = 20;

/// Replays a recording.
///
/// # Errors
/// The configuration or the file cannot be read, or the file contains no recorded message.
pub fn run(args: &ReplayArgs, out: &mut dyn Write) -> anyhow::Result<()> {
    let config = args.config.read()?;
    let params = Arc::new(config.params());
    let fleets: Option<BTreeSet<Name>> =
        args.config.is_given(Key::Fleets).then(|| config.fleets.iter().cloned().collect());
    let other = args.policy.as_deref().map(|path| with_policy(&params, path)).transpose()?;
    let mut out = BufWriter::new(out);
    stop::watch(STOPPED)?;
    let mut input = Input::open(&args.file)?;
    let replayed = match other {
        None => {
            let mut replayer = Replayer::new(params, fleets);
            let replayed =
                input.each(|recorded| replayer.take(recorded, &mut |happened| effect_json::write(happened, &mut out)));
            tell(replayer.refusals());
            replayed
        }
        Some((name, other)) => {
            let sides = [("this".to_owned(), params), (name, other)];
            let mut comparison = Comparison::new(sides, fleets.as_ref());
            let compared = input.each(|recorded| comparison.take(recorded, &mut out));
            tell(comparison.refusals());
            compared.and_then(|()| Ok(comparison.summary(&mut out)?))
        }
    };
    // The output ends with a complete line, whatever happened. Without a context: a closed pipe is not worth an
    // explanation.
    let flushed = out.flush();
    replayed?;
    Ok(flushed?)
}

/// Reports the refused messages on standard error.
fn tell(refusals: &Refusals) {
    for line in refusals.lines() {
        eprintln!("vibrissa: {line}");
    }
}

/// The parameters with another policy, and the name of that policy.
fn with_policy(params: &Params, path: &Path) -> anyhow::Result<(String, Arc<Params>)> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("the policy {} cannot be read", path.display()))?;
    let policy = policy_over(params.policy, path.to_owned(), text)?;
    let name = path.file_name().map_or_else(|| path.to_string_lossy(), |name| name.to_string_lossy()).into_owned();
    Ok((name, Arc::new(Params { policy, ..params.clone() })))
}

/// A recording that is being read.
struct Input {
    name: String,
    lines: Lines<Box<dyn BufRead>>,
    bar: ProgressBar,
}

impl Input {
    fn open(path: &Path) -> anyhow::Result<Self> {
        if path.as_os_str() == "-" {
            let lines = Lines::new(Box::new(BufReader::new(io::stdin())) as Box<dyn BufRead>);
            return Ok(Self { name: "standard input".to_owned(), lines, bar: ProgressBar::hidden() });
        }
        let name = path.display().to_string();
        let opened = File::open(path).and_then(|file| Ok((file.metadata()?.len(), file)));
        let (bytes, file) = opened.with_context(|| format!("the recording {name} cannot be read"))?;
        // Drawn on standard error, and only if that is a terminal.
        let style = ProgressStyle::with_template("{bar:30} {percent} % {bytes_per_sec}, {eta} left")?;
        let bar = ProgressBar::new(bytes).with_style(style);
        Ok(Self { name, lines: Lines::new(Box::new(BufReader::with_capacity(1 << 18, file))), bar })
    }

    /// Passes every message to `take`. Bad lines are reported with their number and skipped.
    fn each(&mut self, mut take: impl FnMut(&Recorded) -> io::Result<()>) -> anyhow::Result<()> {
        let (mut messages, mut bad) = (0_u64, 0_u64);
        loop {
            if stop::is_asked() {
                self.bar.finish_and_clear();
                bail!(Stopped(STOPPED));
            }
            let line = self.lines.next_line();
            let Some(line) = line.with_context(|| format!("{} cannot be read any further", self.name))? else { break };
            match line {
                Ok(recorded) => {
                    messages += 1;
                    take(&recorded)?;
                }
                Err(problem) => {
                    bad += 1;
                    if bad <= TOLD_MAX {
                        self.bar.suspend(|| eprintln!("{}:{}: {problem}", self.name, self.lines.number()));
                    }
                }
            }
            self.bar.set_position(self.lines.bytes());
        }
        self.bar.finish_and_clear();
        eprintln!("vibrissa: {messages} messages replayed, {bad} bad lines");
        if messages == 0 && bad > 0 {
            bail!("{} contains no recorded message", self.name);
        }
        Ok(())
    }
}
