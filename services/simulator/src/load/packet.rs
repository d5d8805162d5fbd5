//! As much of MQTT 3.1.1 as it takes to make load: whole packets into one buffer, and out of another.
//!
//! Written by hand, because what the generator costs is taken from what it measures.

use std::io;

/// The end of a connection in good order.
pub const DISCONNECT: [u8; 2] = [0xe0, 0];
/// The broker answers it after everything that was sent before.
pub const PING: [u8; 2] = [0xc0, 0];
/// Filters of one SUBSCRIBE.
const FILTERS_MAX: usize = 200;

/// What comes from the broker.
#[derive(Debug, PartialEq, Eq)]
pub enum Incoming<'a> {
    /// It lets us in, if that is 0.
    ConnAck(u8),
    /// A subscription stands.
    SubAck,
    /// A message of ours of QoS 1 has arrived.
    PubAck,
    /// Everything before the ping has arrived.
    PingResponse,
    /// A message, with a number if it wants an acknowledgement.
    Publish {
        /// Topic.
        topic: &'a [u8],
        /// The number to acknowledge.
        id: Option<u16>,
        /// Payload.
        payload: &'a [u8],
    },
}

/// How a message is published.
#[derive(Debug, Clone, Copy)]
pub struct Manner {
    /// The number to be acknowledged, with QoS 1.
    pub id: Option<u16>,
    /// Whether the broker retains it.
    pub retain: bool,
}

/// Appends a CONNECT of a clean session, without keep-alive: a burst is no time to fall silent in.
pub fn connect(out: &mut Vec<u8>, client_id: &str) {
    out.push(0x10);
    length(out, 10 + 2 + client_id.len());
    text(out, b"MQTT");
    out.extend_from_slice(&[4, 0x02, 0, 0]);
    text(out, client_id.as_bytes());
}

/// Appends SUBSCRIBEs of QoS 1; gives how many acknowledgements there will be.
pub fn subscribe(out: &mut Vec<u8>, filters: &[String]) -> usize {
    let groups = filters.chunks(FILTERS_MAX);
    let count = groups.len();
    for (at, group) in groups.enumerate() {
        out.push(0x82);
        length(out, 2 + group.iter().map(|filter| 3 + filter.len()).sum::<usize>());
        out.extend_from_slice(&(at as u16 + 1).to_be_bytes());
        for filter in group {
            text(out, filter.as_bytes());
            out.push(1);
        }
    }
    count
}

/// Appends a PUBLISH.
pub fn publish(out: &mut Vec<u8>, topic: &[u8], manner: Manner, payload: &[u8]) {
    out.push(0x30 | (u8::from(manner.id.is_some()) << 1) | u8::from(manner.retain));
    length(out, 2 + topic.len() + if manner.id.is_some() { 2 } else { 0 } + payload.len());
    text(out, topic);
    if let Some(id) = manner.id {
        out.extend_from_slice(&id.to_be_bytes());
    }
    out.extend_from_slice(payload);
}

/// Appends a PUBACK.
pub fn acknowledge(out: &mut Vec<u8>, id: u16) {
    out.extend_from_slice(&[0x40, 2]);
    out.extend_from_slice(&id.to_be_bytes());
}

fn length(out: &mut Vec<u8>, mut bytes: usize) {
    loop {
        let low = (bytes % 128) as u8;
        bytes /= 128;
        out.push(if bytes > 0 { low | 128 } else { low });
        if bytes == 0 {
            return;
        }
    }
}

fn text(out: &mut Vec<u8>, text: &[u8]) {
    out.extend_from_slice(&(text.len() as u16).to_be_bytes());
    out.extend_from_slice(text);
}

/// What was received and is not taken apart yet.
#[derive(Debug)]
pub struct Inbound {
    buffer: Vec<u8>,
    begin: usize,
    end: usize,
}

impl Default for Inbound {
    fn default() -> Self {
        Self { buffer: vec![0; 256 * 1024], begin: 0, end: 0 }
    }
}

impl Inbound {
    /// One without a buffer, to put in the place of another for a moment.
    pub fn none() -> Self {
        Self { buffer: Vec::new(), begin: 0, end: 0 }
    }

    /// Where to read to; say with [`Self::filled`] how much it was.
    pub fn space(&mut self) -> &mut [u8] {
        if self.begin == self.end {
            (self.begin, self.end) = (0, 0);
        }
        if self.end == self.buffer.len() {
            if self.begin == 0 {
                self.buffer.resize(2 * self.end, 0);
            }
            self.buffer.copy_within(self.begin..self.end, 0);
            (self.begin, self.end) = (0, self.end - self.begin);
        }
        &mut self.buffer[self.end..]
    }

    /// So many bytes were read.
    pub fn filled(&mut self, bytes: usize) {
        self.end += bytes;
    }

    /// The next whole packet; none if it is not there yet.
    ///
    /// # Errors
    /// It is no packet that we expect.
    pub fn next_packet(&mut self) -> io::Result<Option<Incoming<'_>>> {
        let bytes = &self.buffer[self.begin..self.end];
        let Some((&head, rest)) = bytes.split_first() else { return Ok(None) };
        let (mut length, mut digits) = (0, 0);
        loop {
            let Some(&digit) = rest.get(digits) else { return Ok(None) };
            length |= usize::from(digit & 127) << (7 * digits);
            digits += 1;
            if digit < 128 {
                break;
            }
            if digits == 4 {
                return Err(io::Error::other("a packet of the broker's has no length"));
            }
        }
        let begin = self.begin + 1 + digits;
        if self.end < begin + length {
            return Ok(None);
        }
        self.begin = begin + length;
        incoming(head, &self.buffer[begin..begin + length]).map(Some)
    }
}

fn incoming(head: u8, body: &[u8]) -> io::Result<Incoming<'_>> {
    let short = || io::Error::other("a packet of the broker's is too short");
    match head >> 4 {
        2 => Ok(Incoming::ConnAck(*body.get(1).ok_or_else(short)?)),
        3 => {
            let (size, rest) = body.split_first_chunk::<2>().ok_or_else(short)?;
            let (topic, rest) = rest.split_at_checked(u16::from_be_bytes(*size).into()).ok_or_else(short)?;
            if head & 0b110 == 0 {
                return Ok(Incoming::Publish { topic, id: None, payload: rest });
            }
            let (id, payload) = rest.split_first_chunk::<2>().ok_or_else(short)?;
            Ok(Incoming::Publish { topic, id: Some(u16::from_be_bytes(*id)), payload })
        }
        4 => Ok(Incoming::PubAck),
        9 => Ok(Incoming::SubAck),
        13 => Ok(Incoming::PingResponse),
        kind => Err(io::Error::other(format!("an unexpected packet of the broker's: {kind}"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_comes_out_as_it_went_in_even_in_pieces() {
        let mut bytes = Vec::new();
        let payload = vec![b'x'; 300];
        publish(&mut bytes, b"a/b", Manner { id: Some(513), retain: false }, &payload);
        publish(&mut bytes, b"c", Manner { id: None, retain: true }, b"");
        let mut inbound = Inbound::default();
        let mut found = Vec::new();
        for piece in bytes.chunks(7) {
            inbound.space()[..piece.len()].copy_from_slice(piece);
            inbound.filled(piece.len());
            while let Some(packet) = inbound.next_packet().unwrap() {
                found.push(format!("{packet:?}"));
            }
        }
        let first = Incoming::Publish { topic: b"a/b", id: Some(513), payload: &payload };
        let second = Incoming::Publish { topic: b"c", id: None, payload: b"" };
        assert_eq!(found, [format!("{first:?}"), format!("{second:?}")]);
    }

    #[test]
    fn a_buffer_grows_for_a_packet_that_is_larger() {
        let mut bytes = Vec::new();
        publish(&mut bytes, b"t", Manner { id: None, retain: false }, &vec![b'y'; 300_000]);
        let mut inbound = Inbound::default();
        for piece in bytes.chunks(100_000) {
            let space = inbound.space();
            let count = piece.len().min(space.len());
            space[..count].copy_from_slice(&piece[..count]);
            inbound.filled(count);
            if count < piece.len() {
                inbound.space()[..piece.len() - count].copy_from_slice(&piece[count..]);
                inbound.filled(piece.len() - count);
            }
        }
        assert!(
            matches!(inbound.next_packet().unwrap(), Some(Incoming::Publish { payload, .. }) if payload.len() == 300_000)
        );
    }
}
