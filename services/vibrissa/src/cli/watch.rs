//! `--watch`: prints a list again and again.

use std::io::{IsTerminal, Write, stdout};
use std::time::Duration;

use clap::Args;
use vibrissa_host::task;

/// Clears a terminal and goes to its first line.
const CLEAR: &str = "\x1b[2J\x1b[H";

/// Arguments of commands that can be repeated.
#[derive(Debug, Args)]
pub struct WatchArgs {
    /// Print the list again every SECONDS, until Ctrl-C; 2 without a number.
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, default_missing_value = "2",
          value_parser = clap::value_parser!(u16).range(1..=3600))]
    watch: Option<u16>,
}

impl WatchArgs {
    /// Prints a list once, or again and again. A failure after the first time is printed, and the next time may succeed:
    /// a supervisor restarts.
    ///
    /// # Errors
    /// The list cannot be had the first time, or the output fails.
    pub fn repeat(
        &self,
        out: &mut impl Write,
        mut list: impl FnMut(&mut Vec<u8>) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let mut text = Vec::new();
        list(&mut text)?;
        out.write_all(&text)?;
        let Some(seconds) = self.watch else { return Ok(()) };
        loop {
            out.flush()?;
            task::block_for(Duration::from_secs(seconds.into()));
            text.clear();
            let failed = list(&mut text).err();
            if stdout().is_terminal() {
                write!(out, "{CLEAR}")?;
            }
            match failed {
                Some(problem) => eprintln!("vibrissa: {problem:#}"),
                None => out.write_all(&text)?,
            }
        }
    }
}
