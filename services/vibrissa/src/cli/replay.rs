//! `vibrissa replay`: recorded traffic through the core once more.

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

use super::config::ConfigArgs;
use super::stop::{self, Stopped};
use crate::config::{Key, policy_over};
use crate::replay::{Comparison, Lines, Recorded, Replayer, told};

/// Arguments of `vibrissa replay`.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The file is one of `vibrissa record`. Time is the file's: nothing waits. The same file gives the same bytes.

Setpoints of the replay take the recorded answers to the recorded ones. One that was never recorded is taken to be
applied (\"assumed\" in what rests on that); contacts at another pressure than the replay's then count as UNSETTLED.
Of a silence of more than a minute, the first minute and its end are told to the core.")]
pub struct ReplayArgs {
    /// The recording; - is standard input.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// A file with other keys of [policy]: both policies are run, and told where they differ.
    #[arg(long, value_name = "OTHER.toml")]
    policy: Option<PathBuf>,
    /// Of it the models, the policy, the detection and the fleets count; without --fleet, all fleets are replayed.
    #[command(flatten)]
    config: ConfigArgs,
}

/// What there is of a replay that was stopped.
const STOPPED: &str = "what is printed was replayed, the rest was not";
/// Lines that are told one by one; the rest are counted.
const TOLD_MAX: u64 = 20;

/// Replays.
///
/// # Errors
/// The configuration or the file cannot be read, or nothing in it is a recorded message.
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
            input.each(|recorded| replayer.take(recorded, &mut |happened| told::write(happened, &mut out)))
        }
        Some((name, other)) => {
            let sides = [("this".to_owned(), params), (name, other)];
            let mut comparison = Comparison::new(sides, fleets.as_ref());
            let compared = input.each(|recorded| comparison.take(recorded, &mut out));
            compared.and_then(|()| Ok(comparison.summary(&mut out)?))
        }
    };
    // What was replayed is told to the end of its line, whatever came then.
    // Not with a context: whoever closes the pipe has seen enough.
    let flushed = out.flush();
    replayed?;
    Ok(flushed?)
}

/// The parameters with another policy, and what to call it.
fn with_policy(params: &Params, path: &Path) -> anyhow::Result<(String, Arc<Params>)> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("the policy {} cannot be read", path.display()))?;
    let policy = policy_over(params.policy, path.to_owned(), text)?;
    let name = path.file_name().map_or_else(|| path.to_string_lossy(), |name| name.to_string_lossy()).into_owned();
    Ok((name, Arc::new(Params { policy, ..params.clone() })))
}

/// A recording that is read.
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

    /// Gives every message to `take`; bad lines are told with their number, and passed over.
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
            bail!("nothing in {} is a recorded message", self.name);
        }
        Ok(())
    }
}
