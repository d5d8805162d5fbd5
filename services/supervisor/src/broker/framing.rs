//! Where the packets of a stream begin and end: how much of a packet has arrived, of which the rest is awaited.

/// Most bytes of a packet's length.
const LENGTH_BYTES_MAX: u32 = 4;

/// The place in a stream of packets.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(super) struct Framing {
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
    /// Moves on by bytes. Returns how many bytes of an incomplete packet have arrived.
    pub(super) fn push(&mut self, mut bytes: &[u8]) -> usize {
        while let Some((&first, rest)) = bytes.split_first() {
            match self.part {
                Part::Kind => self.step(Part::Length(0, 0)),
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
                    bytes = &bytes[taken..];
                    self.arrived += taken;
                    match awaited - taken {
                        0 => *self = Self::default(),
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

    fn step(&mut self, part: Part) {
        (self.arrived, self.part) = (self.arrived + 1, part);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packets_are_counted_however_the_bytes_are_divided() {
        // PINGREQ; PUBLISH of 300 bytes; CONNECT of 3 bytes and half a packet of 10.
        let mut bytes = vec![0xc0, 0, 0x30, 0xac, 0x02];
        bytes.extend([7; 300]);
        bytes.extend([0x10, 3, 1, 2, 3, 0x30, 10, 1, 2]);
        for size in 1..=bytes.len() {
            let mut framing = Framing::default();
            let last = bytes.chunks(size).map(|chunk| framing.push(chunk)).last();
            assert_eq!(last, Some(4), "in pieces of {size}");
        }
        let mut framing = Framing::default();
        assert_eq!(framing.push(&bytes[..104]), 102, "of the second packet");
        assert_eq!(framing.push(&bytes[104..305]), 0, "it is complete");
    }

    #[test]
    fn a_length_that_is_too_long_counts_nothing() {
        let mut framing = Framing::default();
        framing.push(&[0x30, 0xff, 0xff, 0xff, 0xff]);
        assert_eq!(framing.push(&[1; 1000]), 0);
    }
}
