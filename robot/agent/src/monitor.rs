//! `vibrissa-robot monitor`: a line for each whisker, each second, from the running agent.
//!
//! The agent listens at a Unix socket beside its outbox, which only its user can use, and writes a [`Snapshot`] as a
//! line of JSON.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, bail};
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader};
use tokio::net::{UnixListener, UnixStream};
use tokio::time::{sleep, timeout};

use crate::agent::snapshot::{Snapshot, WhiskerView};
use crate::config::Config;

/// Time between two views.
const EVERY: Duration = Duration::from_secs(1);

/// The socket of an agent with a file for its outbox.
#[must_use]
pub fn socket(config: &Config) -> Option<PathBuf> {
    let mut name = config.outbox_file.clone()?.into_os_string();
    name.push(".monitor");
    Some(PathBuf::from(name))
}

/// Shows whoever comes the state of the agent; one at a time, because a person looks.
pub(crate) async fn serve(listener: UnixListener, snapshot: impl Fn() -> Snapshot) {
    loop {
        let Ok((mut stream, _)) = listener.accept().await else {
            sleep(EVERY).await;
            continue;
        };
        loop {
            let mut line = vibrissa_protocol::encode(&snapshot());
            line.push(b'\n');
            let written = timeout(EVERY, stream.write_all(&line)).await;
            if !matches!(written, Ok(Ok(()))) {
                break;
            }
            sleep(EVERY).await;
        }
    }
}

/// Prints views of the running agent until it ends; only one with `once`.
///
/// # Errors
/// No agent runs with this configuration, or the terminal is gone.
pub async fn watch(config: &Config, once: bool) -> anyhow::Result<()> {
    let Some(path) = socket(config) else {
        bail!("the agent has a monitor only with outbox.file in its configuration")
    };
    let stream = UnixStream::connect(&path).await;
    let stream =
        stream.with_context(|| format!("no agent can be reached at {}: does it run, as this user?", path.display()))?;
    let mut lines = BufReader::new(stream).lines();
    while let Some(line) = lines.next_line().await? {
        let view = text(&serde_json::from_str(&line)?);
        let clear = if once { "" } else { "\x1b[H\x1b[2J" };
        std::io::stdout().write_all(format!("{clear}{view}").as_bytes())?;
        std::io::stdout().flush()?;
        if once {
            return Ok(());
        }
    }
    bail!("the agent has ended")
}

/// A view as text: one line for each whisker, and one for each driver that is not there.
#[must_use]
pub fn text(snapshot: &Snapshot) -> String {
    let Snapshot { fleet, robot, connected, messages: (kept, dropped), drivers, whiskers } = snapshot;
    let broker = if *connected { "connected" } else { "no broker" };
    let mut text = format!("{fleet}/{robot}: {broker}, {kept} messages without a receipt, {dropped} dropped\n");
    for driver in drivers {
        let there = if driver.is_there { "there" } else { "NOT THERE" };
        let _ = writeln!(text, "{}: {there}, {} lines, {} refused", driver.label, driver.lines, driver.refused);
    }
    whiskers.iter().for_each(|whisker| text.push_str(&line(whisker)));
    text
}

fn line(whisker: &WhiskerView) -> String {
    let condition = whisker.condition.map_or_else(|| "-".to_owned(), |condition| condition.to_string());
    let segmenter = whisker.segmenter.as_ref().map_or_else(String::new, |word| format!(" segmenter {word}"));
    let pressure = whisker.pressure_mpa.map_or_else(|| "?".to_owned(), |mpa| format!("{mpa:.4}"));
    let contact = whisker.contact_s.map_or_else(|| "no contact".to_owned(), |s| format!("contact {s:.0} s ago"));
    let unused: u64 = whisker.unused.values().sum();
    let most = whisker.unused.iter().max_by_key(|(_, count)| **count);
    let most = most.map_or_else(String::new, |(reason, _)| format!(" ({reason})"));
    let advice = whisker.advice.as_ref().map_or_else(String::new, |advice| format!(" -> {advice}"));
    format!(
        "{}/{} {condition} regulator {} gauge {}{segmenter} {pressure} of {:.4} MPa, {contact}, {} refused, \
         {unused} unused{most}{advice}\n",
        whisker.array, whisker.whisker, whisker.regulator, whisker.gauge, whisker.setpoint_mpa, whisker.refused
    )
}
