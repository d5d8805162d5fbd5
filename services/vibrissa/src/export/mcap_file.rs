//! A recording as an MCAP file: one channel for each topic, JSON messages, and the contract's JSON Schemas.

use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;

use anyhow::Context;
use mcap::WriteOptions;
use mcap::records::MessageHeader;
use vibrissa_protocol::as_json;

use super::McapReport;
use super::new_file::NewFile;
use crate::recording::Lines;

/// A channel of the file.
struct Channel {
    id: u16,
    sequence: u32,
}

/// Writes the messages of a recording. `schema_of` returns the JSON Schema of a message by its name, the last segment of
/// its topic. `read` is called with the number of bytes read so far, and may end the work.
///
/// # Errors
/// The recording cannot be read, or the file cannot be written.
pub fn write(
    recording: impl BufRead,
    path: &Path,
    schema_of: fn(&str) -> Option<&'static str>,
    mut read: impl FnMut(u64) -> anyhow::Result<()>,
) -> anyhow::Result<McapReport> {
    let options = WriteOptions::new().compression(None).library(concat!("vibrissa ", env!("CARGO_PKG_VERSION")));
    let mut writer = options.create(NewFile::create(path)?).context("cannot write the file")?;
    let mut lines = Lines::new(recording);
    let mut channels: BTreeMap<String, Channel> = BTreeMap::new();
    let mut report = McapReport::default();
    while let Some(line) = lines.next_line().context("cannot read the recording")? {
        read(lines.bytes())?;
        let message = line.ok();
        let payload = message.as_ref().and_then(|message| as_json(&message.payload));
        let (Some(message), Some(payload)) = (&message, payload.filter(|payload| payload.first() == Some(&b'{')))
        else {
            report.left_out += 1;
            continue;
        };
        if !channels.contains_key(&message.topic) {
            let kind = message.topic.rsplit('/').next().unwrap_or_default();
            let schema_id = match schema_of(kind) {
                Some(schema) => writer.add_schema(kind, "jsonschema", schema.as_bytes())?,
                // 0 means no schema.
                None => 0,
            };
            let id = writer.add_channel(schema_id, &message.topic, "json", &BTreeMap::new())?;
            channels.insert(message.topic.clone(), Channel { id, sequence: 0 });
        }
        let channel = channels.get_mut(&message.topic).context("a channel of the topic")?;
        // A recording has the time of reception only. MCAP counts nanoseconds.
        let time_ns = message.received.0.saturating_mul(1000);
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time: time_ns,
            publish_time: time_ns,
        };
        writer.write_to_known_channel(&header, &payload).context("cannot write the file")?;
        channel.sequence = channel.sequence.wrapping_add(1);
        report.messages += 1;
    }
    writer.finish().context("cannot write the end of the file")?;
    writer.into_inner().complete()?;
    Ok(report)
}
