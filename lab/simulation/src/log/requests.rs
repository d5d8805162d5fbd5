//! Kafka's requests as far as readers need them, and their answers: one version of each.

use std::sync::atomic::Ordering;

use bytes::{Buf, BufMut, Bytes, BytesMut};

use super::{ModelLog, Partition, State};

/// Numbers of the requests.
const FETCH: i16 = 1;
const LIST_OFFSETS: i16 = 2;
const METADATA: i16 = 3;
const API_VERSIONS: i16 = 18;
/// The requests, each with its only version.
const SPOKEN: [(i16, i16); 4] = [(FETCH, 4), (LIST_OFFSETS, 3), (METADATA, 4), (API_VERSIONS, 3)];

/// Numbers of the errors.
const OFFSET_OUT_OF_RANGE: i16 = 1;
const UNKNOWN_TOPIC_OR_PARTITION: i16 = 3;
const LEADER_NOT_AVAILABLE: i16 = 5;
const NOT_LEADER: i16 = 6;
const UNSUPPORTED_VERSION: i16 = 35;

/// A request of a client.
#[derive(Debug)]
pub(super) struct Request {
    pub(super) correlation: i32,
    body: Body,
}

#[derive(Debug)]
enum Body {
    ApiVersions { version: i16 },
    Metadata { topics: Option<Vec<String>> },
    ListOffsets { asked: Vec<(String, Vec<(i32, i64)>)> },
    Fetch { wait_ms: i32, asked: Vec<(String, Vec<Wanted>)> },
}

/// A read of a partition.
#[derive(Debug)]
struct Wanted {
    partition: i32,
    from: i64,
    bytes: i32,
}

impl Request {
    /// The request in a frame; `None` if nobody here speaks it.
    pub(super) fn read(mut frame: Bytes) -> Option<Self> {
        let from = &mut frame;
        let (kind, version, correlation) =
            (from.try_get_i16().ok()?, from.try_get_i16().ok()?, from.try_get_i32().ok()?);
        text(from)?;
        let is_spoken = SPOKEN.contains(&(kind, version));
        let body = match kind {
            API_VERSIONS => Body::ApiVersions { version },
            METADATA if is_spoken => {
                let count = from.try_get_i32().ok()?;
                let topics = (0..count).map(|_| text(from)?).collect::<Option<Vec<_>>>()?;
                Body::Metadata { topics: (count >= 0).then_some(topics) }
            }
            LIST_OFFSETS if is_spoken => {
                // Who asks, and which records of transactions it sees.
                from.try_get_i32().ok()?;
                from.try_get_i8().ok()?;
                Body::ListOffsets {
                    asked: topics(from, |from| Some((from.try_get_i32().ok()?, from.try_get_i64().ok()?)))?,
                }
            }
            FETCH if is_spoken => {
                from.try_get_i32().ok()?;
                let wait_ms = from.try_get_i32().ok()?;
                // Least and most bytes of the answer, and which records of transactions the client sees.
                from.try_get_i32().ok()?;
                from.try_get_i32().ok()?;
                from.try_get_i8().ok()?;
                let wanted = |from: &mut Bytes| {
                    let (partition, at, bytes) =
                        (from.try_get_i32().ok()?, from.try_get_i64().ok()?, from.try_get_i32().ok()?);
                    Some(Wanted { partition, from: at, bytes })
                };
                Body::Fetch { wait_ms, asked: topics(from, wanted)? }
            }
            _ => return None,
        };
        Some(Self { correlation, body })
    }

    /// Time for which it waits for records, ms.
    pub(super) fn wait_ms(&self) -> u64 {
        match &self.body {
            Body::Fetch { wait_ms, .. } => u64::try_from(*wait_ms).unwrap_or_default(),
            Body::ApiVersions { .. } | Body::Metadata { .. } | Body::ListOffsets { .. } => 0,
        }
    }

    /// The answer, and whether it has something to say already: an answer without records may wait.
    pub(super) fn answer(&self, log: &ModelLog) -> (Bytes, bool) {
        let (state, to) = (log.state(), &mut BytesMut::new());
        to.put_i32(self.correlation);
        let mut has_news = true;
        match &self.body {
            Body::ApiVersions { version: 3 } => {
                to.put_i16(0);
                to.put_u8(SPOKEN.len() as u8 + 1);
                for (kind, version) in SPOKEN {
                    to.put_i16(kind);
                    to.put_i16(version);
                    to.put_i16(version);
                    to.put_u8(0);
                }
                to.put_i32(0);
                to.put_u8(0);
            }
            Body::ApiVersions { .. } => {
                to.put_i16(UNSUPPORTED_VERSION);
                to.put_i32(0);
            }
            Body::Metadata { topics } => metadata(to, &state, topics.as_deref(), &log.0.address),
            Body::ListOffsets { asked } => {
                to.put_i32(0);
                each(to, asked, |to, topic, (number, at)| {
                    let (error, offset) = match leader(&state, topic, *number) {
                        Err(error) => (error, -1),
                        Ok(partition) if *at == -2 => (0, partition.begin),
                        Ok(partition) => (0, partition.end),
                    };
                    to.put_i32(*number);
                    to.put_i16(error);
                    to.put_i64(-1);
                    to.put_i64(offset);
                });
            }
            Body::Fetch { asked, .. } => {
                has_news = false;
                to.put_i32(0);
                each(to, asked, |to, topic, wanted| has_news |= fetch(to, &state, topic, wanted));
            }
        }
        (to.split().freeze(), has_news)
    }
}

/// A text after its length; none for a negative length.
#[expect(clippy::option_option, reason = "a missing text is an answer, and missing bytes are not")]
fn text(from: &mut Bytes) -> Option<Option<String>> {
    let Ok(length) = usize::try_from(from.try_get_i16().ok()?) else { return Some(None) };
    (length <= from.len()).then(|| String::from_utf8(from.split_to(length).to_vec()).ok())
}

/// Topics, each with what is asked of its partitions.
fn topics<T>(from: &mut Bytes, one: impl Fn(&mut Bytes) -> Option<T>) -> Option<Vec<(String, Vec<T>)>> {
    let count = from.try_get_i32().ok()?;
    let topic = |_| {
        let name = text(from)??;
        let count = from.try_get_i32().ok()?;
        Some((name, (0..count).map(|_| one(from)).collect::<Option<Vec<T>>>()?))
    };
    (0..count).map(topic).collect()
}

fn put_text(to: &mut BytesMut, text: &str) {
    to.put_i16(text.len() as i16);
    to.put_slice(text.as_bytes());
}

/// Writes an answer about each partition that is asked for.
fn each<T>(to: &mut BytesMut, asked: &[(String, Vec<T>)], mut one: impl FnMut(&mut BytesMut, &str, &T)) {
    to.put_i32(asked.len() as i32);
    for (topic, partitions) in asked {
        put_text(to, topic);
        to.put_i32(partitions.len() as i32);
        for partition in partitions {
            one(to, topic, partition);
        }
    }
}

/// A partition at its leader, or the number of the error.
fn leader<'a>(state: &'a State, topic: &str, number: i32) -> Result<&'a Partition, i16> {
    let known = state.topics.get(topic).and_then(|topic| topic.get(usize::try_from(number).ok()?));
    match known {
        None => Err(UNKNOWN_TOPIC_OR_PARTITION),
        Some(partition) if partition.is_away => Err(NOT_LEADER),
        Some(partition) => Ok(partition),
    }
}

fn metadata(to: &mut BytesMut, state: &State, topics: Option<&[String]>, (host, port): &(String, u16)) {
    // Throttling; one broker with its number, address and no rack; no name of the cluster; the controller.
    to.put_i32(0);
    to.put_i32(1);
    to.put_i32(1);
    put_text(to, host);
    to.put_i32((*port).into());
    to.put_i16(-1);
    to.put_i16(-1);
    to.put_i32(1);
    let all: Vec<String> = state.topics.keys().cloned().collect();
    let topics = topics.unwrap_or(&all);
    to.put_i32(topics.len() as i32);
    for name in topics {
        let partitions = state.topics.get(name);
        to.put_i16(if partitions.is_some() { 0 } else { UNKNOWN_TOPIC_OR_PARTITION });
        put_text(to, name);
        to.put_u8(0);
        to.put_i32(partitions.map_or(0, Vec::len) as i32);
        for (number, partition) in partitions.into_iter().flatten().enumerate() {
            to.put_i16(if partition.is_away { LEADER_NOT_AVAILABLE } else { 0 });
            to.put_i32(number as i32);
            to.put_i32(if partition.is_away { -1 } else { 1 });
            // Replicas, and those in sync.
            for _ in 0..2 {
                to.put_i32(1);
                to.put_i32(1);
            }
        }
    }
}

/// Writes batches of a partition. Returns whether there is something to say.
fn fetch(to: &mut BytesMut, state: &State, topic: &str, wanted: &Wanted) -> bool {
    let partition = leader(state, topic, wanted.partition).and_then(|partition| {
        let is_in_range = (partition.begin..=partition.end).contains(&wanted.from);
        if is_in_range { Ok(partition) } else { Err(OFFSET_OUT_OF_RANGE) }
    });
    to.put_i32(wanted.partition);
    let Ok(partition) = partition.inspect_err(|&error| {
        to.put_i16(error);
        to.put_i64(-1);
        to.put_i64(-1);
        to.put_i32(-1);
        to.put_i32(0);
    }) else {
        return true;
    };
    to.put_i16(0);
    to.put_i64(partition.end);
    to.put_i64(partition.end);
    to.put_i32(-1);
    // At least one batch, however long; the last one may be cut off.
    let mut batches = BytesMut::new();
    let most = usize::try_from(wanted.bytes).unwrap_or_default();
    for batch in partition.batches.iter().filter(|batch| batch.next > wanted.from) {
        let room = if batches.is_empty() { batch.bytes.len() } else { most.saturating_sub(batches.len()) };
        batches.put_slice(&batch.bytes[..batch.bytes.len().min(room)]);
        partition.read.fetch_max(batch.next, Ordering::Relaxed);
        if batches.len() >= most {
            break;
        }
    }
    to.put_i32(batches.len() as i32);
    to.put_slice(&batches);
    !batches.is_empty()
}
