//! Where the packets of a stream begin and end: how much of a packet has arrived, of which the rest is awaited, and the
//! identifiers of complete packets.

/// Most bytes of a packet's length.
const LENGTH_BYTES_MAX: u32 = 4;

/// Type of the packets that carry messages.
const PUBLISH: u8 = 3;

/// A complete packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Packet {
    /// Its first byte.
    pub(super) first: u8,
    /// Its identifier; of a packet without one, any number.
    pub(super) id: u16,
    pub(super) bytes: usize,
}

impl Packet {
    /// Number of its type.
    pub(super) fn kind(self) -> u8 {
        self.first >> 4
    }

    /// Quality of service of a message; 0 of another packet.
    pub(super) fn qos(self) -> u8 {
        if self.kind() == PUBLISH { self.first >> 1 & 0b11 } else { 0 }
    }
}

/// The place in a stream of packets.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) struct Framing {
    /// First byte of the present packet.
    first: u8,
    /// Bytes of its rest that have arrived.
    rest: usize,
    /// Length of a message's topic, which comes first in its rest.
    topic: [u8; 2],
    id: [u8; 2],
    /// Bytes of the present packet that have arrived.
    arrived: usize,
    /// Part of the packet at this place.
    part: Part,
}

#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
enum Part {
    /// The first byte, which names the type.
    #[default]
    Kind,
    /// The length so far, and the number of its bytes.
    Length(usize, u32),
    /// The rest, of which so many bytes are awaited.
    Rest(usize),
    /// A length with more bytes than the protocol allows; nothing is counted any more.
    Broken,
}

impl Framing {
    /// Moves on by bytes, and tells each packet that they complete. Returns how many bytes of an incomplete packet have
    /// arrived.
    pub(super) fn push(&mut self, mut bytes: &[u8], mut complete: impl FnMut(Packet)) -> usize {
        while let Some((&first, rest)) = bytes.split_first() {
            match self.part {
                Part::Kind => {
                    self.first = first;
                    self.step(Part::Length(0, 0));
                }
                Part::Length(length, count) => {
                    let length = length | (usize::from(first & 0x7f) << (7 * count));
                    match (first & 0x80 != 0, count + 1) {
                        (true, LENGTH_BYTES_MAX) => self.step(Part::Broken),
                        (true, count) => self.step(Part::Length(length, count)),
                        (false, _) if length == 0 => *self = Self::default(),
                        (false, _) => self.step(Part::Rest(length)),
                    }
                }
                Part::Rest(awaited) => {
                    let taken = awaited.min(bytes.len());
                    self.note(&bytes[..taken]);
                    bytes = &bytes[taken..];
                    self.arrived += taken;
                    match awaited - taken {
                        0 => {
                            let id = u16::from_be_bytes(self.id);
                            complete(Packet { first: self.first, id, bytes: self.arrived });
                            *self = Self::default();
                        }
                        awaited => self.part = Part::Rest(awaited),
                    }
                    continue;
                }
                Part::Broken => return 0,
            }
            bytes = rest;
        }
        self.arrived
    }

    /// Reads topic length and identifier from a piece of the rest.
    fn note(&mut self, piece: &[u8]) {
        let mut id_at = 0;
        if self.first >> 4 == PUBLISH {
            // Until the length is whole, the identifier comes from a wrong place. The last reading counts.
            copy(piece, self.rest, 0, &mut self.topic);
            id_at = 2 + usize::from(u16::from_be_bytes(self.topic));
        }
        copy(piece, self.rest, id_at, &mut self.id);
        self.rest += piece.len();
    }

    fn step(&mut self, part: Part) {
        (self.arrived, self.part) = (self.arrived + 1, part);
    }
}

/// Copies the two bytes at a place of which a piece that begins at `from` has some.
fn copy(piece: &[u8], from: usize, place: usize, to: &mut [u8; 2]) {
    for (number, byte) in to.iter_mut().enumerate() {
        if let Some(found) = (place + number).checked_sub(from).and_then(|at| piece.get(at)) {
            *byte = *found;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_are_read_however_the_bytes_are_divided() {
        // PUBLISH with QoS 2, topic "ab", identifier 0x1234, no property and one byte; PUBREL; PUBLISH with QoS 0.
        let mut bytes = vec![0x34, 8, 0, 2, b'a', b'b', 0x12, 0x34, 0, 7, 0x62, 2, 0x56, 0x78];
        bytes.extend([0x30, 3, 0, 1, b'a']);
        for size in 1..=bytes.len() {
            let (mut framing, mut packets) = (Framing::default(), Vec::new());
            bytes.chunks(size).for_each(|chunk| {
                framing.push(chunk, |packet| packets.push(packet));
            });
            let kinds: Vec<_> = packets.iter().map(|one| (one.kind(), one.qos(), one.bytes)).collect();
            assert_eq!(kinds, [(3, 2, 10), (6, 0, 4), (3, 0, 5)], "in pieces of {size}");
            assert_eq!([packets[0].id, packets[1].id], [0x1234, 0x5678], "in pieces of {size}");
        }
    }

    #[test]
    fn packets_are_counted_however_the_bytes_are_divided() {
        // PINGREQ; PUBLISH of 300 bytes; CONNECT of 3 bytes and half a packet of 10.
        let mut bytes = vec![0xc0, 0, 0x30, 0xac, 0x02];
        bytes.extend([7; 300]);
        bytes.extend([0x10, 3, 1, 2, 3, 0x30, 10, 1, 2]);
        for size in 1..=bytes.len() {
            let mut framing = Framing::default();
            let last = bytes.chunks(size).map(|chunk| framing.push(chunk, |_| ())).last();
            assert_eq!(last, Some(4), "in pieces of {size}");
        }
        let mut framing = Framing::default();
        assert_eq!(framing.push(&bytes[..104], |_| ()), 102, "of the second packet");
        assert_eq!(framing.push(&bytes[104..305], |_| ()), 0, "it is complete");
    }

    #[test]
    fn a_length_that_is_too_long_counts_nothing() {
        let mut framing = Framing::default();
        framing.push(&[0x30, 0xff, 0xff, 0xff, 0xff], |_| ());
        assert_eq!(framing.push(&[1; 1000], |_| ()), 0);
    }
}
