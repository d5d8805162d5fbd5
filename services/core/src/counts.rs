//! Counts as they are stored: most are small, and take one byte or two.

use borsh::BorshDeserialize;
use borsh::io::{Error, ErrorKind, Read, Result, Write};

/// Digits to the base 128, the lowest first; all but the last have the highest bit set.
pub(crate) fn write<W: Write>(mut count: u32, writer: &mut W) -> Result<()> {
    while count >= 0x80 {
        writer.write_all(&[count as u8 | 0x80])?;
        count >>= 7;
    }
    writer.write_all(&[count as u8])
}

/// Reads one again.
pub(crate) fn read<R: Read>(reader: &mut R) -> Result<u32> {
    let mut count = 0;
    for shift in (0..u32::BITS).step_by(7) {
        let digit = u8::deserialize_reader(reader)?;
        count |= u32::from(digit & 0x7f) << shift;
        if digit < 0x80 {
            return Ok(count);
        }
    }
    Err(Error::new(ErrorKind::InvalidData, "a count has too many digits"))
}

#[cfg(test)]
mod tests {
    #[test]
    fn property_what_is_written_is_read() {
        for count in [0, 1, 127, 128, 16_383, 16_384, 4_000_000, u32::MAX] {
            let mut bytes = Vec::new();
            super::write(count, &mut bytes).unwrap();
            assert!(bytes.len() <= 5);
            assert_eq!(super::read(&mut bytes.as_slice()).unwrap(), count);
        }
        assert!(super::read(&mut [0xff; 6].as_slice()).is_err());
        assert!(super::read(&mut [0x80].as_slice()).is_err());
    }
}
