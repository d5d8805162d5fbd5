//! Batches of records as Kafka stores and sends them (message format 2), read with limits of their size in memory.

use bytes::{Buf, Bytes};

use super::defect::{Codec, Defect, RECORDS_MAX, UNPACKED_MAX};
use super::record::{Record, Records};

/// Bytes of a batch before those that its length counts.
const BEFORE_LENGTH: usize = 12;
/// Bytes of a batch before its records.
const HEAD: usize = 61;
/// Bytes of a batch before those that the checksum covers.
const BEFORE_CHECKED: usize = 21;

/// The records of an answer.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Batches {
    pub(super) records: Vec<Record>,
    /// Offset after the last batch that was read.
    pub(super) next: i64,
}

/// The records from an offset on in the answer to a read, in which the partition ends at `end`. Reads up to a batch that
/// has a defect, or that the limits leave no room for: the next answer begins with it.
pub(super) fn read(answer: Bytes, at: i64, end: i64) -> Result<Batches, Defect> {
    let mut read = Batches { records: Vec::new(), next: at };
    let (mut rest, mut room) = (answer, UNPACKED_MAX);
    while let Some(batch) = cut(&mut rest) {
        let before = read.records.len();
        match batch.and_then(|batch| add(&mut read, &batch, (at, end), &mut room)) {
            Ok(()) => {}
            Err(defect) if read.next == at => return Err(defect),
            Err(_) => {
                read.records.truncate(before);
                break;
            }
        }
    }
    Ok(read)
}

/// Cuts off the first batch; `None` if there is no whole one, as at the end of an answer.
fn cut(rest: &mut Bytes) -> Option<Result<Bytes, Defect>> {
    let length = rest.get(8..BEFORE_LENGTH)?.try_into().map(i32::from_be_bytes).ok()?;
    let Some(length) = usize::try_from(length).ok().filter(|length| BEFORE_LENGTH + length >= HEAD) else {
        rest.clear();
        return Some(Err(Defect::Malformed("length")));
    };
    (BEFORE_LENGTH + length <= rest.len()).then(|| Ok(rest.split_to(BEFORE_LENGTH + length)))
}

/// Adds the records of a batch.
fn add(to: &mut Batches, batch: &Bytes, (at, end): (i64, i64), room: &mut usize) -> Result<(), Defect> {
    let mut head = batch.slice(..HEAD);
    let base = head.get_i64();
    head.advance(8);
    if head.get_i8() != 2 {
        return Err(Defect::Old);
    }
    if head.get_u32() != crc32c::crc32c(&batch[BEFORE_CHECKED..]) {
        return Err(Defect::Checksum);
    }
    let (attributes, last) = (head.get_i16(), head.get_i32());
    // Two times, and who wrote it.
    head.advance(30);
    let count = head.get_i32();
    let next = base.checked_add(i64::from(last)).and_then(|last| last.checked_add(1));
    // Offsets are not part of what the checksum covers.
    let next = next.filter(|next| last >= 0 && base >= 0 && (to.next + 1..=end).contains(next));
    let next = next.ok_or(Defect::Malformed("offset"))?;
    let is_mark_of_a_transaction = attributes & 0x20 != 0;
    if !is_mark_of_a_transaction {
        let count = usize::try_from(count.max(0)).unwrap_or_default();
        if to.records.len() + count > RECORDS_MAX {
            return Err(Defect::TooMany);
        }
        let packed = batch.slice(HEAD..);
        let bytes = match attributes & 0x07 {
            0 => packed,
            number => {
                let unpacked = Codec::of(number).ok_or(Defect::UnknownCodec(number))?.unpack(&packed, *room)?;
                *room -= unpacked.len();
                unpacked
            }
        };
        let mut records = Records { rest: bytes, base, last, before: -1 };
        for _ in 0..count {
            let record = records.take().ok_or(Defect::Malformed("record"))?;
            if record.offset >= at {
                to.records.push(record);
            }
        }
        if !records.rest.is_empty() {
            return Err(Defect::Malformed("number of records"));
        }
    }
    to.next = next;
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::record::tests::{record, written};
    use super::super::unpack::tests::{CODECS, pack};
    use super::*;

    const END: i64 = i64::MAX;

    /// A batch with these records, whose offsets follow each other.
    fn batch(base: i64, codec: Option<Codec>, records: &[Vec<u8>]) -> Vec<u8> {
        let content = records.concat();
        let (number, content) = match codec {
            None => (0, content),
            Some(codec) => (codec as i16 + 1, pack(codec, &content)),
        };
        raw(base, number, records.len() as i32, &content)
    }

    fn raw(base: i64, attributes: i16, count: i32, content: &[u8]) -> Vec<u8> {
        let mut checked = attributes.to_be_bytes().to_vec();
        checked.extend((count - 1).to_be_bytes());
        checked.extend([0; 30]);
        checked.extend(count.to_be_bytes());
        checked.extend(content);
        let mut batch = base.to_be_bytes().to_vec();
        batch.extend((checked.len() as i32 + 9).to_be_bytes());
        batch.extend([0, 0, 0, 0, 2]);
        batch.extend(crc32c::crc32c(&checked).to_be_bytes());
        batch.extend(checked);
        batch
    }

    fn some(count: i32, length: usize) -> Vec<Vec<u8>> {
        (0..count).map(|delta| written(delta, Some(b"k"), Some(&vec![b'x'; length]), &[])).collect()
    }

    fn offsets(answer: Vec<u8>, at: i64) -> Result<(Vec<i64>, i64), Defect> {
        let read = read(answer.into(), at, END)?;
        Ok((read.records.iter().map(|record| record.offset).collect(), read.next))
    }

    #[test]
    fn records_of_each_codec_are_read_from_the_offset_on_and_up_to_the_last_whole_batch() {
        for codec in [None].into_iter().chain(CODECS.map(Some)) {
            let mut answer = batch(10, codec, &some(3, 20));
            answer.extend(batch(13, codec, &some(2, 20)));
            answer.extend(&batch(15, codec, &some(2, 20))[..70]);
            assert_eq!(offsets(answer, 11), Ok((vec![11, 12, 13, 14], 15)), "{codec:?}");
        }
        assert_eq!(offsets(Vec::new(), 7), Ok((vec![], 7)));
        let read = read(batch(0, Some(Codec::Lz4), &some(1, 3)).into(), 0, 1).unwrap();
        assert_eq!(read.records, [record(0, Some(b"k"), Some(b"xxx"))]);
    }

    #[test]
    fn marks_of_transactions_and_batches_without_records_are_passed() {
        let mut answer = raw(0, 0x30, 1, &[0, 0, 0, 1]);
        let mut empty = raw(1, 0, 0, &[]);
        // A compaction keeps the last offset.
        empty[23..27].copy_from_slice(&4_i32.to_be_bytes());
        let checksum = crc32c::crc32c(&empty[BEFORE_CHECKED..]).to_be_bytes();
        empty[17..21].copy_from_slice(&checksum);
        answer.extend(empty);
        assert_eq!(offsets(answer, 0), Ok((vec![], 6)));
    }

    #[test]
    fn a_defect_is_told_when_its_batch_comes_first() {
        let good = batch(0, None, &some(2, 20));
        let mut checksum = batch(2, None, &some(2, 20));
        checksum[80] ^= 1;
        let mut old = batch(2, None, &some(2, 20));
        old[16] = 1;
        let mut length = batch(2, None, &some(2, 20));
        length[8] = 0xff;
        for (bad, defect) in [
            (checksum, Defect::Checksum),
            (old, Defect::Old),
            (length, Defect::Malformed("length")),
            (raw(2, 6, 1, b"x"), Defect::UnknownCodec(6)),
            (raw(2, 3, 1, b"no lz4"), Defect::Packed(Codec::Lz4)),
            (raw(2, 0, 2, &some(1, 5).concat()), Defect::Malformed("record")),
            (raw(2, 0, 1, &some(2, 5).concat()), Defect::Malformed("number of records")),
            (raw(2, 0, 200_000, b""), Defect::TooMany),
            (raw(-2, 0, 5, b""), Defect::Malformed("offset")),
            (raw(i64::MAX, 0, 1, b""), Defect::Malformed("offset")),
        ] {
            assert_eq!(offsets(bad.clone(), 2), Err(defect));
            assert_eq!(offsets([good.clone(), bad].concat(), 0), Ok((vec![0, 1], 2)), "{defect}");
        }
        assert_eq!(read(batch(2, None, &some(2, 1)).into(), 2, 3), Err(Defect::Malformed("offset")), "beyond the end");
    }

    #[test]
    fn a_bomb_of_each_codec_is_refused_and_several_batches_share_the_room() {
        for codec in CODECS {
            assert_eq!(offsets(batch(0, Some(codec), &some(1, UNPACKED_MAX)), 0), Err(Defect::TooLong(codec)));
            let half = batch(0, Some(codec), &some(2, UNPACKED_MAX / 5 * 2));
            let answer = [half.clone(), batch(2, Some(codec), &some(2, UNPACKED_MAX / 5 * 2))].concat();
            assert_eq!(offsets(answer, 0), Ok((vec![0, 1], 2)), "the second one comes with the next answer");
        }
    }

    proptest! {
        #[test]
        fn property_damaged_answers_are_read_or_refused(
            base in 0_i64..5, count in 1_i32..20, damages: Vec<(prop::sample::Index, u8)>
        ) {
            let next = batch(base + i64::from(count), None, &some(3, 9));
            let mut answer = [batch(base, None, &some(count, 30)), next].concat();
            for (at, byte) in &damages {
                *at.get_mut(&mut answer) = *byte;
            }
            if let Ok(read) = read(answer.into(), base, 100) {
                prop_assert!((base..=100).contains(&read.next));
                prop_assert!(read.records.is_sorted_by(|one, next| one.offset < next.offset));
                prop_assert!(read.records.last().is_none_or(|last| last.offset < read.next));
            }
        }
    }
}
