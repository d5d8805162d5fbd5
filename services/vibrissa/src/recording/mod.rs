//! Recordings: writes the MQTT messages of fleets into a file as they arrive, and reads such a file line by line.

pub mod lines;

use std::io::{self, Write};
use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, bail};
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior, interval};
use tracing::warn;
use vibrissa_protocol::{BootId, Name};

pub use lines::Lines;
use vibrissa_edge::recording::Recorded;
use vibrissa_host::random;
use vibrissa_supervisor::inbox::Incoming;
use vibrissa_supervisor::mqtt::{self, BrokerAddress, BrokerLink, Connection, RecorderState};

/// Received messages that may wait until they are written.
const WAITING: usize = 10_000;
/// Bytes in the buffer at which it is written at once.
const WRITTEN_AT_ONCE: usize = 64 * 1024;
/// Longest time that a line waits in the buffer.
const WRITTEN_EVERY: Duration = Duration::from_millis(200);
/// Time limit for the first subscription of each fleet. A recording that hears nothing must not run for hours.
const SUBSCRIBED_WITHIN: Duration = Duration::from_secs(30);

/// Result of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Report {
    /// Number of recorded messages.
    pub messages: u64,
    /// Number of received messages that could not be written. A failed write counts all messages of its buffer.
    pub lost: u64,
    /// Number of broken connections: messages sent before the reconnection are missing in the recording.
    pub breaks: u64,
}

/// A fleet whose messages are recorded.
struct Source {
    fleet: Name,
    link: BrokerLink,
    state: Arc<RecorderState>,
}

impl Source {
    /// Reason for which no message of this fleet was recorded; `None` if the broker has accepted the subscription.
    fn deafness(&self, broker: &BrokerAddress, tried: Duration) -> Option<String> {
        if self.state.has_subscribed() {
            return None;
        }
        let (fleet, attempts) = (&self.fleet, self.state.attempts());
        let times = if attempts == 1 { "once".to_owned() } else { format!("{attempts} times") };
        let problems = self.link.problems();
        // A problem with the name of a node comes from an attempt to reach this node.
        let is_of_node = |problem: &String| broker.nodes().iter().any(|node| problem.contains(&node.to_string()));
        let problems: Vec<String> = problems.into_iter().filter(is_of_node).collect();
        let reason = match problems.as_slice() {
            [_, ..] => problems.join("; "),
            [] => format!("MQTT broker {broker}: no answer yet: check the network, and mqtt.url"),
        };
        Some(format!("fleet {fleet}: tried {times} in {:.1} s. {reason}", tried.as_secs_f64()))
    }
}

/// Records the given fleets until `stop`.
///
/// # Errors
/// A file that the broker's settings name cannot be used, the broker did not accept the subscription of a fleet, or the
/// reader at the other end of the pipe has gone.
pub async fn record(
    broker: &BrokerAddress,
    fleets: &[Name],
    out: &mut dyn Write,
    stop: impl Future<Output = ()>,
) -> anyhow::Result<Report> {
    let prepared = mqtt::prepare(broker)?;
    let mark = format!("r{}", random::hex());
    let boot_id = BootId::new(&mark).context("making a boot id for the connection")?;
    let (sender, mut heard) = mpsc::channel(WAITING);
    let source = |fleet: &Name| Source { fleet: fleet.clone(), link: BrokerLink::default(), state: Arc::default() };
    let sources: Vec<Source> = fleets.iter().map(source).collect();
    let begun = Instant::now();
    let recorders: Vec<_> = sources
        .iter()
        .map(|source| {
            let fleet = source.fleet.clone();
            let mut connection = Connection::new(broker.clone(), prepared.clone(), fleet, boot_id.clone());
            connection.link = source.link.clone();
            mqtt::record(connection, sender.clone(), source.state.clone())
        })
        .collect();
    drop(sender);
    let mut journal = Journal::new(out);
    let has_unsubscribed = || sources.iter().any(|source| !source.state.has_subscribed());
    // Ends only if a fleet still has no subscription at the time limit.
    let hopeless = async {
        tokio::time::sleep(SUBSCRIBED_WITHIN).await;
        if !has_unsubscribed() {
            std::future::pending::<()>().await;
        }
    };
    let ended = async {
        tokio::select! {
            () = stop => {}
            () = hopeless => {}
        }
    };
    let written = write_until(&mut journal, &mut heard, ended).await;
    for recorder in &recorders {
        recorder.abort();
    }
    written?;
    // Messages that arrived before the stop.
    heard.close();
    while let Some(incoming) = heard.recv().await {
        journal.add(&incoming)?;
    }
    journal.flush()?;
    let tried = begun.elapsed();
    let deaf: Vec<String> = sources.iter().filter_map(|source| source.deafness(broker, tried)).collect();
    if !deaf.is_empty() {
        bail!("{} messages recorded; not recorded: {}", journal.report.messages, deaf.join("; "));
    }
    let breaks = sources.iter().map(|source| source.state.breaks()).sum();
    Ok(Report { breaks, ..journal.report })
}

async fn write_until(
    journal: &mut Journal<'_>,
    heard: &mut mpsc::Receiver<Incoming>,
    stop: impl Future<Output = ()>,
) -> io::Result<()> {
    let mut stop = pin!(stop);
    let mut flushes = interval(WRITTEN_EVERY);
    flushes.set_missed_tick_behavior(MissedTickBehavior::Skip);
    loop {
        tokio::select! {
            () = &mut stop => return Ok(()),
            _ = flushes.tick() => journal.flush()?,
            incoming = heard.recv() => match incoming {
                Some(incoming) => journal.add(&incoming)?,
                None => return Ok(()),
            },
        }
    }
}

/// Writes messages as lines, and counts those that cannot be written.
struct Journal<'a> {
    out: &'a mut dyn Write,
    /// The buffer: lines that are not written yet.
    waiting: Vec<u8>,
    /// Number of lines in `waiting`.
    lines: u64,
    /// An error may have cut a line off: the next line must not continue it.
    torn: bool,
    report: Report,
}

impl<'a> Journal<'a> {
    fn new(out: &'a mut dyn Write) -> Self {
        Self { out, waiting: Vec::new(), lines: 0, torn: false, report: Report::default() }
    }

    fn add(&mut self, incoming: &Incoming) -> io::Result<()> {
        let Ok(topic) = std::str::from_utf8(&incoming.topic) else {
            self.report.lost += 1;
            warn!("topic is not UTF-8, message not recorded");
            return Ok(());
        };
        let (topic, payload) = (topic.to_owned(), incoming.payload.to_vec());
        Recorded { received: incoming.received, topic, payload }.write(&mut self.waiting);
        self.lines += 1;
        if self.waiting.len() >= WRITTEN_AT_ONCE { self.flush() } else { Ok(()) }
    }

    /// Writes the buffer. A full disk may have space again later, so only a broken pipe is an error.
    fn flush(&mut self) -> io::Result<()> {
        if self.lines == 0 {
            return Ok(());
        }
        let end_of_torn: &[u8] = if self.torn { b"\n" } else { b"" };
        let written = self
            .out
            .write_all(end_of_torn)
            .and_then(|()| self.out.write_all(&self.waiting))
            .and_then(|()| self.out.flush());
        self.waiting.clear();
        let lines = std::mem::take(&mut self.lines);
        match written {
            Ok(()) => {
                self.torn = false;
                self.report.messages += lines;
                Ok(())
            }
            Err(problem) if problem.kind() == io::ErrorKind::BrokenPipe => Err(problem),
            Err(problem) => {
                if self.report.lost == 0 {
                    warn!(%problem, "cannot write the recording, losing messages (counted)");
                }
                self.torn = true;
                self.report.lost += lines;
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use bytes::Bytes;
    use vibrissa_core::units::Micros;

    use super::*;

    /// A disk that becomes full in the middle of the second line, and then has space again.
    #[derive(Default)]
    struct Disk {
        held: Vec<u8>,
        is_full: bool,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if !self.is_full {
                self.held.extend_from_slice(bytes);
                return Ok(bytes.len());
            }
            self.held.extend_from_slice(&bytes[..bytes.len() / 2]);
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn incoming(topic: &'static [u8]) -> Incoming {
        Incoming { topic: Bytes::from_static(topic), payload: Bytes::from_static(b"{}"), received: Micros(1) }
    }

    #[test]
    fn what_cannot_be_written_is_counted_and_the_next_line_is_whole() {
        let mut disk = Disk::default();
        let mut report = Report::default();
        for is_full in [false, true, false] {
            disk.is_full = is_full;
            let mut journal = Journal::new(&mut disk);
            (journal.report, journal.torn) = (report, report.lost > 0);
            journal.add(&incoming(b"t")).unwrap();
            journal.flush().unwrap();
            report = journal.report;
        }
        assert_eq!(report, Report { messages: 2, lost: 1, breaks: 0 });
        let mut lines = Lines::new(&disk.held[..]);
        let good = std::iter::from_fn(|| lines.next_line().unwrap()).map(|line| line.is_ok());
        assert_eq!(good.collect::<Vec<_>>(), [true, false, true]);
    }

    #[test]
    fn a_topic_that_cannot_be_written_is_counted() {
        let mut out = Vec::new();
        let mut journal = Journal::new(&mut out);
        journal.add(&incoming(&[0xff])).unwrap();
        assert_eq!(journal.report.lost, 1);
    }
}
