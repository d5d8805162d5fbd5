//! Reads the packets of one client, MQTT 3.1.1 or 5, from the bytes that pass.

use std::collections::BTreeMap;
use std::fmt;

use bytes::{Buf, BytesMut};
use mqtt5::packet::{FixedHeader, Packet, PacketType};

/// Largest packet that is read, in bytes: that of the embedded broker.
const PACKET_MAX: usize = 2 << 20;
/// Most bytes of a fixed header.
const HEADER_MAX: usize = 5;
/// First byte of a TLS handshake.
const TLS_HANDSHAKE: u8 = 0x16;
/// Type of the first packet, in the upper half of its first byte.
const CONNECT: u8 = 1;
/// Most topic aliases of a connection.
const ALIASES_MAX: usize = 256;

/// Something that a client does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Sight {
    /// It connects with a last will on this topic.
    Will(String),
    /// It publishes on this topic.
    Published(String),
    /// It subscribes to this filter.
    Subscribed(String),
}

/// Why the packets of a client are not read, or not any further.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Trouble {
    /// It uses TLS.
    Tls,
    /// A packet is larger than 2 MiB.
    TooLarge,
    /// It has too many topics.
    TooManyTopics,
    /// A packet is not one of MQTT 3.1.1 or 5, for this reason.
    Unreadable(String),
}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tls => f.write_str("it uses TLS, through which the relay cannot see"),
            Self::TooLarge => f.write_str("one of its packets is larger than 2 MiB"),
            Self::TooManyTopics => f.write_str("it has too many topics"),
            Self::Unreadable(why) => write!(f, "one of its packets is not one of MQTT 3.1.1 or 5: {why}"),
        }
    }
}

/// The packets of one client.
#[derive(Debug, Default)]
pub(super) struct Tap {
    buffer: BytesMut,
    /// Version of the protocol, from the first packet.
    version: Option<u8>,
    aliases: BTreeMap<u16, String>,
    is_over: bool,
}

impl Tap {
    /// Takes bytes; what the packets that end with them do. After a trouble nothing is read any more.
    pub(super) fn push(&mut self, bytes: &[u8]) -> (Vec<Sight>, Option<Trouble>) {
        let mut sights = Vec::new();
        if self.is_over {
            return (sights, None);
        }
        self.buffer.extend_from_slice(bytes);
        let trouble = self.read(&mut sights).err();
        if trouble.is_some() {
            self.is_over = true;
            self.buffer = BytesMut::new();
        }
        (sights, trouble)
    }

    fn read(&mut self, sights: &mut Vec<Sight>) -> Result<(), Trouble> {
        match self.buffer.first() {
            Some(&TLS_HANDSHAKE) if self.version.is_none() => return Err(Trouble::Tls),
            Some(first) if self.version.is_none() && first >> 4 != CONNECT => {
                return Err(unreadable("it does not begin with CONNECT"));
            }
            Some(_) | None => {}
        }
        while let Some((header, length)) = header(&self.buffer)? {
            let whole = length + header.remaining_length as usize;
            if whole > PACKET_MAX {
                return Err(Trouble::TooLarge);
            }
            if self.buffer.len() < whole {
                return Ok(());
            }
            let mut body = self.buffer.split_to(whole);
            body.advance(length);
            self.packet(&header, body, sights)?;
        }
        Ok(())
    }

    fn packet(&mut self, header: &FixedHeader, mut body: BytesMut, sights: &mut Vec<Sight>) -> Result<(), Trouble> {
        let kind = header.packet_type;
        // The other packets have no topics. Whether they are valid is the broker's affair.
        if !matches!(kind, PacketType::Connect | PacketType::Publish | PacketType::Subscribe) {
            return Ok(());
        }
        // CONNECT states its version itself.
        let version = self.version.unwrap_or_default();
        let packet = Packet::decode_from_body_with_version(kind, header, &mut body, version);
        match packet.map_err(unreadable)? {
            Packet::Connect(connect) => {
                self.version = Some(connect.protocol_version);
                sights.extend(connect.will.map(|will| Sight::Will(will.topic)));
            }
            Packet::Publish(publish) => {
                let topic = self.named(publish.topic_name, publish.properties.get_topic_alias())?;
                sights.push(Sight::Published(topic));
            }
            Packet::Subscribe(subscribe) => {
                sights.extend(subscribe.filters.into_iter().map(|one| Sight::Subscribed(one.filter)));
            }
            Packet::ConnAck(_)
            | Packet::PubAck(_)
            | Packet::PubRec(_)
            | Packet::PubRel(_)
            | Packet::PubComp(_)
            | Packet::SubAck(_)
            | Packet::Unsubscribe(_)
            | Packet::UnsubAck(_)
            | Packet::PingReq
            | Packet::PingResp
            | Packet::Disconnect(_)
            | Packet::Auth(_) => {}
        }
        Ok(())
    }

    /// The topic of a publication, which may be an alias of an earlier one.
    fn named(&mut self, topic: String, alias: Option<u16>) -> Result<String, Trouble> {
        let Some(alias) = alias else { return Ok(topic) };
        if topic.is_empty() {
            return self.aliases.get(&alias).cloned().ok_or_else(|| unreadable("it uses an unknown topic alias"));
        }
        if self.aliases.len() >= ALIASES_MAX && !self.aliases.contains_key(&alias) {
            return Err(Trouble::TooManyTopics);
        }
        self.aliases.insert(alias, topic.clone());
        Ok(topic)
    }
}

/// The fixed header at the beginning of bytes, and its length; `None` if it is not complete.
fn header(bytes: &[u8]) -> Result<Option<(FixedHeader, usize)>, Trouble> {
    // The last byte of the length is the first one below 128.
    let Some(end) = bytes.iter().skip(1).take(HEADER_MAX - 1).position(|byte| byte & 0x80 == 0) else {
        return if bytes.len() < HEADER_MAX { Ok(None) } else { Err(unreadable("its length is malformed")) };
    };
    let length = end + 2;
    let header = FixedHeader::decode(&mut &bytes[..length]).map_err(unreadable)?;
    Ok(Some((header, length)))
}

fn unreadable(why: impl fmt::Display) -> Trouble {
    Trouble::Unreadable(why.to_string())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A text with its length before it.
    fn text(text: &str) -> Vec<u8> {
        let mut bytes = u16::try_from(text.len()).unwrap().to_be_bytes().to_vec();
        bytes.extend(text.as_bytes());
        bytes
    }

    fn packet(first: u8, body: &[u8]) -> Vec<u8> {
        assert!(body.len() < 128, "one byte for the length");
        [&[first, u8::try_from(body.len()).unwrap()], body].concat()
    }

    /// CONNECT with a will on topic `w`; properties are those of MQTT 5.
    fn connect(version: u8) -> Vec<u8> {
        let none: &[u8] = if version == 5 { &[0] } else { &[] };
        let body =
            [&text("MQTT")[..], &[version, 0b0000_0110, 0, 10], none, &text("id"), none, &text("w"), &text("gone")];
        packet(0x10, &body.concat())
    }

    fn conversation(version: u8) -> Vec<u8> {
        let none: &[u8] = if version == 5 { &[0] } else { &[] };
        let subscribe = [&[0, 1][..], none, &text("a/#"), &[1], &text("b"), &[0]].concat();
        let publish = [&text("p/1")[..], none, b"payload"].concat();
        [connect(version), packet(0x82, &subscribe), packet(0xc0, &[]), packet(0x30, &publish)].concat()
    }

    fn expected() -> Vec<Sight> {
        let [will, a, b, p] = ["w", "a/#", "b", "p/1"].map(str::to_owned);
        vec![Sight::Will(will), Sight::Subscribed(a), Sight::Subscribed(b), Sight::Published(p)]
    }

    #[test]
    fn topics_of_both_versions_are_seen_however_the_bytes_are_divided() {
        for version in [4, 5] {
            let bytes = conversation(version);
            for size in 1..=bytes.len() {
                let mut tap = Tap::default();
                let mut seen = Vec::new();
                for chunk in bytes.chunks(size) {
                    let (sights, trouble) = tap.push(chunk);
                    assert_eq!(trouble, None, "version {version}");
                    seen.extend(sights);
                }
                assert_eq!(seen, expected(), "version {version}");
            }
        }
    }

    #[test]
    fn a_topic_alias_stands_for_its_topic() {
        let mut tap = Tap::default();
        tap.push(&connect(5));
        let alias = [3, 0x23, 0, 7];
        let named = packet(0x30, &[&text("p/7")[..], &alias].concat());
        let short = packet(0x30, &[&text("")[..], &alias].concat());
        let published = || vec![Sight::Published("p/7".to_owned())];
        assert_eq!(tap.push(&named), (published(), None));
        assert_eq!(tap.push(&short), (published(), None));
        let unknown = packet(0x30, &[&text("")[..], &[3, 0x23, 0, 8]].concat());
        assert!(matches!(tap.push(&unknown), (sights, Some(Trouble::Unreadable(_))) if sights.is_empty()));
    }

    #[test]
    fn what_cannot_be_read_is_told_once_and_ends_the_reading() {
        let mut tap = Tap::default();
        assert_eq!(tap.push(&[TLS_HANDSHAKE, 3, 1]), (vec![], Some(Trouble::Tls)));
        assert_eq!(tap.push(&conversation(5)), (vec![], None));
        // PUBLISH with a length of 256 MB.
        let mut tap = Tap::default();
        tap.push(&connect(5));
        assert_eq!(tap.push(&[0x30, 0xff, 0xff, 0xff, 0x7f]), (vec![], Some(Trouble::TooLarge)));
        assert!(matches!(Tap::default().push(b"GET / HTTP/1.1\r\n"), (_, Some(Trouble::Unreadable(_)))));
        assert!(matches!(Tap::default().push(&[0x10, 0xff, 0xff, 0xff, 0xff, 1]), (_, Some(Trouble::Unreadable(_)))));
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic_or_keep_more_than_a_packet(chunks in proptest::collection::vec(any::<Vec<u8>>(), 0..20)) {
            let mut tap = Tap::default();
            tap.push(&connect(5));
            for chunk in chunks {
                tap.push(&chunk);
                prop_assert!(tap.buffer.len() <= PACKET_MAX);
            }
        }
    }
}
