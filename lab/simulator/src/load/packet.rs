//! The part of MQTT 3.1.1 that the load generator needs: packets are written to one buffer and parsed from another.
//!
//! Written by hand, since the generator's processor time is taken from the system under test.

use std::io;

/// DISCONNECT packet.
pub const DISCONNECT: [u8; 2] = [0xe0, 0];
/// PINGREQ packet; the broker answers it after all earlier packets.
pub const PING: [u8; 2] = [0xc0, 0];
/// Largest number of filters in one SUBSCRIBE.
const FILTERS_MAX: usize = 200;

/// A packet from the broker.
#[derive(Debug, PartialEq, Eq)]
pub enum Incoming<'a> {
    /// Answer to CONNECT; 0 is success.
    ConnAck(u8),
    /// A subscription is confirmed.
    SubAck,
    /// A QoS 1 message has been acknowledged.
    PubAck,
    /// Answer to a ping, after all earlier packets.
    PingResponse,
    /// A message; `id` is set if it must be acknowledged.
    Publish {
        /// Topic of the message.
        topic: &'a [u8],
        /// Packet identifier to acknowledge.
        id: Option<u16>,
        /// Payload of the message.
        payload: &'a [u8],
    },
}

/// Options of a published message.
#[derive(Debug, Clone, Copy)]
pub struct Manner {
    /// Packet identifier for QoS 1; `None` for QoS 0.
    pub id: Option<u16>,
    /// Retain flag.
    pub retain: bool,
}

/// Appends a CONNECT with a clean session and without keep-alive, which a burst might miss.
pub fn connect(out: &mut Vec<u8>, client_id: &str) {
    out.push(0x10);
    length(out, 10 + 2 + client_id.len());
    text(out, b"MQTT");
    out.extend_from_slice(&[4, 0x02, 0, 0]);
    text(out, client_id.as_bytes());
}

/// Appends SUBSCRIBE packets with QoS 1; returns the number of expected acknowledgements.
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

/// Buffer of received bytes that are not parsed yet.
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
    /// An empty placeholder without a buffer.
    pub fn none() -> Self {
        Self { buffer: Vec::new(), begin: 0, end: 0 }
    }

    /// Space to read into; call [`Self::filled`] with the number of bytes read.
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

    /// Adds the number of bytes that were read.
    pub fn filled(&mut self, bytes: usize) {
        self.end += bytes;
    }

    /// The next complete packet; `None` if it has not arrived yet.
    ///
    /// # Errors
    /// The packet is malformed or unexpected.
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
                return Err(io::Error::other("packet from the broker with an invalid length"));
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
    let short = || io::Error::other("packet from the broker is too short");
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
        kind => Err(io::Error::other(format!("unexpected packet from the broker: type {kind}"))),
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
