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
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use vibrissa_host::task;

use crate::agent::snapshot::{Snapshot, WhiskerView};
use crate::config::Config;

/// Time between two views.
const EVERY: Duration = Duration::from_secs(1);
/// Time limit for a view.
const PATIENCE: Duration = Duration::from_secs(30);
/// Most people and programs that watch at once.
const WATCHERS_MAX: usize = 8;

/// The socket of an agent with a file for its outbox.
#[must_use]
pub fn socket(config: &Config) -> Option<PathBuf> {
    let mut name = config.outbox_file.clone()?.into_os_string();
    name.push(".monitor");
    Some(PathBuf::from(name))
}

/// Shows whoever comes the state of the agent.
pub(crate) async fn serve(listener: UnixListener, snapshot: impl Fn() -> Snapshot + Clone + Send + 'static) {
    let mut watchers = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept(), if watchers.len() < WATCHERS_MAX => match accepted {
                Ok((stream, _)) => {
                    task::spawn_in(&mut watchers, show(stream, snapshot.clone()));
                }
                Err(_) => sleep(EVERY).await,
            },
            Some(_) = watchers.join_next() => {}
        }
    }
}

/// Writes the state each second until nobody reads it.
async fn show(mut stream: UnixStream, snapshot: impl Fn() -> Snapshot) {
    loop {
        let mut line = vibrissa_protocol::encode(&snapshot());
        line.push(b'\n');
        let written = timeout(EVERY, stream.write_all(&line)).await;
        if !matches!(written, Ok(Ok(()))) {
            return;
        }
        sleep(EVERY).await;
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
    loop {
        let line = timeout(PATIENCE, lines.next_line()).await;
        let line = line.with_context(|| format!("the agent does not answer: do {WATCHERS_MAX} others watch it?"))?;
        let Some(line) = line? else { bail!("the agent has ended") };
        let view = text(&serde_json::from_str(&line)?);
        let clear = if once { "" } else { "\x1b[H\x1b[2J" };
        std::io::stdout().write_all(format!("{clear}{view}").as_bytes())?;
        std::io::stdout().flush()?;
        if once {
            return Ok(());
        }
    }
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use vibrissa_protocol::BootId;

    use super::*;
    use crate::Agent;
    use crate::clock::now;
    use crate::config::tests::EXAMPLE;
    use crate::store::Stored;

    /// The second one waited without end and without a word.
    #[tokio::test]
    async fn regress_two_may_watch_at_once() {
        let path = std::env::temp_dir().join(format!("vibrissa-monitor-{}", std::process::id()));
        let _ = std::fs::remove_file(&path);
        let listener = UnixListener::bind(&path).unwrap();
        let config = Config::from_toml_str(EXAMPLE, Path::new("")).unwrap();
        let (agent, _) = Agent::new(&config, BootId::new("b1").unwrap(), Stored::default(), now());
        let snapshot = agent.snapshot(now());
        let shown = snapshot.clone();
        let watched = async {
            let mut watchers = Vec::new();
            for _ in 0..2 {
                let stream = UnixStream::connect(&path).await.unwrap();
                let mut lines = BufReader::new(stream).lines();
                let line = lines.next_line().await.unwrap().unwrap();
                assert_eq!(serde_json::from_str::<Snapshot>(&line).unwrap(), snapshot);
                watchers.push(lines);
            }
        };
        tokio::select! {
            () = watched => {}
            () = serve(listener, move || shown.clone()) => {}
        }
        std::fs::remove_file(&path).unwrap();
    }
}
