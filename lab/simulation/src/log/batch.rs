//! Batches as Kafka stores them: message format 2, without compression.

use bytes::{BufMut, Bytes, BytesMut};

/// Bytes of a batch before those that its checksum covers: offset, length, epoch of the leader, format, checksum.
const BEFORE_CHECKED: usize = 21;

/// A record as it was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entry {
    /// Key of the record, which chooses its partition.
    pub key: Option<Vec<u8>>,
    /// Payload of the record.
    pub value: Option<Vec<u8>>,
    /// Name and value of its header, if it has one.
    pub header: Option<(String, Vec<u8>)>,
}

/// The batch of these records, of which there is at least one, from an offset on.
pub(super) fn encode(offset: i64, records: &[Entry]) -> Bytes {
    let mut checked = BytesMut::new();
    let count = records.len() as i32;
    // Attributes: neither codec nor transaction.
    checked.put_i16(0);
    checked.put_i32(count - 1);
    // First and last time.
    checked.put_i64(0);
    checked.put_i64(0);
    // No producer that counts.
    checked.put_i64(-1);
    checked.put_i16(-1);
    checked.put_i32(-1);
    checked.put_i32(count);
    for (delta, record) in records.iter().enumerate() {
        let mut bytes = BytesMut::new();
        bytes.put_i8(0);
        number(&mut bytes, 0);
        number(&mut bytes, delta as i64);
        part(&mut bytes, record.key.as_deref());
        part(&mut bytes, record.value.as_deref());
        number(&mut bytes, record.header.is_some().into());
        if let Some((name, value)) = &record.header {
            part(&mut bytes, Some(name.as_bytes()));
            part(&mut bytes, Some(value));
        }
        part(&mut checked, Some(&bytes));
    }
    let mut batch = BytesMut::with_capacity(BEFORE_CHECKED + checked.len());
    batch.put_i64(offset);
    // Epoch, format and checksum count, too.
    batch.put_i32(checked.len() as i32 + 9);
    batch.put_i32(0);
    batch.put_i8(2);
    batch.put_u32(crc32c::crc32c(&checked));
    batch.put(checked);
    batch.freeze()
}

/// Seven bits in a byte, the lowest ones first, with the sign as the lowest bit of all.
fn number(to: &mut BytesMut, number: i64) {
    let mut number = ((number << 1) ^ (number >> 63)) as u64;
    while number >= 0x80 {
        to.put_u8(number as u8 | 0x80);
        number >>= 7;
    }
    to.put_u8(number as u8);
}

fn part(to: &mut BytesMut, part: Option<&[u8]>) {
    number(to, part.map_or(-1, |part| part.len() as i64));
    to.put_slice(part.unwrap_or_default());
}
