//! Bytes that the library keeps for a connection: messages until they are acknowledged, subscriptions, the last will.

use std::collections::HashMap;

use super::framing::Packet;

/// Memory that a message in flight needs beside its bytes.
const OVERHEAD_BYTES: usize = 256;
/// Types of packets.
const CONNECT: u8 = 1;
const PUBLISH: u8 = 3;
const PUBACK: u8 = 4;
const PUBREL: u8 = 6;
const PUBCOMP: u8 = 7;
const SUBSCRIBE: u8 = 8;

/// A change of the bytes that the library keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Change {
    pub(super) more: usize,
    pub(super) fewer: usize,
}

/// The messages of a connection that are not acknowledged, by identifier and direction.
#[derive(Debug, Default)]
pub(super) struct InFlight {
    to_library: HashMap<u16, usize>,
    to_client: HashMap<u16, usize>,
}

impl InFlight {
    /// Takes a packet of the client in. A message with quality of service 1 is acknowledged at once. Subscriptions and the
    /// will count until the connection ends.
    pub(super) fn sent(&mut self, packet: Packet) -> Change {
        let id = packet.id;
        let fewer = |bytes: Option<usize>| Change { more: 0, fewer: bytes.unwrap_or_default() };
        match packet.kind() {
            PUBLISH if packet.qos() == 2 => keep(&mut self.to_library, packet),
            PUBREL => fewer(self.to_library.remove(&id)),
            PUBACK | PUBCOMP => fewer(self.to_client.remove(&id)),
            CONNECT | SUBSCRIBE => Change { more: packet.bytes, fewer: 0 },
            _ => Change::default(),
        }
    }

    /// Takes a packet to the client in.
    pub(super) fn received(&mut self, packet: Packet) -> Change {
        if packet.qos() > 0 { keep(&mut self.to_client, packet) } else { Change::default() }
    }
}

fn keep(kept: &mut HashMap<u16, usize>, packet: Packet) -> Change {
    let more = packet.bytes + OVERHEAD_BYTES;
    let fewer = kept.insert(packet.id, more).unwrap_or_default();
    Change { more, fewer }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_count_until_they_are_acknowledged_by_their_identifier() {
        let packet = |first, id, bytes| Packet { first, id, bytes };
        let (mut flight, kept) = (InFlight::default(), |bytes: usize| bytes + OVERHEAD_BYTES);
        let change = |more, fewer| Change { more, fewer };
        assert_eq!(flight.sent(packet(0x34, 1, 1000)), change(kept(1000), 0));
        assert_eq!(flight.sent(packet(0x34, 2, 10)), change(kept(10), 0));
        assert_eq!(flight.sent(packet(0x62, 3, 4)), change(0, 0), "no such message");
        assert_eq!(flight.sent(packet(0x62, 2, 4)), change(0, kept(10)));
        assert_eq!(flight.sent(packet(0x34, 1, 20)), change(kept(20), kept(1000)), "in its place");
        assert_eq!(flight.sent(packet(0x32, 9, 500)), change(0, 0), "quality of service 1");
        // The other direction has identifiers of its own.
        assert_eq!(flight.received(packet(0x32, 1, 70)), change(kept(70), 0));
        assert_eq!(flight.received(packet(0x30, 1, 70)), change(0, 0));
        assert_eq!(flight.sent(packet(0x40, 1, 4)), change(0, kept(70)));
        assert_eq!(flight.sent(packet(0x82, 1, 90)), change(90, 0));
    }
}
