//! Counts and what can be made of them, as they are stored: most are small, and take one byte or two. What is read is
//! what was written, to the last bit.

use borsh::BorshDeserialize;
use borsh::io::{Error, ErrorKind, Read, Result, Write};
use integer_encoding::{VarIntReader, VarIntWriter};

use crate::units::Micros;

const MILLION: f64 = 1e6;
/// The most millionths that are written as such.
const MILLIONTHS_MAX: f64 = (1_u32 << 30) as f64;

/// A count as a varint: seven bits a byte, the lowest first.
pub(crate) fn write_u32<W: Write>(count: u32, writer: &mut W) -> Result<()> {
    writer.write_varint(count).map(drop)
}

/// Reads what [`write_u32`] wrote.
pub(crate) fn read_u32<R: Read>(reader: &mut R) -> Result<u32> {
    reader.read_varint()
}

/// A longer count as a varint.
pub(crate) fn write_u64<W: Write>(count: u64, writer: &mut W) -> Result<()> {
    writer.write_varint(count).map(drop)
}

/// Reads what [`write_u64`] wrote.
pub(crate) fn read_u64<R: Read>(reader: &mut R) -> Result<u64> {
    reader.read_varint()
}

/// A time by how far it is from another one.
pub(crate) fn write_time<W: Write>(time: Micros, from: Micros, writer: &mut W) -> Result<()> {
    writer.write_varint(time.0.wrapping_sub(from.0) as i64).map(drop)
}

/// Reads one again.
pub(crate) fn read_time<R: Read>(from: Micros, reader: &mut R) -> Result<Micros> {
    let apart: i64 = reader.read_varint()?;
    Ok(Micros(from.0.wrapping_add(apart as u64)))
}

/// An f64 as a varint of its millionths if that is exact, as for numbers that people write; otherwise as 8 bytes.
pub(crate) fn write_number<W: Write>(number: f64, writer: &mut W) -> Result<()> {
    let millionths = (number * MILLION).round();
    let is_near = millionths.abs() <= MILLIONTHS_MAX;
    let millionths = millionths as i32;
    // A negative zero is another number.
    if is_near && (f64::from(millionths) / MILLION).to_bits() == number.to_bits() {
        return write_u32((millionths << 1 ^ millionths >> 31) as u32 + 1, writer);
    }
    write_u32(0, writer)?;
    writer.write_all(&number.to_bits().to_le_bytes())
}

/// Reads one again: never one that is not a number.
pub(crate) fn read_number<R: Read>(reader: &mut R) -> Result<f64> {
    let number = match read_u32(reader)?.checked_sub(1) {
        Some(folded) => f64::from((folded >> 1) as i32 ^ -((folded & 1) as i32)) / MILLION,
        None => f64::from_bits(u64::deserialize_reader(reader)?),
    };
    if number.is_nan() { Err(invalid("a number is none")) } else { Ok(number) }
}

/// Whether things are so, the first in the lowest bit.
pub(crate) fn pack_flags<const N: usize>(are: [bool; N]) -> u16 {
    are.into_iter().rev().fold(0, |bits, is| bits << 1 | u16::from(is))
}

/// The flags of these bits.
///
/// # Errors
/// Bits beyond the last flag are set.
pub(crate) fn unpack_flags<const N: usize>(bits: u16) -> Result<[bool; N]> {
    if u32::from(bits) >> N != 0 {
        return Err(invalid("unknown flag bits are set"));
    }
    Ok(std::array::from_fn(|at| bits & 1 << at != 0))
}

/// What cannot have been written.
pub(crate) fn invalid(why: &'static str) -> Error {
    Error::new(ErrorKind::InvalidData, why)
}

#[cfg(test)]
mod tests {
    use crate::units::Micros;

    #[test]
    fn property_what_is_written_is_read() {
        for count in [0, 1, 127, 128, 16_383, 16_384, 4_000_000, u32::MAX] {
            let mut bytes = Vec::new();
            super::write_u32(count, &mut bytes).unwrap();
            assert!(bytes.len() <= 5);
            assert_eq!(super::read_u32(&mut bytes.as_slice()).unwrap(), count);
        }
        for count in [0, 1 << 32, 1 << 62, u64::MAX] {
            let mut bytes = Vec::new();
            super::write_u64(count, &mut bytes).unwrap();
            assert_eq!(super::read_u64(&mut bytes.as_slice()).unwrap(), count);
            assert!(count == 0 || super::read_u32(&mut bytes.as_slice()).is_err());
        }
        assert!(super::read_u32(&mut [0xff; 6].as_slice()).is_err());
        assert!(super::read_u64(&mut [0xff; 12].as_slice()).is_err());
        assert!(super::read_u32(&mut [0x80].as_slice()).is_err());
    }

    #[test]
    fn property_times_and_numbers_are_read_to_the_last_bit() {
        let times = [0, 1, 5_000_000, 1_795_248_000_000_000, 1 << 63, u64::MAX - 1, u64::MAX].map(Micros);
        for (time, from) in times.iter().flat_map(|&time| times.map(|from| (time, from))) {
            let mut bytes = Vec::new();
            super::write_time(time, from, &mut bytes).unwrap();
            assert_eq!(super::read_time(from, &mut bytes.as_slice()).unwrap(), time);
        }
        let decimal = [0.0, 0.1, 0.2, 70.0, 25.4, -3.3, 0.004_3, -1e-6, 1_073.741_824, -1_073.741_824];
        let others = [-0.0, 0.1 + 0.2, 1e-7, 1.0 / 3.0, 1_073.741_825, 1e300, f64::MIN_POSITIVE, f64::NEG_INFINITY];
        for number in decimal.into_iter().chain(others) {
            let mut bytes = Vec::new();
            super::write_number(number, &mut bytes).unwrap();
            assert_eq!(super::read_number(&mut bytes.as_slice()).unwrap().to_bits(), number.to_bits());
            assert_eq!(
                bytes.len() <= 5,
                decimal.contains(&number) && number.to_bits() != (-0.0_f64).to_bits(),
                "{number}"
            );
        }
        let none = [&[0][..], &f64::NAN.to_le_bytes()].concat();
        assert!(super::read_number(&mut none.as_slice()).is_err());
    }

    #[test]
    fn bits_are_what_is_so() {
        let are = [true, false, false, true, true];
        assert_eq!(super::pack_flags(are), 0b11001);
        assert_eq!(super::unpack_flags::<5>(0b11001).unwrap(), are);
        assert!(super::unpack_flags::<5>(0b100000).is_err());
    }
}
