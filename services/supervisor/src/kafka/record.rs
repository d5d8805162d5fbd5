//! A record of a batch: what the supervisor needs of it.

use bytes::{Buf, Bytes};

/// Headers with the MQTT topic, as bridges name them.
const TOPIC_HEADERS: [&[u8]; 3] = [b"topic", b"mqtt_topic", b"mqtt.topic"];

/// A record with its offset.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Record {
    pub(super) offset: i64,
    pub(super) key: Option<Bytes>,
    pub(super) value: Option<Bytes>,
    /// Values of the headers that may have the MQTT topic. The first one counts that has it.
    pub(super) topics: [Option<Bytes>; TOPIC_HEADERS.len()],
}

/// The records of a batch that are not taken yet.
pub(super) struct Records {
    pub(super) rest: Bytes,
    /// Offset that those of the records are relative to.
    pub(super) base: i64,
    /// Offset of the last record, relative.
    pub(super) last: i32,
    /// Offset of the record before, relative.
    pub(super) before: i32,
}

impl Records {
    /// The next record; `None` if the bytes are no record.
    pub(super) fn take(&mut self) -> Option<Record> {
        let mut bytes = part(&mut self.rest)?;
        // Attributes, which have no meaning yet.
        bytes.try_get_i8().ok()?;
        // The time, relative.
        varint(&mut bytes)?;
        let delta = i32::try_from(varint(&mut bytes)?).ok()?;
        if delta <= self.before || delta > self.last {
            return None;
        }
        self.before = delta;
        let (key, value) = (part_or_none(&mut bytes)?, part_or_none(&mut bytes)?);
        let mut topics = [const { None }; TOPIC_HEADERS.len()];
        for _ in 0..varint(&mut bytes)? {
            let (name, value) = (part(&mut bytes)?, part_or_none(&mut bytes)?);
            if let Some(at) = TOPIC_HEADERS.iter().position(|known| *known == name) {
                topics[at] = value;
            }
        }
        bytes.is_empty().then_some(Record { offset: self.base + i64::from(delta), key, value, topics })
    }
}

/// A number of up to ten bytes of seven bits each, with its sign in the lowest bit.
fn varint(bytes: &mut Bytes) -> Option<i64> {
    let mut number = 0_u64;
    for shift in (0..64).step_by(7) {
        let byte = bytes.try_get_u8().ok()?;
        number |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Some((number >> 1) as i64 ^ -((number & 1) as i64));
        }
    }
    None
}

/// Bytes after their number.
fn part(bytes: &mut Bytes) -> Option<Bytes> {
    part_or_none(bytes)?
}

/// Bytes after their number, or none after the number -1.
fn part_or_none(bytes: &mut Bytes) -> Option<Option<Bytes>> {
    match varint(bytes)? {
        -1 => Some(None),
        length => {
            let length = usize::try_from(length).ok().filter(|length| *length <= bytes.len())?;
            Some(Some(bytes.split_to(length)))
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    pub(in super::super) fn record(offset: i64, key: Option<&[u8]>, value: Option<&[u8]>) -> Record {
        let bytes = |bytes: &[u8]| Bytes::copy_from_slice(bytes);
        Record { offset, key: key.map(bytes), value: value.map(bytes), topics: [const { None }; 3] }
    }

    fn put(to: &mut Vec<u8>, number: i64) {
        let mut number = ((number << 1) ^ (number >> 63)) as u64;
        while number >= 0x80 {
            to.push(number as u8 | 0x80);
            number >>= 7;
        }
        to.push(number as u8);
    }

    fn put_part(to: &mut Vec<u8>, part: Option<&[u8]>) {
        put(to, part.map_or(-1, |part| part.len() as i64));
        to.extend(part.unwrap_or_default());
    }

    /// A record as a batch has it.
    pub(in super::super) fn written(
        delta: i32,
        key: Option<&[u8]>,
        value: Option<&[u8]>,
        headers: &[(&[u8], &[u8])],
    ) -> Vec<u8> {
        let mut record = vec![0];
        put(&mut record, -3);
        put(&mut record, delta.into());
        put_part(&mut record, key);
        put_part(&mut record, value);
        put(&mut record, headers.len() as i64);
        for (name, value) in headers {
            put_part(&mut record, Some(name));
            put_part(&mut record, Some(value));
        }
        let mut written = Vec::new();
        put_part(&mut written, Some(&record));
        written
    }

    fn taken(bytes: Vec<u8>) -> Option<Record> {
        Records { rest: bytes.into(), base: 100, last: 9, before: -1 }.take()
    }

    #[test]
    fn a_record_has_key_value_and_the_headers_with_a_topic() {
        assert_eq!(taken(written(3, None, None, &[])), Some(record(103, None, None)));
        let headers: [(&[u8], &[u8]); 3] = [(b"mqtt.topic", b"a"), (b"x", b"b"), (b"topic", b"")];
        let expected =
            Record { topics: [Some(Bytes::new()), None, Some("a".into())], ..record(100, Some(b"k"), Some(&[7; 300])) };
        assert_eq!(taken(written(0, Some(b"k"), Some(&[7; 300]), &headers)), Some(expected));
    }

    #[test]
    fn bytes_that_are_no_record_are_none() {
        let good = written(0, Some(b"k"), Some(b"v"), &[(b"topic", b"t")]);
        for length in 0..good.len() {
            assert_eq!(taken(good[..length].to_vec()), None, "{length}");
        }
        assert_eq!(taken(written(10, None, None, &[])), None, "an offset after the last one");
        let mut same = Records { rest: [good.clone(), good].concat().into(), base: 0, last: 9, before: -1 };
        assert!(same.take().is_some() && same.take().is_none(), "two records with one offset");
        assert_eq!(taken(vec![0xff; 20]), None);
        let mut huge = Vec::new();
        put(&mut huge, i64::MAX);
        assert_eq!(taken(huge), None);
    }
}
