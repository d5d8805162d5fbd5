//! A recording made of a tape: the format of `vibrissa record`.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;
use vibrissa_core::units::Micros;
use vibrissa_edge::black_box::StateBytes;
use vibrissa_edge::recording::Recorded;
use vibrissa_protocol::RobotTopic;

use super::job::BoxToWrite;
use super::tape::EntryKind;

/// The lines of a box.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Lines {
    /// The lines, compressed.
    pub(super) body: Vec<u8>,
    /// Size of the lines, bytes.
    pub(super) bytes: usize,
    /// Number of messages.
    pub(super) messages: i64,
    /// Whether the first line is the robot's state.
    pub(super) has_state: bool,
    /// Time of the newest message.
    pub(super) last: Micros,
}

/// Makes the lines: the robot's state, its connection message and factsheet as a recorder gets them that subscribes at that
/// time, and then all messages until the end of the box.
pub(super) fn of(one: &BoxToWrite) -> io::Result<Lines> {
    let fleet = one.lease.fleet();
    let topic = |topic: RobotTopic| topic.of(fleet, &one.robot).to_string();
    let mut out = GzEncoder::new(Vec::new(), Compression::new(6));
    let mut lines = Lines { body: Vec::new(), bytes: 0, messages: 0, has_state: false, last: one.from };
    let mut line = Vec::new();
    let mut write = |recorded: &Recorded, bytes: &mut usize| {
        line.clear();
        recorded.write(&mut line);
        *bytes += line.len();
        out.write_all(&line)
    };
    let mut entries = one.tape.entries().peekable();
    if let Some(first) = entries.next_if(|entry| entry.kind == EntryKind::State)
        && let Ok((head, whiskers)) = borsh::from_slice(first.payload)
    {
        let state = StateBytes { head, whiskers };
        write(&state.line(first.at, fleet.as_str(), one.robot.as_str()), &mut lines.bytes)?;
        lines.has_state = true;
    }
    for (kind, payload) in [RobotTopic::Connection, RobotTopic::Factsheet].into_iter().zip(&one.base) {
        if let Some(payload) = payload {
            write(&Recorded { received: one.from, topic: topic(kind), payload: payload.clone() }, &mut lines.bytes)?;
            lines.messages += 1;
        }
    }
    for entry in entries.filter(|entry| entry.at <= one.ends) {
        let EntryKind::Message(kind) = entry.kind else { continue };
        write(&Recorded { received: entry.at, topic: topic(kind), payload: entry.payload.to_vec() }, &mut lines.bytes)?;
        lines.messages += 1;
        lines.last = lines.last.max(entry.at);
    }
    lines.body = out.finish()?;
    Ok(lines)
}
