//! The archive from a partitioned log: the owner of each shard writes the contacts of its partition, as robots sent them.
//!
//! The records of the next files are planned in the database before they are read, so an attempt that was interrupted is repeated
//! with the same files. The log may have a message twice: a bridge repeats it, or the robot had no receipt. [`Seen`] recognises it.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use tokio::time::Instant;
use tracing::{error, info};
use vibrissa_core::units::Micros;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::{Contact, Contacts, Name, Received, RobotTopic, receive_contacts};
use vibrissa_store::archive::Archived;
use vibrissa_store::export::{Cell, RAW_CONTACTS};
use vibrissa_store::log_archive::LogSpan;
use vibrissa_store::{Lease, Writer};

use super::file::File;
use super::seen::Seen;
use super::{Archive, folder, strike};
use crate::kafka::{LogReader, OpenLog, StampedRecord};
use crate::metrics::FleetMetrics;

/// Most records that become files together.
const RECORDS_MAX: i64 = 100_000;
/// Microseconds of a day.
const DAY_US: i64 = 86_400_000_000;
/// Most days whose files are written together. A bridge with a wrong clock could name any number of days.
const DAYS_MAX: usize = 8;

/// Archives the partition of one shard.
pub(super) struct FromLog {
    log: LogReader,
    /// The connection, while it works.
    open: Option<OpenLog>,
    /// Position in the database; `None` before it is read.
    position: Option<Position>,
    /// Begin of the time that the next files cover.
    since: Instant,
}

struct Position {
    next: i64,
    planned: Option<LogSpan>,
    seen: Seen,
    /// Time before which all received records are archived, µs since 1970 UTC.
    archived_to_us: i64,
}

impl FromLog {
    pub(super) fn new(log: LogReader) -> Self {
        Self { log, open: None, position: None, since: Instant::now() }
    }

    /// Writes the next files, if it is time. Returns whether more wait already.
    pub(super) async fn next(
        &mut self,
        archive: &Archive,
        lease: &Lease,
        writer: &mut Writer,
        metrics: &FleetMetrics,
    ) -> anyhow::Result<bool> {
        let asked_at = wall_clock();
        let log = match self.open.take() {
            Some(mut open) => {
                open.refresh().await?;
                open
            }
            None => self.log.open_log().await?,
        };
        let result = self.next_of(&log, asked_at, (archive, lease, writer, metrics)).await;
        if result.is_ok() {
            self.open = Some(log);
        }
        result
    }

    async fn next_of(
        &mut self,
        log: &OpenLog,
        asked_at: Micros,
        (archive, lease, writer, metrics): (&Archive, &Lease, &mut Writer, &FleetMetrics),
    ) -> anyhow::Result<bool> {
        // After a failure the position is unknown: the transaction may be committed.
        let mut position = match self.position.take() {
            Some(position) => position,
            None => {
                let position = self.read(lease, writer, log).await?;
                metrics.archive_position_timestamp_seconds.set(position.archived_to_us as f64 / 1e6);
                position
            }
        };
        let span = match position.planned.take() {
            Some(span) => span,
            None => {
                if position.next > log.latest {
                    // The topic was created anew: the position is read again, and tells it.
                    return Ok(true);
                }
                if position.next < log.earliest {
                    log.tell_deleted(position.next);
                    position.next = log.earliest;
                }
                let (from, waiting) = (position.next, log.latest - position.next);
                if waiting == 0 {
                    position.archived_to_us = asked_at.0 as i64;
                    metrics.archive_position_timestamp_seconds.set(asked_at.as_s());
                }
                if waiting == 0 || (waiting < RECORDS_MAX && self.since.elapsed() < archive.every) {
                    self.position = Some(position);
                    return Ok(false);
                }
                let span = LogSpan { topic: self.log.topic().to_owned(), from, to: log.latest.min(from + RECORDS_MAX) };
                let seen = position.seen.to_json()?;
                writer.plan_log_archive(lease, &span, (&seen, position.archived_to_us)).await?;
                span
            }
        };
        let written = write(archive, lease, writer, log, (&span, position.archived_to_us), &mut position.seen).await?;
        strike(written.archived);
        let seen = position.seen.to_json()?;
        let is_more = log.latest > span.to;
        // The newest record in the log, when its end was read; else that of the span.
        let reached_us = if is_more { written.newest_us } else { Some(asked_at.0 as i64) };
        let archived_to_us = reached_us.unwrap_or(position.archived_to_us);
        let advanced = (written.files, written.archived);
        writer.advance_log_archive(lease, &span, (&seen, archived_to_us), advanced).await?;
        let Archived { contacts, bytes } = written.archived;
        metrics.archive_contacts.inc_by(contacts);
        metrics.archive_bytes.inc_by(bytes);
        let LogSpan { topic, from, to } = &span;
        info!(fleet = %lease.shard(), topic, from, to, files = written.files, contacts, bytes, "contacts archived from the log");
        metrics.archive_position_timestamp_seconds.set(archived_to_us as f64 / 1e6);
        self.since = Instant::now();
        self.position = Some(Position { next: span.to, planned: None, seen: position.seen, archived_to_us });
        Ok(is_more)
    }

    /// Reads the position from the database. A partition without one is archived from its first record.
    async fn read(&self, lease: &Lease, writer: &mut Writer, log: &OpenLog) -> anyhow::Result<Position> {
        let Some(known) = writer.log_archive(lease).await? else {
            let archived_to_us = wall_clock().0 as i64;
            return Ok(Position { next: log.earliest, planned: None, seen: Seen::default(), archived_to_us });
        };
        let (seen, archived_to_us) = (Seen::from_json(&known.seen)?, known.archived_to_us);
        if known.topic != self.log.topic() || known.next_offset > log.latest {
            error!(
                fleet = %lease.shard(), archived_topic = known.topic, topic = self.log.topic(), at = known.next_offset,
                latest = log.latest,
                "the archive was written from another topic, or the topic was created anew: archiving from its first record"
            );
            return Ok(Position { next: log.earliest, planned: None, seen, archived_to_us });
        }
        let next = known.next_offset;
        let planned = known.planned_to.map(|to| LogSpan { topic: known.topic, from: next, to });
        if planned.is_some() && next < log.earliest {
            log.tell_deleted(next);
        }
        Ok(Position { next, planned, seen, archived_to_us })
    }
}

/// The files of a span.
struct Written {
    files: u64,
    archived: Archived,
    /// Time of receipt of the newest message.
    newest_us: Option<i64>,
}

/// Writes the files of a span, one for each day; none if it has no new contacts. Their names have the time up to which
/// everything was archived, because a topic that is created anew has the same offsets again.
async fn write(
    archive: &Archive,
    lease: &Lease,
    writer: &mut Writer,
    log: &OpenLog,
    (span, since_us): (&LogSpan, i64),
    seen: &mut Seen,
) -> anyhow::Result<Written> {
    let mut files: BTreeMap<i64, File> = BTreeMap::new();
    let mut newest_us = None;
    let mut at = span.from;
    while at < span.to {
        let (records, next) = log.read(at, span.to).await?;
        at = next;
        for StampedRecord { received_us, record } in records {
            if record.kind != RobotTopic::Contacts {
                continue;
            }
            let Ok(Received { message, .. }) = receive_contacts(&record.payload, Vec::new()) else { continue };
            newest_us = newest_us.max(Some(received_us));
            if !seen.is_new(record.robot.as_str(), message.boot_id.as_str(), message.seq, received_us) {
                continue;
            }
            let mut day = received_us.div_euclid(DAY_US);
            if files.len() >= DAYS_MAX && !files.contains_key(&day) {
                day = files.keys().next_back().copied().unwrap_or(day);
            }
            let file = match files.entry(day) {
                Entry::Occupied(file) => file.into_mut(),
                Entry::Vacant(place) => {
                    let folder = folder(lease.fleet(), day * DAY_US);
                    let (shard, LogSpan { from, to, .. }) = (lease.shard().number(), span);
                    let path = format!("{folder}/contacts-log-{shard}-{from}-{to}-{since_us}.parquet");
                    place.insert(File::begin(&archive.objects, path, RAW_CONTACTS)?)
                }
            };
            for (position, contact) in message.contacts.iter().enumerate() {
                file.push(cells(lease.fleet(), &record.robot, &message, (position, contact), received_us)).await?;
            }
        }
    }
    if let Some(newest_us) = newest_us {
        seen.forget_old(newest_us);
    }
    let mut written = Written { files: 0, archived: Archived::default(), newest_us };
    files.retain(|_, file| file.contacts() > 0);
    if !files.is_empty() {
        // Otherwise another supervisor has archived the span, and the log may have deleted some of its records meanwhile.
        let at = writer.log_archive(lease).await?;
        let is_planned = at.is_some_and(|at| at.next_offset == span.from && at.planned_to == Some(span.to));
        anyhow::ensure!(is_planned, "another supervisor has archived these records");
    }
    for (_, file) in files {
        let archived = file.complete(&archive.objects).await?;
        written.files += 1;
        written.archived.contacts += archived.contacts;
        written.archived.bytes += archived.bytes;
    }
    Ok(written)
}

/// The columns of a contact, in the order of [`RAW_CONTACTS`].
fn cells(
    fleet: &Name,
    robot: &Name,
    message: &Contacts,
    (position, contact): (usize, &Contact),
    received_us: i64,
) -> Vec<Cell> {
    let text = |text: &str| Cell::Text(text.to_owned());
    let real = |value: Option<f64>| value.map_or(Cell::Null, Cell::Real);
    vec![
        text(fleet.as_str()),
        text(robot.as_str()),
        text(contact.array.as_str()),
        Cell::Whole(i64::from(contact.whisker)),
        Cell::Time(contact.t_us as i64),
        Cell::Time(received_us),
        text(message.boot_id.as_str()),
        Cell::Whole(message.seq as i64),
        Cell::Whole(position as i64),
        text(contact.place().word()),
        real(contact.ratio),
        real(contact.distance_mm),
        Cell::Real(contact.deflection_mm),
        Cell::Real(contact.strain),
        Cell::Real(contact.pressure_mpa),
        Cell::Real(contact.temperature_c),
        Cell::Null,
        Cell::Null,
        Cell::Null,
        Cell::Null,
    ]
}
